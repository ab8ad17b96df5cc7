"""`slipwave run`: Run one model on one scene; print events, periods and stress drops of the run's second half."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from fullwave.fields.files import write_field
from slipwave.errors import NumericsError, SceneError
from slipwave.files import FIGURES, part_of
from slipwave.input.assemble import SceneSource
from slipwave.observe.protocol import StageFigures
from slipwave.observe.verdict import REPEATING
from slipwave.scene.drive import StartKind
from slipwave.scene.scene import doubts
from slipwave.solve import Leaping, State, has_fields
from slipwave.solve.checkpoint import saved_time
from slipwave.solve.lyapunov import INTERVALS, TRANSIENT, Exponent, largest_exponent
from validation.chart import Chart
from validation.chart.draw import Drawing, draw
from validation.commands.figures import return_map, run_chart
from validation.commands.options import LengthOptions, ModelOptions, NumericalOptions, announced, command, option
from validation.commands.result import Output, Result, aligned, rounded, save_chart
from validation.commands.run_dataset import run_dataset, write_events, write_run
from validation.commands.stage_table import stage_lines, stage_results, stages_in_words
from validation.commands.wording import (
    ENDED,
    events_in_words,
    face_figures,
    figure_rows,
    header,
    longer_in_words,
    margins_in_words,
    watched,
)
from validation.data.datasets import Dataset
from validation.data.variables import cycle_in_si
from validation.data.writing import MOST_LINES, write_series
from validation.models.build import judged_grid, prepare
from validation.models.by_name import Options, made, one_port_of
from validation.models.history_file import ALL, Thinning, Window
from validation.models.outlook import amplified_rounding, costly_steps, expected_period, length_of, needed
from validation.models.progress import log, progress
from validation.models.provenance import provenance
from validation.models.run import FIELD_FILES, MOST_CYCLES, Records, Run, reconsidered, simulate, time_between

if TYPE_CHECKING:
    from fullwave.adapt import Choice

_TOO_COARSE = 1e-2
"""Estimated error of the default grid above which the user is advised to choose one."""


class RunOptions(NumericalOptions, LengthOptions, ModelOptions):
    """Options of `slipwave.run`."""

    EXAMPLES: ClassVar = (
        "slipwave run paper --model modal:2 --set slab.log10_r=-2.6 --plot run.png",
        "slipwave run paper --out run.nc --every 10",
        "slipwave run run.nc",
    )

    cycles: int | None = option(
        "end when the second half of the run has N complete cycles, not --until",
        metavar="N",
        stored=True,
        least=1,
        most=MOST_CYCLES,
        must=f"be a whole number from 1 to {MOST_CYCLES}",
    )
    interface: bool | None = option(
        "keep the interface's history, or not; a history that would not fit on the disk, or into a quarter of the memory, is "
        "refused (default: as the scene records)",
        python_only=True,
        stored=True,
    )
    fields: bool | None = option(
        "keep the last 100 transits of a full wave, or not (default: as the scene records)", python_only=True
    )
    samples: Path | None = option("file of the history during the run (default: a temporary one)", python_only=True)
    checkpoint: Path | None = option("save checkpoints here during the run, and go on from FILE if it exists", metavar="FILE")
    checkpoint_every: float | str | None = option(
        "time between checkpoints, in transits or as 10s (default 1000)", metavar="TRANSITS|TIME"
    )
    every: int | None = option(
        "keep one in N samples of the interface's history",
        metavar="N",
        stored=True,
        least=1,
        must="be 1 or more: one in so many samples is kept",
    )
    rate: float | str | None = option(
        "keep even samples of the history, at so many per transit or as 1kHz, not the solver's own", metavar="RATE", stored=True
    )
    window: Window | None = option(
        "keep only the history from A to B, in transits or as 10s:60s, to the end as 50:; in Python also a pair of them",
        metavar="A:B",
        stored=True,
    )
    lyapunov: bool = option("largest Lyapunov exponent (second, perturbed run)", False)


class RunResult(Result):
    """The run `done` and its `records`. `choice`: the grid chosen for a full wave; `notes` on the numbers; `options` of the call;
    `exponent`: the largest Lyapunov exponent of the motion after the run, if requested."""

    done: Run
    records: Records
    choice: "Choice | None"
    notes: list[str]
    options: Mapping[str, Any]
    exponent: Exponent | None = None

    OUTPUTS: ClassVar = (
        Output("--out", (".nc",), "to_netcdf", "write events, and the interface and fields if recorded", "FILE.nc"),
        Output(
            "--fields",
            FIELD_FILES,
            "write_fields",
            "full wave: write velocity and stress of the last 100 transits, .vtu, .xdmf or .nc",
        ),
        Output("--events", (".csv",), "write_events", "write the slip events, in s and Pa for scenes in SI", "FILE.csv"),
        Output("--series", (".csv",), "write_series", "write the interface's motion as a record, with units", "FILE.csv"),
        Output("--plot", FIGURES, "save_plot", "draw stress and slip rate over time: .png, .pdf or .svg"),
        Output("--return-map", FIGURES, "save_return_map", "draw the period of each cycle over that of the one before"),
    )

    @classmethod
    def wanted_for(cls, files: Mapping[str, Path | None], options: Any) -> dict[str, Any]:
        """The history for a record, and for a netCDF file if its scene records it; the fields for their files."""
        out, record = files["out"], {"interface": True} if files["series"] else {}
        for name in ("every", "rate", "window"):
            if getattr(options, name) is not None and not (out or record or (name == "window" and files["plot"])):
                log.info(
                    "note: --%s changes nothing: no file holds the interface's history (--out FILE.nc, --series FILE.csv)", name
                )
        if out is None:
            return {"interface": False, "fields": files["fields"] is not None} | record
        return {"samples": part_of(out, ".samples")} | ({"fields": True} if files["fields"] else {}) | record

    def to_go_on(self, options: Any) -> str:
        """How to continue from its checkpoint, for a message."""
        path = options.checkpoint
        if path is None:
            return "no checkpoint was kept: --checkpoint FILE.npz keeps one to go on from"
        if path.exists():
            return f"{str(path)!r} holds the run up to t = {saved_time(path):.6g}: the same command goes on from there"
        return f"no checkpoint was written yet: --checkpoint-every TRANSITS|TIME keeps them more often in {str(path)!r}"

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The scene, the run with its verdict, cycles, stages, the state at the end, and the energy balance."""
        done, choice, scene = self.done, self.choice, self.done.solver.scene
        yield from header(scene)
        if choice is not None:  # the default grid tried no others
            yield f"{'grid chosen for the tolerance' if choice.tried else 'default grid'}: {_grid_in_words(choice)}"
        yield from (f"note: {note}" for note in self.notes)
        march = f" ({self._march} in time)" if self._march else ""
        words = f": {stages_in_words(self.stages)}" if done.kind == "protocol" else ""
        longer = longer_in_words(self.needed, scene) if done.kind == "too short" else ""
        if done.failed and not done.stopped:
            longer = "it failed before its end"  # which no other --until prevents
        judged = f"{events_in_words(done.event_count, done.verdict, longer)}{words}"
        yield f"model {done.solver.model}{march}, {done.until:g} transits: {judged}"
        yield from self.reasons
        if done.ended in ENDED:
            yield ENDED[done.ended]
        if done.verdict and done.verdict.repeats:
            yield ""
            means = {name: (spread.mean, spread.std) for name, spread in done.statistics.spreads.items()}
            rates = {name: (getattr(done.statistics, name), math.nan) for name in ("v_max", "v_min")}
            yield from aligned(*figure_rows(("mean", "std"), means | rates, scene))
            yield from margins_in_words(done.statistics, scene)
        if self.exponent is not None:
            growth, margin = self.exponent.rate, self.exponent.margin
            said = "the exponent is zero within its error"
            if abs(growth) > margin:
                word = "diverge" if growth > 0.0 else "converge"
                said = f"nearby motions {word} by a factor e in {1.0 / abs(growth):.3g} transits"
            yield f"largest Lyapunov exponent {rounded(growth, 3)} +- {rounded(margin, 2)} per transit (95 %): {said}"
        if self.stages:
            yield from stage_lines(self.stages, scene)
        if done.final:
            rate = {"v": done.final.v} if done.final.v <= 0.0 else {"ln v": done.final.ln_v}
            state = rate | {"psi": done.final.psi, "mu": done.final.mu}
            yield "\nat the end: " + ", ".join(f"{name} = {rounded(value, 12)}" for name, value in state.items())
        for label, figures in self._observed.items():
            yield f"{label}: " + ", ".join(f"{name} = {rounded(value, 6)}" for name, value in figures.items())
        if self.energy:
            entries = ", ".join(f"{name} {rounded(value, 6)}" for name, value in self.energy.items())
            yield f"energy to t = {done.marched:.8g}: {entries}"
        if done.solver.failures:
            yield f"interface solves that did not converge: {done.solver.failures}"
        yield f"wall time {done.wall_s:.3g} s"

    @property
    def step(self) -> float:
        """Length of the steps of a full wave (transits)."""
        solver = self.done.solver
        if not has_fields(solver):
            raise AttributeError(f"{solver.model} has no grid, and steps of several lengths")
        return solver.step

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`. `grid` exists only if the user did not choose its cells, `protocol`, the stages, only if the drive
        changes, `lyapunov` only if requested, `observed` only if the scene records observers by name."""
        done, statistics, scene = self.done, self.done.statistics, self.done.solver.scene
        result: dict[str, Any] = {
            "scene": done.solver.scene.name,
            "model": done.solver.model,
            "until": done.until,
            "events": done.event_count,
            "verdict": done.kind,
            "multiplicity": done.verdict.multiplicity if done.verdict else None,
            "rotation_number": done.verdict.rotation if done.verdict else None,
            "rate": done.verdict.rate if done.verdict else None,
            **{name: asdict(spread) for name, spread in statistics.spreads.items()},
            "v_max": statistics.v_max,
            "v_min": statistics.v_min,
            "v_max_median": statistics.v_max_median,
            "margins": statistics.margins if done.verdict and done.verdict.wanders else None,
            "final": asdict(done.final) if done.final else None,
            "energy": self.energy,
            "energy_until": done.marched if self.energy else None,
            "ended": done.ended,
            "reasons": self.reasons,
            "failures": done.solver.failures,
            "faces": [] if scene.is_held_rigidly else face_figures(scene, watched(scene)),
            "wall_s": done.wall_s,
        }
        if done.solver.scene.units:
            values = statistics.values() | {"v_max_median": statistics.v_max_median}
            result |= cycle_in_si(values | self._spreads, done.solver.scene)
        if self._march:
            result["time"] = self._march
        if isinstance(done.solver, Leaping) and done.solver.skipped:
            result["left_out"] = done.solver.skipped
        if self.choice:
            result["grid"] = {name: getattr(self.choice, name) for name in ("cells", "step", "quantity", "error_estimate")}
        more = {
            "protocol": stage_results(self.stages, done.solver.scene) if self.stages else [],
            "lyapunov": self.exponent._asdict() if self.exponent else None,
            "observed": self._observed,
            "notes": [*doubts(done.solver.scene), *self.notes],
        }
        return result | {name: value for name, value in more.items() if value}

    @property
    def _observed(self) -> dict[str, dict[str, float]]:
        """The figures of observers by name, also those of numpy, as numbers that every file holds; NaN where there is none."""
        named = {label: observer.figures() for label, observer in self.records.named.items()}
        return {
            label: {name: float("nan" if x is None else x) for name, x in figures.items()} for label, figures in named.items()
        }

    @property
    def _march(self) -> str | None:
        """How the slabs of a full wave are propagated in time, if it can be done in several ways."""
        return self.done.solver.settings.get("time")

    @property
    def _spreads(self) -> dict[str, float]:
        """Standard deviations of the cycles' figures and, for motion that never repeats, margins of their means."""
        statistics, wanders = self.done.statistics, self.done.verdict and self.done.verdict.wanders
        margins = {f"{name}_margin": value for name, value in statistics.margins.items()} if wanders else {}
        return {f"{name}_std": spread.std for name, spread in statistics.spreads.items()} | margins

    @property
    def stages(self) -> list[StageFigures]:
        """The stages of a protocol with their figures, the last one to the end of the run; none if V never changes."""
        figures = self.records.protocol.figures if self.records.protocol else []
        return [replace(stage, end=min(stage.end, self.done.until)) for stage in figures]

    @cached_property
    def reasons(self) -> list[str]:
        """Text on why the motion is what it is, and on what would change it; of cycles, the figures whose spread exceeds their
        mean."""
        if self.done.failed or self.done.verdict is None:
            return []
        if self.done.verdict.repeats:
            wide = [name.replace("_", " ") for name, spread in self.done.statistics.spreads.items() if spread.std > spread.mean]
            differ = "exceeds the mean: cycles differ so much that a mean says little"
            return [f"the std of {' and '.join(wide)} {differ}"] if wide else []
        from validation.commands.reasons import reasons  # it analyses stability

        return reasons(self.done, one_port_of(self.done.solver.model))

    @property
    def needed(self) -> float:
        """Length (transits) of a run with enough cycles, if this one is too short."""
        return needed(self.done.verdict, self.done.solver.scene, one_port_of(self.done.solver.model))

    @property
    def energy(self) -> dict[str, float] | None:
        """Name -> entry of the energy balance since t = 0; None for models without one and for a failed run."""
        ledger = self.done.energy
        if ledger is None:
            return None
        viscous = ["viscous"] * any(slab.viscosity for slab in self.done.solver.scene.slabs)
        return {name: getattr(ledger, name) for name in ("input", "friction", "radiated", "stored", "residual", *viscous)}

    @cached_property
    def dataset(self) -> Dataset:
        """Cycles by `event`, stages of a protocol by `stage`, and the interface's history by `time`, if it was kept; all
        of it is in memory."""
        return run_dataset(self.done, self._facts(), self.stages, self.records.history)

    def to_netcdf(self, path: str | Path) -> None:
        """Write the dataset, block by block, and the fields as a group if the scene records them. Raises SceneError if the file
        cannot be written."""
        record = self.records.fields if "fields" in self.done.solver.scene.record else None
        field = record.field if record is not None and self.done.final is not None else None
        write_run(Path(path), self.done, self._facts(), self.stages, self.records.history, field)

    def chart(self) -> Chart:
        """Stress and slip rate over time, or for a protocol friction over time and slip; in the window, if given. Some thousand
        ranges are drawn, whatever the length of the run."""
        return run_chart(self.done, self.records.envelope, self.stages if self.records.protocol else None)

    def plot_return_map(self) -> Drawing:
        """The period of each cycle of the run's second half over that of the one before. Raises SceneError for fewer than two
        cycles."""
        return draw(return_map(self.done))

    def save_return_map(self, path: str | Path) -> None:
        """Write the return map as .png, .pdf or .svg. Raises SceneError if the file cannot be written."""
        save_chart(path, lambda: return_map(self.done))

    def _facts(self) -> dict[str, Any]:
        facts = provenance("run", self.done.solver.scene, self.done.solver.model, self.options)
        observed = {f"{label}_{name}": x for label, figures in self._observed.items() for name, x in figures.items()}
        return facts | {"ended": self.done.ended or "failed", "reasons": "; ".join(self.reasons)} | observed

    def write_events(self, path: str | Path) -> None:
        """Write one line for each complete cycle to a .csv file, in SI if the scene has units."""
        write_events(Path(path), self.done.events, self.done.solver.scene)

    def write_series(self, path: str | Path) -> None:
        """Write the interface's motion as a record that `validation.data.series.read_series` reads, in SI if the scene has units:
        one in so many samples that there are MOST_LINES at most, unless `every`, `rate` or `window` chose them. Raises SceneError
        if the run kept no history (`interface`), or if it cannot be written."""
        history = self.records.history
        if history is None or history.problem:
            why = "a record needs the interface's history: run with interface=True"
            raise SceneError(why if history is None else history.problem)
        chosen = any(self.options[name] is not None for name in ("every", "rate", "window"))
        every = 1 if chosen else max(1, math.ceil(len(history) / MOST_LINES))
        if every > 1:
            log.info("series: one in %d of %d samples; --every 1 writes all, --rate even ones", every, len(history))
        write_series(Path(path), history.parts(), self.done.solver.scene, every)

    def write_fields(self, path: str | Path) -> None:
        """Write velocity and stress of the last transits to a .vtu, .xdmf or .nc file; nothing if the run kept none."""
        if self.records.fields is not None and self.done.final is not None:
            write_field(Path(path), self.records.fields.field)

    def close(self) -> None:
        """Remove the temporary file that holds the interface's history."""
        self.records.close()


@command
def run(source: SceneSource, options: RunOptions) -> RunResult:
    """Run one model on a scene.

    Without `until` and `cycles` the scene gives the length, or the run ends when its motion is settled
    (`validation.models.outlook`). If `source` is a netCDF file of an earlier run, it is run again: its model and its options
    apply where none are given.

    Raises SceneError for wrong input and for a run that is expected to take more than `most_seconds`; NumericsError if the
    numerics fail, with the result so far as its `result`.
    """
    until, checkpoint = options.until, options.checkpoint
    if until is not None and options.cycles is not None:
        raise SceneError(f"cycles = {options.cycles}: must not be given together with until = {until}")
    if options.interface is None and (options.every, options.window, options.rate) != (None, None, None):
        options = replace(options, interface=True)
    options = options.recalled(source, "run", without=["cycles"] if until is not None else [])
    scene = options.scene_of(source, until)
    if options.cycles is not None and not scene.record:
        raise SceneError(f"cycles = {options.cycles}: cannot be counted, because run.record is empty")
    if options.lyapunov and (not scene.drive.is_constant or scene.velocity == 0.0):
        raise SceneError(f"scene {scene.name!r}: a Lyapunov exponent needs a constant drive.velocity")
    every = time_between(checkpoint, options.checkpoint_every, scene)
    chosen = (options.every, options.window, options.rate) != (None, None, None)
    kept = Thinning.of(options.every, options.window, scene, options.rate) if chosen else ALL
    if scene.start.kind is StartKind.ORBIT:
        built = prepare(options.model, scene, checkpoint is not None and checkpoint.exists(), **options.numerical)
    else:
        built = made(options.model, scene, **options.numerical)
    solver = built.solver
    if built.choice is not None:
        log.info("%s: %s", solver.model, _grid_in_words(built.choice))
    announced(solver.model, built.why)
    if has_fields(solver):
        solver.keep_ledger()
    start, one_port = solver.state(), one_port_of(solver.model)
    length = length_of(scene, one_port, options.cycles)
    amplified = amplified_rounding(solver.scene, one_port, length.until, options.tol)
    notes = [amplified[1]] if amplified else []
    if options.cells is not None and options.tol is not None and has_fields(solver):
        what = "is for the steps in time: cells are given, and the error of their grid is not estimated"
        notes.append(f"tolerance {options.tol:g} {what}")
    notes += costly_steps(solver)
    records = Records(solver, length, options.interface, options.fields, kept, options.samples, checkpoint, every)
    try:
        watch = records.watch if scene.record else None
        done = simulate(solver, length, records.observers, options.most_seconds, watch, records.marks)
        done = done if done.stopped else reconsidered(done, one_port)
        exponent, (default, failed, stopped) = None, _default_grid(done, start, options)
        if options.lyapunov and not (failed or stopped):
            exponent, failed, stopped = _exponent(done, options)
    except BaseException:
        records.close()
        raise
    notes += _afterwards(default, kept, solver.time)
    for note in notes:
        log.info("note: %s", note)
    parts = done, records, built.choice or default, notes, options.stored, exponent
    return RunResult(*parts, failed=failed, stopped=stopped)


def _default_grid(done: Run, start: State, options: RunOptions) -> tuple["Choice | None", str, bool]:
    """The default grid of a full wave with its estimated error, if it was used from this `start`; why the command ends early, if
    it does, and whether the user stopped it: the figures of a run that is whole are kept then too."""
    solver, failed, stopped = done.solver, done.failed, done.stopped
    if options.cells is not None or options.tol is not None or failed or not has_fields(solver):
        return None, failed, stopped
    try:
        return judged_grid(solver, start, options.cfl, options.time), failed, stopped
    except KeyboardInterrupt:
        return None, f"interrupted at t = {solver.time:.6g} transits, before the error of the grid was known", True


def _exponent(done: Run, options: RunOptions) -> tuple[Exponent | None, str, bool]:
    """The exponent of the motion from the end of a run on, or why there is none, and whether the user stopped it. The second,
    perturbed solver has the same options, but a grid chosen for a tolerance is not chosen again.

    A run whose cycles do not represent its motion has none: a disturbance of steady sliding fades or grows as `slipwave
    stability` says, and a transient has no exponent."""
    solver, scene, numerical = done.solver, done.solver.scene, options.numerical
    if done.verdict is not None and not done.verdict.repeats:
        advice = "run longer" if done.verdict.kind in ("too short", "settling") else "slipwave stability gives its rate"
        problem = (
            f"{solver.model}: a Lyapunov exponent is measured of runs with the verdict {', '.join(REPEATING[:-1])} or "
            f"{REPEATING[-1]}; this one is {done.verdict.kind}: {advice} (scene {scene.name!r})"
        )
        return None, problem, False
    if has_fields(solver):
        numerical = numerical | Options(cells=solver.cells, tolerance=solver.settings.get("resolution"))
    period = float(done.events.period[-1]) if done.events.period.size else expected_period(scene)
    cycle = period if math.isfinite(period) else 1.0
    try:
        twin = prepare(solver.model, scene, True, **numerical).solver
        with progress(f"{scene.name}, {solver.model}, and a perturbed run", float(TRANSIENT + INTERVALS)) as report:
            return largest_exponent(solver, twin, cycle, report, most_seconds=options.most_seconds), "", False
    except NumericsError as error:
        return None, str(error), False
    except KeyboardInterrupt:
        return None, f"interrupted at t = {done.solver.time:.6g} transits, before the Lyapunov exponent was known", True


def _afterwards(choice: "Choice | None", kept: Thinning, end: float) -> list[str]:
    """Warnings about a run that ended at `end` (transits): of what is kept nothing was reached, or the default grid is too
    coarse."""
    if kept.begin >= end:
        return [f"nothing is kept: the window begins at t = {kept.begin:g}, the run ended at t = {end:g} transits"]
    if choice is None or choice.error_estimate <= _TOO_COARSE:
        return []
    known = math.isfinite(choice.error_estimate)
    error = f"{choice.error_estimate:.1e}" if known else "unknown, a coarser grid finds other cycles"
    advice = f"too coarse for this scene: estimated error {error}; give --tol or --cells"
    return [f"the default grid of {choice.cells} cells is {advice}"]


def _grid_in_words(choice: "Choice") -> str:
    """Cells, steps and estimated error of a grid."""
    steps = f"steps of {'at most ' * choice.adapts}{choice.step:.4g}"
    return f"{choice.cells} cells, {steps}, estimated error of {choice.quantity} {choice.error_estimate:.1e}"

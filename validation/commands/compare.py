"""`slipwave compare`: Draw one cycle of each model in one figure; print periods and stress drops with their errors."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, ClassVar

from slipwave.errors import SceneError
from slipwave.files import FIGURES
from slipwave.input.assemble import SceneSource
from slipwave.observe import EventObserver
from slipwave.scene import Scene
from slipwave.solve import Solver
from slipwave.solve.follow import require_time
from validation.chart import Chart, Look, Panel, Scale, Trace, color_number
from validation.commands.comparison import Comparison, barred, errors_of, nothing, remarks, row_of
from validation.commands.figures import for_rates, scale_of
from validation.commands.options import LengthOptions, NumericalOptions, RecordOptions, command, option
from validation.commands.result import Output, aligned, rounded
from validation.commands.with_data import chart_with_data, data_lines, distances_from_data, facts_of_data
from validation.data.record_events import MeasuredMotion, measured_motion
from validation.data.series import read_series
from validation.models.build import build_all
from validation.models.by_name import one_port_of
from validation.models.cycle import CycleObserver, OneCycle
from validation.models.outlook import Length, length_of
from validation.models.progress import log
from validation.models.run import Run, reconsidered, second_half, simulate
from validation.models.timing import warm

_OVERLAY = "the overlay figure (default compare.png; with --json none)"
_ON_TOP = Look(dashes=(0, (4, 2)), width=0.9)
"""Line style of the reference: covered curves remain visible between the dashes."""


class CompareOptions(RecordOptions, NumericalOptions, LengthOptions):
    """Options of `slipwave.compare`."""

    EXAMPLES: ClassVar = (
        "slipwave compare paper --models delay,kelvin-voigt,fd --out compare.png",
        "slipwave compare mine.toml --with measured.csv --models quasidynamic --out compare.pdf",
    )

    models: str | Sequence[str] | None = option(
        "the models; the reference is delay if it is among them, else the first (with a record: default auto)",
        metavar="M1,M2,...",
        positional=True,
    )
    data: Path | None = option("a measured record of time and friction, CSV or columns", flag="--with", metavar="FILE")
    smooth: int | None = option(
        "samples of the record that a local parabola smooths (default: at most a quarter of a slip event)",
        metavar="N",
        least=1,
        must="be 1 or more samples",
    )


class CompareResult(Comparison):
    """The `runs` of the models on the scene and the last complete cycle of each, None where it has none; the reference is delay
    if it is among them, else the first."""

    DIMENSION: ClassVar = "model"
    COMMAND: ClassVar = "compare"
    OUTPUTS: ClassVar = (Output("--out", FIGURES, "save_plot", _OVERLAY, "FILE.png", default="compare.png", key="figure"),)

    runs: list[Run]
    cycles: list[OneCycle | None]
    motion: MeasuredMotion | None

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One for each model."""
        rows = [row_of(run, _figures(run), self.reference) for run in self.runs]
        if self.motion is None:
            return rows
        data = facts_of_data(self.motion, self.scene)
        pairs = zip(self.runs, rows, strict=True)
        return [row | {"against_data": distances_from_data(run.statistics, data)} for run, row in pairs]

    @property
    def facts(self) -> dict[str, Any]:
        """As `Comparison`; `data`: the figures of the record, if there is one."""
        return super().facts | ({} if self.motion is None else {"data": facts_of_data(self.motion, self.scene)})

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """One row per model, and the conclusion."""

        def mean(row: Mapping[str, Any], name: str, digits: int) -> str:
            """A cell, with a margin for motion that never repeats."""
            return barred(row[name]["mean"], row["margins"][name] if row["margins"] else 0.0, digits)

        names = ["model", "period", "std", "stress drop", "elastic drop", "v_max", "v_min", "error T", "error drop", "wall s"]
        rows = [
            [
                row["model"],
                mean(row, "period", 9),
                rounded(row["period"]["std"], 2),
                mean(row, "stress_drop", 7),
                mean(row, "elastic_stress_drop", 7),
                rounded(row["v_max"], 7),
                rounded(row["v_min"], 7),
                *errors_of(row),
                rounded(row["wall_s"], 3),
            ]
            for row in summary["models"]
        ]
        yield from aligned(names, rows)
        against = f"relative errors against {summary['reference']}"
        yield f"\nperiods in transits, means over the second half, {against}; figure: {summary['figure']}"
        yield from remarks(summary)
        if self.motion is not None:
            yield from data_lines(summary, self.scene)

    def chart(self) -> Chart:
        """Stress and slip rate over one cycle, aligned on the date of the slip event, one style per model, the reference dashed
        on top; a motion without cycles appears in the legend only. With a record: its cycles and the residuals."""
        pairs = zip(self.runs, self.cycles, strict=True)
        shown = [(run, cycle if run.verdict and run.verdict.repeats else None) for run, cycle in pairs]
        if self.motion is not None:
            return chart_with_data(self.motion, [(run.solver.model, cycle) for run, cycle in shown], self.scene)
        looks = [_ON_TOP if run is self.reference else Look(color_number(k), width=1.2) for k, run in enumerate(self.runs)]
        names = [_label(run, cycle is not None) for run, cycle in shown]
        last = sorted(range(len(shown)), key=lambda k: self.runs[k] is self.reference)

        def traces(quantity: str) -> list[Trace]:
            drawn = [(k, cycle) for k in last if (cycle := shown[k][1])]
            return [Trace(names[k], cycle.time, getattr(cycle, quantity), looks[k]) for k, cycle in drawn]

        time = "transits since v passed half its largest value in the slip event"
        above = Panel("", replace(scale_of("time", self.scene), label=time), scale_of("stress", self.scene), traces("stress"))
        rates = traces("slip_rate")
        below = Panel(
            "", Scale(time), for_rates(scale_of("slip_rate", self.scene), (trace.columns["y"] for trace in rates)), rates
        )
        if not above.traces:
            text = nothing(self.reference) or "no run has cycles that represent its motion"
            above = replace(above, traces=[Trace(text, 0.5, 0.5, Look(kind="text", marker="center"))])
        keys = [Trace(name, [], [], look) for name, look in zip(names, looks, strict=True)]
        title = "The last complete cycle of each run; T: mean over the second half, in transits"
        return Chart([above, below], 6.0, width=9.0, legend="outside lower left", legend_columns=2, keys=keys, title=title)


def _label(run: Run, shown: bool) -> str:
    """Legend of a run, with its mean period as in the table."""
    kind, period = run.kind or "events not watched", run.statistics.period.mean
    if shown:
        margin = run.statistics.margins["period"]
        return f"{run.solver.model}: {kind}, T = {period:.6g}" + (f" ± {margin:.2g}" if math.isfinite(margin) else "")
    return f"{run.solver.model}: {'slides steadily' if kind == 'steady' else kind}, no cycle drawn"


@command
def compare(source: SceneSource, options: CompareOptions) -> CompareResult:
    """Run several models (a list, or names separated by commas) on a scene and compare their cycles with those of the delay
    system, or of the first model; with `data`, a record, also with its cycles.

    Raises SceneError for wrong input; NumericsError if one of them fails, with all of them as its `result`.
    """
    scene = options.scene_of(source, options.until)
    if options.models is None and options.data is None:
        raise SceneError("--models: missing: name models, as in delay,kelvin-voigt, or a record by --with FILE")
    given = "auto" if options.models is None else options.models
    names = given if isinstance(given, str) else ",".join(given)
    motion = _measured(options, scene)
    computed, stopped = _runs_of(build_all(names, scene, **options.numerical), scene, options.most_seconds)
    runs, cycles = [run for run, _ in computed], [cycle for _, cycle in computed]
    failed = [*(run.failed for run in runs if run.failed), *([stopped] if stopped else [])]
    reference = next((run for run in runs if run.solver.model == "delay"), runs[0])
    parts = scene, reference, options.stored, runs, cycles, motion
    return CompareResult(*parts, failed="; ".join(failed), stopped=bool(stopped))


def _measured(options: CompareOptions, scene: Scene) -> MeasuredMotion | None:
    """The motion in the record, if given. Raises SceneError for a record's options without a record, and for a drive that
    changes, under which cycles are not comparable."""
    if options.data is None:
        without = [name for name in (*options.reading, "smooth") if getattr(options, name) is not None]
        if without:
            raise SceneError(f"{without[0]}: needs a record: --with FILE")
        return None
    if not scene.drive.is_constant:
        raise SceneError(f"scene {scene.name!r}: its drive changes; cycles are compared under a constant drive.velocity")
    series = read_series(options.data, **options.reading)
    for note in series.notes:
        log.info("note: %s", note)
    return measured_motion(series, scene, options.smooth)


def _runs_of(solvers: list[Solver], scene: Scene, most: float) -> tuple[list[tuple[Run, OneCycle | None]], str]:
    """The runs and their last cycles, in the order of `solvers`, and where the user stopped them. The reference runs first: all
    others last as long as it does."""
    first = next((solver for solver in solvers if solver.model == "delay"), solvers[0])
    length = length_of(scene, one_port_of(first.model))
    for solver in solvers:
        if math.isfinite(length.until):
            require_time(solver, length.until, most)
        warm(solver)
    computed: dict[str, tuple[Run, OneCycle | None]] = {}
    stopped = ""
    for solver in sorted(solvers, key=lambda solver: solver is not first):
        watch = EventObserver(scene, solver.nodes)
        observer = CycleObserver(solver, watch)
        run = simulate(solver, length, [observer] if scene.record else [], most, watch if scene.record else None)
        run = reconsidered(run, one_port_of(solver.model))
        stopped = f"model {solver.model}" if run.stopped else ""
        computed[solver.model] = run, observer.cycle(second_half(solver, run.until))
        if stopped:
            break
        length = Length(until=run.until)
    return [computed[solver.model] for solver in solvers if solver.model in computed], stopped


def _figures(run: Run) -> dict[str, Any]:
    """One model's answer."""
    ours = run.statistics
    return {
        "events": run.event_count,
        **{name: asdict(spread) for name, spread in ours.spreads.items()},
        "margins": ours.margins if run.verdict and run.verdict.wanders else None,
        "v_max": ours.v_max,
        "v_min": ours.v_min,
    }

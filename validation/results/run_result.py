"""What `slipwave.run` gives back."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from fullwave.fields.files import write_field
from slipwave.errors import SceneError
from slipwave.files import part_of
from slipwave.observe.stages import StageFigures
from slipwave.scene.doubts import doubts
from slipwave.solve import Leaping
from slipwave.solve.lyapunov import Exponent
from validation.compute.default_grid import grid_in_words
from validation.compute.length import needed
from validation.compute.models import one_port_of
from validation.compute.recording import FIELD_FILES, Records, how_to_resume
from validation.compute.run import Run
from validation.data.writing import write_series
from validation.output import FIGURES, aligned, rounded
from validation.results.provenance import SCHEMA, provenance
from validation.results.quantities import cycle_in_si
from validation.results.result import Dataset, Output, Result, finite, save_drawing
from validation.results.run_dataset import run_dataset, write_events, write_run
from validation.results.stage_table import missing_in_words, stage_results, stage_rows, stages_in_words
from validation.results.wording import (
    ENDED,
    events_in_words,
    exponent_in_words,
    header,
    margins_in_words,
    spreads_in_words,
    statistics_rows,
)

if TYPE_CHECKING:
    from fullwave.adapt import Choice
    from validation.study.drawing import Drawing


@dataclass(frozen=True, repr=False, eq=False)
class RunResult(Result):
    """A run that is `done`, with what was kept of it on its way in `records`. `choice` is the grid that was chosen for a full
    wave, `notes` are remarks on the numbers, `options` those of the call; `exponent`, if asked for, is the largest Lyapunov
    exponent of the motion from the end on."""

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
    def wanted_for(cls, files: Mapping[str, Path | None]) -> dict[str, Any]:
        """The history for a record, and for a netCDF file if its scene records it; the fields for theirs."""
        out, record = files["out"], {"interface": True} if files["series"] else {}
        if out is None:
            return {"interface": False, "fields": files["fields"] is not None} | record
        return {"samples": part_of(out, ".samples")} | ({"fields": True} if files["fields"] else {}) | record

    def to_go_on(self, options: Any) -> str:
        """From its checkpoint."""
        return how_to_resume(options.checkpoint)

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The scene, the run with its verdict, cycles, stages, the state at the end, and the energy ledger."""
        done, choice, scene = self.done, self.choice, self.done.solver.scene
        yield from header(scene)
        if choice is not None:  # the default grid tried no others
            yield f"{'grid chosen for the tolerance' if choice.tried else 'default grid'}: {grid_in_words(choice)}"
        yield from (f"note: {note}" for note in self.notes)
        march = f" ({done.solver.settings['time']} in time)" if "time" in done.solver.settings else ""
        words = f": {stages_in_words(self.stages)}" if done.kind == "protocol" else ""
        judged = f"{events_in_words(done.starts, done.verdict, self.needed)}{words}"
        yield f"model {done.solver.model}{march}, {done.until:g} transits: {judged}"
        yield from self.reasons
        if done.ended in ENDED:
            yield ENDED[done.ended]
        if done.verdict and done.verdict.repeats:
            yield ""
            yield from aligned(*statistics_rows(done.statistics, scene))
            yield from margins_in_words(done.statistics, scene)
        if self.exponent is not None:
            yield exponent_in_words(self.exponent)
        if self.stages:
            yield ""
            yield from aligned(*stage_rows(self.stages, scene))
            yield from missing_in_words(self.stages)
        if done.final:
            state = {"ln v": done.final.ln_v, "psi": done.final.psi, "mu": done.final.mu}
            yield "\nat the end: " + ", ".join(f"{name} = {rounded(value, 12)}" for name, value in state.items())
        for label, one in self.records.named.items():
            yield f"{label}: " + ", ".join(f"{name} = {rounded(value, 6)}" for name, value in one.figures().items())
        if self.energy:
            yield "energy: " + ", ".join(f"{name} {rounded(value, 6)}" for name, value in self.energy.items())
        if done.solver.failures:
            yield f"interface solves that did not converge: {done.solver.failures}"
        yield f"wall time {done.wall_s:.3g} s"

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave run` (users rely on its keys). `grid` is there only if the user did not choose its cells,
        `protocol`, its stages, only if the drive changes, `lyapunov` only if it was asked for, `failed` only if the numerics
        failed, `observed` only if the scene records observers by name."""
        done, found = self.done, self.done.statistics
        result: dict[str, Any] = {
            "schema": SCHEMA,
            "scene": done.solver.scene.name,
            "model": done.solver.model,
            "until": done.until,
            "events": done.starts,
            "verdict": done.kind,
            "multiplicity": done.verdict.multiplicity if done.verdict else None,
            "rotation_number": done.verdict.rotation if done.verdict else None,
            "rate": done.verdict.rate if done.verdict else None,
            **{name: asdict(one) for name, one in found.spreads.items()},
            "v_max": found.v_max,
            "v_min": found.v_min,
            "margins": asdict(found.margins) if done.verdict and done.verdict.wanders else None,
            "final": asdict(done.final) if done.final else None,
            "energy": self.energy,
            "ended": done.ended,
            "reasons": self.reasons,
            "failures": done.solver.failures,
            "wall_s": done.wall_s,
        } | cycle_in_si(found.values() | self._spreads, done.solver.scene)
        if "time" in done.solver.settings:
            result["time"] = done.solver.settings["time"]
        if isinstance(done.solver, Leaping) and done.solver.skipped:
            result["left_out"] = done.solver.skipped
        if self.choice:
            result["grid"] = {name: getattr(self.choice, name) for name in ("cells", "step", "quantity", "error_estimate")}
        more = {
            "protocol": stage_results(self.stages, done.solver.scene) if self.stages else [],
            "lyapunov": self.exponent._asdict() if self.exponent else None,
            "observed": {name: one.figures() for name, one in self.records.named.items()},
            "failed": done.failed,
            "notes": [*doubts(done.solver.scene), *self.notes],
        }
        return dict(finite(result | {name: value for name, value in more.items() if value}))

    @property
    def _spreads(self) -> dict[str, float]:
        """The std of the cycles' figures, and of motion that never repeats the margins of their means."""
        found, wanders = self.done.statistics, self.done.verdict and self.done.verdict.wanders
        margins = {f"{name}_margin": getattr(found.margins, name) for name in found.spreads} if wanders else {}
        return {f"{name}_std": one.std for name, one in found.spreads.items()} | margins

    @property
    def stages(self) -> list[StageFigures]:
        """The stages of a protocol with their figures; none if V never changes."""
        return self.records.protocol.figures if self.records.protocol else []

    @cached_property
    def reasons(self) -> list[str]:
        """Why the motion is what it is, and what would change it, in words."""
        if self.done.failed or self.done.verdict is None:
            return []
        if self.done.verdict.repeats:
            return spreads_in_words(self.done.statistics)
        from validation.results.reasons import reasons  # it analyses stability

        return reasons(self.done, one_port_of(self.done.solver.model))

    @property
    def needed(self) -> float:
        """Length (transits) of a run with enough cycles, if this one is too short."""
        return needed(self.done.verdict, self.done.solver.scene, one_port_of(self.done.solver.model))

    @property
    def energy(self) -> dict[str, float] | None:
        """The energy ledger since t = 0 by name; None for models that keep none and for a run that failed."""
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

    def plot(self) -> "Drawing":
        """Stress and slip rate over time, or of a protocol friction over time and slip; in a window if one was given. Some
        thousand ranges are drawn, however long the run was."""
        from validation.results.figures import run_figure

        return run_figure(self.done, self.records.envelope, self.stages if self.records.protocol else None)

    def plot_return_map(self) -> "Drawing":
        """The period of each cycle of the run's second half over that of the one before. Raises SceneError for fewer than two
        cycles."""
        from validation.results.figures import return_map

        return return_map(self.done)

    def save_return_map(self, path: str | Path) -> None:
        """Write the return map as .png, .pdf or .svg. Raises SceneError if the file cannot be written."""
        save_drawing(path, self.plot_return_map)

    def _facts(self) -> dict[str, Any]:
        facts = provenance("run", self.done.solver.scene, self.done.solver.model, self.options)
        return facts | {"ended": self.done.ended or "failed", "reasons": "; ".join(self.reasons)}

    def write_events(self, path: str | Path) -> None:
        """Write one line for each complete cycle to a .csv file, in SI if the scene has units."""
        write_events(Path(path), self.done.events, self.done.solver.scene)

    def write_series(self, path: str | Path) -> None:
        """Write the interface's motion as a record that `validation.data.series.read_series` reads, in SI if the scene has units.
        Raises SceneError if the run kept no history (`interface`), or if it cannot be written."""
        history = self.records.history
        if history is None or history.problem:
            raise SceneError(history.problem if history else "a record needs the interface's history: run with interface=True")
        write_series(Path(path), history.parts(), self.done.solver.scene)

    def write_fields(self, path: str | Path) -> None:
        """Write velocity and stress of the last transits to a .vtu, .xdmf or .nc file; nothing if the run kept none."""
        if self.records.fields is not None and self.done.final is not None:
            write_field(Path(path), self.records.fields.field)

    def close(self) -> None:
        """Remove the temporary file that holds the interface's history."""
        self.records.close()

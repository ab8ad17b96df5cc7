"""Compares several runs of a scene with a reference: rows, a one-line conclusion, and their table."""

import math
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

from slipwave.family import Exact
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from slipwave.scene.scene import doubts
from validation.commands.result import Result, finite, rounded
from validation.commands.wording import longer_in_words
from validation.data.datasets import Dataset
from validation.data.variables import table_of
from validation.models.by_name import family_of, one_port_of
from validation.models.outlook import needed
from validation.models.provenance import provenance
from validation.models.run import Run

_Row: TypeAlias = Mapping[str, Any]

CLOSE = 0.05
"""Largest relative distance in period and stress drop at which a cheaper model is recommended."""

_CERTAIN = 2.0  # times of single runs of equal work differed by up to 1.7 on a busy machine


def differences(run: Run, reference: Run) -> dict[str, dict[str, float | None]]:
    """The relative differences of the mean period and stress drop by name: the `error` if both motions are periodic; else the
    `difference` and its `margin`, because motions that never repeat agree only in their statistics. An error is None where a run
    has none, or failed. `margin`: half the width of the 95 % interval, 0 of the reference itself, NaN for too few cycles."""
    values, margins = dict[str, float | None](), dict[str, float | None]()
    for name in ("period", "stress_drop"):
        ours, theirs = (getattr(motion.statistics, name).mean for motion in (run, reference))
        parts = [
            0.0 if motion.kind == "periodic" else motion.statistics.margins[name] / float(mean)
            for motion, mean in ((run, ours), (reference, theirs))
        ]
        value = math.nan if run.failed else ours / theirs - 1.0
        if run.kind == reference.kind == "periodic" or not math.isnan(value):
            values[name], margins[name] = value, 0.0 if run is reference else (1.0 + value) * math.hypot(*parts)
    if run.kind == reference.kind == "periodic":
        return {"error": values}
    return {"error": dict.fromkeys(("period", "stress_drop"))} | ({"difference": values, "margin": margins} if values else {})


def conclusion(rows: Sequence[_Row]) -> str:
    """Which model to use, by run time and distance in period and stress drop; empty if the rows do not decide.

    `rows` are those of the JSON of `slipwave compare` and `bench`. Failed runs and motions without cycles are ignored.
    """
    counted = [row for row in rows if "failed" not in row and distances(row)]
    exact = _cheapest(row for row in counted if _exactness(row) is Exact.TO_TOLERANCE)
    reduced = [row for row in counted if _exactness(row) is Exact.NEVER]
    waves = _cheapest(row for row in counted if _exactness(row) is Exact.ON_FINE_GRIDS)
    if exact is None:
        return ""
    cheaper = [row for row in reduced if _is_cheaper(row, exact)]
    close = _cheapest(row for row in cheaper if _largest(row) <= CLOSE)
    if close is not None:
        return f"{close['model']} is cheaper than {exact['model']}, {_ratio(exact, close)} times, {_apart(close)}"
    if cheaper:
        best = min(cheaper, key=_largest)
        return (
            f"nothing cheaper than {exact['model']} is within {100.0 * CLOSE:g} %: the nearest is {best['model']}, "
            f"{_ratio(exact, best)} times cheaper, {_apart(best)}"
        )
    if reduced:
        certain = all(_is_cheaper(exact, row) for row in reduced)
        others = "cheaper than any reduction here and exact" if certain else "exact, and no reduction here is certainly cheaper"
        return f"{exact['model']} is {others}"
    if waves is not None and _is_cheaper(exact, waves):
        wave = f"the cheapest full wave here, {waves['model']}"
        return f"{exact['model']} is exact and {_ratio(waves, exact)} times cheaper than {wave}"
    return ""


def nothing(reference: Run) -> str:
    """Why no model can be compared with the `reference`, and which length suffices; empty if its cycles represent its motion."""
    if reference.failed or reference.verdict is None or reference.verdict.repeats:
        return ""
    model, longer = reference.solver.model, needed(reference.verdict, reference.solver.scene, one_port_of(reference.solver.model))
    run = f"the {'' if reference.kind == 'too short' else 'second half of the '}run of {model}"
    why = f"nothing to compare: {run} is {reference.kind}"
    return f"{why}; {longer_in_words(longer, reference.solver.scene)}" if math.isfinite(longer) else why


def distances(row: _Row) -> dict[str, tuple[float, float | None]]:
    """Name -> relative distance of the mean from the reference's, and its margin: 0 for errors, None if unknown; empty for a row
    without cycles."""
    margins = row.get("margin", {})
    return {
        name: (value, margins.get(name) if "difference" in row else 0.0)
        for name, value in row.get("difference", row["error"]).items()
        if value is not None
    }


def _exactness(row: _Row) -> Exact | None:
    family = family_of(row["model"])
    return family.exact if family is not None else None


def _is_cheaper(row: _Row, other: _Row) -> bool:
    """Whether the run of a row took certainly less time: by quartiles over rounds or, if timed once, a factor of `_CERTAIN`."""
    if "wall_high_s" in row:
        return bool(row["wall_high_s"] < other["wall_low_s"])
    return bool(_CERTAIN * row["wall_s"] <= other["wall_s"])


def _cheapest(rows: Iterable[_Row]) -> _Row | None:
    return min(rows, key=lambda row: float(row["wall_s"]), default=None)


def _ratio(costly: _Row, cheap: _Row) -> str:
    return f"{costly['wall_s'] / cheap['wall_s']:.2g}"


def _largest(row: _Row) -> float:
    """Upper bound of both distances, margins included."""
    return max(abs(value) + (margin or 0.0) for value, margin in distances(row).values())


def _apart(row: _Row) -> str:
    """Text on a model's distance from the reference."""
    parts = (f"{_share(abs(value), margin)} in the {name.replace('_', ' ')}" for name, (value, margin) in distances(row).items())
    return f"{'off by' if 'difference' in row else 'with errors of'} {' and '.join(parts)}"


def _share(value: float, margin: float | None) -> str:
    """In per cent, with the margin where there is one."""
    bar = "" if margin == 0.0 else f" +- {'?' if margin is None else f'{100.0 * margin:.2g}'}"
    return f"{100.0 * value:.2g}{bar} %"


class Comparison(Result):
    """Runs of the `scene`, which are compared with the `reference`: rows by `DIMENSION`."""

    DIMENSION: ClassVar[str]
    COMMAND: ClassVar[str]

    scene: Scene
    reference: Run
    options: Mapping[str, Any]

    @property
    @abstractmethod
    def rows(self) -> list[dict[str, Any]]:
        """One row per run: its figures and its distances from the reference."""

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`, with relative errors against the reference; where one of the motions never repeats they are None, and
        `difference` and `margin` are given instead."""
        facts = {"scene": self.scene.name, "until": self.reference.until}
        rows = finite(self.rows)
        facts |= {"reference": self.reference.solver.model, "conclusion": conclusion(rows), "models": rows}
        notes = [*doubts(self.scene), *filter(None, [nothing(self.reference)])]
        return facts | ({"notes": notes} if notes else {})

    @cached_property
    def dataset(self) -> Dataset:
        """The figures of each run: means, spreads, errors, run time."""
        data = table_of(self.summary["models"], self.DIMENSION, self.scene)
        models = dict.fromkeys(row["model"] for row in self.rows) if self.DIMENSION == "model" else [self.reference.solver.model]
        return data.assign_attrs(provenance(self.COMMAND, self.scene, ",".join(models), self.options))


def row_of(run: Run, figures: Mapping[str, Any], reference: Run) -> dict[str, Any]:
    """A row: model, `figures`, distances from the reference, and the failure, if any."""
    row = {"model": run.solver.model, "verdict": run.kind, **figures, **differences(run, reference)}
    row |= {"failures": run.solver.failures, "wall_s": run.wall_s}
    return row | ({"failed": run.failed} if run.failed else {})


def remarks(summary: _Row) -> list[str]:
    """The lines below a table of models: meaning of margins, missing figures with the reason, failures, conclusion."""
    rows = summary["models"]
    failed = {row["model"]: f"failed: {row['failed']}" for row in rows if "failed" in row}
    wanders = any("difference" in row for row in rows)
    bars = ["+-: half the width of the 95 % interval of a mean of motion that never repeats"] * wanders
    notes = (line for line in summary.get("notes", []) if line.startswith("nothing to compare"))
    return [*bars, *_without_errors(rows), *failed.values(), *notes, *filter(None, [summary["conclusion"]])]


def _without_errors(rows: Sequence[_Row]) -> list[str]:
    """One line for each verdict without period and errors (a transient has none), with its models."""
    models: dict[str, dict[str, None]] = {}
    for row in rows:
        if row["verdict"] not in (None, *REPEATING):
            models.setdefault(row["verdict"], {})[row["model"]] = None
    reasons = {
        "protocol": "a protocol is judged by its stages (slipwave run)",
        "steady": "it slides steadily in the second half of the run, without cycles",
    }
    return [
        f"no figures of {', '.join(names)}: {reasons.get(verdict, f'the second half of the run is {verdict}')}"
        for verdict, names in models.items()
    ]


def errors_of(row: _Row) -> list[str]:
    """The cells of a model's errors in period and stress drop, with margins where one of the motions never repeats."""
    known = distances(row)
    return [barred(*known[name]) if name in known else "-" for name in ("period", "stress_drop")]


def barred(value: float | None, margin: float | None, digits: int = 3) -> str:
    """A number for a table; with its margin, to two figures, where that is not 0, and as many decimals."""
    if value is None or margin == 0.0:
        return rounded(value, digits)
    if margin is None or not math.isfinite(margin):
        return f"{rounded(value, digits)} +- ?"
    decimals = max(0, 1 - math.floor(math.log10(margin)))
    return f"{value:.{decimals}f} +- {margin:.{decimals}f}"

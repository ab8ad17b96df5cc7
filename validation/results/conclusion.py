"""What a comparison of models comes to, in one line: computed from its rows."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from slipwave.family import Exact
from validation.registry.families import family_of, one_port_of
from validation.results.reasons import needed
from validation.run.simulate import Run

_Row = Mapping[str, Any]


CLOSE = 0.05
"""Relative distance in period and stress drop up to which a cheaper model is of use."""


def conclusion(rows: Sequence[_Row]) -> str:
    """Which model to use, by run time and distance in period and stress drop; empty if the rows cannot tell.

    `rows` are those of the JSON of `slipwave compare` and `bench`. Runs that failed and motions without cycles do not count.
    """
    counted = [row for row in rows if "failed" not in row and distances(row)]
    exact = _cheapest(row for row in counted if _exactness(row) is Exact.TO_TOLERANCE)
    reduced = [row for row in counted if _exactness(row) is Exact.NEVER]
    waves = _cheapest(row for row in counted if _exactness(row) is Exact.ON_FINE_GRIDS)
    if exact is None:
        return ""
    cheaper = [row for row in reduced if row["wall_s"] < exact["wall_s"]]
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
        return f"{exact['model']} is cheaper than any reduction here and exact"
    if waves is not None and waves["wall_s"] > exact["wall_s"]:
        wave = f"the cheapest full wave here, {waves['model']}"
        return f"{exact['model']} is exact and {_ratio(waves, exact)} times cheaper than {wave}"
    return ""


def nothing(reference: Run) -> str:
    """Why no model can be compared with the `reference`, and which length would do; empty if its cycles represent its motion."""
    if reference.failed or reference.verdict is None or reference.verdict.repeats:
        return ""
    model, longer = reference.solver.model, needed(reference, one_port_of(reference.solver.model))
    run = f"the {'' if reference.kind == 'too short' else 'second half of the '}run of {model}"
    why = f"nothing to compare: {run} is {reference.kind}"
    return f"{why}; try --until {float(f'{longer:.2g}'):g}" if math.isfinite(longer) else why


def distances(row: _Row) -> dict[str, tuple[float, float | None]]:
    """The relative distance of each mean from that of the reference with its margin: 0 for errors, None if it is unknown; none
    for a row without cycles."""
    margins = row.get("margin", {})
    return {
        name: (value, margins.get(name) if "difference" in row else 0.0)
        for name, value in row.get("difference", row["error"]).items()
        if value is not None
    }


def _exactness(row: _Row) -> Exact | None:
    family = family_of(row["model"])
    return family.exact if family is not None else None


def _cheapest(rows: Iterable[_Row]) -> _Row | None:
    return min(rows, key=lambda row: float(row["wall_s"]), default=None)


def _ratio(costly: _Row, cheap: _Row) -> str:
    return f"{costly['wall_s'] / cheap['wall_s']:.2g}"


def _largest(row: _Row) -> float:
    """The larger of both distances, margins included: what it may be."""
    return max(abs(value) + (margin or 0.0) for value, margin in distances(row).values())


def _apart(row: _Row) -> str:
    """What is known of a model's distance from the reference."""
    parts = (f"{_share(abs(value), margin)} in the {name.replace('_', ' ')}" for name, (value, margin) in distances(row).items())
    return f"{'off by' if 'difference' in row else 'with errors of'} {' and '.join(parts)}"


def _share(value: float, margin: float | None) -> str:
    """In per cent, with the margin where there is one."""
    bar = "" if margin == 0.0 else f" +- {'?' if margin is None else f'{100.0 * margin:.2g}'}"
    return f"{100.0 * value:.2g}{bar} %"

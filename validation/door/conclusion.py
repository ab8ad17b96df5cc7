"""What a comparison of models comes to, in one line: computed from its rows."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from slipwave.family import Exact
from validation.registry.families import family_of

_Row = Mapping[str, Any]


def conclusion(rows: Sequence[_Row]) -> str:
    """Which model to use, by run time and error of the period; empty if the rows cannot tell.

    `rows` are those of the JSON of `slipwave compare` and `bench`. Runs that failed and motions without cycles do not count.
    """
    counted = [row for row in rows if "failed" not in row and (row["error"]["period"] is not None or "difference" in row)]
    exact = _cheapest(row for row in counted if _exactness(row) is Exact.TO_TOLERANCE)
    reduced = [row for row in counted if _exactness(row) is Exact.NEVER]
    waves = _cheapest(row for row in counted if _exactness(row) is Exact.ON_FINE_GRIDS)
    if exact is None:
        return ""
    cheaper = _cheapest(row for row in reduced if row["wall_s"] < exact["wall_s"])
    if cheaper is not None:
        return f"{cheaper['model']} is cheaper than {exact['model']}, {_ratio(exact, cheaper)} times, {_error(cheaper)}"
    if reduced:
        return f"{exact['model']} is cheaper than any reduction here and exact"
    if waves is not None and waves["wall_s"] > exact["wall_s"]:
        wave = f"the cheapest full wave here, {waves['model']}"
        return f"{exact['model']} is exact and {_ratio(waves, exact)} times cheaper than {wave}"
    return ""


def _exactness(row: _Row) -> Exact | None:
    family = family_of(row["model"])
    return family.exact if family is not None else None


def _cheapest(rows: Iterable[_Row]) -> _Row | None:
    return min(rows, key=lambda row: float(row["wall_s"]), default=None)


def _ratio(costly: _Row, cheap: _Row) -> str:
    return f"{costly['wall_s'] / cheap['wall_s']:.2g}"


def _error(row: _Row) -> str:
    """What is known of a model's distance from the reference."""
    error = row["error"]["period"]
    if error is not None:
        return f"with an error of {abs(error):.1e} in the period"
    margin = row["margin"]["period"]
    return (
        f"and its mean period differs by {row['difference']['period']:+.1e} +- {'unknown' if margin is None else f'{margin:.1e}'}"
    )

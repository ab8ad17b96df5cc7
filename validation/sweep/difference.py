"""Differences of models over a map: of the regime, and of period and stress drop."""

from typing import Any

import numpy as np

from slipwave.errors import SceneError
from validation.data.datasets import Dataset, flag_numbers
from validation.sweep.measures import VERDICTS

_KINDS = {"steady": 0, "decaying": 0, "periodic": 1, "torus": 2, "irregular": 3, "growing": 4}
"""Verdict -> regime; points with other, undecided verdicts are not compared."""

_COMPARED = ("period", "stress_drop")


def decided_regimes(verdict: Any) -> Any:
    """Convert the numbers of verdicts to numbers of regimes, -1 if undecided. Steady sliding and the return to it are one
    regime."""
    numbers = np.array([_KINDS.get(word, -1) for word in VERDICTS] + [-1])
    return numbers[np.asarray(verdict, dtype=int)]


def difference(data: Dataset, reference: str) -> Dataset:
    """`other_regime` (1 where it differs from the `reference`, 0 where not, NaN where one of both is not decided), and relative
    differences of period and stress drop where both are periodic, for every other model of a sweep of verdicts.

    Raises SceneError for a sweep of one model, without that model, or of another measure."""
    names = [str(name) for name in np.atleast_1d(data["model"].values)]
    if reference not in names or len(names) < 2:
        raise SceneError(f"--against = {reference!r}: must be one of at least two models of the sweep, {', '.join(names)}")
    if "verdict" not in data:
        raise SceneError("--against: needs a sweep with verdicts (--measure verdict, run or lyapunov)")
    ours, others = data.sel(model=reference), data.sel(model=[name for name in names if name != reference])
    here, there = (decided_regimes(flag_numbers(one["verdict"])) for one in (ours, others))
    decided = (here >= 0) & (there >= 0)
    differences = others[["verdict"]].rename(verdict="other_regime")
    differences["other_regime"] = others["verdict"].copy(data=np.where(decided, here != there, np.nan))
    differences["other_regime"].attrs = {"long_name": f"regime differs from that of {reference}", "units": "1"}
    both = (here == _KINDS["periodic"]) & (there == _KINDS["periodic"])
    for name in _COMPARED:
        differences[name] = others[name] / ours[name] - 1.0
        differences[name].values[~both] = np.nan
        differences[name].attrs = {"long_name": f"relative difference of {name.replace('_', ' ')} from {reference}", "units": "1"}
    return differences


def difference_rows(differences: Dataset) -> list[dict[str, Any]]:
    """The differences that were `differences`, for each model: per cent of the decided area with another regime, per cent that is
    decided, and the largest relative difference of each figure."""
    return [{"model": str(name), **_row(differences.sel(model=name))} for name in differences["model"].values]


def _row(one: Dataset) -> dict[str, float]:
    other, decided = one["other_regime"].values, np.isfinite(one["other_regime"].values)
    percent = {"other_regime_percent": other[decided].mean() if decided.any() else np.nan, "compared_percent": decided.mean()}
    largest = {name: _largest(one[name].values) for name in _COMPARED}
    return {name: 100.0 * float(share) for name, share in percent.items()} | largest


def _largest(values: Any) -> float:
    """The value of largest modulus, with its sign; NaN if there is none."""
    there = values[np.isfinite(values)]
    return float(there[np.argmax(np.abs(there))]) if there.size else np.nan

"""Nonlinear least squares with an interval for each parameter, and whether the data determine it."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from scipy import optimize, stats

from slipwave.errors import NumericsError, SceneError
from slipwave.files import going_on, require_writable, whole_or_absent
from slipwave.input.wording import sentence
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import autocorrelations
from validation.models.progress import News

CONFIDENCE = 0.95
_SINGULAR = 1e-9  # of the largest singular value of the scaled derivative
_NAMED = 0.2  # share of a direction from which on a parameter is named in it
_MOST, _EXPLORING = 60, 6  # steps of a descent, and of one that explores
_LAST = 400  # steps of the last descent, to the minimum: along a narrow, bent valley it takes hundreds
_FAR = 1.5  # times the noise: a residual from which on other starts are tried
_PROFILE = 5  # trials for the end of an interval
_ALIKE = 0.1  # relative difference from the derivative's interval that is let stand
_INDEPENDENT = 20  # groups of samples that are taken as independent at least
_AT_BOUND = 1e-6  # of the range
_SHOWN = 3  # differences of two fits
_ABOVE = 0.04  # of the square of a standard error


class Problem(Protocol):
    """Residuals over parameters."""

    names: list[str]
    low: Array
    high: Array
    large: Array
    """Half width of an interval beyond which a parameter counts as undetermined; NaN: its value."""

    fineness: float
    """Relative change of the sum of squares, and of the parameters, below which a descent ends."""

    def residual(self, inner: Array) -> Array:
        """Residual (n,). Raises NumericsError where it cannot be computed."""

    def slopes(self, inner: Array) -> Array:
        """Derivative of the residual (n, m)."""


class Solution(NamedTuple):
    """Best `inner` values with their `residual` (n,) and its derivative `slopes` (n, m); `evaluations`; `failed`: why this is no
    minimum, or empty."""

    inner: Array
    residual: Array
    slopes: Array
    evaluations: int
    failed: str

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


@dataclass
class BestValues:
    """The best values so far, available after an interruption; tells the `news`. `file`: the checkpoint that keeps them with the
    `facts` of their fit, from which a killed fit continues. `also` is called with all values and residuals."""

    inner: Array
    cost: float = math.inf
    evaluations: int = 0
    news: News = field(default_factory=News)
    file: Path | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    also: Callable[[Array, Array], object] | None = None

    @classmethod
    def kept(cls, file: Path | None, first: Array, facts: Mapping[str, Any]) -> Self:
        """The best values in the checkpoint `file`, `first` if there is none. Raises SceneError for a file that cannot be
        written, is damaged, or belongs to another fit, naming the differences."""
        if file is not None:
            require_writable(file, (".json",), "--checkpoint")
        if file is None or not file.exists():
            return cls(first, file=file, facts=facts)
        try:
            known = json.loads(file.read_text(encoding="utf-8"))
            there, inner, evaluations = dict(known["facts"]), np.array(known["best"], dtype=float), int(known["evaluations"])
        except (OSError, ValueError, LookupError, TypeError):
            raise SceneError(f"--checkpoint = {str(file)!r}: is no checkpoint of a fit; remove it, or name another") from None
        other = [key for key in {**there, **facts} if there.get(key) != facts.get(key)]
        if other or inner.shape != first.shape:
            differences = "; ".join(
                f"{key}: {sentence(str(there.get(key, 'not there')))}, now {sentence(facts.get(key, 'not there'))}"
                for key in other[:_SHOWN]
            )
            raise SceneError(f"--checkpoint = {str(file)!r}: belongs to another fit ({differences}); remove it, or name another")
        return cls(inner, evaluations=evaluations, file=file, facts=facts)

    def see(self, inner: Array, residual: Array) -> None:
        """Store these values if they are better."""
        self.evaluations += 1
        cost = float(residual @ residual)
        if cost < self.cost:
            self.inner, self.cost = inner.copy(), cost
            if self.file is not None:
                known = {"facts": self.facts, "best": [*inner], "cost": cost, "evaluations": self.evaluations}
                with going_on(), whole_or_absent(self.file) as temporary:
                    temporary.write_text(json.dumps(known, indent=1), encoding="utf-8")
        far = math.sqrt(self.cost / residual.size)
        self.news("fit: %d evaluations, the best residual is %.3g times the noise", self.evaluations, far)
        if self.also is not None:
            self.also(inner, residual)


def minimise(problem: Problem, starts: Iterable[Array], best: BestValues) -> Solution:
    """The lowest minimum from several `starts`: descend from the first and, if its residual is far above the noise, take a few
    steps from each other start and descend from the best of these. Raises NumericsError if no start can be computed."""
    tried: list[tuple[optimize.OptimizeResult, list[str]]] = []
    reasons: list[str] = []
    for start in starts:
        try:
            tried.append(_descend(problem, start, best, _EXPLORING if tried else _MOST))
        except (NumericsError, SceneError) as error:
            reasons.append(str(error))
            continue
        if np.sqrt(np.mean(tried[-1][0].fun ** 2)) < _FAR:
            break
    if not tried:
        raise NumericsError(f"fit: no start value can be computed: {reasons[0]}")
    lowest = min(tried, key=lambda descent: descent[0].cost)
    if lowest[0].status == 0:
        with suppress(NumericsError, SceneError):  # it may come where nothing can be computed: this was no minimum either
            lowest = _descend(problem, lowest[0].x, best, _LAST)
    (end, refusals), failed = lowest, ""
    if end.status == 0:
        failed = f"no minimum after {best.evaluations} evaluations"
    elif refusals and _is_above(end):
        failed = f"cannot be computed beside these values, which are no minimum ({refusals[-1]})"
    return Solution(end.x, end.fun, end.jac, best.evaluations, failed)


def _is_above(end: optimize.OptimizeResult) -> bool:
    """Whether a linear step lowers the sum of squares by more than a fifth of a standard error does: what ended the descent was
    no minimum."""
    free = end.jac[:, end.active_mask == 0]
    scaled = free / np.maximum(np.linalg.norm(free, axis=0), 1e-300)
    gained = scaled @ np.linalg.lstsq(scaled, end.fun, rcond=_SINGULAR)[0]
    return bool(gained @ gained > _ABOVE * (end.fun @ end.fun) / end.fun.size)


def _descend(problem: Problem, start: Array, best: BestValues, most: int) -> tuple[optimize.OptimizeResult, list[str]]:
    """Descend from one start: the end, and why steps on the way could not be computed, which are shortened. NumericsError if the
    residual of the start cannot be computed."""
    inside = np.clip(start, problem.low, problem.high)
    samples, refusals = problem.residual(inside).size, list[str]()

    def residual(inner: Array) -> Array:
        try:
            misfit = problem.residual(inner)
        except (NumericsError, SceneError) as error:
            refusals.append(str(error))
            misfit = np.full(samples, np.nan)
        best.see(inner, misfit)
        return misfit

    bounds = (problem.low, problem.high)
    near: dict[str, Any] = {"ftol": problem.fineness, "xtol": problem.fineness, "gtol": None, "x_scale": "jac", "max_nfev": most}
    with np.errstate(divide="ignore", invalid="ignore"):  # in its steps where the data say nothing of a parameter
        return optimize.least_squares(residual, inside, problem.slopes, bounds, **near), refusals


def profiled(problem: Problem, solution: Solution, spread: "Intervals") -> "Intervals":
    """The intervals, corrected where the sum of squares does not rise along one as the derivative predicts: there each end is at
    the predicted rise with all other parameters at their best values (profile)."""
    low, high, notes = spread.low.copy(), spread.high.copy(), []
    for k in np.flatnonzero(np.isfinite(spread.high) & spread.determined):
        half = spread.high[k] - solution.inner[k]
        way = spread.covariance[k] / spread.covariance[k, k]
        ends = [_crossing(problem, solution, sign * half * way, int(k), spread.rise) for sign in (-1.0, 1.0)]
        if any(end != 1.0 for end in ends):
            low[k], high[k] = solution.inner[k] - ends[0] * half, solution.inner[k] + ends[1] * half
            notes.append(problem.names[k])
    return spread._replace(low=low, high=high, profiled=tuple(notes))


def _crossing(problem: Problem, solution: Solution, way: Array, k: int, rise: float) -> float:
    """Share of the step `way` from the minimum at which the sum of squares has risen by `rise`; 1 if nearly so."""
    share, inner = 1.0, solution.inner + way
    for trial in range(_PROFILE):
        if not ((inner > problem.low) & (inner < problem.high)).all():
            return share
        try:
            inner = inner if trial == 0 else _others_best(problem, inner, k)
            risen = float(np.sum(problem.residual(inner) ** 2)) - solution.cost
        except (NumericsError, SceneError):
            return share
        ratio = math.sqrt(max(risen, 1e-4 * rise) / rise)
        if abs(ratio - 1.0) < (_ALIKE if trial == 0 else 0.2 * _ALIKE):
            return share
        if trial > 0:  # before, the others are only predicted: in a bent valley that is no bound of the rise
            longer = share * (min(max(1.0 / ratio, 0.5), 2.0) - 1.0)
            share, inner = share + longer, inner + longer * way  # all move: by one alone they would leave the valley
    return share


def _others_best(problem: Problem, inner: Array, k: int) -> Array:
    """The best values of all parameters but the k-th. Raises NumericsError if they are not found."""
    free = np.arange(inner.size) != k
    if not free.any():
        return inner

    def whole(part: Array) -> Array:
        filled = inner.copy()
        filled[free] = part
        return filled

    def slopes(part: Array) -> Array:
        return problem.slopes(whole(part))[:, free]

    def residual(part: Array) -> Array:
        return problem.residual(whole(part))

    bounds = (problem.low[free], problem.high[free])
    with np.errstate(divide="ignore", invalid="ignore"):  # as in `_descend`
        best = optimize.least_squares(residual, inner[free], slopes, bounds, x_scale="jac", max_nfev=_MOST)
    if best.status == 0:
        raise NumericsError(f"no minimum over the others after {best.nfev} evaluations")
    return whole(best.x)


class Intervals(NamedTuple):
    """Per parameter: half width of the interval of `CONFIDENCE` in `inner` values, `low` and `high`, whether it is `determined`;
    their `correlation`; the standard deviation of the `noise`, the number of samples that fluctuate `together`, and texts of
    `singular` directions; `covariance` for a noise of 1, the `rise` of the sum of squares at the ends, and the parameters whose
    ends are `profiled`."""

    low: Array
    high: Array
    determined: "np.ndarray[tuple[int], np.dtype[np.bool_]]"
    correlation: Array
    noise: float
    together: float
    singular: tuple[str, ...]
    covariance: Array
    rise: float
    profiled: tuple[str, ...] = ()


def intervals(problem: Problem, solution: Solution) -> Intervals:
    """Intervals from the derivative: t quantile times standard errors, which are wider for correlated residuals."""
    n, m = solution.slopes.shape
    degrees = max(n - m, 1)
    noise = math.sqrt(solution.cost / degrees)
    together = _correlated_samples(solution.residual)
    lengths = np.linalg.norm(solution.slopes, axis=0)
    scaled = solution.slopes / np.where(lengths > 0.0, lengths, 1.0)
    _, values, directions = np.linalg.svd(scaled, full_matrices=False)
    weak = values <= _SINGULAR * values[0]
    singular = [  # parameters that can change together without any effect
        " with ".join(name for name, share in zip(problem.names, row, strict=True) if abs(share) > _NAMED)
        for row in directions[weak]
    ]
    singular += [name for name, length in zip(problem.names, lengths, strict=True) if length == 0.0]
    kept = directions[~weak]
    covariance = (kept.T / values[~weak] ** 2) @ kept / np.outer(*[np.where(lengths > 0.0, lengths, 1.0)] * 2)
    spread = np.sqrt(np.diag(covariance))
    undecided = (np.abs(directions[weak]) > _NAMED).any(axis=0) | (lengths == 0.0)
    error = noise * math.sqrt(together) * np.where(undecided, math.inf, spread)
    quantile = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, max(degrees / together, 1.0)))
    half, rise = quantile * error, quantile**2 * noise**2 * together
    size = np.where(np.isnan(problem.large), np.maximum(np.abs(solution.inner), 1e-300), problem.large)
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = covariance / np.outer(spread, spread)
    known, low, high = half < size, solution.inner - half, solution.inner + half
    return Intervals(low, high, known, correlation, noise, together, tuple(dict.fromkeys(singular)), covariance, rise)


def _correlated_samples(residual: Array) -> float:
    """Number of neighbouring samples that fluctuate together: 1 + 2 times the sum of the autocorrelations that are significant
    against white noise, for which it is 1."""
    n = residual.size
    if n < 50 or not residual.any():
        return 1.0
    correlation = autocorrelations(residual)[1 : n // _INDEPENDENT]
    noise = correlation < 3.0 / math.sqrt(n)
    return min(1.0 + 2.0 * float(correlation[: noise.argmax() if noise.any() else None].sum()), n / _INDEPENDENT)


def at_bounds(problem: Problem, inner: Array) -> list[str]:
    """Names of the parameters that end at a bound."""
    margin = _AT_BOUND * (problem.high - problem.low)
    ends = (inner - problem.low < margin) | (problem.high - inner < margin)
    finite = np.isfinite(problem.low) & np.isfinite(problem.high)
    return [name for name, end, known in zip(problem.names, ends, finite, strict=True) if end and known]

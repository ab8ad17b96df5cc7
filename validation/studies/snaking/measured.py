"""Direct runs of the delay system near its branch: where they settle or wander, and the multipliers measured in them; and the
claims on the snake of folds.

Each run near a special point begins near an orbit on one side of it, displaced in the direction of the critical multiplier, which
is measured by how the run departs or returns.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import slipwave as sw
from reduced.continuation.point import OrbitPoint
from reduced.continuation.special import Special, critical
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, floquet
from reduced.orbit.periodic import figures_of
from slipwave.observe import HistoryObserver
from slipwave.observe.statistics import Estimate
from slipwave.solve import follow
from validation.measure import memo
from validation.measure.over_r import COMPARED, Branch, scene_at
from validation.models.build import build
from validation.models.orbit_start import BEGIN, state_on
from validation.references.published import reference
from validation.report import ASYMPTOTIC, PROGRAM, SELF, WITNESS, Cell, Table, Verdict, claim, every, holding, table
from validation.report.text import minus, plain

_MOST = 9000.0
_LAST = 0.7  # share of a run after which its cycles are judged
_TORUS = 16000.0
_CYCLES, _SAMPLES = 4, 300  # of a run near a special point; samples of a cycle
_OFF = 1e-6  # largest component of the state by which such a run is off its orbit
_REAL = 1e-9  # imaginary part below which a multiplier is real

_MESHES = 1e-10
_ONE = 0.2  # distance from 1 of the last growth of T
_SAME = 2e-9  # the rest of the run
_ROTATION = 5e-4
_PASSES = 4e-6
_WANDERS = 1e-2  # transits, on both sides of the unstable orbit's period


class DirectRun(NamedTuple):
    """A run from a nudge of this `size`: the periods of the cycles of its last part (transits), whether they settled, and the
    period of the branch's `orbit` nearest to its last cycle, of the stable ones if there are any."""

    log10_r: float
    size: float
    last: np.ndarray
    settled: bool
    orbit: float


class FoldSide(NamedTuple):
    """An orbit beside a special point, at `log10_r`: its critical multiplier, of the `orbit` and as `seen` in runs."""

    log10_r: float
    orbit: complex
    seen: complex

    @property
    def apart(self) -> float:
        """Relative difference of both multipliers."""
        return abs(self.seen / self.orbit - 1.0)


def run_at(log10_r: float, size: float, orbits: Sequence[Closed]) -> DirectRun:
    """A run of the delay system until its cycles stop changing, 9000 transits at most; `orbits`: those of the branch there."""
    scene = scene_at(log10_r)
    found = memo.settled("delay", replace(scene, start=replace(scene.start, size=size)), 1e-10, 1e-8, _MOST)
    last = found.observer.events(_LAST * found.transits).period
    known = [one.cycle.period for one in orbits if count_unstable(one) == 0] or [one.cycle.period for one in orbits]
    return DirectRun(log10_r, size, last, found.settled, min(known, key=lambda period: abs(period - last[-1])))


def torus_at(log10_r: float) -> tuple[float, Estimate]:
    """The rotation number of the delay system's run at `log10_r`, and its mean period (transits) with its margin."""
    run = sw.run(sw.read("paper", {"slab.log10_r": log10_r}), model="delay", until=_TORUS, tol=1e-8).summary
    return run["rotation_number"] or math.nan, Estimate(run["period"]["mean"], run["margins"]["period"])


def _multiplier_seen(apart: np.ndarray, turns: bool) -> complex:
    """The multiplier m of the distance `apart` (cycles, values) of two runs, by least squares: d_(n+1) = m d_n or, if it `turns`,
    the one above the real axis of d_(n+2) = 2 Re(m) d_(n+1) - |m|^2 d_n."""
    first, second, third = (apart[k : apart.shape[0] + k - turns - 1].ravel() for k in (0, 1, 1 + turns))
    if not turns:
        return complex(second @ first / (first @ first))
    twice, square = np.linalg.lstsq(np.column_stack([second, -first]), third, rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(max(square - 0.25 * twice**2, 0.0)))


def sides(branch: Branch, first: int = 0, every: int = 1) -> list[FoldSide]:
    """The points of the delay branch before and beyond its special points, from the `first` special point on with stride
    `every`."""
    number = {id(point): n for n, point in enumerate(branch.points)}
    return [
        _side(branch.points[number[id(special.point)] + beside], special.kind)
        for special in branch.special[first::every]
        for beside in (-1, 1)
    ]


def _side(point: OrbitPoint, kind: str) -> FoldSide:
    closed = point.closed
    passing, direction = _passing(closed, kind)
    apart = _cycles(closed, _OFF * direction) - _cycles(closed, -_OFF * direction)
    return FoldSide(point.parameter, passing, _multiplier_seen(apart, abs(passing.imag) > _REAL))


def _passing(closed: Closed, kind: str) -> tuple[complex, np.ndarray]:
    """The critical multiplier at a point of `kind`, and the real part of its eigenvector, with 1 as the largest component."""
    values, vectors = np.linalg.eig(closed.monodromy)
    others = np.delete(values, np.abs(values - 1.0).argmin())
    passing = critical(kind, others.astype(complex))
    vector = vectors[:, np.abs(values - passing).argmin()].real
    return passing, vector / np.abs(vector).max()


def _cycles(closed: Closed, change: np.ndarray) -> np.ndarray:
    """z and psi (cycles, 2 samples) in the cycles of a run that begins on the orbit displaced by a `change` of its state."""
    cycle, period = closed.flow.march(closed.cycle.start + change, closed.cycle.period), closed.cycle.period
    solver = build("delay", closed.flow.scene, tolerance=1e-11)
    solver.restore(state_on(solver, replace(closed, cycle=cycle)))
    history = HistoryObserver(solver.scene.law, solver.nodes)
    times = BEGIN + 1.0 + np.linspace(0.0, period, _SAMPLES, endpoint=False)
    follow(solver, float(times[-1]) + _CYCLES * period, [history])
    return np.array([history.at(times + n * period)[1:3].ravel() for n in range(_CYCLES + 1)])


def fold_pairs(branch: Branch) -> list[tuple[Special, Special]]:
    """Pairs of folds after the first: where the branch turns to smaller r, and where it turns back."""
    folds = branch.of_kind("LP")[1:]
    return list(zip(folds[::2], folds[1::2], strict=False))


def fold_claims(branch: Branch, finer: Branch) -> Iterator[Verdict]:
    """Verdicts: the special points agree with those on a finer mesh with shorter steps; the growth of T from pair to pair of
    folds."""
    title = "Special points depend neither on the mesh nor on the length of steps"
    both = list(zip(branch.special, finer.special, strict=False))
    off = max(abs(one.point.parameter - other.point.parameter) for one, other in both)
    sizes = " and ".join(str(one.point.closed.flow.size) for one in both[-1])
    mesh = f"mesh: largest change of log_{{10}} r of {len(both)} points, states of {sizes} values at the last one"
    yield claim(title, SELF, off, _MESHES, mesh)
    kinds, others = ([one.kind for one in some.special[: len(both)]] for some in (branch, finer))
    last = finer.points[-1].closed.cycle.period
    beyond, found = sum(one.point.closed.cycle.period < last for one in branch.special), len(finer.special)
    up_to = f"steps of half the length: special points up to T = {last:.1f} transits"
    verdict = holding(title, SELF, f"{beyond} points", f"{found} points", kinds == others and beyond == found, up_to)
    yield verdict.with_margin(abs(found - beyond), 1.0)
    growth = np.diff([turn.point.closed.cycle.period for turn, _ in fold_pairs(branch)]).tolist()
    yield claim(
        "Folds come in pairs, and T grows by one transit from pair to pair: each pair lets one more ripple into the cycle",
        ASYMPTOTIC,
        growth[-1],
        _ONE,
        f"T grows by {', '.join(f'{one:.3f}' for one in growth)}; the last is judged",
        near=1.0,
    )


def coexisting_table(found: dict[float, list[Closed]]) -> Table:
    """Figures and largest multiplier of the orbits of the branch, by log10 r."""
    rows: list[tuple[Cell, ...]] = []
    for log10_r, orbits in found.items():
        for closed in orbits:
            lead, figures = floquet(closed.monodromy)[0][0], figures_of(closed)
            words = plain(lead.real, ".4f") + (f" ± {plain(abs(lead.imag), '.4f')} i" if lead.imag else "")
            rows.append((log10_r, *(figures[name] for name in COMPARED), float(count_unstable(closed)), words))
    heading = "log_{10} r .2f | T [transits] .7f | Δμ [σ] .7f | Δy [σ] .7f | unstable .0f | largest multiplier"
    caption = "Orbits of the branch that coexist at one r; unstable: multipliers outside the unit circle."
    return table("coexisting", caption, heading, rows)


def settles(runs: Iterable[DirectRun]) -> Iterator[Verdict]:
    """Runs before the torus point against the orbits of the branch."""
    title = "Before the first torus point direct runs settle on orbits of the branch"
    for run in runs:
        ratio = float(run.last[-1]) / run.orbit if run.settled else math.nan
        remark = minus(f"log_{{10}} r = {run.log10_r:g}, nudge {run.size:g}: T of the run over that of the orbit")
        yield claim(title, WITNESS, ratio, _SAME, remark, near=1.0)


def wanders(run: DirectRun) -> Verdict:
    """A run beyond the torus point."""
    low, high = float(run.last.min()), float(run.last.max())
    apart = min(run.orbit - low, high - run.orbit)
    return holding(
        "Beyond the first torus point a direct run does not settle, and its periods lie on both sides of the unstable orbit’s",
        WITNESS,
        f"around {run.orbit:.4f}",
        f"{low:.3f} to {high:.3f}",
        not run.settled and apart > _WANDERS,
        minus(f"log_{{10}} r = {run.log10_r:g}, T in transits; at least {_WANDERS:g} apart"),
    ).with_margin(_WANDERS / apart if apart > 0.0 else math.inf, 1.0)


def grows(beside: Sequence[FoldSide]) -> Verdict:
    """Direct runs on both sides of special points."""
    apart = max(side.apart for side in beside)
    title = "On both sides of special points, direct runs depart or come back by the multiplier that passes there"
    return claim(title, WITNESS, apart, _PASSES, f"largest relative difference, {len(beside)} sides")


def coexisting(runs: Sequence[DirectRun]) -> Iterator[Verdict]:
    """Runs from different nudges at one r."""
    title = "Two stable orbits coexist at one r: the size of the nudge decides on which a run settles"
    for log10_r in dict.fromkeys(run.log10_r for run in runs):
        periods = {run.size: run.orbit for run in runs if run.log10_r == log10_r}
        listed = ", ".join(f"{period:.4f} from {size:g}" for size, period in periods.items())
        count = len({round(period, 6) for period in periods.values()})
        yield every(title, WITNESS, count, 2, minus(f"log_{{10}} r = {log10_r:g}: T {listed}"), "orbits")


def on_torus(rotation: float, period: Estimate) -> Iterator[Verdict]:
    """A long run beyond the first torus point, against the independent program's."""
    title = "A run on the torus has the rotation number and the mean period that another program finds"
    known = reference()["torus"]
    where = minus(f"log_{{10}} r = {known['log10_r']:g}")
    yield claim(title, PROGRAM, rotation, _ROTATION, f"rotation number, {where}", near=known["rotation_number"])
    yield claim(title, PROGRAM, period.value, period.error, f"mean T with its margin, {where}", near=known["mean_period"])

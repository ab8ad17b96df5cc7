"""What the snake must show: the same points on two meshes, folds once per transit, runs that do what the multipliers say."""

from collections.abc import Iterable, Mapping

import numpy as np

from reduced.continuation.special import Special
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import floquet
from validation.references.published import reference
from validation.studies.snaking.beside import Side
from validation.studies.snaking.runs import Attractor, Run, Torus, multiplier_of
from validation.studies.snaking.shown import fold_pairs
from validation.study import Evidence, Verdict, judge
from validation.study.bounds import bounded
from validation.study.over_r import Branch

_MESHES = 1e-8  # 5e-10 was measured
_ONE = 0.2  # distance from 1 of the last growth of T: 0.03 was measured on the quick branch, 0.008 on the full one
_SAME = 4e-9  # 1.5e-10 was measured, the rest of the run
_PAIR = 1e-3  # 1e-4 was measured
_ATTRACTED = 2e-9  # 9e-11 was measured
_REAPPEARS = 1e-10  # 6e-12 was measured
_ROTATION = 5e-4  # 6e-5 was measured
_PASSES = 1e-4  # 7e-6 was measured
_RANGE = 5e-3  # transits; 9e-4 was measured


def meshes(branch: Branch, finer: Branch) -> tuple[Verdict, Verdict]:
    """The special points of the branch that a finer mesh and shorter steps find."""
    both = list(zip(branch.special, finer.special, strict=False))
    off = max(abs(one.point.parameter - other.point.parameter) for one, other in both)
    sizes = " and ".join(str(one.point.closed.flow.size) for one in both[-1])
    kinds = [[one.kind for one in some.special[: len(both)]] for some in (branch, finer)]
    beyond = sum(one.point.closed.cycle.period < finer.points[-1].closed.cycle.period for one in branch.special)
    return (
        bounded(
            "Special points do not depend on the mesh",
            Evidence.SELF,
            off,
            _MESHES,
            f"largest change of log_{{10}} r of {len(both)} points, states of {sizes} values at the last one",
        ),
        Verdict(
            "Steps of half the length find no other special points",
            Evidence.SELF,
            f"{beyond} points",
            f"{len(finer.special)} points",
            judge(kinds[0] == kinds[1] and beyond == len(finer.special)),
            f"up to T = {finer.points[-1].closed.cycle.period:.1f} transits",
        ),
    )


def once_per_transit(branch: Branch) -> Verdict:
    """The growth of T from one pair of folds to the next."""
    periods = np.array([turn.point.closed.cycle.period for turn, _ in fold_pairs(branch)])
    growth = np.diff(periods)
    return bounded(
        "Folds come in pairs, and T grows by one transit from pair to pair: each pair lets one more ripple into the cycle",
        Evidence.ASYMPTOTIC,
        abs(float(growth[-1]) - 1.0),
        _ONE,
        "distance of the last growth of T from 1",
        f"T grows by {', '.join(f'{one:.3f}' for one in growth)}",
    )


def settles(run: Run, orbit: Closed) -> tuple[Verdict, Verdict]:
    """A run before the torus point against the orbit of the branch, and its approach against the multipliers."""
    period = orbit.cycle.period
    lead, seen = complex(floquet(orbit.monodromy)[0][0]), multiplier_of(run, period)
    lead = complex(lead.real, abs(lead.imag))
    at = f"log_{{10}} r = {run.log10_r:g}".replace("-", "−")
    return (
        bounded(
            "Before the first torus point a direct run settles on the branch",
            Evidence.WITNESS,
            abs(float(run.last[-1]) / period - 1.0) if run.settled else float("nan"),
            _SAME,
            f"relative difference of T, {at}",
        ),
        bounded(
            "A run settles as fast, and with the rotation, that the multipliers say",
            Evidence.WITNESS,
            abs(seen - lead),
            _PAIR,
            f"{at}: {_told(seen)} from the periods of a run, {_told(lead)} from the orbit’s linearised motion",
        ),
    )


def wanders(run: Run, orbit: Closed) -> Verdict:
    """A run beyond the torus point."""
    low, high = float(run.last.min()), float(run.last.max())
    return Verdict(
        "Beyond the first torus point a direct run does not settle, and its periods lie on both sides of the unstable orbit’s",
        Evidence.WITNESS,
        f"around {orbit.cycle.period:.4f}",
        f"{low:.3f} to {high:.3f}",
        judge(not run.settled and low < orbit.cycle.period < high and high - low > 1e-3),
        f"log_{{10}} r = {run.log10_r:g}, T in transits".replace("-", "−"),
    )


def grows(both: Iterable[tuple[Special, Side, Side]]) -> tuple[Verdict, Verdict]:
    """Direct runs on both sides of special points."""
    listed = list(both)
    apart = max(side.apart for _, *sides in listed for side in sides)
    counted = sum(
        (abs(beyond.seen) > 1.0 > abs(before.seen))
        if one.unstable_after > one.unstable_before
        else abs(beyond.seen) < 1.0 < abs(before.seen)
        for one, before, beyond in listed
    )
    return (
        bounded(
            "On both sides of special points, direct runs depart or come back by the multiplier that passes there",
            Evidence.WITNESS,
            apart,
            _PASSES,
            f"largest relative difference, {2 * len(listed)} sides",
        ),
        Verdict(
            "Runs begin to depart where the count of unstable multipliers grows, and to come back where it falls",
            Evidence.WITNESS,
            f"{len(listed)} points",
            f"{counted} points",
            judge(counted == len(listed)),
            "signs of ln |m| before and beyond, as runs show it",
        ),
    )


def coexisting(attractors: Iterable[Attractor]) -> tuple[Verdict, Verdict]:
    """Runs from different nudges at one r."""
    listed = list(attractors)
    ends = {log10_r: {round(one.orbit, 6) for one in listed if one.run.log10_r == log10_r} for log10_r in _places(listed)}
    return (
        bounded(
            "Runs from a small and from a large nudge settle on orbits of the branch",
            Evidence.WITNESS,
            float(np.max([one.apart for one in listed])),
            _ATTRACTED,
            f"relative difference of T, {len(listed)} runs at {len(ends)} r",
        ),
        Verdict(
            "Two stable orbits coexist at one r, and each attracts runs",
            Evidence.WITNESS,
            "two at each r",
            ", ".join(f"{len(found)} at {log10_r:g}".replace("-", "−") for log10_r, found in ends.items()),
            judge(all(len(found) == 2 for found in ends.values())),
            "the size of the nudge decides which",
        ),
    )


def _places(attractors: list[Attractor]) -> list[float]:
    return list(dict.fromkeys(one.run.log10_r for one in attractors))


def reappears(residuals: Mapping[int, float]) -> Verdict:
    """An orbit put into thicker slabs."""
    return bounded(
        "An orbit of T transits at r is an orbit at r (1 + k T) too",
        Evidence.EXACT,
        max(residuals.values()),
        _REAPPEARS,
        f"largest difference of ψ over a period, k = {', '.join(map(str, residuals))}, the orbit at log_{{10}} r = −2.68",
    )


def on_torus(found: Torus) -> tuple[Verdict, Verdict]:
    """A long run beyond the first torus point, against the independent program's."""
    known = reference()["torus"]
    ends = max(abs(found.shortest - known["period_range"][0]), abs(found.longest - known["period_range"][1]))
    off = abs(found.mean.value - known["mean_period"])
    where = f"log_{{10}} r = {known['log10_r']:g}".replace("-", "−")
    return (
        bounded(
            "A run on the torus has the rotation number that another program finds",
            Evidence.WITNESS,
            abs(found.rotation - known["rotation_number"]),
            _ROTATION,
            where,
            f"{found.rotation:.5f}, known {known['rotation_number']}",
        ),
        Verdict(
            "Its periods have the mean and the range that another program finds",
            Evidence.WITNESS,
            f"{known['mean_period']}, {known['period_range'][0]} to {known['period_range'][1]}",
            f"{found.mean.value:.4f} ± {found.mean.error:.4f}, {found.shortest:.3f} to {found.longest:.3f}",
            judge(off < 3.0 * found.mean.error and ends < _RANGE),
            f"transits, {where}; three standard errors are allowed, and {_RANGE:g} at the ends",
        ),
    )


def _told(value: complex) -> str:
    return f"{value.real:.5f} ± {value.imag:.5f} i".replace("-", "−")

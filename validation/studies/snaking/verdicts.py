"""What the snake must show: the same points on two meshes, folds once per transit, runs that do what the multipliers say."""

import numpy as np

from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import floquet
from validation.studies.bifurcation.branches import Branch
from validation.studies.snaking.runs import Run, multiplier_of
from validation.studies.snaking.shown import fold_pairs
from validation.study import Evidence, Verdict, judge
from validation.study.bounds import bounded

_MESHES = 1e-8  # 5e-10 was measured
_ONE = 0.2  # distance from 1 of the last growth of T: 0.03 was measured on the quick branch, 0.008 on the full one
_SAME = 4e-9  # 1.5e-10 was measured, the rest of the run
_PAIR = 1e-3  # 1e-4 was measured


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


def _told(value: complex) -> str:
    return f"{value.real:.5f} ± {value.imag:.5f} i".replace("-", "−")

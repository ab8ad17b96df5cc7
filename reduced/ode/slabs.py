"""An ODE reduction as `Slabs` (`slipwave.step.port`): its response within a collocation step of any length.

Collocation turns the linear network of a `Reduction` (its module gives the states) into a stage impedance: with u = v - V at the
s nodes of a step of length h, the collocation matrix A and c = A 1, mode k responds with

    tau = W (tau_0 1 + h p_0 c - (residue h A + offset h^2 A^2) u),     W = (1 + 2 decay h A + omega^2 h^2 A^2)^-1,

the spring with  -spring h A u,  damping with  -damping u,  and mass m with  -(m/h) A^-1 (v - v_0 1).  The sum of all factors of u
is one s x s matrix K(h), so the cost of a Newton iteration does not depend on the number of modes. A `Reduction` is relative to
epsilon, on the transit clock.

Marches any ODE reduction of a slab pair (MODEL.md section 3), all with the same stiff integrator.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from reduced.impedance.reduce import reduction_of
from reduced.impedance.reduction import Reduction
from slipwave.observe.pieces import Array, slack
from slipwave.scene import Scene
from slipwave.solve import Energy
from slipwave.step.collocation import radau
from slipwave.step.port import LEVELS, NO_LEDGER, Levels, Port, line_aligned, padded
from slipwave.step.port_march import PortMarch


class ReducedSlabs:
    """The `Slabs` (slipwave.step.port) of the reduction that `reduce` makes of `scene`. The memory of a port: spring stress (with
    a spring), slip rate times the upper slab's impedance (with a mass), tau of all modes, and p of all but relaxations."""

    def __init__(self, scene: Scene, reduce: Callable[[Scene], Reduction], stages: int) -> None:
        self.scene, self.stages, self._reduce = scene, stages, reduce
        self.reduction = reduce(scene)
        self.model = self.reduction.name
        self.remembered = int(_kept(self.reduction).sum())
        self._stop = math.inf

    def of(self, scene: Scene) -> "ReducedSlabs":
        """As `Slabs`."""
        return ReducedSlabs(scene, self._reduce, self.stages)

    def port(self, longest: float, levels: int = LEVELS) -> Port:
        """As `Slabs`; all tables are made at once."""
        scene, stages = self.scene, self.stages
        length, impedance, free, driven, change = _tables(self.reduction, scene.upper.epsilon, stages, longest, levels)
        steady, n = scene.steady_stress + impedance.sum(axis=2) * scene.velocity, free.shape[1]
        tables = length, np.ones(levels, dtype=np.bool_), impedance, steady, free, driven, change
        return Port(*tables, scene.velocity, scene.drive.is_constant, line_aligned(n), np.zeros(n + 2 * stages), NO_LEDGER)

    def prepare(self, port: Port, level: int) -> None:
        """As `Slabs`."""

    def resistance(self, port: Port, levels: Levels, growth: float) -> Array:
        """As `Slabs`."""
        resistance = _resistances(self.reduction, growth, float(port.length[0]), port.length.size)
        return self.scene.upper.epsilon * resistance[levels]

    @property
    def follows_drive(self) -> bool:
        """As `Slabs`: a fit's answer to the drive is fitted only if the drive changes."""
        return not self.reduction.is_fitted or self.reduction.transfer is not None

    def next_break(self, time: float) -> float:
        """As `Slabs`: the knots of the drive, and where it is to stop."""
        after = time + slack(time)
        return min(self._stop if self._stop > after else math.inf, self.scene.drive.knot_after(after))

    def stop_at(self, time: float) -> None:
        """Have a break point at `time` (transits) too, instead of the one told before."""
        self._stop = time


def impedance_at(reduction: Reduction, s: Array) -> Array:
    """Z(s)/epsilon for real s > 0 (1/transit)."""
    residue, offset, decay2, omega2, _, _ = (term[:, None] for term in _terms(reduction))
    modes = (residue * s + offset) / (s * s + decay2 * s + omega2)
    return np.asarray(reduction.spring / s + reduction.mass * s + reduction.damping + modes.sum(axis=0))


@lru_cache(maxsize=16)
def _resistances(reduction: Reduction, growth: float, longest: float, levels: int) -> Array:
    """`impedance_at` the growth rate `growth`/length of all step lengths."""
    return impedance_at(reduction, growth / np.ldexp(longest, -np.arange(levels)))


@lru_cache(maxsize=16)
def _tables(reduction: Reduction, epsilon: float, stages: int, longest: float, levels: int) -> tuple[Array, ...]:
    """`length`, `impedance`, `free`, `driven` and `change` (`Port`) for `levels` step lengths, the first of them `longest`
    (transits). A change of the drive acts on the spring as the opposite slip rate, on the mass not at all, and on the rest by the
    `transfer`; as the opposite slip rate without one."""
    rule = radau(stages)
    residue, offset, decay2, omega2, by_residue, by_offset = _terms(reduction)
    count, s = offset.size, stages
    length = np.ldexp(longest, -np.arange(levels))
    ones, unit = np.ones(s), np.eye(s)
    ha = length[:, None, None] * rule.integral
    ha2 = ha @ ha
    by_mode = (slice(None), None)
    response = np.linalg.inv(unit + decay2[:, None, None] * ha[by_mode] + omega2[:, None, None] * ha2[by_mode])
    forced, carried = (
        response @ (gain[:, None, None] * ha[by_mode] + other[:, None, None] * ha2[by_mode])
        for gain, other in ((residue, offset), (by_residue, by_offset))
    )
    from_tau, from_p = response @ ones, np.einsum("lnij,lj->lni", response, ha @ ones)
    elastic = epsilon * (reduction.spring * ha + forced.sum(axis=1) + reduction.damping * unit)
    damping = reduction.damping if reduction.transfer is None else 0.0
    driven = epsilon * (reduction.spring * ha + carried.sum(axis=1) + damping * unit)
    inertia = reduction.mass * rule.inverse / length[:, None, None]
    spring, moving, tau, p = 0, 1, slice(2, 2 + count), slice(2 + count, 2 + 2 * count)
    free = np.empty((levels, 2 + 2 * count, s))
    free[:, spring], free[:, moving] = 1.0, inertia @ ones
    free[:, tau], free[:, p] = from_tau, from_p
    moved = length[:, None] * rule.integral[-1]  # integral over the step from nodal values
    own, by_rate = np.zeros((levels, 2 + 2 * count, 2 + 2 * count)), np.zeros((levels, s, 2 + 2 * count))
    own[:, moving, moving] = -1.0
    by_rate[:, :, spring] = -epsilon * reduction.spring * moved[:, :]
    modes = np.arange(count)
    for row, part in ((2 + modes, from_tau), (2 + count + modes, from_p)):
        own[:, row, 2 + modes] = part[:, :, -1]
        own[:, row, 2 + count + modes] = -omega2 * np.einsum("lni,li->ln", part, moved)
    own[:, 2 + modes, 2 + modes] -= 1.0
    by_drive = -by_rate
    for rows, share, other, sign in ((by_rate, forced, offset, -1.0), (by_drive, carried, by_offset, 1.0)):
        rows[:, :, tau] = sign * epsilon * share[:, :, -1].swapaxes(1, 2)
        passed = omega2 * np.einsum("lj,lnjm->lmn", moved, share)
        rows[:, :, p] = -sign * epsilon * (passed - other * moved[:, :, None])
    by_rate[:, -1, moving] = epsilon
    kept = _kept(reduction)
    change = np.concatenate([own[:, kept], by_rate, by_drive], axis=1)[:, :, kept]
    impedance, driven = elastic + epsilon * inertia, np.ascontiguousarray(driven.swapaxes(1, 2))
    used, whole = int(kept.sum()), padded(int(kept.sum()))
    frees, changes = line_aligned(levels, whole, s), line_aligned(levels, whole + 2 * s, whole)
    frees[:, :used], changes[:, :used, :used] = free[:, kept], change[:, :used]
    changes[:, whole:, :used] = change[:, used:]
    return length, impedance, frees, driven, changes


def _terms(reduction: Reduction) -> Array:
    """residue, offset, 2 decay, omega^2 of all terms, and residue and offset of their answer to V, (6, terms); a relaxation is a
    mode without inertia (p = 0). Poles that a transfer does not share are terms of its own."""
    (modes, relaxing), transfer = reduction.terms, reduction.transfer
    if transfer is None:
        rows = [(*term, *term[:2]) for term in (*modes, *relaxing)]
    elif [term[2:] for term in transfer.terms[0]] == [term[2:] for term in modes] and not (relaxing or transfer.relaxations):
        rows = [(*term, *other[:2]) for term, other in zip(modes, transfer.terms[0], strict=True)]
    else:
        rows = [(*term, 0.0, 0.0) for term in (*modes, *relaxing)]
        rows += [(0.0, 0.0, *term[2:], *term[:2]) for part in transfer.terms for term in part]
    return np.array(rows, dtype=float).reshape(-1, 6).T.copy()


@lru_cache(maxsize=16)
def _kept(reduction: Reduction) -> Array:
    """Which of spring, slip rate, tau and p belong to the memory; a relaxation has no p."""
    _, offset, _, omega2, _, by_offset = _terms(reduction)
    moving = (omega2 != 0.0) | (offset != 0.0) | (by_offset != 0.0)
    return np.array([reduction.spring != 0.0, not reduction.is_algebraic, *np.ones_like(moving), *moving])


STAGES = 8
_LONGEST = 30  # 2^30 transits, the longest step, are as long as the longest run
_SHORTEST = -30  # as a power of 2: the slip rate of a block falls the faster the slower it is, whatever a transit is
_SLOW = 4e-4  # of the time of slip by L: the longest step of an orbit's mesh without waves, if that is above 2 transits
_FIRST = 0.125  # transits; behind a knot, if waves ring, at most this share of the shortest period
_SWING = 0.7  # of the largest growth: the nodes then show a swing as well as the end of the step reproduces it
_RUSHES = 0.05  # slip (L) in a transit from which modes ring on from slip to slip


class ReducedModel(PortMarch):
    """Marches `reduction` of the scene's slab pair to `tolerance`, the requested relative error of the cycle's figures.

    Radau IIA with 8 nodes (order 15 at step ends, L-stable), step lengths 2^k transits, as long as the motion allows whatever a
    transit is. Knots of the drive cause kinks of the motion; between two knots, step lengths are their distance over powers of
    two, so that a step ends on each. The first step takes an eighth of a transit. Behind each knot, where the motion may begin to
    ring, steps begin at an eighth of the shortest period of a mode: an implicit step that is longer damps the ring unseen.

    `failures` counts unconverged solves; a step that cannot be solved at the shortest length raises NumericsError naming time and
    scene (a quasi-static model runs away). Raises SceneError for a reduction that is none of passive slabs.
    """

    failed_at = math.nan
    failures = 0
    seconds_per_piece = 2e-6  # 1.2 to 2.4 measured
    transits_per_piece = math.nan

    def __init__(self, scene: Scene, reduction: Reduction, tolerance: float = 1e-9, stages: int = STAGES) -> None:
        self.scene, self.model, self.reduction = scene, reduction.name, reduction.of_slabs()
        self.settings: dict[str, Any] = {"tolerance": tolerance, "stages": stages}
        reason = "nothing limits its slip rate: it runs away" if reduction.runs_away else ""
        # where modes ring on few steps could be longer than 2 transits, and none is: irregular motions repeat only step by step
        longest = _LONGEST if not reduction.modes or scene.transit * max(scene.drive.velocities) < _RUSHES else 1
        slabs = ReducedSlabs(scene, self._reduce, stages)
        super().__init__(slabs, tolerance, 2.0**longest, _FIRST, longest - _SHORTEST + 1, reason)
        self._reduced = slabs
        if longest == _LONGEST:
            self._limits = self._limits._replace(swing=_SWING * self._limits.growth)
        self.longest_after_break = _FIRST * min(1.0, 2.0 * math.pi / max(reduction.frequencies, default=1.0))
        slow = 0.0 if reduction.modes else _SLOW / (scene.transit * max(scene.drive.velocities))
        self._longest_in_cycle = 2.0 ** max(1, math.floor(math.log2(max(slow, 2.0))))

    def stop_at(self, time: float) -> None:
        """As `Stopping`."""
        self._rest = None
        self._reduced.stop_at(time)
        self._take_stretch(self._now, self._next_length)

    def _reduce(self, scene: Scene) -> Reduction:
        """The reduction of `scene`; this one if the slabs are the same."""
        same = (scene.upper, scene.lower) == (self.scene.upper, self.scene.lower)
        return self.reduction if same else reduction_of(scene, self.model)

    def energy(self) -> Energy | None:
        """None: a reduction's energy is not that of the slabs."""
        return None

"""An exact solution with waves, friction and state: the interface's motion is prescribed, and the drive follows.

The state is prescribed, psi = psi_ss + `depth` e^(-x^2), x = (t~ - `centre`)/`width` (Kozdon, Dunham and Nordstrom, J. Sci.
Comput. 50, 2012, prescribe rate and state). The ageing law gives the slip rate, v = e^-psi - psi'/r, friction the stress mu. No
equation has a source: d'Alembert's solution in the slabs gives the V(t) of the outer faces that sends just the waves which meet
this motion. With E the shift by a transit, c_i = E^(k_i/2) + E^(-k_i/2), s_i = E^(k_i/2) - E^(-k_i/2), and round trips of k_i
transits,

    (c_1 + c_2) V = c_1 c_2 v + (s_1 c_2/eps_1 + s_2 c_1/eps_2) mu,

which is solved for V by a finite sum: both sides are steady sliding before the motion begins. For alike slabs it is
V = [v(t~ + 1/2) + v(t~ - 1/2)]/2 + [mu(t~ + 1/2) - mu(t~ - 1/2)]/eps; of unlike ones the lower round trip is three times the
upper.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

import slipwave
from slipwave.compiled import inlined
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.drive import Drive, side_of, velocity_at
from slipwave.solve import follow
from validation.models.build import build

UNTIL = 10.0
"""Transits: the pulse, and twice the time that its waves take to the far face of the thicker slab and back."""

RATIO = 3
"""Ratio of the round trips of unlike slabs."""

BEGIN = 2.0
"""Transits from which solutions are compared; before, there is steady sliding."""

_DEPTH, _CENTRE, _WIDTH = -1.2, 4.5, 0.6  # of the state, which falls as in a slip event; transits


class _GivenMotion(NamedTuple):
    """The given motion, and the parameters of the drive: a and b of the ageing law, V_0 of steady sliding before, one `transit`
    on the friction clock, both impedances, and whether the lower slab's round trip is `RATIO` transits (else one)."""

    depth: float
    centre: float
    width: float
    a: float
    b: float
    velocity: float
    transit: float
    upper: float
    lower: float
    unlike: bool


@inlined
def _state(motion: _GivenMotion, time: float) -> tuple[float, float]:
    """psi minus its steady value, and its change per transit."""
    x = (time - motion.centre) / motion.width
    fallen = motion.depth * math.exp(-x * x)
    return fallen, -2.0 * x / motion.width * fallen


@inlined
def _rate_and_stress(motion: _GivenMotion, time: float) -> tuple[float, float]:
    """v and mu minus their steady values."""
    psi, change = _state(motion, time)
    v = motion.velocity * math.exp(-psi) - change / motion.transit
    return v - motion.velocity, motion.a * math.log(v / motion.velocity) + motion.b * psi


@inlined
def _both_sides(motion: _GivenMotion, time: float) -> float:
    """The right side of the equation for V, for unlike slabs."""
    (v2, mu2), (v1, mu1) = _rate_and_stress(motion, time + 2.0), _rate_and_stress(motion, time + 1.0)
    (v3, mu3), (v4, mu4) = _rate_and_stress(motion, time - 1.0), _rate_and_stress(motion, time - 2.0)
    return v2 + v1 + v3 + v4 + (mu2 - mu1 + mu3 - mu4) / motion.upper + (mu2 + mu1 - mu3 - mu4) / motion.lower


@side_of.register(_GivenMotion)
def _never_jumps(drive, time, middle):  # type: ignore[no-untyped-def]
    return time


@velocity_at.register(_GivenMotion)
def _driven(drive, time, within):  # type: ignore[no-untyped-def]
    if not drive.unlike:
        (ahead, more), (behind, less) = _rate_and_stress(drive, time + 0.5), _rate_and_stress(drive, time - 0.5)
        return drive.velocity + 0.5 * (ahead + behind) + (more - less) / drive.upper
    total = drive.velocity
    late = time - 1.5
    while late > -2.0:  # 1/(c_1 + c_2) = E^(-3/2) (1 - E^-1)/(1 - E^-4)
        total += _both_sides(drive, late) - _both_sides(drive, late - 1.0)
        late -= 4.0
    return total


@dataclass(frozen=True)
class _GivenDrive(Drive):
    """The V(t) that causes a given `motion`: smooth, so that it needs as many terms in a step as the motion."""

    motion: _GivenMotion
    terms: ClassVar[int] = 8

    is_constant = cached_property(lambda self: False)
    knots = cached_property(lambda self: ())
    compiled = cached_property(lambda self: self.motion)

    def exact(self, scene: Scene, times: Array) -> Array:
        """z, psi and mu at `times` (transits); shape (times, 3)."""
        states = []
        for time in times.tolist():
            psi, _ = _state(self.motion, time)
            v, mu = _rate_and_stress(self.motion, time)
            states.append((math.log(scene.velocity + v), scene.steady_psi + psi, scene.steady_stress + mu))
        return np.array(states)


def given_scene(unlike: bool) -> Scene:
    """Alike or unlike slabs under the drive that causes the motion."""
    upper, lower = {"epsilon": 0.04, "r": 1.0}, {"epsilon": 0.06, "r": float(RATIO)}
    slabs = {"upper": upper, "lower": lower} if unlike else {"slab": upper}
    law = {"law": "ageing", "a_star": 0.37, "a": 0.035, "b": 0.049}
    scene = slipwave.read({"name": "given", "interface": law, "drive": {"velocity": 1.0}, "start": {"size": 0.0}, **slabs})
    motion = _GivenMotion(
        _DEPTH, _CENTRE, _WIDTH, scene.law.a, scene.law.b, 1.0, scene.transit, scene.upper.epsilon, scene.lower.epsilon, unlike
    )
    return replace(scene, drive=_GivenDrive((0.0,), (1.0,), motion), until=UNTIL)


def error_of_motion(model: str, scene: Scene, cells: int, **options: Any) -> float:
    """Root mean square, over the time from `BEGIN`, of the differences of z, psi and mu from the exact ones, each relative to its
    range; at the nodes of the pieces, so that interpolation does not enter. `options`: as those of `validation.models.build`."""
    solver = build(model, scene, cells=cells, **options)
    history = HistoryObserver(solver.scene.law, solver.nodes, BEGIN)
    follow(solver, UNTIL, [history], leaps=False)
    pieces = history.pieces().part(history.pieces().time > BEGIN)
    times = (pieces.time[:, None] + pieces.length[:, None] * solver.nodes).ravel()
    assert isinstance(scene.drive, _GivenDrive)
    truth = scene.drive.exact(solver.scene, times)
    ours = np.stack([pieces.z.ravel(), pieces.psi.ravel(), pieces.mu.ravel()], axis=1)
    squares = (((ours - truth) / np.ptp(truth, axis=0)) ** 2).mean(axis=1)
    return float(np.sqrt(np.average(squares, weights=np.repeat(pieces.length, solver.nodes.size))))

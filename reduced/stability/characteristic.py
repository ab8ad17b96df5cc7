"""The one characteristic equation of every scene and model (MODEL.md section 5),

    D(s) = (F_v s + G_phi F_ss') p(s) + (s + G_phi) q(s) = 0,      H(s) + Z(s) = 0 with Z = q/p,

written with the one-port's pair (p, q), so that D is analytic: poles of Z are zeros of p, not poles of D. A count of its zeros by
the argument principle therefore needs no correction. s is on the friction clock, in 1/(L/V*).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Complex, Jet, Ratio, is_exact, ratio_of
from reduced.impedance.reduce import analysed
from reduced.impedance.reduction import Reduction
from reduced.impedance.transmission_line import slab_ratio
from slipwave.friction.law import FrictionSlopes, friction_slopes
from slipwave.scene import Scene

_SHARED = 1e-6


@dataclass(frozen=True)
class Characteristic:
    """D(s) of one scene under one model; `transit` is the upper slab's round trip, `reduction` the model if it is one."""

    scene: Scene
    slopes: FrictionSlopes
    one_port: Callable[[Jet], Ratio]
    transit: float
    reduction: Reduction | None = None

    def friction(self, s: Jet) -> Ratio:
        """(numerator, denominator) of friction's impedance H as jets."""
        return s * self.slopes.direct + self.slopes.healing * self.slopes.steady, s + self.slopes.healing

    def _terms(self, s: object) -> tuple[Jet, Jet]:
        """Both terms of D at s (complex array)."""
        variable = Jet.variable(s)
        (p, q), (n, d) = self.one_port(variable), self.friction(variable)
        return n * p, d * q

    def jet(self, s: object) -> Jet:
        """D and dD/ds at s (complex array)."""
        of_slabs, of_friction = self._terms(s)
        return of_slabs + of_friction

    def imbalance(self, s: object) -> Complex:
        """D over the sum of the sizes of its two terms: 0 at a root, of modulus <= 1, smooth in every parameter."""
        left, right = (term.value for term in self._terms(s))
        size = np.asarray(np.abs(left) + np.abs(right))  # 0 at -G_phi, a root, without a state effect
        return np.asarray(np.divide(left + right, size, out=np.zeros(size.shape, dtype=complex), where=size > 0.0))

    def idle(self, s: Complex) -> NDArray[np.bool_]:
        """True at roots of idle modes: both slabs oscillate alike, without slip or stress at the interface. Friction does not
        affect them; they exist if free modes of unlike slabs coincide. D of slabs with an `equivalent` is free of them."""
        if self.scene.equivalent is not None or self.reduction is not None:
            return np.zeros(s.shape, dtype=bool)
        variable = Jet.variable(s)
        small = []
        for slab in (self.scene.upper, self.scene.lower):
            p, q = slab_ratio(slab, variable)
            small.append(np.abs(q.value) < _SHARED * np.abs(p.value) * slab.epsilon)
        return np.logical_and(*small)

    def eigenvalues(self) -> Complex:
        """All roots of a `reduction`: eigenvalues of its linear equations (`Reduction.state_space`) for deviations u of the slip
        rate from steady sliding, with friction's stress  F_v u + x,  x' = -G_phi (x + (F_v - F_ss') u).  With a mass, u is a
        state."""
        assert self.reduction is not None
        model, slopes, transit, epsilon = self.reduction, self.slopes, self.transit, self.scene.upper.epsilon
        a, b, c = model.state_space()
        rates = np.diag(np.append(np.zeros(b.size), -slopes.healing * transit))
        rates[:-1, :-1] = a
        driven = np.append(b, slopes.healing * (slopes.steady - slopes.direct) * transit)
        load, resistance = -np.append(epsilon * c, 1.0), slopes.direct + model.damping * epsilon
        if model.is_algebraic:  # u = load/resistance
            return np.asarray(np.linalg.eigvals(rates + np.outer(driven, load / resistance)) / transit, dtype=complex)
        inertia = model.mass * epsilon
        with_rate = np.block([[rates, driven[:, None]], [load / inertia, -resistance / inertia]])
        return np.asarray(np.linalg.eigvals(with_rate) / transit, dtype=complex)

    @property
    def is_active(self) -> bool:
        """Whether the slabs have unstable poles."""
        return self.reduction is not None and self.reduction.is_active

    @property
    def longest(self) -> float:
        """The longer of both round trips (L/V*)."""
        return max(self.scene.upper.round_trip, self.scene.lower.round_trip)

    @property
    def anchors(self) -> tuple[complex, ...]:
        """Points near which D varies on a short scale: 0, the rate of the friction state, the relaxation rates of viscous slabs,
        and the relaxation rates of the outer faces alone."""
        points: set[complex] = {0.0, -self.slopes.healing}
        for slab in (self.scene.upper, self.scene.lower):
            held, solid = slab.termination, slab.rheology
            rates = [] if held.is_rigid else [complex(root) for root in np.roots([held.mass, held.dashpot, held.spring])]
            points.update(rates, (-1.0 / time for time in (solid.retardation, solid.relaxation) if time > 0.0))
        return tuple(points)

    @property
    def leftmost(self) -> float:
        """Re s (< 0) left of which D may not be analytic: the relaxation of a viscous slab; -inf if both are elastic."""
        return -min(slab.rheology.creep_rate for slab in (self.scene.upper, self.scene.lower))


@lru_cache(maxsize=8)
def characteristic(scene: Scene, model: str = "delay") -> Characteristic:
    """D(s) for steady sliding at the scene's drive velocity. Raises SceneError if the model cannot compute the scene."""
    reduced = None if is_exact(model) else analysed(scene, model)
    one_port = ratio_of(scene, model if reduced is None else reduced)
    return Characteristic(scene, friction_slopes(scene.law, scene.velocity), one_port, scene.transit, reduced)

"""The equations of an ODE reduction (docstring of `reduced.impedance.reduction`) integrated by scipy: a witness for the ladder.

It is begun afresh at every knot of the drive. It shares the table of poles with the ladder, and neither the friction law (ageing)
nor the integrator.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import wrightomega

from reduced.impedance.reduction import Reduction
from slipwave.scene.drive import NUDGE_CENTRE

Array = NDArray[np.float64]
_MODES = {"frequencies": (6.2, 12.3), "residues": (2.1, 1.9), "decays": (0.5, 0.9), "offsets": (1.2, -0.4)}
EVERY_TERM = Reduction("made up", mass=0.02, damping=0.1, relaxations=((0.4, 1.3), (-0.1, 9.0)), spring=0.7, **_MODES)
TRANSFER = Reduction(
    "made up", frequencies=(5.9,), residues=(-1.7,), decays=(0.4,), offsets=(0.3,), relaxations=((0.2, 2.0),), spring=0.7
)


class Equations:
    """x = (psi, ln v or nothing, y, tau_1, p_1, ..., relaxations, the same of a transfer), y and tau relative to epsilon."""

    def __init__(self, scene, reduction):
        self.what, self.reduction = scene, reduction
        self.massive = reduction.mass > 0.0
        self.parts = [reduction] if reduction.transfer is None else [reduction, reduction.transfer]

    def start(self):
        states = sum(2 * len(part.modes) + len(part.relaxations) for part in self.parts)
        ln_v = [math.log(self.what.velocity)] if self.massive else []
        psi, load = self.what.steady_psi + self.what.start.jump_size, self.what.steady_stress / self.what.upper.epsilon
        return np.array([psi, *ln_v, load, *[0.0] * states])

    def ln_v(self, time, psi, load):
        """Without mass: F(ln v, psi) + epsilon damping (v - V) = epsilon load."""
        law, resistance = self.what.law, self.what.upper.epsilon * self.reduction.damping
        stress = self.what.upper.epsilon * load + resistance * self.radiated_at(time)
        free = (stress - law.a_star - law.b * psi) / law.a
        return free - float(np.real(wrightomega(free + math.log(resistance / law.a)))) if resistance else free

    def radiated_at(self, time):
        """The slip rate that damping does not resist: V, that of steady sliding where a transfer says what V does."""
        return self.what.drive.at(time) if self.reduction.transfer is None else self.what.velocity

    def states_of(self, x):
        """(part, its modes' tau and p, its relaxations' tau)."""
        rest = x[2 + self.massive :]
        for part in self.parts:
            modes, relaxing = 2 * len(part.modes), len(part.relaxations)
            yield part, rest[:modes], rest[modes : modes + relaxing]
            rest = rest[modes + relaxing :]

    def load(self, x):
        return x[1 + self.massive] + sum(sum(modes[::2]) + sum(relaxing) for _, modes, relaxing in self.states_of(x))

    def rates(self, time, x):
        law, r, reduction = self.what.law, self.what.transit, self.reduction
        psi, load = x[0], self.load(x)
        ln_v = x[1] if self.massive else self.ln_v(time, psi, load)
        v, driven = math.exp(ln_v), self.what.drive.at(time)
        found = [r * (math.exp(-psi) - v) + self.what.start.nudge_size * math.exp(-((time - NUDGE_CENTRE) ** 2))]
        if self.massive:
            stress = (law.a_star + law.a * ln_v + law.b * psi) / self.what.upper.epsilon
            found.append((load - stress - reduction.damping * (v - self.radiated_at(time))) / (reduction.mass * v))
        found.append(-reduction.spring * (v - driven))
        for part, modes, relaxing in self.states_of(x):
            u = v - self.radiated_at(time) if part is reduction else self.what.velocity - driven
            for (omega, residue, decay, offset), tau, p in zip(part.modes, modes[::2], modes[1::2], strict=True):
                found += [-residue * u - 2.0 * decay * tau + p, -offset * u - omega**2 * tau]
            found += [-strength * u - rate * tau for (strength, rate), tau in zip(part.relaxations, relaxing, strict=True)]
        return found

    def motion_at(self, ends, tolerance=1e-11, method="LSODA"):
        """Rows psi, ln v, mu at each of `ends` (transits), rising."""
        x, time, found, law = self.start(), 0.0, [], self.what.law
        for stop in sorted({*ends, *(knot for knot in self.what.drive.times if 0.0 < knot < ends[-1])}):
            span, limits = (time, stop), {"rtol": tolerance, "atol": tolerance, "max_step": 1.0}
            x = solve_ivp(self.rates, span, x, method=method, **limits).y[:, -1]
            time = stop
            if stop in ends:
                ln_v = x[1] if self.massive else self.ln_v(time, x[0], self.load(x))
                found.append([x[0], ln_v, law.a_star + law.a * ln_v + law.b * x[0]])
        return np.array(found)

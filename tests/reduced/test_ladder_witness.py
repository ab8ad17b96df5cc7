"""Every hand-written simplified model, alike slabs or not, drive steady or on ramps, against our one integrator of them all."""

import numpy as np
import pytest
from plain_pair import plain_pair
from scipy.integrate import solve_ivp
from scipy.interpolate import BarycentricInterpolator

import slipwave
from reduced.impedance import reduction_of
from reduced.impedance.reduction import Reduction
from reduced.ode.march import ReducedModel
from slipwave.solve import follow

UNLIKE = ["upper.epsilon=2.8e-5", "upper.r=0.00244", "lower.epsilon=8.4e-5", "lower.r=0.00388"]
RAMPS = "drive.velocity=[[0.0,100.0],[20.3,100.0],[31.7,180.0],[44.1,70.0]]"
PAIRS = {"alike": [], "unlike": UNLIKE, "thin above": [*UNLIKE, "upper.r=0.00011"]}
TIMES = [13.0, 40.0, 90.0]
MODELS = ["quasidynamic", "block12", "block8", "kelvin-voigt"]


class Last:
    """The pieces seen last."""

    def scan(self, pieces):
        self.pieces = pieces

    def elastic(self, nodes, time):
        """y at `time`, which lies in the last but a few of the pieces."""
        k = np.searchsorted(self.pieces.time, time - 1e-9) - 1
        return float(BarycentricInterpolator(nodes, self.pieces.y[k])((time - self.pieces.time[k]) / self.pieces.length[k]))


def apart(settings, model):
    """Largest difference of ln v, psi, mu and y from the witness at TIMES."""
    chosen = slipwave.read("paper", settings)
    solver, last, found = ReducedModel(chosen, reduction_of(chosen, model), tolerance=1e-11), Last(), []
    for time in TIMES:
        final = follow(solver, time, [last])
        found.append([final.ln_v, final.psi, final.mu, last.elastic(solver.nodes, time)])
    return np.abs(np.array(found) - plain_pair(chosen, model, TIMES)).max(axis=0)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("pair", PAIRS)
def test_steady_drive(pair, model):
    """Measured: 2.5e-9 in ln v and psi, 2e-10 in the stresses, most of it the witness's."""
    assert (apart(PAIRS[pair], model) < [3e-8, 3e-8, 3e-9, 3e-9]).all()


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("pair", PAIRS)
def test_ramps(pair, model):
    """Measured: 5e-9 in ln v and psi, 1e-10 in the stresses."""
    assert (apart([*PAIRS[pair], RAMPS], model) < [5e-8, 5e-8, 1e-9, 1e-9]).all()


EVERY_TERM = Reduction(
    "made up",
    mass=0.02,
    damping=0.1,
    frequencies=(6.2, 12.3),
    residues=(2.1, 1.9),
    decays=(0.5, 0.9),
    offsets=(1.2, -0.4),
    relaxations=((0.4, 1.3), (-0.1, 9.0)),
    spring=0.7,
)


def as_written(chosen, reduction, time):
    """ln v, psi and mu at `time` from the states in the docstring of `reduced.impedance.reduction`, by LSODA; mass > 0."""
    law, epsilon, transit, v0 = chosen.law, chosen.upper.epsilon, chosen.transit, chosen.velocity
    omega, c, d, o = (np.array(part) for part in (reduction.frequencies, reduction.residues, reduction.decays, reduction.offsets))
    strength, rate = np.array(reduction.relaxations).T
    n, mu0 = omega.size, law.a_star + (law.a - law.b) * np.log(v0)

    def rates(t, x):
        z, psi, y, tau, p, slow = x[0], x[1], x[2], x[3 : 3 + n], x[3 + n : 3 + 2 * n], x[3 + 2 * n :]
        v = np.exp(z)
        u = v - np.interp(t, chosen.drive.times, chosen.drive.velocities)
        q = (law.a_star + law.a * z + law.b * psi - mu0) / epsilon
        push = (y + tau.sum() + slow.sum() - q - reduction.damping * u) / reduction.mass
        healing = transit * (np.exp(-psi) - v) + chosen.start.size * np.exp(-((t - 6.0) ** 2))
        moving = [-c * u - 2 * d * tau + p, -o * u - omega**2 * tau, -strength * u - rate * slow]
        return np.concatenate([[push / v, healing, -reduction.spring * u], *moving])

    x, before = np.zeros(3 + 2 * n + rate.size), 0.0
    x[:2] = np.log(v0), -np.log(v0)
    for end in [knot for knot in chosen.drive.times if 0.0 < knot < time] + [time]:
        x = solve_ivp(rates, (before, end), x, method="LSODA", rtol=1e-11, atol=1e-11).y[:, -1]
        before = end
    return [x[0], x[1], law.a_star + law.a * x[0] + law.b * x[1]]


@pytest.mark.parametrize("settings", [[], [RAMPS]], ids=["steady", "ramps"])
def test_every_term_of_a_reduction(settings):
    chosen = slipwave.read("paper", settings)
    for time in TIMES:
        final = follow(ReducedModel(chosen, EVERY_TERM, tolerance=1e-11), time)
        apart = np.abs([final.ln_v, final.psi, final.mu] - np.array(as_written(chosen, EVERY_TERM, time)))
        assert (apart < [1e-8, 1e-8, 1e-10]).all()  # measured: 8e-10, 5e-12

"""Every hand-written simplified model, alike slabs or not, drive steady or on ramps, against our one integrator of them all."""

import numpy as np
import pytest
from plain_pair import plain_pair
from scipy.interpolate import BarycentricInterpolator

import scene
from reduced.impedance import reduction_of
from reduced.ladder import Ladder
from scene.observe import follow

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
        return float(BarycentricInterpolator(nodes, self.pieces.elastic[k])((time - self.pieces.time[k]) / self.pieces.length[k]))


def apart(settings, model):
    """Largest difference of ln v, psi, mu and y from the witness at TIMES."""
    chosen = scene.read("paper", settings)
    solver, last, found = Ladder(chosen, reduction_of(chosen, model), tolerance=1e-11), Last(), []
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
    """Measured: 8e-7 in ln v and psi, 1.2e-8 in the stresses."""
    assert (apart([*PAIRS[pair], RAMPS], model) < [1e-5, 1e-5, 2e-7, 2e-7]).all()

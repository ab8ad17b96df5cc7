"""Steps of a reduction as long as its motion allows, against steps of 1/8 transit behind knots of V and around slip events."""

import math

import numpy as np
import pytest

from reduced.impedance.reduce import reduction_of
from reduced.ode.slabs import STAGES, ReducedModel, ReducedSlabs
from slipwave.input import read_scene
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Pieces, lagrange_basis
from slipwave.solve import follow
from slipwave.step.port_march import PortMarch
from tests.granite import SAMPLE

SHORT = 0.125
TOLERANCE = 1e-9
SHORT_RUN = SAMPLE | {"run": {"until": "12 s"}}


def marched(solver, until):
    parts = [solver.advance(until)]
    while solver.time < until - 1e-6:
        parts.append(solver.advance(until))
    return Pieces.joined(parts)


def short_steps(scene, model):
    slabs = ReducedSlabs(scene, lambda one: reduction_of(one, model), STAGES)
    return PortMarch(slabs, TOLERANCE, SHORT, SHORT)


BASIS = lagrange_basis(short_steps(read_scene("paper"), "quasidynamic").nodes)


def motion(pieces, times):
    return np.stack(values_at(pieces, BASIS, times)[:3])


@pytest.mark.parametrize("model", ["quasidynamic", "block8", "kelvin-voigt", "modal:1"])
@pytest.mark.parametrize("name", ["velocity-steps", "hold"])
def test_motion_behind_a_knot_is_that_of_short_steps(name, model):
    scene = read_scene(name)
    knot = scene.drive.knots[1]
    end = knot + 1000.0
    long, short = marched(ReducedModel(scene, reduction_of(scene, model), TOLERANCE), end), short_steps(scene, model)
    times = knot + np.geomspace(0.01, 999.0, 20)
    difference = np.abs(motion(long, times) - motion(marched(short, end), times))
    assert difference.max() < 10.0 * TOLERANCE
    quiet = long.length[long.time < knot - 1.0]
    assert quiet.max() > 1000.0  # it has long steps to forget them


def test_motion_around_a_slip_event_is_that_of_short_steps():
    scene = read_scene(SHORT_RUN)
    solver = ReducedModel(scene, reduction_of(scene, "quasidynamic"), TOLERANCE)
    pieces = marched(solver, scene.until)
    fast = int(np.argmax(pieces.z.max(axis=1)))
    assert pieces.z[fast].max() - pieces.z[0, 0] > 2.0
    for start in (pieces.time[fast] - 600.0, pieces.time[fast] + 400.0):
        again = ReducedModel(scene, reduction_of(scene, "quasidynamic"), TOLERANCE)
        while again.time < start - 1.0:
            again.advance(again.time + 1e-3)  # a step a call
        begin = again.time
        short = short_steps(scene, "quasidynamic")
        short.restore(again.state() | {"counts": np.array([0.0, -1.0, 0.0]), "stretch": np.array([begin])})
        times = begin + np.linspace(5.0, 995.0, 20)
        difference = np.abs(motion(pieces, times) - motion(marched(short, begin + 1000.0), times))
        assert difference.max() < 10.0 * TOLERANCE


def test_steps_follow_the_motion_whatever_a_transit_is():
    """A sample of a tenth of the thickness between the same springs: as many steps, though a transit is a tenth."""
    counts = []
    for thickness in ("1 mm", "0.1 mm"):
        scene = read_scene(SHORT_RUN | {"slab": SAMPLE["slab"] | {"thickness": thickness}})
        counts.append(marched(ReducedModel(scene, reduction_of(scene, "quasidynamic"), TOLERANCE), scene.until).time.size)
    assert max(counts) < 200
    assert abs(counts[0] - counts[1]) < 0.1 * counts[0]


class Seen:
    """The pieces that observers are given."""

    def __init__(self):
        self.parts = []

    def scan(self, pieces):
        self.parts.append(pieces)


def test_a_run_ends_within_a_step_and_goes_on_there():
    scene = read_scene("hold")
    whole, halves = Seen(), Seen()
    follow(ReducedModel(scene, reduction_of(scene, "quasidynamic")), 9e5, [whole])
    solver = ReducedModel(scene, reduction_of(scene, "quasidynamic"))
    for end in (3e5, 3e5 + 10.0, 9e5):
        final = follow(solver, end, [halves])
        assert solver.time == end
        assert halves.parts[-1].time[-1] + halves.parts[-1].length[-1] == pytest.approx(end, rel=1e-15)
        assert math.isfinite(final.ln_v)
        again = ReducedModel(scene, reduction_of(scene, "quasidynamic"))
        again.restore(solver.state())
        assert again.time == end
        solver = again
    joined = Pieces.joined(halves.parts)
    np.testing.assert_allclose(joined.time[1:], (joined.time + joined.length)[:-1], rtol=1e-15)
    times = np.linspace(10.0, 8.9e5, 50)
    np.testing.assert_allclose(motion(joined, times), motion(Pieces.joined(whole.parts), times), rtol=1e-12, atol=1e-13)

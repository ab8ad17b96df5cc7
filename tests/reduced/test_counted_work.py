"""What a march costs in steps and Newton iterations: no busy machine can change that.

A worse guess, a slower iteration or a step shorter than the tolerance asks for gives the same answers, and is seen nowhere else.
"""

import pytest

import slipwave
from reduced.ode import slabs
from slipwave.observe import EventObserver
from slipwave.solve import follow
from tests.granite import GRANITE
from validation.compute.build import build


class Steps:
    """Counts the pieces of a march."""

    count = 0

    def scan(self, pieces):
        self.count += pieces.time.size


@pytest.mark.parametrize(
    ("scene", "model", "tolerance", "until", "steps", "iterations"),
    [
        ("paper", "delay", 1e-9, 1000.0, 7334, 11283),
        ("unlike", "delay", 1e-9, 1000.0, 4297, 7485),
        ("unlike-irrational", "delay", 1e-10, 400.0, 1328, 2592),
        ("paper", "kelvin-voigt", 1e-9, 1000.0, 4870, 7033),
        ("ramp", "kelvin-voigt", 1e-7, 1200.0, 3934, 5601),
    ],
)
def test_steps_and_iterations_are_as_many_as_measured(scene, model, tolerance, until, steps, iterations):
    solver = build(model, slipwave.read(scene), tolerance=tolerance)
    taken = Steps()
    follow(solver, until, [taken])
    assert (taken.count, solver.iterations) == pytest.approx((steps, iterations), rel=2e-3)  # rounding may decide on one more


def test_a_thin_sample_takes_few_steps_to_the_same_cycle(monkeypatch):
    """A cycle of 5e5 transits in a machine, beside steps of two transits as where waves ring."""
    sample = GRANITE["slab"] | {"thickness": 0.08, "face": {"kind": "machine", "stiffness": 8.8e9, "impedance": 0.0, "mass": 0.0}}
    thin, found = slipwave.read(GRANITE | {"slab": sample, "drive": {"velocity": 5.0}}), []
    for longest in (slabs._LONGEST, 1):
        monkeypatch.setattr(slabs, "_LONGEST", longest)
        solver, taken = build("quasidynamic", thin, tolerance=1e-9), Steps()
        watched = EventObserver(thin, solver.nodes)
        follow(solver, 1.6e6, [taken, watched])
        found.append([taken.count, *watched.events(0.0).period[-1:], *watched.events(0.0).v_max[-1:]])
    (few, *short), (many, *long) = found
    assert few < 0.2 * many
    assert short == pytest.approx(long, rel=1e-7)

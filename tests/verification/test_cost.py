"""What a run costs, counted: steps and Newton iterations, steps times values, twice for two slabs, nothing for a rigid face;
memory of one grid. The seconds that a step takes are measured by `make bench`.

A worse guess, a slower iteration or a step shorter than the tolerance asks for gives the same answers, and is seen nowhere
else."""

import dataclasses
import gc
import tracemalloc

import pytest

import slipwave
from reduced.ode import slabs
from slipwave.observe import EventObserver
from slipwave.solve import follow
from tests.compiled_work import count_calls
from tests.granite import GRANITE
from validation.models.build import build
from validation.models.by_name import explicit_time

PAPER = slipwave.read("paper")
GRIDS = {"fd": 128, "sbp:4": 64, "fem:4": 16, "dg:7": 8}
TRANSITS = 20.0


@pytest.fixture
def cost(monkeypatch):
    """A function of (model, scene, cells, transits): steps that compiled code takes, and values that it marches in each."""
    calls = count_calls(monkeypatch)

    def count(model, scene, cells, transits=TRANSITS):
        calls.clear()
        follow(build(model, scene, cells=cells, time=explicit_time(model)), transits)
        (values,) = {call.values for call in calls}
        return sum(call.steps for call in calls), values

    return count


@pytest.mark.parametrize("model", GRIDS)
def test_work_is_proportional_to_cells_times_steps(model, cost):
    """Twice the transits, four times the cells, two slabs; a run ends with the piece of up to 8 steps in which its end lies."""
    cells = GRIDS[model]
    unlike = dataclasses.replace(PAPER, lower=dataclasses.replace(PAPER.lower, round_trip=(1.0 + 4e-16) * PAPER.lower.round_trip))
    steps, values = cost(model, PAPER, cells)
    assert cost(model, PAPER, cells, 40.0) == (pytest.approx(2 * steps, abs=16), values)
    assert cost(model, PAPER, 4 * cells) == (pytest.approx(4 * steps, abs=40), pytest.approx(4 * values, abs=40))
    assert cost(model, unlike, cells) == (steps, pytest.approx(2 * values, abs=10))


def peak(model, cells, transits):
    """Most memory (bytes) that a run holds at once, the solver included, with everything compiled."""
    follow(build(model, PAPER, cells=cells, time=explicit_time(model)), 0.1)
    gc.collect()
    tracemalloc.start()
    try:
        follow(build(model, PAPER, cells=cells, time=explicit_time(model)), transits)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("model", ["fd", "sbp:4"])
def test_memory_does_not_grow_with_the_run(model):
    """Keeping its samples would take ten times as much. All lines share a march. Least of three runs: objects come and go."""
    solver = build(model, PAPER, cells=GRIDS[model], time=explicit_time(model))
    samples = 4 * 8 * 800.0 / solver.step
    short, long = (min(peak(model, GRIDS[model], transits) for _ in range(3)) for transits in (400.0, 1200.0))
    assert long - short < 0.1 * samples


class Steps:
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

"""Settling on an orbit, on a solver whose orbit is known: z = ln V + c_k sin(2 pi t/T) with an amplitude that relaxes."""

import math

import numpy as np
import pytest

import slipwave
from slipwave.observe import EventObserver, HistoryObserver, Pieces
from slipwave.solve import FieldSolver, follow
from validation.measure.settle import MOST_TRANSITS, NoCycle, one_cycle, settle
from validation.references.published import reference_orbit
from validation.registry.build import build
from validation.study.memo import cycle_of, cycles_in_turn, late_cycles, own_orbit

PERIOD = 50.0


class Relaxing:
    """ln v = ln V + A(t) sin(2 pi t/T): A -> 2 with the factor `multiplier` per cycle, y = 0.05 A cos, mu = 0.2 sin."""

    model = "relaxing"
    seconds_per_piece, transits_per_piece, failed_at = 0.0, math.nan, math.nan
    nodes = np.linspace(0.0, 1.0, 8)
    failures = 0

    def __init__(self, multiplier, jitter=0.0, amplitude=2.0):
        self.scene, self.time = slipwave.read("paper"), 0.0
        self.multiplier, self.jitter, self.amplitude = multiplier, jitter, amplitude
        self.random = np.random.default_rng(0)

    def advance(self, until):
        count = 64
        start = self.time + np.arange(count)
        t = start[:, None] + self.nodes
        phase = 2 * math.pi * t / PERIOD
        growth = self.amplitude * (1 - self.multiplier ** (1 + t // PERIOD)) + self.jitter * self.random.standard_normal()
        z = math.log(self.scene.velocity) + growth * np.sin(phase)
        self.time += count
        return Pieces(start, np.ones(count), z, z * 0 - 4, 0.2 * np.sin(phase), 0.05 * growth * np.cos(phase))

    def energy(self):
        return None

    def state(self):
        return {"time": self.time}

    def restore(self, state):
        self.time = state["time"]


def test_settles_and_tells_the_orbit():
    settled = settle(Relaxing(0.2), tolerance=1e-9)
    assert settled.settled
    assert settled.unrest < 1e-9
    known = {"stress_drop": 0.4, "elastic_stress_drop": 0.2, "v_max": 100 * math.exp(2), "v_min": 100 * math.exp(-2)}
    found = settled.orbit.values()
    assert found.pop("period") == pytest.approx(PERIOD, rel=1e-8)
    assert found == pytest.approx(known, rel=1e-6)


def test_error_bounds_what_is_left_of_the_transient():
    settled = settle(Relaxing(0.9), tolerance=1e-3)
    assert abs(settled.orbit.v_max.value - 100 * math.exp(2)) < 10 * settled.orbit.v_max.error


def test_gives_up_or_stops_at_the_solvers_jitter():
    slow, rough = settle(Relaxing(0.995), tolerance=1e-9, most=2000.0), settle(Relaxing(0.2, 1e-7), tolerance=1e-12, most=20000.0)
    assert (slow.settled, rough.settled) == (False, True)
    assert slow.unrest > 1e-3
    assert rough.transits < 10000.0
    assert 1e-9 < rough.unrest < 1e-5


@pytest.mark.parametrize(("amplitude", "said"), [(0.0, "0 slip events"), (1e-4, "back to steady sliding")])
def test_a_motion_without_events_is_no_cycle(amplitude, said):
    with pytest.raises(NoCycle, match=said):
        settle(Relaxing(0.2, amplitude=amplitude), most=500.0 if amplitude == 0.0 else MOST_TRANSITS)


def test_one_cycle_starts_at_its_event():
    cycle = one_cycle(settle(Relaxing(0.2)), before=5.0, after=2.0)
    assert (cycle.time[0], cycle.time[-1]) == (pytest.approx(-5.0, abs=0.2), pytest.approx(PERIOD + 2.0, abs=0.2))
    at_start = np.interp(0.0, cycle.time, np.log(cycle.slip_rate))
    assert at_start == pytest.approx(math.log(50.0) + 2.0, abs=1e-3)
    assert np.all(np.diff(cycle.time) > 0)


def test_a_start_on_the_orbit_has_no_transient_and_keeps_its_grid():
    solver = build("fd", slipwave.read("paper", ["start.kind=orbit"]), cells=24)
    watch = EventObserver(solver.scene, solver.nodes)
    follow(solver, 400.0, [watch])
    assert np.ptp(watch.events().period) < 1e-6
    assert watch.events().time[0] == pytest.approx(watch.events().period[0], abs=0.2)
    assert isinstance(solver, FieldSolver)
    assert not isinstance(build("block8", slipwave.read("paper", ["start.kind=orbit"])), FieldSolver)


def test_the_orbit_is_found_where_nothing_is_recorded():
    silent, watched = (
        build("delay", slipwave.read("paper", ["start.kind=orbit", record])) for record in ("run.record=[]", "run.until=9")
    )
    assert follow(silent, 8.0) == follow(watched, 8.0)


@pytest.mark.parametrize(
    ("model", "log10_r", "options"),
    [
        ("delay", -2.68, {}),
        ("delay", -2.65, {}),
        ("kelvin-voigt", -2.60, {}),
        ("dg:7", -2.68, {"cells": 5, "time": "exact"}),
        ("dg:7", -2.68, {"cells": 5, "time": "explicit"}),
    ],
)
def test_every_cycle_from_the_start_on_is_the_orbit(model, log10_r, options):
    """At log10 r = -2.65 the orbit is unstable: by a factor of 1.17 in a cycle, so that an error of 1e-9 stays invisible."""
    solver = build(model, slipwave.read("paper", {"start.kind": "orbit", "slab.log10_r": log10_r}), **options)
    watch = EventObserver(solver.scene, solver.nodes)
    follow(solver, 330.0, [watch])
    known = reference_orbit("delay" if model == "dg:7" else model, log10_r)
    cycles = watch.events()
    assert watch.dates()[0] == pytest.approx(0.0, abs=0.2)
    assert cycles.period == pytest.approx(np.full(cycles.period.size, known["period"]), rel=5e-9)
    assert cycles.stress_drop == pytest.approx(np.full(cycles.period.size, known["stress_drop"]), rel=3e-7)
    assert cycles.period.size >= 3


@pytest.mark.parametrize("name", ["grip", "layered"])
def test_a_network_of_lines_begins_on_its_orbit(name):
    solver = build("delay", slipwave.read(name, {"start.kind": "orbit"}))
    watch = EventObserver(solver.scene, solver.nodes)
    follow(solver, 330.0, [watch])
    assert watch.events().period.size >= 2
    assert np.ptp(watch.events().period) < 1e-8
    assert np.ptp(watch.events().v_max) < 1e-5


@pytest.mark.parametrize("model", ["delay", "kelvin-voigt"])
def test_the_elastic_stress_of_an_orbit_is_that_of_a_settled_run(model):
    """It depends on the whole history: the orbit alone knows it but for a constant."""
    extremes = []
    for start, begin in (("nudge", 1500.0), ("orbit", 0.0)):
        solver = build(model, slipwave.read("paper", {"start.kind": start}))
        history = HistoryObserver(solver.scene.law, solver.nodes, begin)
        follow(solver, begin + 80.0, [history])
        extremes.append([bound(history.columns()["elastic_stress"]) for bound in (np.min, np.max)])
    assert extremes[1] == pytest.approx(extremes[0], abs=1e-5)


@pytest.mark.parametrize("model", ["delay", "kelvin-voigt"])
def test_the_cycle_of_an_orbit_is_that_of_a_settled_run(model):
    """From its event on, with some transits ahead of it and past its end."""
    scene = slipwave.read("paper")
    found = cycle_of(own_orbit(model, scene, 1e-8).closed, before=3.0, after=2.0)
    run = one_cycle(settle(build(model, scene, tolerance=1e-9), tolerance=1e-7), before=3.0, after=2.0)
    assert found.period == pytest.approx(run.period, rel=1e-6)
    assert [found.time.min(), found.time.max()] == pytest.approx([-3.0, found.period + 2.0], abs=0.05)
    assert np.diff(found.time).min() > 0.0
    calm = (run.time > 3.0) & (run.time < 60.0)
    assert np.interp(run.time[calm], found.time, found.stress) == pytest.approx(run.stress[calm], abs=1e-4)
    at_event = [np.interp(0.0, cycle.time, cycle.slip_rate) / cycle.slip_rate.max() for cycle in (found, run)]
    assert at_event == pytest.approx([0.5, 0.5], abs=0.05)


def test_cycles_of_a_run_in_turn():
    """Beyond its torus point; the delay system's periods end between 79.122 and 79.544."""
    scene = slipwave.read("paper", ["slab.log10_r=-2.65"])
    cycles = cycles_in_turn("delay", scene, 3, longest=80.0)
    assert len(cycles) == 3
    assert all(79.0 < cycle.period < 79.7 for cycle in cycles)
    assert len({cycle.period for cycle in cycles}) == 3
    assert all(0.0 <= cycle.time.min() < 0.1 and 0.0 <= cycle.period - cycle.time.max() < 0.1 for cycle in cycles)
    late = late_cycles("delay", scene, 2200.0).period
    assert late[:3] == pytest.approx([cycle.period for cycle in cycles], rel=1e-12)

"""ODE reductions: a step ends on each knot of V, none is shorter than the motion asks for, and order and tolerance stay."""

import dataclasses

import numpy as np
import pytest
from reduction_equations import EVERY_TERM, TRANSFER, Equations

import slipwave
from reduced.delay.system import delay_system
from reduced.impedance import reduction_of
from reduced.impedance.reduction import TABULATED, reduction
from reduced.ode import slabs
from reduced.ode.slabs import STAGES, ReducedModel, ReducedSlabs, impedance_at
from slipwave.errors import NumericsError
from slipwave.input.assemble import read_scene
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Pieces, lagrange_basis
from slipwave.scene.drive import Drive
from slipwave.solve import follow
from slipwave.step.port_march import PortMarch
from tests.granite import SAMPLE

KNOTS = (20.1234567, 21.3456789, 30.77777, 30.87777, 41.42135)
RAMP = "drive.velocity=" + str([[0.0, 100.0], *map(list, zip(KNOTS, (100.0, 300.0, 60.0, 200.0, 100.0), strict=True))])
ENDS = (15.0, 30.0, 45.0)


def errors(scene, reduction, tolerance):
    """Largest errors of psi, ln v and mu at ENDS."""
    solver = ReducedModel(scene, reduction, tolerance)
    ours = [(end.psi, end.ln_v, end.mu) for end in (follow(solver, time) for time in ENDS)]
    return np.abs(np.array(ours) - Equations(scene, reduction).motion_at(ENDS)).max(axis=0)


UNLIKE = ("lower.epsilon=8.4e-5", "lower.r=0.00388")
CASES = [
    ("quasidynamic", ()),
    ("block8", ()),
    ("kelvin-voigt", ()),
    ("every term", ()),
    ("every term, own transfer", ()),
    *((model, UNLIKE) for model in ("quasidynamic", "block8", "block12", "kelvin-voigt")),
    ("kelvin-voigt", ("upper.r=0.00011", "lower.r=0.0024")),
    pytest.param("fitted:6", ("slab.face={kind='grip', stiffness=10.0, impedance=19.0}",), marks=pytest.mark.slow),
    pytest.param("modal:6", UNLIKE, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("model", "settings"), CASES)
def test_the_march_obeys_the_equations(model, settings):
    """Before, between and after the knots. Measured: 1.5e-9 at most without mass; with mass LSODA's own, 1.8e-8."""
    scene = slipwave.read("paper", ["slab.log10_r=-2.62", *settings, RAMP, "run.until=400"])
    made_up = {"every term": EVERY_TERM, "every term, own transfer": dataclasses.replace(EVERY_TERM, transfer=TRANSFER)}
    reduction = made_up.get(model) or reduction_of(scene, model)
    assert (errors(scene, reduction, 1e-9) < (5e-8 if reduction.mass else 5e-9)).all()


def test_no_step_is_tiny_before_a_knot_far_away():
    """Half a million steps of no round length end at a knot exactly: a sum of their lengths would miss it."""
    scene = slipwave.read("paper", ["drive.velocity=[[0.0, 100.0], [20011.17, 100.0], [20031.3, 105.0]]"])
    solver, shortest, ends = ReducedModel(scene, reduction_of(scene, "modal:1")), np.inf, []
    while solver.time < 20040.0:
        pieces = solver.advance(20040.0)
        ends += (pieces.time + pieces.length).tolist()
        shortest = min(shortest, pieces.length.min())
    assert np.abs(np.array(ends) - 20011.17).min() < 1e-11
    assert shortest > 1e-3


def test_only_the_quasistatic_pair_runs_away_and_it_says_so():
    assert [name for name in TABULATED if reduction(name).runs_away] == ["quasistatic"]
    with pytest.raises(NumericsError, match=r"quasistatic: no step is short enough at t = .*runs away"):
        follow(ReducedModel(slipwave.read("paper", ["slab.log10_r=-2.5"]), reduction("quasistatic")), 6000)


def test_a_drive_of_many_knots_is_marched_at_once_to_the_same_motion(monkeypatch):
    """120 stretches between knots: one batch of steps, and the impedances of all step lengths of a stretch in one call."""
    knots = np.linspace(0.0, 1.5, 121) ** 1.1
    velocities = 100.0 + 50.0 * np.cos(np.arange(121) ** 2)
    scene = dataclasses.replace(slipwave.read("paper"), drive=Drive(tuple(knots.tolist()), tuple(velocities.tolist())))
    calls = []
    monkeypatch.setattr(slabs, "impedance_at", lambda reduction, s: calls.append(s.size) or impedance_at(reduction, s))
    whole, parted = (ReducedModel(scene, reduction_of(scene, "quasidynamic"), 1e-9) for _ in range(2))
    calls.clear()
    pieces = whole.advance(float(knots[-1]))
    assert len(calls) == 119  # the first stretch had its own before
    parts = [parted.advance(float(knot)) for knot in knots[1:]]
    for ours, theirs in zip(pieces, map(np.concatenate, zip(*parts, strict=True)), strict=True):
        assert np.array_equal(ours, theirs)
    assert np.abs((pieces.time + pieces.length)[:, None] - knots[1:]).min(axis=0).max() < 1e-12


MOMENTS = (20.25, 20.75, 31.0, 40.0)
DRIVES = {"step": [[0, 100], [20, 100], [20, 200]], "ramp": [[0, 100], [20, 100], [30, 200]]}
SLABS = {
    "alike": ("paper", {"slab.log10_r": -2.75}, "modal"),
    "unlike": ("unlike", {"upper.r": 0.0017, "lower.r": 0.0026}, "modal"),
    "layered": ("layered", {"slab.log10_r": -2.75}, "modal"),
    "grip": ("grip", {"slab.log10_r": -2.75}, "fitted"),
    "machine": ("machine", {"slab.log10_r": -2.75}, "fitted"),
    "reflection": ("reflection", {"slab.log10_r": -2.75}, "fitted"),
}


def off_the_waves(scene, model):
    """ln v against the exact delay system at the MOMENTS."""
    exact, ours = delay_system(scene, 1e-11), ReducedModel(scene, reduction_of(scene, model), 1e-10)
    return np.abs([follow(ours, time).ln_v - follow(exact, time).ln_v for time in MOMENTS])


@pytest.mark.parametrize("name", SLABS)
@pytest.mark.parametrize("size", [4, pytest.param(16, marks=pytest.mark.slow)])
def test_reductions_converge_to_the_waves_of_a_ramp_at_the_outer_faces(name, size):
    """Four and sixteen terms against one mode, or a fit with two."""
    scene, changes, kind = SLABS[name]
    scene = slipwave.read_scene(scene, **changes, **{"start.size": 0.0, "drive.velocity": DRIVES["ramp"]})
    few, many = (off_the_waves(scene, f"{kind}:{count}").max() for count in (1 if kind == "modal" else 2, size))
    assert many < (0.5 if size == 4 else 0.06) * few


def test_a_step_of_the_drive_reaches_the_interface_half_a_transit_later():
    """As MODEL.md's modes with (-1)^k: what another program found; then ever less with the number of modes."""
    changes = {"slab.log10_r": -2.75, "start.size": 0.0, "drive.velocity": DRIVES["step"]}
    scene = slipwave.read_scene("paper", **changes)
    assert off_the_waves(scene, "modal:1") == pytest.approx([5.7e-3, 4.7e-3, 2.7e-4, 2.6e-4], rel=0.02)
    assert off_the_waves(scene, "modal:16") == pytest.approx([8.0e-4, 7.3e-4, 7.5e-7, 1.2e-5], rel=0.1)
    assert (off_the_waves(scene, "modal:64") < [2.5e-4, 2.5e-4, 1e-7, 1e-5]).all()


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


def test_steps_follow_the_motion_whatever_a_transit_is():
    """A sample of a tenth of the thickness between the same springs: as many steps, though a transit is a tenth."""
    counts = []
    for thickness in ("1 mm", "0.1 mm"):
        scene = read_scene(SHORT_RUN | {"slab": SAMPLE["slab"] | {"thickness": thickness}})
        counts.append(marched(ReducedModel(scene, reduction_of(scene, "quasidynamic"), TOLERANCE), scene.until).time.size)
    assert max(counts) < 200
    assert abs(counts[0] - counts[1]) < 0.1 * counts[0]

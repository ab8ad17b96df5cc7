"""Leaps over slow motion of unlike, gripped and machine-held slabs: the figures are those of a march of every transit."""

import dataclasses

import numpy as np
import pytest

import slipwave
from reduced.delay.break_points import DelayBreaks
from reduced.delay.leaping_network import LeapingNetwork
from reduced.delay.network import DelayNetwork
from reduced.delay.slow_motion import transfer_of
from reduced.delay.system import LeapingDelay, delay_system
from reduced.delay.transmission_lines import lines_of
from reduced.impedance.models import impedance
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.protocol import ProtocolObserver
from slipwave.scene.drive import Drive
from slipwave.solve import follow
from slipwave.solve.checkpoint import Checkpoints
from tests.granite import GRANITE

TOLERANCE = 1e-6
ROCK = {"density": 2650.0, "shear_modulus": 3e10, "thickness": 0.5}
HEAVY = {"density": 5300.0, "shear_modulus": 6e10, "thickness": 1.0}
MACHINE = {"kind": "machine", "area": "25 cm2", "stiffness": "100 kN/mm", "impedance": 0, "mass": "5 kg"}
KINDS = {
    "machine": {"slab": ROCK | {"face": MACHINE}},
    "grip": {"slab": ROCK | {"face": {"kind": "grip", "stiffness": 0.3, "impedance": 0.5}}},
    "spring": {"slab": ROCK | {"face": {"kind": "grip", "stiffness": 0.3, "impedance": 0.0}}},
    "unlike": {"upper": ROCK, "lower": HEAVY},
    "machine above": {"upper": ROCK | {"face": MACHINE}, "lower": HEAVY},
}
HOLD = Drive((0.0, 2000.0, 2000.0, 30_000.0, 30_000.0), (1.0, 1.0, 0.0, 0.0, 1.0))
STEPS = Drive((0.0, 2000.0, 2000.0, 22_000.0, 22_000.0), (1.0, 1.0, 3.0, 3.0, 0.3))
ODD = Drive((0.0, 2000.1, 2000.1, 30_000.37, 30_000.37), (1.0, 1.0, 0.0, 0.0, 1.0))


def sample(kind, drive):
    interface = {"law": "ageing", "a_star": 0.6, "a": 0.012, "b": 0.010}
    units = {"normal_stress": 1e7, "memory_length": 5e-6, "reference_velocity": 1e-6}
    tables = {"interface": interface | units, "drive": {"velocity": 1.0}, "start": {"size": 0.0}, **KINDS[kind]}
    return dataclasses.replace(slipwave.read(tables), drive=drive)


def test_the_transfer_to_slow_motion_is_the_impedance_of_the_slabs():
    """-Z(s) = c_(-1)/s + c_0 + c_1 s + .. on the transit clock, to the order of the terms left out."""
    for kind in KINDS:
        scene = sample(kind, HOLD)
        found = transfer_of(lines_of(scene))
        s = 0.05 * found.radius * np.exp(0.7j)
        series = sum(term * s ** (k - 1) for k, term in enumerate(found.stress))
        assert series == pytest.approx(-impedance(scene, s / scene.transit), rel=1e-6), kind


@pytest.mark.parametrize(
    ("kind", "drive", "least"),
    [
        ("machine", HOLD, 0.75),
        ("machine", ODD, 0.75),
        ("spring", HOLD, 0.75),
        ("unlike", HOLD, 0.5),
        ("machine above", HOLD, 0.5),
        ("grip", STEPS, 0.8),
    ],
)
def test_leapt_and_marched_runs_agree(kind, drive, least):
    """Also beyond a hold, in which waves last for ever, and after two changes of V. Measured: 5e-10."""
    scene, until = sample(kind, drive), 36_000.5
    leaping, marching = (LeapingNetwork(scene, TOLERANCE) for _ in range(2))
    protocols = [ProtocolObserver(scene, marching.nodes, until) for _ in range(2)]
    ends = [follow(leaping, until, protocols[:1]), follow(marching, until, [protocols[1]], leaps=False)]
    assert leaping.skipped > least * until
    assert marching.skipped == 0.0
    assert ends[0].psi == pytest.approx(ends[1].psi, abs=0.1 * TOLERANCE)
    assert ends[0].ln_v == pytest.approx(ends[1].ln_v, abs=0.1 * TOLERANCE)
    for ours, theirs in zip(*(one.figures for one in protocols), strict=True):
        for name in ("relaxation", "healing", "direct_effect", "slip_to_recovery"):
            found, known = getattr(ours, name), getattr(theirs, name)
            assert found == (None if known is None else pytest.approx(known, rel=TOLERANCE)), name


def test_a_leap_without_waves_has_pieces_everywhere():
    """They are those of the slow motion, and have its values also in the middle of a leap."""
    scene, until = sample("grip", STEPS), 36_000.5
    leaping, marching = (LeapingNetwork(scene, TOLERANCE) for _ in range(2))
    ours, theirs = (HistoryObserver(scene.law, leaping.nodes) for _ in range(2))
    follow(leaping, until, [ours])
    follow(marching, until, [theirs], leaps=False)
    assert leaping.skipped > 0.8 * until
    times = np.linspace(2500.0, until, 4321)
    found, known = ours.at(times), theirs.at(times)
    assert np.abs(found[:3] - known[:3]).max() < TOLERANCE
    assert found[3:] == pytest.approx(known[3:], abs=0.012 * TOLERANCE)


def test_waves_that_last_are_not_shown_by_long_pieces():
    """An observer that spans no gaps then gets every transit: in a hold the waves of its beginning never decay."""
    scene = sample("machine", HOLD)
    solver = LeapingNetwork(scene, TOLERANCE)
    follow(solver, 2000.0)
    before, seen = solver.skipped, HistoryObserver(scene.law, solver.nodes)
    follow(solver, 20_000.0, [seen])
    assert solver.skipped == before
    assert np.diff(seen.samples()[0]).max() < 1.0


def test_a_jump_of_the_drive_within_a_step_is_met_by_its_end():
    scene = dataclasses.replace(slipwave.read("machine"), drive=Drive((0.0, 20.3, 20.3), (100.0, 100.0, 130.0)))
    ours, theirs = LeapingNetwork(scene, 1e-9), DelayBreaks(scene, 1e-9)
    assert follow(ours, 60.0).psi == pytest.approx(follow(theirs, 60.0).psi, abs=1e-8)


@pytest.mark.parametrize("stop", [9_000.0, 31_000.0, 33_000.0, 60_000.0])
def test_a_run_resumed_after_a_leap_is_the_same_to_the_last_bit(stop, tmp_path):
    """Also where the next leap is no longer the first one, nor the pause the shortest. Beyond, of alike slabs."""
    march, scene, until = LeapingNetwork, sample("machine", ODD), 36_000.5
    if stop > 31_000.0:
        march, scene, until = LeapingDelay, slipwave.read(GRANITE), 65_000.0
    straight, again = (march(scene, tolerance=TOLERANCE) for _ in range(2))
    kept, later = (EventObserver(scene, straight.nodes) for _ in range(2))
    end = follow(straight, until, [kept], marks=[Checkpoints(straight, {"events": kept}, tmp_path / "kept.npz", until, stop)])
    marks = Checkpoints(again, {"events": later}, tmp_path / "kept.npz", until, stop)
    marks.resume()
    assert stop <= again.time < until
    assert again.skipped > 0.0
    assert follow(again, until, [later]) == end
    for ours, theirs in ((again.state(), straight.state()), (later.state(), kept.state())):
        assert all(np.array_equal(ours[name], theirs[name], equal_nan=True) for name in theirs)


def test_nothing_is_leapt_over_where_steady_sliding_is_left_quickly():
    scene = slipwave.read("unlike")
    solver, plain = delay_system(scene, 1e-6), DelayNetwork(scene, 1e-6)
    assert isinstance(solver, LeapingNetwork)
    assert follow(solver, 1500.0, [EventObserver(scene, solver.nodes)]).psi == pytest.approx(follow(plain, 1500.0).psi, abs=1e-6)
    assert solver.skipped == 0.0


def test_tries_that_fail_are_made_ever_more_rarely(monkeypatch):
    """Of steel on PMMA, which sticks for too short a time: after a try that is given up late, twice as long as before."""
    scene, began = slipwave.read("steel-on-pmma"), []
    solver = LeapingNetwork(scene, TOLERANCE)
    check = solver._check
    monkeypatch.setattr(solver, "_check", lambda split, count: began.append(solver.time) or check(split, count))
    follow(solver, 40_000.0, [EventObserver(scene, solver.nodes)])
    assert solver.skipped == 0.0
    assert len(began) == 4
    assert began[1] - began[0] == pytest.approx(2048.0, abs=2.0)
    assert solver.state()["leaps"][1] == 1024.0 * 2.0 ** len(began)

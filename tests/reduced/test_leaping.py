"""Leaps over long sticks and slow motion: the figures are those of a march of every transit."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

import slipwave
from reduced.delay.alike import Delay
from reduced.delay.break_points import DelayBreaks
from reduced.delay.leaping_network import LeapingNetwork
from reduced.delay.multirevolution import MarchedTransits, sum_rules
from reduced.delay.slow_motion import SlowMotion
from reduced.delay.stroboscopic_kernel import _sum_of_new, _weights_of_sum, turns
from reduced.delay.system import LeapingDelay, delay_system
from reduced.delay.transmission_lines import lines_of
from reduced.impedance.models import impedance
from slipwave.friction import rates
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.pieces import Pieces
from slipwave.observe.protocol import ProtocolObserver
from slipwave.scene.drive import Drive
from slipwave.solve import follow
from slipwave.solve.checkpoint import Checkpoints
from slipwave.step.nodal import Limits
from tests.granite import GRANITE, SAMPLE
from tests.verification.order import assert_order

CYCLE = 80_000.0
"""Transits; two slip events of granite, and the rise after the second."""


def granite(**drive):
    """Slabs of granite, 10 m thick, driven at 1 um/s: a stick lasts 57,000 transits; or with some other drive."""
    return slipwave.read(GRANITE | {"drive": {"velocity": 1.0} | drive})


class Seen:
    """An observer that keeps all pieces, with their gaps."""

    whole_from = np.inf

    def __init__(self):
        self._parts = []

    def scan(self, pieces):
        self._parts.append(pieces)

    @property
    def pieces(self):
        return Pieces.joined(self._parts)


def watched(solver, until, marks=()):
    """Events and pieces of a run, and its end."""
    events, seen = EventObserver(solver.scene, solver.nodes), Seen()
    return events, seen, follow(solver, until, [events, seen], marks=marks)


@pytest.fixture(scope="module", params=[1e-6, 1e-8])
def both(request):
    """The tolerance, a run with leaps, and the same by the march without."""
    leaping, plain = (kind(granite(), tolerance=request.param) for kind in (LeapingDelay, Delay))
    every = EventObserver(plain.scene, plain.nodes)
    return request.param, leaping, watched(leaping, CYCLE), every, follow(plain, CYCLE, [every])


def test_a_cycle_has_the_figures_of_the_march_without_leaps(both):
    """Measured: 0.03 to 0.5 of the tolerance; for v_min, the value of one transit, 0.8 to 1.1."""
    tolerance, leaping, (ours, _, end), every, wanted = both
    found, known = ours.events(), every.events()
    assert leaping.skipped > 50_000
    assert found.time.size == known.time.size == 1
    for name in ("period", "stress_drop", "elastic_stress_drop", "v_max"):
        assert getattr(found, name) == pytest.approx(getattr(known, name), rel=5.0 * tolerance), name
    assert found.v_min == pytest.approx(known.v_min, rel=10.0 * tolerance)
    assert end.psi == pytest.approx(wanted.psi, abs=5.0 * tolerance)


def test_only_whole_transits_without_events_are_left_out(both):
    """Of the stick and, where it pays, of the rise of v after it, in which y falls."""
    tolerance, leaping, (ours, seen, _), _, _ = both
    pieces = seen.pieces
    ends = pieces.time + pieces.length
    gap = np.flatnonzero(pieces.time[1:] - ends[:-1] > 1e-9)
    lengths = pieces.time[gap + 1] - ends[gap]
    assert (lengths, lengths.sum()) == (pytest.approx(np.round(lengths), abs=1e-9), pytest.approx(leaping.skipped))
    assert pieces.time[gap + 1] == pytest.approx(np.round(pieces.time[gap + 1]), abs=1e-9)
    assert all(((pieces.time < date) & (date < ends)).any() for date in ours.dates())
    rising = pieces.y[gap + 1, 0] > pieces.y[gap, -1]
    assert lengths[rising].sum() > 50_000
    assert (lengths[~rising].sum() > 500) == (tolerance == 1e-6)
    assert pieces.z[gap + 1].max() < 1.0


@pytest.mark.parametrize(
    ("velocity", "leaps_again"),
    [
        ([[30_000.25, 1.0], [30_010.5, 2.0]], True),
        ([[30_000.0, 1.0], [35_000.0, 3.0]], False),  # 1000 transits are left
        ([[20_000.0, 1.0], [20_100.0, 0.0]], True),
        ([[30_000.0, 1.0], [30_000.5, 1.3], [30_001.0, 1.0]], True),
    ],
    ids=["step", "long ramp", "hold", "pulse"],
)
def test_no_leap_crosses_a_change_of_the_drive(velocity, leaps_again):
    scene = granite(velocity=velocity)
    leaping, plain = (kind(scene, tolerance=1e-6) for kind in (LeapingDelay, Delay))
    _, seen, found = watched(leaping, 36_000.4)
    known = follow(plain, 36_000.4)
    assert (found.psi, found.mu) == (pytest.approx(known.psi, abs=2e-6), pytest.approx(known.mu, abs=5e-4))
    pieces = seen.pieces
    begins, ends = pieces.time[1:], (pieces.time + pieces.length)[:-1]
    gap = begins - ends > 1e-9
    first, last = scene.drive.knots[0], scene.drive.knots[-1]
    assert gap[ends < first].any()
    assert not (gap & (begins > first - 1.0) & (ends < last)).any()
    assert gap[ends >= last].any() == leaps_again


SMALL = GRANITE | {"start": {"size": 1e-4}}


@pytest.mark.parametrize(
    ("source", "until"),
    [("paper", 1500.0), ("rock", 1500.0), (SMALL, 20_000.0), ("unlike", 1500.0)],
    ids=["paper", "rock", "small", "unlike"],
)
def test_nothing_changes_where_sticks_are_short_or_a_small_disturbance_grows(source, until):
    scene = slipwave.read(source)
    leaping, plain = (delay_system(scene, tolerance=1e-6) for _ in range(2))
    assert isinstance(leaping, LeapingNetwork if source == "unlike" else LeapingDelay)
    (ours, seen, end), theirs = watched(leaping, until), EventObserver(scene, plain.nodes)
    assert end == follow(plain, until, [theirs], leaps=False)
    assert np.array_equal(ours.dates(), theirs.dates())
    assert leaping.skipped == 0
    assert seen.pieces.time[1:] == pytest.approx((seen.pieces.time + seen.pieces.length)[:-1], abs=1e-9)
    assert abs(end.psi - scene.steady_psi) > 5e-4


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
        motion = SlowMotion(scene, lines_of(scene), 8, Limits(1e-12, 1e-9, 1.0))
        s = 0.05 * motion.radius * np.exp(0.7j)
        series = sum(term * s ** (k - 1) for k, term in enumerate(motion.to_stress))
        assert series == pytest.approx(-impedance(scene, s / scene.transit), rel=1e-6), kind


@pytest.mark.parametrize(
    ("kind", "drive", "least"),
    [
        ("machine", HOLD, 0.7),
        ("machine", ODD, 0.7),
        ("spring", HOLD, 0.7),
        ("unlike", HOLD, 0.5),
        ("machine above", HOLD, 0.5),
        ("grip", STEPS, 0.75),
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


def test_rounding_is_no_error_of_a_leap():
    """Of a sample of 1 mm on a spring, at 1e-9. Measured: 1e-11."""
    scene, until = slipwave.read(SAMPLE), 100_000.0
    leaping, marching = (LeapingNetwork(scene, 1e-9) for _ in range(2))
    ends = [follow(leaping, until), follow(marching, until, leaps=False)]
    assert leaping.skipped > 0.8 * until
    assert ends[0].psi == pytest.approx(ends[1].psi, abs=1e-10)
    assert ends[0].ln_v == pytest.approx(ends[1].ln_v, abs=1e-10)
    assert ends[0].mu == pytest.approx(ends[1].mu, abs=1e-11)


STIFF = {"slab": SAMPLE["slab"] | {"face": SAMPLE["slab"]["face"] | {"stiffness": "40 GPa/m", "mass": "100 kg/m2"}}}


def test_a_leap_is_corrected_by_the_steps_behind_it():
    """Leaps of a hold, which double its time. Measured: 1e-9; by the trapezoidal rule 2.8e-9, not corrected 5.5e-9."""
    hold = {"velocity": [["0 s", "10 um/s"], ["60 ms", "10 um/s"], ["60 ms", "0 um/s"]]}
    scene = slipwave.read(SAMPLE | STIFF | {"start": {"size": 0.0}, "drive": hold})
    leaping, exact = (watched(LeapingNetwork(scene, tolerance), 4e6)[2] for tolerance in (1e-8, 1e-10))
    assert leaping.ln_v == pytest.approx(exact.ln_v, abs=2e-9)
    assert leaping.psi == pytest.approx(exact.psi, abs=1e-9)


def test_leaps_let_psi_relax_to_steady_sliding():
    """A stiff machine, 15 s after a jump: a march's psi stops 6e-10 before, where rounding takes all of its change in a step."""
    scene = slipwave.read(SAMPLE | STIFF)
    assert follow(LeapingNetwork(scene, 1e-9), 2.5e7).psi == pytest.approx(scene.steady_psi, abs=3e-12)


def test_no_event_begins_in_a_gap():
    """Waves of 1e-9 in ln v remain when v rises over V, and y begins to fall: a leap there shows its slow motion."""
    scene = slipwave.read(SAMPLE)
    solver = LeapingNetwork(scene, 1e-9)
    events = EventObserver(scene, solver.nodes)
    follow(solver, 2e7, [events])
    assert events.dates()[-1] == pytest.approx(19_208_666.5, abs=0.2)
    assert solver.skipped > 0.97 * 2e7


@pytest.mark.parametrize("velocity", [0.0, 3.0])
@pytest.mark.parametrize("kind", ["machine", "grip", "spring", "unlike", "layered", "reflection"])
def test_a_block_is_its_map_without_slip_and_the_slip_in_it(kind, velocity):
    """After a change of V from 1, with any slip rate. Leaps over blocks rest on it. Measured: 5e-14 of the change."""
    scene = sample(kind, HOLD) if kind in KINDS else slipwave.read(kind)
    drive = Drive((0.0, 200.0, 200.0), tuple(scene.velocity * pace for pace in (1.0, 1.0, velocity)))
    solver = LeapingNetwork(dataclasses.replace(scene, drive=drive), TOLERANCE)
    follow(solver, 400.0, leaps=False)
    block, still = solver._block_of(solver._repeating_steps()), solver._translation()
    before, psi = solver._now().vector - still, solver.state()["now"][1]
    pieces = solver._marched(block.steps)
    slip = (rates(scene.law, pieces.z) - drive.at(solver.time)).ravel() @ block.by_slip
    slip[-2] = solver.state()["now"][1] - psi
    held = block.powers[0].T
    miss = held @ (solver._now().vector - still - held @ before - slip)  # once more: what no wave reads any more is left out
    assert np.abs(miss).max() < 1e-12 * np.abs(held @ slip).max() + 1e-15


@pytest.mark.parametrize("jumps", [(), (0.0, 2.0)], ids=["hold", "jump in the stick"])
@pytest.mark.parametrize("face", [SAMPLE["slab"]["face"], {"kind": "rigid"}], ids=["soft spring", "rigid"])
def test_leaps_over_blocks_of_a_stick_keep_its_large_waves(face, jumps, monkeypatch):
    """A stiff sample that slides at 1 cm/s heals at once and sticks, and V stops: waves stay that change ln v by 2 and
    4, also where V jumps while it sticks. Leaps of the linear theory are switched off. Measured: 5e-11."""
    slab = SAMPLE["slab"] | {"face": face}
    scene = slipwave.read(SAMPLE | {"slab": slab, "start": {"kind": "jump", "size": 12.0}, "drive": {"velocity": 1e4}})
    drive, until = Drive((0.0, 1.0, 2.0, *(20_000.0 for _ in jumps)), (1e4, 1e4, 0.0, *jumps)), 40_000.0
    scene = dataclasses.replace(scene, drive=drive)
    leaping, marching = (LeapingNetwork(scene, 1e-9) for _ in range(2))
    monkeypatch.setattr(leaping, "_leap", lambda stop, gaps: None)
    (_, seen, end), known = watched(leaping, until), follow(marching, until, leaps=False)
    pieces = seen.pieces
    begins, ends = pieces.time[1:], (pieces.time + pieces.length)[:-1]
    gaps = (begins - ends)[begins - ends > 1e-6]
    assert np.ptp(pieces.z[-100:]) > 1.0
    assert gaps.sum() == pytest.approx(leaping.skipped, rel=1e-9)
    assert leaping.skipped > 0.5 * until
    assert gaps == pytest.approx(2.0 * np.round(0.5 * gaps), abs=1e-6)  # blocks last two transits
    for name in ("psi", "ln_v", "mu"):
        assert getattr(end, name) == pytest.approx(getattr(known, name), abs=1e-10), name


@pytest.mark.parametrize(("tolerance", "followed"), [(TOLERANCE, 0), (1e-8, 1000)])
def test_kinks_of_the_drive_are_followed_until_they_have_decayed(tolerance, followed):
    """A spring without a mass lets each jump of V kink the waves, between the ends of equal steps. Measured: 1e-9, 3e-9."""
    scene, until = sample("spring", ODD), 36_000.5
    leaping, marching = (delay_system(scene, tolerance=tolerance) for _ in range(2))
    assert isinstance(leaping, DelayBreaks)
    events = [EventObserver(scene, leaping.nodes) for _ in range(2)]
    ends = [follow(leaping, until, events[:1]), follow(marching, until, events[1:], leaps=False)]
    assert leaping.skipped > 0.75 * until
    assert marching.skipped == 0.0
    assert followed <= leaping.break_points <= 5 * followed
    assert ends[0].psi == pytest.approx(ends[1].psi, abs=0.5 * tolerance)
    assert ends[0].ln_v == pytest.approx(ends[1].ln_v, abs=0.5 * tolerance)


def test_a_jump_whose_echoes_last_is_followed_for_ever():
    """Rigid faces and a hold damp no wave."""
    scene = sample("unlike", ODD)
    solver = delay_system(scene, tolerance=TOLERANCE)
    follow(solver, 4000.0)
    assert (solver.skipped, solver.break_points) == (0.0, 4001)


def test_a_leap_without_waves_has_pieces_everywhere():
    """They are those of the slow motion, and have its values also in the middle of a leap."""
    scene, until = sample("grip", STEPS), 36_000.5
    leaping, marching = (LeapingNetwork(scene, TOLERANCE) for _ in range(2))
    ours, theirs = (HistoryObserver(scene.law, leaping.nodes) for _ in range(2))
    follow(leaping, until, [ours])
    follow(marching, until, [theirs], leaps=False)
    assert leaping.skipped > 0.75 * until
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


@pytest.mark.parametrize("stop", [9_000.0, 9_001.0, 31_000.0, 31_001.0, 33_000.0, 60_000.0])
def test_a_run_resumed_after_a_leap_is_the_same_to_the_last_bit(stop, tmp_path):
    """Of each march; also where breaks were followed before, and beyond."""
    march, scene, until = LeapingNetwork, sample("machine", ODD), 36_000.5
    if stop in (9_001.0, 31_001.0):
        march, scene = DelayBreaks, sample("spring", ODD)
    elif stop > 31_000.0:
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


RATE, LAST, ORDER = 1e-4, 30_000, 6
LENGTHS = {6: np.array([600, 500, 400, 300, 200]), 8: np.array([625, 500, 400, 320, 300])}
"""By order: that of alike slabs' leaps, and that of leaps over blocks."""


def change(state):
    """What one transit does to two states: logistic growth, and a decay that it drives."""
    return RATE * np.array([state[0] * (1.0 - state[0]), state[0] ** 2 - 0.5 * state[1]])


def every_transit():
    states = [np.array([0.2, 1.0])]
    for _ in range(LAST):
        states.append(states[-1] + change(states[-1]))
    return states


EVERY = every_transit()


def known(number):
    """The latest transits, of these numbers, as the march knows them."""
    order = len(number)
    return MarchedTransits(
        order, np.array(number, dtype=float), np.array([change(EVERY[n]) for n in number]), np.zeros((order, 1))
    )


def leapt(length, order):
    """The state at LAST by leaps of equal `length` from known transits."""
    number = np.arange(LAST % length, LAST + 1, length)
    past, state = known(number[:order]), EVERY[number[order - 1]]
    for now, target in pairwise(number[order - 1 :].tolist()):
        state = state + past.change[-1] + past.total(now + 1.0, target)
        past = past.then(target, change(state), np.zeros(1))
    return state


def estimate(length, order):
    """Of a leap from the middle; it is the difference between both sums."""
    middle = LAST // 2
    past = known(middle + length * np.arange(1 - order, 1))
    longer = past.then(middle + length, change(EVERY[middle + length]), np.zeros(1))
    first, target = middle + 1.0, middle + length
    found = past.error(first, target, longer.change[-1])
    assert found == pytest.approx(longer.total(first, target) - past.total(first, target), abs=1e-15)
    return np.abs(found).max()


@pytest.mark.parametrize("order", LENGTHS)
def test_leaps_have_the_declared_order(order):
    lengths = LENGTHS[order]
    errors = [np.abs(leapt(length, order) - EVERY[LAST]).max() for length in lengths]
    assert_order(errors, lengths, order, tolerance=0.4, absolute=1e-10)


@pytest.mark.parametrize("order", LENGTHS)
def test_the_estimated_error_of_a_leap_is_one_order_smaller(order):
    lengths = LENGTHS[order]
    errors = [estimate(length, order) for length in lengths]
    assert_order(errors, lengths, order + 1, tolerance=0.4, absolute=1e-10)


@pytest.mark.parametrize("last", [62.0, 63.0, 64.0, 150.0])
def test_sums_are_exact_for_polynomials(last):
    """Transits at unequal distances, as the control of the error makes them; sums of one, two, three and many terms."""
    past = MarchedTransits(ORDER, np.empty(0), np.empty((0, 1)), np.empty((0, 1)))
    for n in (7.0, 11.0, 12.0, 20.0, 44.0, 60.0):
        past = past.then(n, np.array([(n / 50.0) ** 5 - n]), np.zeros(1))
    ahead = np.arange(61.0, last)
    assert abs(past.total(61.0, last)[0] / np.sum((ahead / 50.0) ** 5 - ahead) - 1.0) < 1e-10


def test_peaks_between_two_transits_are_found():
    """Two of four quantities turn at 51.3 and 44.8, one turned before 44, one rises all the time; twice the same counts once."""
    past = MarchedTransits(ORDER, np.empty(0), np.empty((0, 1)), np.empty((0, 5)))
    for n in (7.0, 11.0, 12.0, 20.0, 44.0, 60.0):
        past = past.then(
            n, np.zeros(1), np.array([-((n - 51.3) ** 2), -((n - 44.8) ** 2), -((n - 30.0) ** 2), n, 2 * n - n**2 / 102.6])
        )
    assert (past.peaks(44.0, 60.0), past.peaks(59.0, 60.0)) == ([45.0, 51.0], [])
    assert past._replace(highest=-past.highest).peaks(44.0, 60.0) == []


@pytest.mark.parametrize("distance", [1, 2, 3, 40])
def test_compiled_leaps_are_those_in_plain_numpy(distance):
    """Sums over what a leap leaves out, what the block after it changes in them, and the blocks in which something turns."""
    number, random = np.array([3.0, 5.0, 12.0, 20.0, 24.0, 30.0]), np.random.default_rng(distance)
    past, new = MarchedTransits(ORDER, number, random.random((ORDER, 3)), random.random((ORDER, 4))), random.random(3)
    first, last = 31.0, 31.0 + distance
    later = past.then(last, new, random.random(4))
    rule = [table[distance] for table in sum_rules(ORDER)]
    assert _weights_of_sum(number, first, *rule) @ past.change == pytest.approx(past.total(first, last), rel=1e-12)
    change = _sum_of_new(later.number, first, *rule) * (new - past._rows(np.array([last]))[0] @ past.change)
    assert change == pytest.approx(past.error(first, last, new), rel=1e-12)
    assert turns(later.number, later.highest).tolist() == later.peaks(number[-1], last)

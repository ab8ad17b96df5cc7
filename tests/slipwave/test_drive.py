"""V(t) and the nudge, the stages that a drive has, and what they show of friction: closed forms."""

import math

import numpy as np
import pytest

import slipwave
from slipwave.compiled import allocating
from slipwave.observe import Pieces
from slipwave.observe.protocol import ProtocolObserver, _Course, stages_of
from slipwave.scene.drive import NUDGE_CENTRE, Constant, Drive, Ramps, nudge_rate, side_of, velocity_at
from slipwave.solve import follow
from validation.models.build import prepare

MANY = 10_000


@allocating
def sampled(drive, times):
    found = np.empty(times.size)
    for k in range(times.size):
        found[k] = velocity_at(drive, times[k], times[k])
    return found


@pytest.mark.parametrize("knots", [2, 3, MANY])
def test_ramps_are_the_broken_line_through_the_knots(knots):
    draw = np.random.default_rng(knots)
    drive = Drive(tuple(np.cumsum(draw.uniform(0.1, 2.0, knots)).tolist()), tuple(draw.uniform(-3.0, 5.0, knots).tolist()))
    times = np.linspace(drive.times[0] - 1.0, drive.times[-1] + 1.0, 4001)
    expected = np.interp(times, drive.times, drive.velocities)
    np.testing.assert_allclose(sampled(drive.compiled, times), expected, rtol=0, atol=1e-12)  # of slopes up to 80, times to 1e4
    np.testing.assert_allclose([drive.at(float(time)) for time in times[::40]], expected[::40], rtol=0, atol=1e-12)


def test_the_next_knot_lies_after_a_time():
    drive = Drive((0.0, 5.0, 5.0, 7.0), (1.0, 1.0, 2.0, 3.0))
    assert [drive.knot_after(time) for time in (-1.0, 0.0, 4.9, 5.0, 6.0, 7.0)] == [0.0, 5.0, 5.0, 7.0, 7.0, math.inf]
    assert Drive((0.0, 5.0), (1.0, 1.0)).knot_after(0.0) == math.inf


@pytest.mark.parametrize("before", [2, 999])
def test_a_time_given_twice_is_a_step(before):
    times = (*(float(k) for k in range(before)), 1000.0, 1000.0, 1003.0)
    drive = Drive(times, (4.0,) * before + (4.0, 7.0, 1.0))
    near = np.nextafter(1000.0, 0.0)
    assert sampled(drive.compiled, np.array([near, 1000.0, 1001.5, 1003.0])).tolist() == [4.0, 7.0, 4.0, 1.0]
    assert drive.knots == (*times[:-2], 1003.0)


def test_a_step_of_a_march_sees_one_stretch_of_the_drive():
    drive = Drive((0.0, 5.0, 5.0, 6.0), (1.0, 3.0, 8.0, 10.0)).compiled
    assert isinstance(drive, Ramps)
    assert [velocity_at(drive, time, 4.9) for time in (5.0, 5.0 + 1e-9, 0.0)] == pytest.approx([3.0, 3.0, 1.0], abs=1e-8)
    assert [velocity_at(drive, time, 5.1) for time in (5.0, 5.0 - 1e-9, 6.0)] == pytest.approx([8.0, 8.0, 10.0], abs=1e-8)
    assert [velocity_at(drive, time, 6.5) for time in (5.9, 6.0, 7.0)] == [10.0] * 3
    # fixed steps leave their stretch at a kink, not at a jump
    assert [side_of(drive, *step) for step in ((4.9, 5.1), (5.0, 4.9), (5.2, 5.1), (6.1, 5.9))] == [5.1, 4.9, 5.2, 6.1]
    assert [side_of(Drive((3.0, 3.0), (1.0, 2.0)).compiled, *step) for step in ((2.9, 3.1), (2.8, 2.9))] == [3.1, 2.8]


def test_only_a_drive_that_changes_is_searched():
    assert Drive((0.0, 4.0), (2.0, 2.0)).compiled == Constant(2.0)
    assert [Drive((0.0, 4.0), (2.0, last)).knots for last in (2.0, 3.0)] == [(), (0.0, 4.0)]
    at_once = Drive((0.0, 0.0), (2.0, 5.0))
    assert (at_once.initial, at_once.at(0.0), at_once.knots, at_once.rests_from(0.0)) == (2.0, 5.0, (0.0,), True)


@pytest.mark.parametrize("late", [-6.0, -1.5, 0.0, 0.3, 6.9])
def test_the_nudge_is_a_bell_around_its_centre(late):
    for size in (0.5, 1.0):
        assert nudge_rate(size, NUDGE_CENTRE + late) == pytest.approx(size * math.exp(-(late**2)), rel=1e-13)
        assert nudge_rate(size, NUDGE_CENTRE + 7.1) == 0.0  # exp(-49) is below rounding


KNOTS = [(0, 1), (5, 1), (5, 10), (8, 10), (8, 0), (12, 0), (12, 1), (15, 1), (20, 3), (25, 3)]


def test_every_kind_of_stage():
    drive = Drive(*zip(*KNOTS, strict=True))
    found = [(stage.kind, stage.start, stage.end, stage.before, stage.velocity) for stage in stages_of(drive, 40.0)]
    assert found == [
        ("start", 0.0, 5, 1, 1),
        ("step", 5, 8, 1, 10),
        ("hold", 8, 12, 10, 0),
        ("slide", 12, 15, 0, 1),
        ("ramp", 15, 20, 1, 3),
        ("level", 20, 40.0, 3, 3),
    ]
    assert stages_of(drive, 17.5)[-1] == ("ramp", 15, 17.5, 1, 2.0)  # cut off by the end of the run
    assert [stage.sign for stage in stages_of(drive, 40.0)] == [1.0, 1.0, -1.0, 1.0, 1.0, 1.0]


def ringing(rate, period):
    """What is seen of a step after which ln v oscillates about ln V with an amplitude of 2 exp(-rate t)."""
    scene = slipwave.read("paper", {"drive.velocity": [[0, 100], [20, 100], [20, 300]], "run.until": 220})
    nodes = np.array([0.2, 0.5, 1.0])
    observer, begins = ProtocolObserver(scene, nodes, 220.0), np.arange(0.0, 220.0)
    time = begins[:, None] + nodes
    swing = np.where(time > 20.0, 2.0 * np.exp(-rate * (time - 20.0)) * np.sin(2 * np.pi * time / period), 0.0)
    velocity = np.where(time > 20.0, 300.0, 100.0)
    observer.scan(Pieces(begins, np.ones(220), np.log(velocity) + swing, swing, 0.3 + 0.01 * swing, swing))
    return observer


def test_a_ringing_that_decays_is_no_stick_slip():
    start, rings = ringing(0.006, 12.0).figures
    assert (start.steady_stress, start.stick_slips) == (0.3, False)
    assert (rings.steady_stress, rings.stick_slips) == (None, False)
    assert ringing(0.0, 12.0).figures[1].stick_slips
    assert not ringing(0.0, 300.0).figures[1].stick_slips  # one way through, no cycle


def test_stick_slip_whose_slip_reverses_has_no_figures():
    """Cycles through v < 0 since a step; before, its first peak was a direct effect of 7e-5, where a ln(V2/V1) is 3.5e-3."""
    law = {"law": "ageing-regularised", "a_star": 0.02, "a": 0.005, "b": 0.02}
    drive = {"velocity": [[0, 1], [20, 1], [20, 2]]}
    scene = {"interface": law, "slab": {"epsilon": 1e-6, "r": 0.02}, "drive": drive, "start": {"size": 0.0}}
    found = slipwave.run(scene, "block8", until=200)
    assert found.v_min < 0.0
    step = found.summary["protocol"][1]
    assert (step["stick_slips"], step["direct_effect"], step["slip_to_recovery"]) == (True, None, None)


@pytest.mark.parametrize(("end", "whole_from"), [(3, math.inf), (20, 0.0), (25, 0.0), (120, math.inf)])
def test_a_protocol_goes_on_as_without_a_stop(end, whole_from):
    """Inside the start, at a jump, after the peak of a step and in the middle of a hold."""
    drive = [[0, 100], [20, 100], [20, 300], [100, 300], [100, 0], [150, 0], [150, 100]]
    scene = slipwave.read("paper", {"slab.log10_r": -3.0, "start.size": 0.0, "drive.velocity": drive, "run.until": 220})
    rng = np.random.default_rng(1)
    parts = [Pieces(np.array([t]), np.ones(1), *(4.0 + 0.1 * rng.standard_normal((4, 1, 3)))) for t in np.arange(0.0, 220.0)]
    whole, before, after = (ProtocolObserver(scene, np.array([0.2, 0.5, 1.0]), 220.0) for _ in range(3))
    for part in parts:
        whole.scan(part)
    for part in parts[:end]:
        before.scan(part)
    after.restore(before.state())
    assert after.whole_from == before.whole_from == whole_from
    for part in parts[end:]:
        after.scan(part)
    assert repr(after.figures) == repr(whole.figures)
    assert [stage.reached for stage in after._seen] == [20.0, 100.0, 150.0, 220.0]


def test_a_peak_between_nodes_is_found_also_after_the_stress_has_come_back():
    """Two parabolas over nodes that miss their peaks, in pieces of their own, and a fall to the steady stress between them."""
    scene = slipwave.read("paper", {"drive.velocity": [[0, 100], [20, 100], [20, 300]], "run.until": 60})
    nodes, steady = np.array([0.2, 0.5, 1.0]), scene.steady_stress
    observer = ProtocolObserver(scene, nodes, 60.0)

    def take(time, velocity, mu):
        shape = np.full((1, 3), math.log(velocity))
        observer.scan(Pieces(np.array([time]), np.array([10.0]), shape, shape, np.array([mu]), shape))

    take(10.0, 100.0, [steady] * 3)
    for time, peak in ((20.0, 0.02), (40.0, 0.03)):
        take(time, 300.0, list(steady + peak - 0.1 * (nodes - 0.75) ** 2))
        take(time + 10.0, 300.0, [steady - 0.02] * 3)
        assert observer.figures[1].direct_effect == pytest.approx(peak, abs=1e-12)


@pytest.mark.parametrize(("gap", "known"), [(1, True), (3, False), (5, True)])
@pytest.mark.parametrize("at_once", [True, False])
def test_slip_across_a_gap_is_not_known(gap, known, at_once):
    """Transits that are left out before a peak or after the recovery from it take nothing from the figures."""
    scene = slipwave.read("paper", {"drive.velocity": [[0, 100], [20, 100], [20, 300]], "run.until": 60})
    ends = scene.steady_stress + np.array([0.0, 0.01, 0.02, 0.03, 0.02, -0.01, -0.01, 0.0])
    stress = np.column_stack([0.5 * (np.append(ends[0], ends[:-1]) + ends), ends])
    begins = np.append(19.0, np.arange(20.0, 27.0))
    begins[gap + 1 :] += 4.0
    velocity = np.append(100.0, np.full(7, 300.0))[:, None] * np.ones(2)
    pieces = Pieces(begins, np.ones(8), *[np.log(velocity)] * 2, stress, np.log(velocity))
    whole, gapped = (ProtocolObserver(scene, np.array([0.5, 1.0]), 60.0) for _ in range(2))
    whole.scan(pieces._replace(time=19.0 + np.arange(8.0)))
    for part in [pieces] if at_once else [pieces.part(slice(k, k + 1)) for k in range(8)]:
        gapped.scan(part)
    assert whole.figures[1].slip_to_recovery > 100.0 * scene.transit
    assert gapped.figures[1].slip_to_recovery == (whole.figures[1].slip_to_recovery if known else None)
    assert gapped.figures[1].direct_effect == whole.figures[1].direct_effect


A, B, X = 0.01, 0.015, 10.0
HOLD = 30.0
"""In L/V."""

LEFT = {
    ("slip", X): 1.0,
    ("slip", 1 / X): 1.0,
    ("ageing", X): -math.log((X ** (1 / math.e) - 1) / (X - 1)),
    ("ageing", 1 / X): -math.log((X ** (-1 / math.e) - 1) / (1 / X - 1)),
}
"""Slip (in L) until 1/e of the evolution is left."""


@pytest.mark.parametrize("law", ["ageing", "slip"])
def test_a_stiff_loading_shows_the_law(law):
    """A step up, a step down, a hold and a restart, by the quasi-static pair; one L of slip at V takes so many transits."""
    n, stiffness = 200, 1e4  # in sigma/L
    knots = [[0, 1], [n, 1], [n, X], [3 * n, X], [3 * n, 1], [15 * n, 1], [15 * n, 0], [(15 + HOLD) * n, 0], [(15 + HOLD) * n, 1]]
    interface, slab = {"law": law, "a_star": 0.6, "a": A, "b": B}, {"r": 1 / n, "epsilon": stiffness / n}
    run = {"start.size": 0.0, "drive.velocity": knots, "run.until": (30 + HOLD) * n}
    scene = slipwave.read("paper", {"interface": interface, "slab": slab} | run)
    solver = prepare("quasistatic", scene).solver
    observer = ProtocolObserver(scene, solver.nodes, scene.until)
    follow(solver, scene.until, [observer])
    start, up, down, hold, slide = observer.figures
    assert [stage.kind for stage in (start, up, down, hold, slide)] == ["start", "step", "step", "hold", "slide"]
    for stage, x in ((up, X), (down, 1 / X)):
        assert stage.direct_effect == pytest.approx(A * math.log(x), abs=2e-5)  # 2e-6 measured: b/stiffness
        assert stage.evolution == pytest.approx(B * math.log(x), abs=2e-5)
        assert stage.slip_to_recovery == pytest.approx(LEFT[law, x], abs=2e-4)  # 2e-5 measured
    healed = B * math.log1p(HOLD) if law == "ageing" else 0.0
    assert slide.healing == pytest.approx(healed, abs=3e-5)  # 3e-6 measured
    assert start.steady_stress == pytest.approx(0.6, abs=1e-11)  # 1.3e-12 measured
    assert slide.steady_stress == pytest.approx(0.6, abs=2e-6)  # B HOLD exp(-15)
    assert hold.relaxation is not None
    assert not any(stage.stick_slips for stage in (start, up, down, hold, slide))


def test_a_full_wave_shows_the_stages_of_the_delay_system():
    """Slabs whose waves matter: without them the direct effect is 9 % smaller."""
    knots = [[0, 100], [20.3, 100], [20.3, 300], [120, 300], [120, 0], [150, 0], [150, 300]]
    changes = {"slab.log10_r": -3.2, "start.size": 0.0, "drive.velocity": knots, "run.until": 260}
    exact, grid, still = (
        slipwave.run("paper", model, cells=cells, **changes).summary["protocol"]
        for model, cells in (("delay", None), ("fd", 100), ("quasidynamic", None))
    )
    for stage, name in ((1, "direct_effect"), (1, "evolution"), (1, "slip_to_recovery"), (2, "relaxation"), (3, "healing")):
        assert grid[stage][name] == pytest.approx(exact[stage][name], rel=3e-3)  # 4e-4 measured
        assert abs(still[stage][name] / exact[stage][name] - 1) > 1e-2


def test_no_leap_hides_the_recovery_from_a_peak():
    """Before, transits were left out where friction rests at its peak, and with them the slip since."""
    changes = {"interface.law": "ageing-cutoff", "interface.cutoff_velocity": 1e-4}
    exact, still = (slipwave.run("hold", model, set=changes).summary["protocol"][2] for model in ("delay", "quasidynamic"))
    assert exact["slip_to_recovery"] == pytest.approx(still["slip_to_recovery"], rel=1e-3)  # 5e-5 measured


@pytest.mark.parametrize("later", [0.1 + 0.2, np.nextafter(0.3, 0.0)])
def test_times_that_differ_by_rounding_are_a_step(later):
    """Before, a ramp of 1e-16 transits whose stage had no direct effect, or a refusal: times must rise."""
    drive = slipwave.read("paper", {"drive.velocity": [[0.0, 100.0], [0.3, 100.0], [later, 1000.0], [0.31, 1000.0]]}).drive
    assert drive == Drive((0.0, 0.3, 0.3, 0.31), (100.0, 100.0, 1000.0, 1000.0))
    assert [stage.kind for stage in stages_of(drive, 10.0)] == ["start", "step"]


@pytest.mark.parametrize("lasts", [1e-4, 3.0, 1e3, 2e6])
def test_the_course_of_a_stage_is_the_same_however_its_times_come(lasts):
    """The ranges of equal parts by brute force; a time may lie before the stage by rounding."""
    draw = np.random.default_rng(int(1e4 * lasts))
    times, z = np.sort(draw.uniform(0.0, lasts, 500)), draw.standard_normal(500)
    times[0] = -1e-13
    one, other = _Course(), _Course()
    one.take(times, z)
    for part in np.split(np.arange(500), np.unique(draw.integers(1, 500, 6))):
        other.take(times[part], z[part])
    for begin, end in ((0.5, 0.75), (0.75, math.inf), (0.0, 1.0)):
        found = one.between(begin * lasts, end * lasts)
        assert found.tolist() == other.between(begin * lasts, end * lasts).tolist()
        inner, outer = (
            z[(times >= begin * lasts + part) & (times <= end * lasts - part)] for part in (one._length, -one._length)
        )
        assert outer.min() <= found.min() <= inner.min() <= inner.max() <= found.max() <= outer.max()
    whole = one.between(0.0, math.inf)
    assert (whole.min(), whole.max()) == (z.min(), z.max())

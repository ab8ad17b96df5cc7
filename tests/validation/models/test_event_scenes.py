"""Slip events and verdicts of scenes that a detector by V, by round trips or by the history of events gets wrong."""

import numpy as np
import pytest

import slipwave
from tests.granite import GRANITE as GRANITE_BLOCK
from validation.models.build import build
from validation.models.cycle import watch

LAYERS = ["upper.epsilon=2.8e-05", "upper.r=0.0031622776601683794", "lower.epsilon=5.6e-05", "lower.r=0.004743416490252569"]
LAYERS += ["drive.velocity=100.0", "upper.layers=[{fraction=0.25, impedance=1.0}, {fraction=0.75, impedance=0.5}]"]
"""Unlike slabs, the upper one layered: every third cycle has a precursor in which v crosses V and sticks again."""

WAVES = {
    "interface": {"law": "ageing", "a_star": 0.369, "a": 0.0349, "b": 0.0489},
    "upper": {"epsilon": 2.8e-5, "log10_r": -2.68},
    "lower": {"epsilon": 7.667574975940215e-05, "r": 0.0019827480929255734},
    "drive": {"velocity": 100.0},
}


def seen_in(chosen, until, model="delay", **options):
    return watch(build(model, chosen, **options), until)


def test_a_drive_that_came_up_from_one_hundredth_has_the_events_of_the_same_drive_without():
    ramped, plain = (seen_in(slipwave.read("paper", settings), 8000.0) for settings in (["drive.velocity=[[0,1],[10,100]]"], []))
    assert plain.count == 111
    assert ramped.count == 108
    assert ramped.events(4000.0).period[-1] == pytest.approx(73.4721449443, rel=1e-9)
    assert ramped.events(4000.0).period.size == plain.events(4000.0).period.size + 1 == 54


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_precursors_are_no_events(tolerance):
    observer = seen_in(slipwave.read("unlike", LAYERS), 4000.0, tolerance=tolerance)
    cycles = observer.events(2000.0)
    assert 33 <= observer.count <= 38
    assert cycles.period.mean() == pytest.approx(115.0, abs=10.0)
    assert cycles.period.min() > 80.0
    prominence = observer.judge(2000.0).prominence
    assert prominence.min() > 0.5 * prominence.max()


GRANITE = ["slab.density=2700.0", "slab.shear_modulus=3e10", "slab.thickness=12.0", "drive.velocity=100.0"]
GRANITE += ["interface.normal_stress=5e6", "interface.memory_length=1e-5"]
"""Granite under 5 MPa, twice as at the onset of stick-slip: slabs ring after each event, so that v crosses V again and
again. Counted by these crossings, 110 events in 9000 transits have periods of 69 +- 162 transits."""


def test_ringing_of_granite_is_no_event(answer):
    run = answer("run", "rock", "--model", "kelvin-voigt", "--set", *GRANITE, "--until", "17000")
    assert run["events"] == pytest.approx(36, abs=2)  # 35 to 37 with nodes that differ by rounding
    assert run["verdict"] == "irregular"
    assert run["period"]["mean"] == pytest.approx(478.8, rel=0.05)  # 20 cycles of a run of 20000 transits, 5.2 apart
    assert run["period"]["std"] < 0.05 * run["period"]["mean"]
    assert run["elastic_stress_drop"]["mean"] == pytest.approx(0.0783, rel=0.05)


STICKING = GRANITE_BLOCK | {
    "slab": GRANITE_BLOCK["slab"] | {"thickness": 14.14},
    "interface": GRANITE_BLOCK["interface"] | {"normal_stress": 8.43e6},
}
"""Slips at t = 15 977 and 157 255, and waves that ring in the stick between them and after."""


@pytest.mark.parametrize(
    ("source", "changes", "model", "until", "count"),
    [
        (STICKING, [], "delay", 318_198.0, 2),
        ("unlike", LAYERS, "delay", 4000.0, 35),
        ("paper", ["slab.log10_r=-2.59"], "kelvin-voigt", 4000.0, 51),
        ("paper-2.3", [], "delay", 4000.0, 38),
        ("paper", ["start.kind='jump'", "start.size=5.0"], "delay", 2000.0, 26),
    ],
    ids=["waves in a stick", "precursors", "doubled cycles", "irregular cycles", "a first large jump"],
)
def test_every_window_has_the_slip_events_that_the_whole_run_has_there(source, changes, model, until, count):
    """Also one that lies between two slips, or in which a first jump three times as large as any other slip is not."""
    observer = seen_in(slipwave.read(source, changes), until, model)
    whole = observer.dates()
    assert whole.size == pytest.approx(count, abs=1)
    for after in np.linspace(0.0, until, 61)[:-1]:
        assert observer.dates(after).tolist() == whole[whole >= after].tolist(), after


def test_a_run_that_ends_before_its_second_slip_is_too_short_and_says_how_long_it_should_be():
    run = slipwave.run(STICKING, until=318_198.0)
    assert (run.summary["verdict"], run.summary["events"]) == ("too short", 2)
    assert 3.0 < run.needed / 318_198.0 < 16.0  # sixteen cycles of some 160 000 transits
    assert "try --until 2.5e+06 (2.1e+04 s)" in "\n".join(run.lines(run.summary))


def test_waves_beside_stable_sliding_decay():
    """399 of them in the second half, of 1e-8 of the normal stress, some 2 transits apart; they do not fall one by one."""
    run = slipwave.run(WAVES).summary
    assert (run["verdict"], run["events"], run["ended"], run["rate"]) == ("decaying", 4, "settled", None)
    assert slipwave.stability(WAVES).stable


def test_a_motion_grows_however_small_it_is(answer):
    run = answer("run", "paper", "--set", "start.size=1e-9", "--until", "400")
    assert run["verdict"] == "growing"
    assert run["rate"] == pytest.approx(1.0 / 542.0, rel=0.01)  # of `stability`


def test_a_hold_and_a_reload():
    """Stick-slip, V = 0 for 500 transits, stick-slip again: the hold has no event, and the first one after it is larger."""
    held = slipwave.read("paper", ["drive.velocity=[[0,100],[2000,100],[2001,0],[2500,0],[2501,100]]"])
    dates = seen_in(held, 4000.0).dates()
    assert np.count_nonzero((dates > 2080.0) & (dates < 2500.0)) == 0
    before, after = dates[dates < 2001.0], dates[dates > 2500.0]
    assert before.size == seen_in(slipwave.read("paper"), 2001.0).count
    assert np.diff(after)[-3:] == pytest.approx(np.full(3, 73.4721449443), rel=1e-4)


REAL = [
    (["paper"], "periodic", 1),
    (["paper", "--model", "quasidynamic"], "decaying", None),
    (["paper", "--set", "slab.log10_r=-2.72"], "decaying", None),
    (["paper", "--set", "slab.log10_r=-2.8"], "steady", None),
    (["paper", "--set", "slab.log10_r=-2.65"], "torus", None),
    (["paper", "--model", "kelvin-voigt", "--set", "slab.log10_r=-2.59"], "periodic", 2),
    (["paper", "--until", "900"], "settling", None),
    (["paper", "--set", "slab.log10_r=-2.7003", "--until", "16000"], "decaying", None),  # by 0.6 % in two cycles, for ever
    (["paper-2.3"], "irregular", None),
    (["paper", "--until", "300"], "too short", None),
    (["paper", "--set", "drive.velocity=[[0,100],[3000,100],[3500,120]]"], "protocol", None),
    (["paper", "--set", "drive.velocity=[[0,100],[4001,120]]"], "driven", None),
]


@pytest.mark.parametrize(("words", "verdict", "multiplicity"), REAL, ids=[" ".join(words) for words, _, _ in REAL])
def test_verdicts_of_runs(words, verdict, multiplicity, answer):
    run = answer("run", *words)
    assert (run["verdict"], run["multiplicity"]) == (verdict, multiplicity)
    figures = [run[name][part] for name in ("period", "stress_drop", "elastic_stress_drop") for part in ("mean", "std")]
    figures += [run["v_max"], run["v_min"]]
    if verdict in ("periodic", "torus", "irregular"):
        assert all(value is not None for value in figures)
    else:
        assert figures == [None] * 8
    assert run["events"] >= 5


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ("delay", {}),
        ("delay", {"tolerance": 1e-5}),
        ("delay", {"tolerance": 1e-11}),
        ("dg:7", {"cells": 8}),
        ("fd", {"cells": 64}),
    ],
)
def test_brief_sticks_are_counted_alike(model, options):
    """V so large that the paper's slabs stick for hardly more than one round trip."""
    assert seen_in(slipwave.read("paper", ["drive.velocity=1e4"]), 100.0, model, **options).count == 37


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_the_stress_just_behind_a_front_counts(tolerance):
    """A step of V in layered slabs, whose echoes raise the stress to its highest in a cycle at once."""
    stepped = slipwave.read("layered", ["drive.velocity=[[0,100],[150.3,100],[150.3,30]]"])
    drops = seen_in(stepped, 500.0, tolerance=tolerance).events().stress_drop
    assert drops[2:4] == pytest.approx([0.077221470158, 0.119215786789], abs=1e-10)


def test_cycles_behind_faces_that_leak_are_counted_however_long_they_last():
    """The elastic stress of such slabs falls a little from cycle to cycle: in 250 cycles by more than an event."""
    leaking = slipwave.read(
        "paper", {"slab.log10_r": -2.534172, "slab.face": {"kind": "reflection", "coefficient": 0.99}, "start.size": 0.5}
    )
    seen = seen_in(leaking, 20000.0)
    assert seen.count == 253
    assert seen.events(10000.0).period == pytest.approx(79.3532925, abs=1e-6)
    assert seen.events().elastic_stress_drop[-1] == pytest.approx(seen.events(15000.0).elastic_stress_drop[-1], rel=1e-12)

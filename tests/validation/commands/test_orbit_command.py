"""`slipwave orbit` against programs that share nothing with this one; what a run says of motions close to its own."""

import json
import math
import re

import numpy as np
import pytest

import slipwave
import slipwave as sw
from reduced.orbit import periodic_orbit
from reduced.orbit.closing import close
from slipwave.errors import NumericsError, SceneError
from tests.granite import GRANITE
from tests.orbit_by_hand import SUBCRITICAL, FlowByHand
from validation.commands.cli import INPUT_WRONG, main
from validation.models import at_scene
from validation.models.at_scene import Primary
from validation.models.orbits import OrbitFound
from validation.references.published import half_digit, reference, reference_orbit


@pytest.mark.parametrize(
    ("model", "log10_r", "stable", "leading"),
    [
        ("delay", -2.68, True, [0.254520, 0.347982]),
        ("delay", -2.65, False, [-0.218935, 1.152419]),
        ("kelvin-voigt", -2.68, True, None),
    ],
)
def test_figures_are_those_of_other_programs(answer, model, log10_r, stable, leading):
    """The multipliers are those of DDE-BIFTOOL; figures agree within 5e-10 or in every digit that is published."""
    found = answer("orbit", "paper", "--model", model, "--set", f"slab.log10_r={log10_r}")
    for name, value in reference_orbit(model, log10_r).items():
        assert found[name] == pytest.approx(value, rel=2e-9, abs=1.01 * half_digit(value)), name
    assert found["stable"] is stable
    assert any("had not settled" in note for note in found["notes"]) is not stable
    assert found["period_time"] == pytest.approx(found["period"] * 10.0**log10_r, rel=1e-14)
    assert found["residual"] < 1e-12
    assert found["trivial_defect"] < 1e-5
    assert 0.0 <= found["error_estimate"]["period"] < 1e-8 * found["period"]
    assert found["idle_modes"] == []
    if leading:
        assert found["multipliers"][0] == pytest.approx(leading, abs=1e-6)
    moduli = [math.hypot(*value) for value in found["multipliers"]]
    assert moduli == sorted(moduli, reverse=True)
    assert min(moduli) > found["essential_radius"] >= 0.0


def test_idle_modes_are_named_with_their_multipliers():
    """Unlike slabs of irrational ratio: the waves' own multipliers reach the unit circle, and stability is not decided. Two modes
    are nearly idle. Of the first one the orbit's own multiplier is known, 0.60898 +- 0.78650 i: the loss to first order, 0.00583,
    is that of slow slip; 0.00530 is what the whole cycle takes."""
    found = sw.orbit("unlike-irrational", tol=1e-6)
    lines = list(found.lines({}))
    assert "no multiplier lies outside the essential radius" in lines
    for said in ("its stability is not decided", "some motion of the slabs is never damped by friction", "5 and 7 quarter waves"):
        assert any(said in line for line in lines), said
    modes = found.summary["idle_modes"]
    assert [mode["quarter_waves"] for mode in modes[:2]] == [[5, 7], [29, 41]]
    assert found.summary["stable"] is None
    told, own = complex(*modes[0]["multiplier"]), np.linalg.eigvals(found.found.found.closed.monodromy)
    nearest = own[np.abs(own - told).argmin()]
    assert abs(nearest) == pytest.approx(0.9947022, abs=1e-5)
    assert abs(nearest - told) < 0.01
    assert 1.0 - abs(told) == pytest.approx(1.0 - abs(nearest), rel=0.2)


def test_a_run_that_leads_to_none_gives_way_to_the_branch():
    """Between the fold and the Hopf point the run returns to steady sliding, and two orbits coexist: the small unstable one has
    a period between those of both points, the stable one a longer one than the fold's."""
    hopf, fold = 49.66821032, reference()["special"]["kelvin-voigt"]["first fold"]["period"]
    found = sw.orbit("paper", "kelvin-voigt", tol=1e-6, log10_r=-2.7001)
    assert found.stable is True
    unstable = float(re.search(r"periods ([\d.]+) \(unstable\):", "".join(found.notes))[1])
    assert hopf < unstable < fold < found.period < unstable + 5.0


@pytest.mark.parametrize(
    ("near", "s", "other", "word", "on_branch", "own"),
    [
        (5.9, 0.2, 0.8, "stable", (0.2, 0.8), None),
        (5.1, 0.8, 0.2, "unstable", (0.2, 0.8), 0.8),
        (5.1, 0.8, 0.2, "unstable", (0.2,), 0.8),
        (5.1, 0.8, None, "", None, 0.8),
    ],
)
def test_the_orbit_of_the_nearest_period(monkeypatch, near, s, other, word, on_branch, own):
    """Two orbits coexist at p = -0.16, known in closed form: on a branch, if one is known, and where the run leads to. The
    run's motion does not return to others."""
    flow = FlowByHand(SUBCRITICAL, -0.16)
    guesses = {size: (flow, 1.01 * SUBCRITICAL.state(size), SUBCRITICAL.period(size)) for size in (0.2, 0.8)}

    def given(orbits):
        """What is known, or an error if nothing is."""
        if orbits is None:
            raise NumericsError("none is known")
        return orbits

    monkeypatch.setattr(
        at_scene, "primary", lambda *_: Primary([close(*guesses[size]) for size in given(on_branch)], "it was followed")
    )
    monkeypatch.setattr(at_scene, "moving", lambda *_: None)
    monkeypatch.setattr(at_scene, "orbits_near", lambda *_: given(None))
    monkeypatch.setattr(
        at_scene, "find_orbit", lambda *_: OrbitFound(given(own and periodic_orbit(*guesses[own])), 1e-8, "from the run")
    )
    found = at_scene.orbit_at_scene("by hand", flow.scene, 1e-8, near=near)
    assert found.found.orbit.period.value == pytest.approx(SUBCRITICAL.period(s), rel=1e-10)
    assert found.found.multipliers.stable is (s == 0.8)
    assert (found.source == "from the run") is (s == own and s not in (on_branch or ()))
    assert [str(one) for one in found.others] == ([f"{SUBCRITICAL.period(other):.7g} ({word})"] if other else [])


def test_a_branch_of_long_periods_is_not_begun():
    """Granite blocks of 10 m: a cycle takes tens of thousands of transits, a branch of such orbits would take hours."""
    says = r"^block8: a run of 6000 .* not followed: their periods are [\d.]+e\+04 transits there, over 600, and .* dense "
    says += r"derivative through every transit, in time proportional to the period; slipwave run, .* at single values"
    with pytest.raises(NumericsError, match=says):
        sw.orbit(GRANITE, "block8")


FAST = {"model": "kelvin-voigt", "until": 200.0, "drive.velocity": 2000.0}
"""Cycles of four transits, which repeat."""


def test_an_exponent_on_request():
    """The run repeats: neither a motion ahead of it nor one behind comes nearer."""
    found = slipwave.run("paper", **FAST, lyapunov=True)
    assert found.done.kind == "periodic"
    told = found.summary["lyapunov"]
    assert abs(told["rate"]) <= 2.0 * told["margin"] < 0.06
    assert told["transits"] == 200 * 2.0 * round(found.done.events.period[-1] / 2.0)
    assert found.summary["final"] == slipwave.run("paper", **FAST).summary["final"]


@pytest.mark.parametrize(
    ("until", "verdict", "advice"), [(2000.0, "steady", "slipwave stability gives its rate"), (6.0, "too short", "run longer")]
)
def test_a_motion_without_cycles_has_none_but_the_run_is_kept(until, verdict, advice):
    """Steady sliding that a disturbance leaves has an exponent below zero, which the elastic stress, a mere sum, would hide."""
    with pytest.raises(NumericsError, match=f"this one is {verdict}: {advice}") as failed:
        slipwave.run("paper", "block8", until=until, lyapunov=True, **{"slab.log10_r": -3.5})
    assert failed.value.result.summary["verdict"] == verdict
    assert "lyapunov" not in failed.value.result.summary


def test_a_changing_drive_is_refused():
    with pytest.raises(SceneError, match=r"a Lyapunov exponent needs a constant drive\.velocity"):
        slipwave.run("ramp", lyapunov=True)


def test_the_return_map_shows_each_period_over_the_one_before(tmp_path, printed):
    found = slipwave.run("paper", **FAST)
    dots = found.plot_return_map().axes[0].get_lines()[0]
    late = found.done.events.period[found.done.events.time >= 100.0]
    np.testing.assert_array_equal(dots.get_xdata(), late[:-1])
    np.testing.assert_array_equal(dots.get_ydata(), late[1:])
    file = tmp_path / "map.svg"
    words = ["run", "paper", "--model", "kelvin-voigt", "--until", "200", "--set", "drive.velocity=2000", "--json"]
    assert json.loads(printed(*words, "--return-map", str(file)))["verdict"] == "periodic"
    assert file.read_text(encoding="utf-8").count("<use") >= late.size - 1
    assert main([*words[:-1], "--until", "5", "--return-map", str(file)]) == INPUT_WRONG

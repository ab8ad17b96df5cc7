"""The reason below a run's verdict, and its figures in SI, against values by hand."""

import json
import math

import pytest

import slipwave
from tests.granite import THIN as GRANITE
from validation.results.reasons import engineering
from validation.run.outlook import outlook


def told(*settings, until, scene="paper"):
    return list(slipwave.run(scene, "delay", until=until, settings=settings).summary["reasons"])


def test_a_stable_sample_says_what_would_make_it_slip():
    (line,) = told(until=5e4, scene=GRANITE)[-1:]
    assert line.endswith("it would slip with slabs over 6 m (here 200 mm) or a normal stress over 150 MPa (here 5 MPa)")
    assert "(8.92 s)" in line  # of the slower root of a s^2 + (a - b + k) s + k = 0, k = 0.15, on the clock of 10 s
    assert pytest.approx((0.145 - math.sqrt(0.145**2 - 4 * 0.01 * 0.15)) / 0.02, rel=1e-3) == 10.0 / 8.92


def test_a_run_without_cycles_says_how_long_one_takes():
    lines = told(until=20.0)
    assert lines[0] == "a cycle is expected to take about 69 transits"
    assert lines[1].startswith("steady sliding is unstable; a disturbance grows by a factor e in 542 transits; ")


def test_a_decaying_run_says_how_fast():
    """At r = 10^-2.75 the leading root decays by e in 228 transits, and so does the motion."""
    lines = told("slab.log10_r=-2.75", until=3000.0)
    assert lines[0] == "it changes by a factor e in 228 transits"
    assert lines[1].startswith(
        "steady sliding is stable; a disturbance decays by a factor e in 228 transits; it would slip with r over"
    )


def test_unlike_slabs_are_scaled_together():
    (line,) = told("upper.r=0.002", "lower.r=0.004", until=50.0, scene="unlike")[-1:]
    assert "r of the upper slab, both slabs scaled together, over 0.00239 (here 0.002)" in line


@pytest.mark.parametrize(
    ("value", "unit", "text"), [(1.5e8, "Pa", "150 MPa"), (5.99999997, "m", "6 m"), (999.9, "s", "1 ks"), (0.2, "", "0.2")]
)
def test_three_figures_and_a_prefix(value, unit, text):
    assert engineering(value, unit) == text


def test_figures_of_a_run_in_si(answer, printed):
    """paper-si: one transit is 2 thickness/c, L/V* = 0.9 s, sigma = 1000 Pa, V* = 1e-6 m/s."""
    words = ["run", "paper-si", "--set", "drive.velocity=2000", "--until", "200", "--json"]
    found = json.loads(printed(*words))
    transit = 2.0 * 0.03357797353158276 / math.sqrt(1e6 / 784.0)
    assert found["si"] == pytest.approx(
        {
            "period_s": found["period"]["mean"] * transit,
            "stress_drop_Pa": 1e3 * found["stress_drop"]["mean"],
            "elastic_stress_drop_Pa": 1e3 * found["elastic_stress_drop"]["mean"],
            "v_max_m_per_s": 1e-6 * found["v_max"],
            "v_min_m_per_s": 1e-6 * found["v_min"],
            "transit_s": transit,
        }
        | {
            f"{name}_std_{unit}": scale * found[name]["std"]
            for name, unit, scale in (("period", "s", transit), ("stress_drop", "Pa", 1e3), ("elastic_stress_drop", "Pa", 1e3))
        },
        rel=1e-12,
    )
    short = answer(*words[:-3], "--until", "2")["si"]
    assert (short["period_s"], short["transit_s"]) == (None, pytest.approx(transit, rel=1e-12))


def test_an_interface_that_is_hardly_loaded_has_no_expected_cycle():
    """The spring of the machine takes 1e11 transits, or 1e300, to load it: the run gives its verdict, and no length to try."""
    done = slipwave.run("machine", settings=["slab.face.stiffness=1e-9"], until=20.0)
    assert done.summary["verdict"] == "too short"
    assert math.isinf(done.needed)
    assert outlook(slipwave.read("machine", ["slab.face.stiffness=1e-300"]), "delay").period > 1e290

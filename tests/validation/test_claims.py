"""The paper's claims on orbits and cycles of our own making: every verdict from both sides, the answer, the figures."""

from types import SimpleNamespace

import numpy as np
import pytest

import slipwave
from slipwave.observe import Events
from slipwave.observe.statistics import Estimate, Orbit
from validation.measure.cycle import Cycle
from validation.references.onset import FAST_PERIOD_KELVIN_VOIGT
from validation.studies import claims
from validation.studies.claims import irregular, returns
from validation.studies.claims import measured as claims_load
from validation.studies.claims import measured as claims_verdicts
from validation.studies.claims.measured import MODELS, Deep, Loading, Ripples, loading_of, recurrence, where
from validation.study import Evidence, Outcome, Verdict

FIGURES = ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")
GRID = (-2.69, -2.68, -2.67)


def orbit(period=73.5, drop=0.17, elastic=0.15):
    return Orbit(*(Estimate(value, 0.0) for value in (period, drop, elastic, 4000.0, 3.0)))


def branch(**changes):
    """Three r; periods 70.73, 73.5, 76, 78; the ODE's drops 4, 5, 6 % short. `changes`: model -> a function of an orbit."""
    found = {}
    for k, r in enumerate(GRID):
        gap = 0.04 + 0.01 * k
        one = {
            "delay": orbit(),
            "kelvin_voigt": orbit(70.73, 0.17 * (1 - gap), 0.15 * (1 - gap)),
            "block8": orbit(76.0, 0.175, 0.155),
            "block12": orbit(78.0, 0.18, 0.16),
        }
        one |= {model: change(k) for model, change in changes.items()}
        found[r] = {model.replace("_", "-"): value for model, value in one.items()}
    return found


def outcomes(verdicts):
    return [verdict.outcome for verdict in verdicts]


def test_the_claim_names_the_range_that_was_run():
    assert where(branch()) == "log_{10} r from −2.69 to −2.67"
    assert "log_{10} r from −2.69 to −2.67" in claims_verdicts._order_of_periods(branch()).claim
    assert "log_{10} r from −2.69 to −2.67" in claims_verdicts._gaps(branch()).claim


@pytest.mark.parametrize(
    ("model", "period", "ours", "outcome"),
    [
        ("delay", 75.9, "at 3 of 3 r", "pass"),
        ("delay", 76.1, "at 2 of 3 r", "finding"),
        ("delay", 70.7, "at 2 of 3 r", "finding"),
        ("block12", 73.4, "at 2 of 3 r", "finding"),
    ],
)
def test_p7_needs_the_order_at_every_r(model, period, ours, outcome):
    """One period moved at one r."""
    base = {"delay": 73.5, "block12": 78.0}[model]
    found = claims_verdicts._order_of_periods(branch(**{model: lambda k: orbit(period if k == 1 else base, 0.17, 0.15)}))
    assert (found.ours, found.outcome) == (ours, outcome)


def test_p11_needs_larger_drops_and_both_gaps_growing():
    assert claims_verdicts._gaps(branch()).outcome is Outcome.PASS

    def ode(*drops):
        return branch(kelvin_voigt=lambda k: orbit(70.73, 0.17 * drops[k], 0.15 * (0.96 - 0.01 * k)))

    found = claims_verdicts._gaps(ode(0.96, 0.97, 0.94))
    assert found.outcome is Outcome.FINDING
    assert found.ours == "larger; Δμ does not grow steadily; Δy grows"
    assert "Δμ 4.0, 3.0, 6.0 %; Δy 4.0, 5.0, 6.0 %" in found.remark
    assert claims_verdicts._gaps(ode(1.01, 0.95, 0.94)).ours.startswith("not larger")


def test_p6_asks_for_three_figures():
    assert claims_verdicts._blocks(branch()).outcome is Outcome.PASS
    found = claims_verdicts._blocks(branch(block8=lambda k: orbit(76.0, 0.2, 0.155)))
    assert (found.outcome, found.ours) == (Outcome.FINDING, "T yes, Δy yes, Δμ no")


@pytest.mark.parametrize(
    ("ode", "delay", "expected"),
    [
        (70.7345, 73.545, "pass pass"),
        (70.745, 73.5, "fail pass"),
        (70.715, 73.5, "fail pass"),
        (70.73, 73.65, "pass fail"),
        (70.73, 73.35, "pass fail"),
    ],
)
def test_p3_and_p4_hold_to_the_digits_printed(ode, delay, expected):
    found = branch(delay=lambda k: orbit(delay), kelvin_voigt=lambda k: orbit(ode))
    assert outcomes(claims_verdicts._periods(found)) == expected.split()


def ripples(delay=1.0, ode=FAST_PERIOD_KELVIN_VOIGT, off=0.0):
    return {
        "delay": Ripples(delay, Loading(73.0, 55.0 + 73.0 * off, 7.0, 11.0)),
        "kelvin-voigt": Ripples(ode, Loading(70.0, 52.0, 7.0, 11.0)),
    }


@pytest.mark.parametrize(
    ("delay", "ode", "expected"),
    [(1.00028, 1.0, "pass finding"), (1.0, 0.99972, "pass finding"), (0.999, 1.0, "fail finding"), (1.0, 1.001, "fail finding")],
)
def test_p5_on_both_ripples(delay, ode, expected):
    found = claims_verdicts._ripples(ripples(delay, ode * FAST_PERIOD_KELVIN_VOIGT))
    assert outcomes(found) == expected.split()
    assert found[1].ours == "-22 % in frequency"


def test_p5_as_printed_would_pass():
    assert claims_verdicts._ripples(ripples(1.0, 1.0 / 1.28))[1].outcome is Outcome.PASS


def test_p1_and_p2_are_judged(monkeypatch):
    assert outcomes(claims_verdicts._onset()) == ["pass"] * 5
    right = claims_verdicts.onset_at

    def displaced(velocity):
        one = right(velocity)
        return SimpleNamespace(r_delay=one.r_delay * (1 + 3e-9), r_kelvin_voigt=one.r_kelvin_voigt, omega_c=one.omega_c)

    monkeypatch.setattr(claims_verdicts, "onset_at", displaced)
    assert outcomes(claims_verdicts._onset())[:3] == ["pass", "fail", "fail"]


@pytest.mark.parametrize(("off", "outcome"), [(1.8e-6, "pass"), (-1.8e-6, "pass"), (6e-6, "fail"), (-6e-6, "fail")])
def test_p12_is_an_identity(off, outcome):
    assert claims_load._identity(ripples(off=off)).outcome == outcome


def test_the_parts_of_a_period_add_up():
    """v = 300 for 7 transits, 20 for 23, V = 100: y falls by eps (7 * 200), and rises by eps (23 * 80) less what does not fit."""
    scene = slipwave.read("paper")
    time = np.linspace(0.0, 30.0, 30001)[:-1]
    rate = np.where((time > 5.0) & (time < 12.0), 100.0 + 23.0 * 80.0 / 7.0, 20.0)
    y = 0.4 + scene.upper.epsilon * np.concatenate([[0.0], np.cumsum((100.0 - rate)[:-1] * 1e-3)])
    drop = float(np.ptp(y))
    found = loading_of(orbit(30.0, 0.2, drop), Cycle(time, rate, time, time, y, 30.0), scene)
    assert found.drop == pytest.approx(23.0 * 0.8, abs=0.01)
    assert found.falling == pytest.approx(7.0, abs=0.01)
    assert found.slipped == pytest.approx(23.0 * 0.2, abs=0.01)
    assert found.drop + found.falling + found.slipped == pytest.approx(30.0, abs=0.01)


@pytest.mark.parametrize(
    ("power", "outcome"), [(1.0, "pass"), (0.92, "pass"), (1.08, "pass"), (0.7, "finding"), (1.3, "finding"), (0.53, "finding")]
)
def test_p12_proportional_means_a_power_of_one(power, outcome):
    drops = (0.10, 0.12, 0.15)
    found = claims_load._proportional(branch(delay=lambda k: orbit(50.0 * (drops[k] / 0.1) ** power, 0.17, drops[k])))
    assert found.outcome == outcome
    assert found.ours == f"T ∝ Δy^{{{power:.2f}}}"


def deep(period=100.0, drop=0.35, share=0.93, spread=(0.02, 0.02, 0.02), v_max=1e4, cycles=60, seed=1):
    """Cycles whose period, drop and v_max scatter by `spread`, normal and without memory."""
    random = np.random.default_rng(seed)
    noise = random.standard_normal((3, cycles))
    noise = (noise - noise.mean(axis=1, keepdims=True)) / noise.std(axis=1, keepdims=True)
    columns = [value * (1.0 + size * z) for value, size, z in zip((period, drop, v_max), spread, noise, strict=True)]
    elastic = np.full(cycles, share * period * 2.8e-3)
    return Deep(
        Events(np.cumsum(columns[0]), columns[0], columns[1], elastic, columns[2], columns[2]), np.arange(5.0), np.ones(5)
    )


@pytest.mark.parametrize(
    ("share", "outcome"), [(0.91, "pass"), (0.985, "pass"), (0.88, "finding"), (0.7, "finding"), (0.995, "finding")]
)
def test_p12_nearly_equal_has_two_ends(share, outcome):
    assert claims_load._nearly_equal(deep(share=share)).outcome == outcome


def test_recurrence_tells_periodic_from_irregular():
    random = np.random.default_rng(2)
    assert recurrence(np.tile([1.0, 3.0, 2.0, 7.0, 5.0], 20)) < 1e-12
    assert recurrence(np.tile(np.arange(12.0), 9) + 1e-3 * random.standard_normal(108)) < 0.01
    assert 0.8 < recurrence(random.standard_normal(200)) < 1.05


@pytest.mark.parametrize(("beat", "outcome"), [(0.0, "pass"), (2.5, "pass"), (10.0, "finding"), (1e6, "finding")])
@pytest.mark.parametrize("name", ["period", "stress_drop"])
def test_p13_an_ode_that_nearly_repeats_would_not_pass(name, beat, outcome):
    """A doubled orbit of amplitude `beat` times the scatter: recurrence 1/sqrt(1 + beat^2)."""
    one = deep(spread=(0.01, 0.01, 0.01))
    values = getattr(one.events, name)
    doubled = values + beat * float(np.std(values)) * np.tile([1.0, -1.0], values.size // 2)
    assert claims_load._aperiodic(one._replace(events=one.events._replace(**{name: doubled}))).outcome == outcome


@pytest.mark.parametrize(("spread", "outcome"), [(0.045, "pass"), (0.15, "finding")])
def test_p13_nearly_constant(spread, outcome):
    assert claims_load._constant(deep(spread=(0.02, spread, 0.02))).outcome == outcome


@pytest.mark.parametrize(
    ("ratios", "outcome"),
    [((1.65, 1.65, 5.5), "pass"), ((0.5, 3.0, 9.0), "finding"), ((3.0, 0.5, 9.0), "finding"), ((3.0, 3.0, 1.7), "finding")],
)
def test_p13_needs_a_contrast_in_periods_drops_and_events(ratios, outcome):
    runs = {"delay": deep(), "kelvin-voigt": deep(spread=tuple(0.02 * ratio for ratio in ratios), seed=3)}
    assert claims_load._contrast(runs).outcome == outcome


def test_the_answer_counts_what_holds():
    def verdict(outcome):
        return Verdict("P0", Evidence.PAPER, "", "", outcome)

    told = claims._answer((verdict(Outcome.PASS), verdict(Outcome.PASS), verdict(Outcome.FINDING), verdict(Outcome.FAIL)))
    told_of = "those about branches are judged by the studies `bifurcation` and `period-doubling`."
    assert told == f"Of 4 checks 2 hold and 1 qualify a claim; {told_of}"


@pytest.mark.parametrize(
    ("other", "words"), [(73.5, "leads to the same orbit as the scene’s own start"), (74.0, "two stable orbits")]
)
def test_another_start_may_find_another_orbit(monkeypatch, other, words):
    monkeypatch.setattr(claims, "beside", lambda log10_r: orbit(other))
    assert words in claims._two_orbits(branch())


def test_figures_show_cycles_and_returns():
    one = deep()
    first, second = irregular({model: one._replace(stress=np.arange(5.0)) for model in ("delay", "kelvin-voigt")}).axes
    assert [axes.get_ylabel() for axes in (first, second)] == [r"$\mu$"] * 2
    assert second.get_xlabel() == "time (transits)"
    assert list(first.get_lines()[0].get_ydata()) == [0.0, 1.0, 2.0, 3.0, 4.0]
    period, drop = returns({"delay": one}).axes
    assert [axes.get_xlabel() for axes in (period, drop)] == ["$T$ (transits) of one cycle", r"$\Delta\mu$ of one cycle"]
    assert {axes.get_ylabel() for axes in (period, drop)} == {"of the next"}
    assert np.array_equal(drop.get_lines()[0].get_xdata(), one.events.stress_drop[:-1])
    assert np.array_equal(drop.get_lines()[0].get_ydata(), one.events.stress_drop[1:])


def test_all_models_are_on_the_branch():
    assert set(branch()[-2.68]) == set(MODELS)

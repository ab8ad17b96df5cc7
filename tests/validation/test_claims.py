"""The paper's claims on orbits and cycles of our own making: verdicts from both sides, the answer, the figures."""

import numpy as np
import pytest

import slipwave
from slipwave.observe import Events
from slipwave.observe.statistics import Estimate, Orbit
from validation.measure.cycle import OneCycle
from validation.references.onset import FAST_PERIOD_KELVIN_VOIGT
from validation.studies import claims as measured
from validation.studies.claims import Deep, Loading, Ripples, loading_of, recurrence

GRID = (-2.69, -2.68, -2.67)


def orbit(period=73.5, drop=0.17, elastic=0.15):
    return Orbit(*(Estimate(value, 0.0) for value in (period, drop, elastic, 4000.0, 3.0)))


def branch(**changes):
    """Three r; periods 70.73, 73.5, 76, 78; the ODE's drops 4, 5, 6 % short. `changes`: model -> a function of the place."""
    found = {}
    for k, r in enumerate(GRID):
        gap = 0.96 - 0.01 * k
        one = {"delay": orbit(), "kelvin_voigt": orbit(70.73, 0.17 * gap, 0.15 * gap)}
        one |= {"block8": orbit(76.0, 0.175, 0.155), "block12": orbit(78.0, 0.18, 0.16)}
        one |= {model: change(k) for model, change in changes.items()}
        found[r] = {model.replace("_", "-"): value for model, value in one.items()}
    return found


def judged(verdicts, title):
    """The last verdict of this title's beginning."""
    return [verdict for verdict in verdicts if verdict.claim.startswith(title)][-1]


@pytest.mark.parametrize(
    ("title", "changes", "outcome", "ours"),
    [
        ("P7", {}, "pass", "3 of 3 r"),
        ("P7", {"delay": lambda k: orbit(75.9 if k == 1 else 73.5)}, "pass", "3 of 3 r"),
        ("P7", {"delay": lambda k: orbit(76.1 if k == 1 else 73.5)}, "finding", "2 of 3 r"),
        ("P7", {"delay": lambda k: orbit(70.7 if k == 1 else 73.5)}, "finding", "2 of 3 r"),
        ("P7", {"block12": lambda k: orbit(73.4 if k == 1 else 78.0)}, "finding", "2 of 3 r"),
        ("P11", {}, "pass", "larger; Δμ grows; Δy grows"),
        ("P11", {"kelvin_voigt": lambda k: orbit(70.73, 0.17 * (0.96, 0.97, 0.94)[k], 0.15 * (0.96 - 0.01 * k))}, "finding",
         "larger; Δμ does not grow steadily; Δy grows"),
        ("P11", {"kelvin_voigt": lambda k: orbit(70.73, 0.17 * (1.01, 0.95, 0.94)[k], 0.15 * (0.96 - 0.01 * k))}, "finding",
         "not larger; Δμ grows; Δy grows"),
        ("P6", {}, "pass", "T yes, Δy yes, Δμ yes"),
        ("P6", {"block8": lambda k: orbit(76.0, 0.2, 0.155)}, "finding", "T yes, Δy yes, Δμ no"),
    ],
)  # fmt: skip
def test_claims_on_the_branch(title, changes, outcome, ours):
    found = judged(measured.stable_branch_claims(branch(**changes)), title)
    assert (found.outcome, found.ours) == (outcome, ours)
    assert title == "P6" or "log_{10} r from −2.69 to −2.67" in found.claim


def ripples(delay=1.0, ode=1.0, off=0.0):
    parts = {"delay": Loading(73.0, 55.0 + 73.0 * off, 7.0, 11.0), "kelvin-voigt": Loading(70.0, 52.0, 7.0, 11.0)}
    return {model: Ripples(period, parts[model]) for model, period in (("delay", delay), ("kelvin-voigt", ode * FAST))}


FAST = FAST_PERIOD_KELVIN_VOIGT


@pytest.mark.parametrize(
    ("delay", "ode", "expected"),
    [(1.00028, 1.0, "pass pass finding"), (1.0, 0.99972, "pass pass finding"), (0.999, 1.0, "fail pass finding"),
     (1.0, 1.001, "fail pass finding"), (1.0, 1.0 / 1.28 / FAST, "fail fail pass")],
)  # fmt: skip
def test_p5_on_both_ripples(delay, ode, expected):
    assert [verdict.outcome for verdict in measured.ripple_claims(ripples(delay, ode))] == expected.split()


def test_p1_needs_the_closed_forms(monkeypatch):
    assert [verdict.outcome for verdict in measured.onset_claims()] == ["pass"] * 3
    right = measured.onset_at
    monkeypatch.setattr(measured, "onset_at", lambda v: right(v)._replace(r_delay=right(v).r_delay * (1 + 3e-4)))
    assert next(measured.onset_claims()).outcome == "fail"


@pytest.mark.parametrize(
    ("slow", "fast", "outcomes"),
    [(0.9e-2, 0.033, "pass pass"), (3e-2, 0.077, "finding pass"), (3e-3, 0.03, "pass finding"), (3e-3, 0.33, "pass finding")],
)
def test_one_reading_of_fig_2(slow, fast, outcomes):
    assert [verdict.outcome for verdict in measured.error_of_27(slow, fast)] == outcomes.split()


def deep(period=100.0, drop=0.35, share=0.93, spread=(0.02, 0.02, 0.02), v_max=1e4, cycles=60, seed=1):
    """Cycles whose period, drop and v_max scatter by `spread`, normal and without memory."""
    noise = np.random.default_rng(seed).standard_normal((3, cycles))
    noise = (noise - noise.mean(axis=1, keepdims=True)) / noise.std(axis=1, keepdims=True)
    T, drops, v = (value * (1.0 + size * z) for value, size, z in zip((period, drop, v_max), spread, noise, strict=True))
    events = Events(np.cumsum(T), T, drops, np.full(cycles, share * period * 2.8e-3), v, v)
    return Deep(events, np.arange(5.0), np.arange(5.0))


DROPS = (0.10, 0.12, 0.15)


@pytest.mark.parametrize(
    ("title", "orbits", "run", "parts", "outcome"),
    [
        *(
            ("P12 The period is Δy", {}, {}, {"off": off}, end)
            for off, end in ((1.8e-6, "pass"), (6e-6, "fail"), (-6e-6, "fail"))
        ),
        *(
            ("P12 The period is prop", {"delay": lambda k, n=n: orbit(50.0 * (DROPS[k] / 0.1) ** n, 0.17, DROPS[k])}, {}, {}, end)
            for n, end in ((1.0, "pass"), (0.92, "pass"), (1.08, "pass"), (0.7, "finding"), (1.3, "finding"))
        ),
        *(
            ("P12 T ~", {}, {"share": share}, {}, end)
            for share, end in ((0.91, "pass"), (0.985, "pass"), (0.88, "finding"), (0.7, "finding"), (0.995, "finding"))
        ),
    ],
)
def test_p12(title, orbits, run, parts, outcome):
    orbits = orbits or {"delay": lambda k: orbit(50.0, 0.17, DROPS[k])}
    found = measured.load_claims(branch(**orbits), {"delay": deep(**run)}, ripples(**parts))
    assert judged(found, title).outcome == outcome


@pytest.mark.parametrize(("second", "share"), [(0.0, 0.0), (0.5, 0.2), (1.0, 0.5)])
def test_overtones_are_the_power_outside_the_sine(second, share):
    """On a rising stress, in each of two cycles that are shown whole; the third is not."""
    time = np.arange(0.0, 150.0, 0.005)
    ripple = np.sin(2.0 * np.pi * time / 1.3) + second * np.cos(4.0 * np.pi * time / 1.3)
    events = deep(cycles=3).events._replace(time=np.array([10.0, 70.0, 130.0]))
    found = measured.overtones(Deep(events, time, 1e-3 * ripple + 0.003 * time), 1.3)
    np.testing.assert_allclose(found, [share, share], atol=4e-3)


@pytest.mark.parametrize(("delay", "ode", "outcome"), [(0.5, 0.0, "pass"), (0.0, 0.0, "finding"), (0.5, 0.5, "finding")])
def test_p13_on_the_shape_of_ripples(delay, ode, outcome):
    time = np.arange(0.0, 150.0, 0.005)
    runs = {}
    for model, second, period in (("delay", delay, 1.0), ("kelvin-voigt", ode, FAST)):
        wave = np.sin(2.0 * np.pi * time / period) + second * np.sin(4.0 * np.pi * time / period)
        runs[model] = deep()._replace(time=time, stress=wave)
    assert judged(measured.irregular_claims(runs), "P13 At r = 10^{-2.3} the ODE’s ripples").outcome == outcome


def test_the_parts_of_a_period_add_up():
    """v = 300 for 7 transits, 20 for 23, V = 100: y falls by eps (7 * 200), and rises by eps (23 * 80) less what does not fit."""
    scene = slipwave.read("paper")
    time = np.linspace(0.0, 30.0, 30001)[:-1]
    rate = np.where((time > 5.0) & (time < 12.0), 100.0 + 23.0 * 80.0 / 7.0, 20.0)
    y = 0.4 + scene.upper.epsilon * np.concatenate([[0.0], np.cumsum((100.0 - rate)[:-1] * 1e-3)])
    found = loading_of(orbit(30.0, 0.2, float(np.ptp(y))), OneCycle(time, rate, time, time, y, 30.0), scene)
    assert found == pytest.approx((30.0, 23.0 * 0.8, 7.0, 23.0 * 0.2), abs=0.01)


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
    ode = one._replace(events=one.events._replace(**{name: doubled}))
    assert next(measured.irregular_claims({"kelvin-voigt": ode, "delay": deep()})).outcome == outcome


@pytest.mark.parametrize(
    ("constant", "ratios", "outcomes"),
    [
        (0.02, (1.65, 1.65, 5.5), ["pass", "pass"]),
        (0.045, (3.0, 3.0, 9.0), ["pass", "finding"]),
        (0.15, (0.5, 3.0, 9.0), ["finding", "finding"]),
        (0.02, (3.0, 3.0, 1.7), ["pass", "finding"]),
    ],
)
def test_p13_drops_are_nearly_constant_and_the_contrast_is_large(constant, ratios, outcomes):
    runs = {"delay": deep(spread=(0.02, constant, 0.02))}
    runs["kelvin-voigt"] = deep(spread=tuple(0.02 * ratio for ratio in ratios), seed=3)
    assert [verdict.outcome for verdict in measured.irregular_claims(runs)][1:3] == outcomes

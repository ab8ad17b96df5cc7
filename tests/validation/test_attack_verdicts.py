"""The study of attacks on outcomes of our own: every limit from both sides, what excuses an error, the answer."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from validation.studies.stability_attacks import runs, verdicts
from validation.studies.stability_attacks.runs import ATTACKS, Advice, AttackOutcome
from validation.study import Outcome as Light

LIMITS = {
    "epsilon -9": (2e-6, 2e-7), "epsilon -4": (3e-6, 1e-11), "epsilon -2": (6e-6, 1e-12), "epsilon 2": (7e-6, 3e-9),
    "V -6": (2e-6, 1e-9), "V -2": (2e-6, 1e-10), "V 3": (1e-2, 4e-3), "V 4": (2e-3, 3e-2),
    "V 5": (2e-8, 2e-5), "V 6": (3e-9, 1e-8),
    "impedance": (6e-6, 1e-6), "round trip": (2e-6, 2e-7), "pi": (3e-5, 1e-4), "jump": (1e-4, 5e-2), "jump back": (1e-2, 5e-2),
}  # fmt: skip


def found(**changes):
    plain = {
        "decades": (-4, 0, 8),
        "limits": {"fd": [1.0, 1.2, 1.02], "dg:4": [1.01, 1.0, 0.99]},
        "reach": {"fd": math.inf, "sbp:2": 2.785, "dg:4": 6.394},
        "media": {"alike": {"fd": (5.0, 1e3)}},
        "stopped": {"fd": True},
        "late": True,
        "attacks": {"V 3": {"fd": AttackOutcome(1e-3, 1e-3), "dg:4": AttackOutcome(math.nan, message="too stiff")}},
        "advice": {"fd": Advice(0, "", 64, 1e-7)},
        "transits": 1e3,
        "noise": {"fd": 1.0, "dg:4": 0.5},
    }
    return verdicts.Found(**(plain | changes))


def test_every_attack_has_its_own_limits():
    assert {name: attack.right for name, attack in ATTACKS.items()} == LIMITS


CHANGED = {"epsilon": ("slab.epsilon=1e{}", "ε = 10^{{{}}}"), "V": ("drive.velocity=1e{}", "V = 10^{{{}}} V*")}


@pytest.mark.parametrize("name", [name for name in LIMITS if name.split()[0] in CHANGED])
def test_an_attack_changes_what_its_name_says(name):
    quantity, power = name.split()
    changes, title = (text.format(power) for text in CHANGED[quantity])
    assert (ATTACKS[name].changes, ATTACKS[name].title) == ((changes,), title)
    assert ATTACKS[name].late == (200.0 if quantity == "V" and int(power) > 4 else 400.0)


@pytest.mark.parametrize("name", LIMITS)
def test_an_attack_must_end_right_or_with_a_message(name):
    early, late = LIMITS[name]

    def light(outcome):
        return verdicts.attack_verdict(name, {"fd": AttackOutcome(0.0), "dg:4": outcome}, True).outcome

    assert light(AttackOutcome(0.95 * early, 0.95 * late)) is Light.PASS
    assert light(AttackOutcome(3.0 * early, 0.0)) is Light.FAIL
    assert light(AttackOutcome(0.0, 3.0 * late)) is Light.FAIL
    assert light(AttackOutcome(math.nan)) is Light.FAIL
    assert light(AttackOutcome(math.nan, message="too stiff")) is Light.PASS


def test_a_counted_failure_excuses_no_wrong_answer(monkeypatch):
    """A solver that counts failed solves and goes on, wrong by 1 in psi, with exit status 0."""

    class Solver(SimpleNamespace):
        model, failures, nodes = "fd", 3, np.array([0.0, 1.0])

    psis = iter([0.0] * 5 + [1.0] * 5)
    monkeypatch.setattr(runs, "build", lambda *args, **options: Solver(scene=None))
    monkeypatch.setattr(runs, "EventObserver", lambda *args: SimpleNamespace(events=lambda *window: None))
    monkeypatch.setattr(runs, "summarise", lambda *args: SimpleNamespace(cycles=0))
    monkeypatch.setattr(runs, "follow", lambda *args: SimpleNamespace(psi=next(psis)))
    monkeypatch.setattr(runs, "CELLS", {"fd": 4})
    outcome = runs.attack("V 3")["fd"]
    assert outcome.silently_wrong(0.1)
    assert verdicts.attack_verdict("V 3", {"fd": outcome}, False).outcome is Light.FAIL


@pytest.mark.parametrize(
    ("values", "light"),
    [
        ([1.0, 1.3, 1.039], "pass"),
        ([0.961, 1.3, 1.0], "pass"),
        ([1.0, 1.3, 1.12], "fail"),
        ([0.88, 1.3, 1.0], "fail"),
        ([1.0, 0.88, 1.0], "fail"),
    ],
)
def test_where_the_step_limit_may_lie(values, light):
    assert verdicts.limit_verdict(found(limits={"fd": values})).outcome == light


@pytest.mark.parametrize(
    ("below", "above", "light"), [(19.0, 110.0, "pass"), (19.0, math.inf, "pass"), (60.0, math.inf, "fail"), (5.0, 33.0, "fail")]
)
def test_noise_stays_below_the_limit_and_grows_above(below, above, light):
    assert verdicts.medium_verdict({"alike": {"fd": (1.0, math.inf), "dg:4": (below, above)}}).outcome == light


@pytest.mark.parametrize(("ratio", "light"), [(1.009, "pass"), (0.991, "pass"), (1.03, "fail"), (0.97, "fail")])
def test_where_the_states_limit_may_lie(ratio, light):
    assert verdicts.state_verdict({"fd": math.inf, "sbp:2": 2.785 * ratio}).outcome == light
    assert verdicts.state_verdict({"fd": math.inf, "dg:4": 6.394 * ratio}).outcome == light
    assert verdicts.state_verdict({"fd": 9.0, "dg:4": 6.394}).outcome is Light.FAIL


def test_a_step_past_the_limit_must_be_told():
    assert verdicts.stop_verdict({"fd": True, "dg:4": True}).outcome is Light.PASS
    assert verdicts.stop_verdict({"fd": True, "dg:4": False}).outcome is Light.FAIL


@pytest.mark.parametrize(("model", "limit"), [("sbp:2", 5e-3), ("fem:1", 5e-3), ("fd", 1e-5), ("dg:3", 2e-6), ("sbp:4", 2e-6)])
def test_advice_must_cure(model, limit):
    lights = [
        verdicts.advice_verdict({"dg:7": Advice(0, "", 4, 1e-9), model: Advice(8, "more cells", 16, error)}).outcome
        for error in (0.95 * limit, 3.0 * limit, math.inf)
    ]
    assert lights == [Light.PASS, Light.FAIL, Light.FAIL]


@pytest.mark.parametrize(
    ("noise", "light"),
    [
        ({"fd": 1.00028, "dg:4": 0.99}, "pass"),
        ({"fd": 0.99972, "dg:4": 0.99}, "pass"),
        ({"fd": 0.999, "dg:4": 0.9}, "fail"),
        ({"fd": 1.001, "dg:4": 0.9}, "fail"),
        ({"fd": 1.0, "dg:4": 1.001}, "fail"),
        ({"fd": 1.0, "dg:4": math.inf}, "fail"),
        ({"fd": math.nan, "dg:4": 0.9}, "fail"),
    ],
)
def test_noise_gains_nothing_and_the_leapfrog_loses_nothing(noise, light):
    assert verdicts.noise_verdict(noise, 1e3).outcome == light


def test_the_answer_counts():
    told = verdicts.answer(found())
    assert told.startswith("The step limit lies at 0.99 to 1.02 of the declared one")
    assert "of 2 attacks 1 end right, 1 with a message, 0 silently wrong; at most 1 of the energy" in told
    wrong = {"V 3": {"fd": AttackOutcome(1.0), "dg:4": AttackOutcome(0.0)}}
    assert "of 2 attacks 1 end right, 0 with a message, 1 silently wrong" in verdicts.answer(found(attacks=wrong))

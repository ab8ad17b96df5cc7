"""The attacks: runs end right or with a message, and every limit of the study is held from both sides."""

import math

import pytest

from validation.studies import stability_attacks
from validation.studies.stability_attacks.limits import _largest, stops_beyond
from validation.studies.stability_attacks.runs import ATTACKS, CELLS, AttackOutcome, Cure, advised, attack, locked_noise
from validation.study import Outcome as Light

STOPPED = AttackOutcome(math.nan, message="too stiff")


@pytest.mark.parametrize("model", CELLS)
def test_a_step_past_the_limit_ends_with_a_message(model):
    assert stops_beyond(model, 1.2)
    assert not stops_beyond(model, 0.9)


@pytest.mark.parametrize("name", ["epsilon 2", "V -6", "impedance", "jump"])
def test_attacks_end_right_or_with_a_message(name):
    found = attack(name)
    assert set(found) == set(CELLS)
    assert not any(outcome.silently_wrong(1e-4) for outcome in found.values())


@pytest.mark.parametrize("name", ["V 4", "jump back"])
def test_late_cycles_are_right(name):
    assert not any(outcome.silently_wrong(1e-2, 2e-2) for outcome in attack(name, late=True).values())


@pytest.mark.parametrize("model", ["sbp:4", "fem:4"])
def test_cells_that_the_message_asks_for_make_the_run_right(model):
    advice = advised(model)
    assert 0 < advice.stopped < advice.cells
    assert "relaxes at" in advice.message
    assert "more cells or a smaller cfl" in advice.message
    assert advice.error < 1e-6


@pytest.mark.parametrize("model", ["fd", "sbp:6", "dg:4"])
def test_noise_gains_no_energy(model):
    assert 0.0 < locked_noise(model, 200.0) <= 1.0 + 1e-4


@pytest.mark.parametrize(("edge", "found"), [(0.7, 0.0), (0.9, 0.9), (1.2, 1.2), (1.6, 1.5)])
def test_the_search_for_a_limit_says_where_it_ends(edge, found):
    """Between 0.8 and 1.5 to 1 per cent; beyond, 0 and 1.5."""
    assert _largest(lambda share: share < edge) == pytest.approx(found, rel=1e-2)


CHANGED = {"epsilon": ("slab.epsilon=1e{}", "ε = 10^{{{}}}"), "V": ("drive.velocity=1e{}", "V = 10^{{{}}} V*")}


@pytest.mark.parametrize("name", [name for name in ATTACKS if name.split()[0] in CHANGED])
def test_an_attack_changes_what_its_name_says(name):
    quantity, power = name.split()
    changes, title = (text.format(power) for text in CHANGED[quantity])
    assert (ATTACKS[name].changes, ATTACKS[name].title) == ((changes,), title)
    assert ATTACKS[name].late == (200.0 if quantity == "V" and int(power) > 4 else 400.0)


@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_must_end_right_or_with_a_message(name):
    early, late = ATTACKS[name].right

    def light(outcome):
        return stability_attacks.attack_verdict(name, {"fd": AttackOutcome(0.0), "dg:4": outcome}, True).outcome

    passing, failing = [AttackOutcome(early, late), STOPPED], [(1.1 * early, 0.0), (0.0, 1.1 * late), (math.nan,)]
    assert [light(one) for one in passing] == [Light.PASS] * 2
    assert [light(AttackOutcome(*one)) for one in failing] == [Light.FAIL] * 3


RATIOS = {"fd": math.inf, "sbp:2": 2.785, "dg:4": 6.394}
CURED = Cure(0, "", 4, 1e-9)
JUDGED = {
    "limit_verdict": (
        [{"fd": dict(zip((-4, 0, 8), values, strict=True))} for values in ((1.0, 1.3, 1.039), (0.961, 1.3, 1.0))],
        [{"fd": dict(zip((-4, 0, 8), values, strict=True))} for values in ((1, 1.3, 1.12), (0.88, 1.3, 1), (1, 0.88, 1))],
    ),
    "medium_verdict": (
        [{"alike": {"fd": (1.0, math.inf), "dg:4": pair}} for pair in ((19.0, 110.0), (19.0, math.inf))],
        [{"alike": {"fd": (1.0, math.inf), "dg:4": pair}} for pair in ((60.0, math.inf), (5.0, 33.0))],
    ),
    "state_verdict": (
        [RATIOS, RATIOS | {"sbp:2": 2.785 * 1.009}, RATIOS | {"dg:4": 6.394 * 0.991}],
        [RATIOS | {"fd": 9.0}, RATIOS | {"sbp:2": 2.785 * 0.97}, RATIOS | {"dg:4": 6.394 * 1.03}],
    ),
    "stop_verdict": ([{"fd": True, "dg:4": True}], [{"fd": True, "dg:4": False}]),
    "advice_verdict": tuple(
        [
            {"dg:7": CURED, model: Cure(8, "more cells", 16, share * limit)}
            for model, limit in {"sbp:2": 5e-3, "fem:1": 5e-3, "fd": 1e-5, "dg:3": 2e-6}.items()
        ]
        for share in (0.95, 3.0)
    ),
}


@pytest.mark.parametrize("verdict", JUDGED)
def test_every_measurement_is_judged_on_both_sides(verdict):
    for light, cases in zip((Light.PASS, Light.FAIL), JUDGED[verdict], strict=True):
        assert [getattr(stability_attacks, verdict)(case).outcome for case in cases] == [light] * len(cases)


@pytest.mark.parametrize(
    ("leapfrog", "elements", "light"),
    [
        (1.00028, 0.99, "pass"),
        (0.99972, 0.99, "pass"),
        (0.999, 0.9, "fail"),
        (1.001, 0.9, "fail"),
        (1.0, 1.001, "fail"),
        (1.0, math.inf, "fail"),
        (math.nan, 0.9, "fail"),
    ],
)
def test_noise_gains_nothing_and_the_leapfrog_loses_nothing(leapfrog, elements, light):
    assert stability_attacks.noise_verdict({"fd": leapfrog, "dg:4": elements}, 1e3).outcome == light

"""The study of the paper's claims is complete; attacks end right or with a message."""

import math

import pytest
from shown import outcomes
from test_quick_studies import held

from validation.measure.grids.limits import stops_beyond
from validation.report.grid_verdicts import limit_verdict, medium_verdict, noise_verdict
from validation.studies.stability_attacks import CELLS as ATTACKED
from validation.studies.stability_attacks import AttackOutcome, advised, attack, attack_verdict


def test_every_claim_of_the_paper_is_settled_or_said_to_be_left_out():
    result = held("claims")
    settled = {verdict.claim.split()[0] for verdict in result.verdicts}
    left_out = {omission.what.split(",")[0] for omission in result.omissions}
    assert {f"P{n}" for n in range(1, 15)} <= settled | (left_out & {"P8", "P9", "P10", "P14"})
    paper, _, rock = zip(*(row[1:] for row in result.tables[0].rows), strict=True)
    assert (paper[-1], rock[3]) == pytest.approx((1.04604, 5e-8), rel=1e-5)


@pytest.mark.parametrize("model", ATTACKED)
def test_a_step_past_the_limit_ends_with_a_message(model):
    assert stops_beyond(model, 1.2)
    assert not stops_beyond(model, 0.9)


@pytest.mark.parametrize("name", ["epsilon 2", "V -6", "impedance", "jump"])
def test_attacks_end_right_or_with_a_message(name):
    found = attack(name)
    assert set(found) == set(ATTACKED)
    assert not any(outcome.is_silently_wrong for outcome in found.values())


@pytest.mark.parametrize("name", ["V 4", "jump back"])
def test_late_cycles_are_right(name):
    assert not any(outcome.is_silently_wrong for outcome in attack(name, late=True).values())


@pytest.mark.parametrize("model", ["sbp:4", "fem:4"])
def test_cells_that_the_message_asks_for_make_the_run_right(model):
    advice = advised(model)
    assert 0 < advice.stopped < advice.cells
    assert "relaxes at" in advice.message
    assert "more cells or a smaller cfl" in advice.message
    assert advice.error < 1e-6


def test_an_attack_must_end_right_to_1_percent_or_with_a_message():
    ends = [(0.0099, 0.0099), (math.nan, 0.0, "too stiff"), (0.011, 0.0), (0.0, 0.011), (math.nan,)]
    found = [{"fd": AttackOutcome(0.005), "dg:4": AttackOutcome(*end)} for end in ends]
    assert outcomes(attack_verdict("jump", one) for one in found) == "pass pass fail fail fail"


def limits(*shares):
    return limit_verdict("fd", dict(zip((-4, 0, 8), shares, strict=True)))


def medium(*pair):
    return medium_verdict("alike", {"fd": (1.0, math.inf), "dg:4": pair})


def noise(left):
    """The leapfrog loses what friction takes: 1.60458e-6 in 1000 transits, known to 1.6e-3."""
    return noise_verdict("fd", 1.0 - left, 1e3)


@pytest.mark.parametrize(
    ("judge", "held", "missed"),
    [
        (limits, [(1.0, 1.3, 1.031), (0.969, 1.3, 1.0)], [(1, 1.3, 1.12), (0.88, 1.3, 1), (1, 0.88, 1)]),
        (medium, [(90.0, 110.0), (90.0, math.inf)], [(300.0, math.inf), (5.0, 33.0)]),
        (noise, [(1.6025e-6,), (1.6065e-6,)], [(0.0,), (1.61e-6,), (math.nan,)]),
    ],
)
def test_limits_and_noise_are_held_on_both_sides(judge, held, missed):
    assert [judge(*one).outcome for one in held + missed] == ["pass"] * len(held) + ["fail"] * len(missed)

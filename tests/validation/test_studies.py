"""The registered studies, those of one verdict or two, and their measurements."""

import math
from dataclasses import replace

import numpy as np
import pytest
from shown import judged, outcomes
from test_quick_studies import held

import slipwave
from validation.measure.grids.limits import _largest, stops_beyond
from validation.studies import slip_event, stability_attacks
from validation.studies.partial_reflection import locking_leak
from validation.studies.stability_attacks.runs import ATTACKS, AttackOutcome, Cure, advised, attack
from validation.studies.stability_attacks.runs import CELLS as ATTACKED
from validation.study import grid_verdicts


def test_every_claim_of_the_paper_is_settled_or_said_to_be_left_out():
    result = held("claims")
    settled = {verdict.claim.split()[0] for verdict in result.verdicts}
    left_out = {omission.what.split(",")[0] for omission in result.omissions}
    assert {f"P{n}" for n in range(1, 15)} <= settled | (left_out & {"P8", "P9", "P10", "P14"})
    paper, _, rock = zip(*(row[1:] for row in result.tables[0].rows), strict=True)
    assert (paper[-1], rock[3]) == pytest.approx((1.04604, 5e-8), rel=1e-5)


def test_characteristics_notice_a_wrong_wave_speed_and_an_event_that_never_ends_is_red():
    event = slip_event._record(8)
    field, upper = event.field, event.field.upper
    assert slip_event.characteristics(field) < 1e-3
    assert slip_event.characteristics(replace(field, upper=replace(upper, depth=1.05 * upper.depth))) > 1e-2
    endless = replace(event, field=replace(field, upper=replace(upper, velocity=np.full_like(upper.velocity, 1e3))))
    assert outcomes(slip_event._verdicts(endless, 0.0)).endswith("fail")


def test_where_the_interface_locks():
    assert locking_leak() == pytest.approx(2.0 / 11.0)


@pytest.mark.parametrize("model", ATTACKED)
def test_a_step_past_the_limit_ends_with_a_message(model):
    assert stops_beyond(model, 1.2)
    assert not stops_beyond(model, 0.9)


@pytest.mark.parametrize("name", ["epsilon 2", "V -6", "impedance", "jump"])
def test_attacks_end_right_or_with_a_message(name):
    found = attack(name)
    assert set(found) == set(ATTACKED)
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


@pytest.mark.parametrize(("edge", "found"), [(0.7, 0.0), (0.9, 0.9), (1.2, 1.2), (1.6, 1.5)])
def test_the_search_for_a_limit_says_where_it_ends(edge, found):
    """Between 0.8 and 1.5 to 1 per cent; beyond, 0 and 1.5."""
    assert _largest(lambda share: share < edge) == pytest.approx(found, rel=1e-2)


@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_must_end_right_or_with_a_message(name):
    early, late = ATTACKS[name].right
    passing = [(early, late), (math.nan, 0.0, "too stiff")]
    ends = [*passing, (1.1 * early, 0.0), (0.0, 1.1 * late), (math.nan,)]
    found = [{"fd": AttackOutcome(0.0), "dg:4": AttackOutcome(*end)} for end in ends]
    assert outcomes(stability_attacks.attack_verdict(name, one, True) for one in found) == "pass pass fail fail fail"


PAPER, GRID = slipwave.read("paper"), np.array([8, 12, 16, 24, 32, 48])
RATIOS = {"fd": math.inf, "sbp:2": 2.785, "dg:4": 6.394}


def limits(*values):
    return ({"fd": dict(zip((-4, 0, 8), values, strict=True))},)


def medium(*pair):
    return ({"alike": {"fd": (1.0, math.inf), "dg:4": pair}},)


def cured(model, error):
    return ({"dg:7": Cure(0, "", 4, 1e-9), model: Cure(8, "more cells", 16, error)},)


ADVISED = {"sbp:2": 5e-3, "fem:1": 5e-3, "fd": 1e-5, "dg:3": 2e-6}
JUDGED = [
    *((grid_verdicts.limit_verdict, limits(*case), end) for *case, end in (
      (1.0, 1.3, 1.031, "pass"), (0.969, 1.3, 1.0, "pass"), (1, 1.3, 1.12, "fail"), (0.88, 1.3, 1, "fail"),
      (1, 0.88, 1, "fail"))),
    *((grid_verdicts.medium_verdict, medium(*case), end) for *case, end in
      ((90.0, 110.0, "pass"), (90.0, math.inf, "pass"), (300.0, math.inf, "fail"), (5.0, 33.0, "fail"))),
    *((grid_verdicts.state_verdict, (RATIOS | one,), end) for one, end in
      (({}, "pass"), ({"sbp:2": 2.785 * 1.009}, "pass"), ({"dg:4": 6.394 * 0.991}, "pass"), ({"fd": 9.0}, "fail"),
       ({"sbp:2": 2.785 * 0.97}, "fail"), ({"dg:4": 6.394 * 1.03}, "fail"))),
    (grid_verdicts.stop_verdict, ({"fd": True, "dg:4": True},), "pass"),
    (grid_verdicts.stop_verdict, ({"fd": True, "dg:4": False},), "fail"),
    *((stability_attacks.advice_verdict, cured(model, share * limit), end) for model, limit in ADVISED.items()
      for share, end in ((0.95, "pass"), (3.0, "fail"))),
    # noise gains nothing, and the leapfrog loses what friction takes: 1.60458e-6 in 1000 transits, known to 1.6e-3
    *((stability_attacks.noise_verdict, ({"fd": leapfrog, "dg:4": elements}, 1e3), end) for leapfrog, elements, end in
      ((1.0 - 1.6025e-6, 0.99, "pass"), (1.0 - 1.6065e-6, 0.99, "pass"), (1.0, 0.9, "fail"), (1.0 - 1.61e-6, 0.9, "fail"),
       (1.0 - 1.6045e-6, 1.001, "fail"), (1.0 - 1.6045e-6, math.inf, "fail"), (math.nan, 0.9, "fail"))),
]  # fmt: skip


@pytest.mark.parametrize(("study", "given", "expected"), JUDGED)
def test_verdicts_from_both_sides(study, given, expected):
    assert judged(study(*given), expected)

"""The bifurcation diagrams: published special points, the index, the paper's claims from both sides, coexisting orbits."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from validation.branches.points import BranchPoint
from validation.studies.bifurcation import measured as verdicts
from validation.studies.bifurcation import structure_table
from validation.study import Outcome
from validation.study.over_r import branch_of, parts, unaccounted


def special(kind, log10_r, before=0, after=1):
    return SimpleNamespace(kind=kind, point=point(log10_r, after), unstable_before=before, unstable_after=after)


def point(log10_r, unstable):
    return SimpleNamespace(parameter=log10_r, unstable=unstable)


def made(model, *found, points=()):
    """A branch of given special points."""
    return SimpleNamespace(
        model=model,
        onset=SimpleNamespace(parameter=-2.7),
        points=points or tuple(one.point for one in found),
        special=found,
        of_kind=lambda *kinds: [one for one in found if one.kind in kinds],
    )


def test_the_index_counts_what_no_point_explains():
    fold, torus = special("LP", -2.71, 1, 0), special("NS", -2.6, 0, 2)
    whole = (point(-2.7, 1), fold.point, point(-2.65, 0), torus.point, point(-2.5, 2))
    assert unaccounted(made("delay", fold, torus, points=whole)) == 0
    assert verdicts.index([made("delay", fold, torus, points=whole)]).outcome is Outcome.PASS
    missed = (*whole[:2], point(-2.65, 1), *whole[3:])
    assert unaccounted(made("delay", fold, torus, points=missed)) == 1
    assert verdicts.index([made("delay", fold, torus, points=missed)]).outcome is Outcome.FAIL
    wrong = special("PD", -2.6, 0, 2)
    assert unaccounted(made("delay", wrong, points=(point(-2.7, 0), wrong.point))) == 1


@pytest.mark.parametrize(
    ("first", "outcome"),
    [
        (special("LP", -2.7007, 1, 0), "pass"),
        (special("LP", -2.6993, 1, 0), "finding"),
        (special("LP", -2.7007, 2, 1), "finding"),
        (special("PD", -2.7007, 1, 0), "finding"),
    ],
)
def test_p8_needs_a_fold_below_the_onset_that_gives_stability(first, outcome):
    fold = special("LP", -2.7007, 1, 0)
    assert verdicts.mildly_subcritical(made("delay", fold), made("kelvin-voigt", first)).outcome == outcome


@pytest.mark.parametrize(
    ("kinds", "torus", "outcomes"),
    [
        ("LP PD PD LP LP PD PD LP LP PD PD NS", -2.4682, ["pass", "pass"]),
        ("LP PD PD LP LP PD PD LP LP PD PD NS", -2.469, ["pass", "finding"]),
        ("LP PD PD LP LP PD PD NS", -2.468, ["finding", "pass"]),
    ],
)
def test_p9_needs_the_order_of_the_points_and_the_place_of_the_torus(kinds, torus, outcomes):
    ode = made("kelvin-voigt", *(special(kind, torus if kind == "NS" else -2.5) for kind in kinds.split()))
    assert [verdict.outcome for verdict in verdicts.bubbles(ode)] == outcomes


def test_p14_compares_what_takes_stability_first():
    doubling, torus = special("PD", -2.6, 0, 1), special("NS", -2.65, 0, 2)
    ode = made("kelvin-voigt", doubling, torus)
    assert verdicts.unlike(made("delay", torus, doubling), ode).outcome is Outcome.FINDING
    assert verdicts.unlike(made("delay", doubling, torus), ode).outcome is Outcome.PASS


def test_parts_share_their_ends():
    corners = [BranchPoint(float(n), *[0.0] * 5, unstable, None) for n, unstable in enumerate((1, 1, 0, 0, 2, 1))]
    assert [(stable, [corner.value for corner in part]) for stable, part in parts(corners)] == [
        (False, [0.0, 1.0, 2.0]),
        (True, [2.0, 3.0, 4.0]),
        (False, [4.0, 5.0]),
    ]


def test_coexisting_orbits_are_all_found():
    branch = branch_of("kelvin-voigt", -2.3, 61.0)
    periods = [orbit.cycle.period for orbit in branch.orbits_at(-2.7)]
    assert periods == pytest.approx([55.082257, 60.584973], abs=1e-5)
    assert branch.orbits_at(-2.69) == []
    shifted = replace(branch, onset=branch.onset._replace(parameter=branch.onset.parameter + 1e-8))
    assert [verdicts.published(one).outcome for one in (branch, shifted)] == [Outcome.PASS, Outcome.FAIL]


def test_how_much_of_the_structure_a_model_has():
    delay = made("delay", special("LP", -2.7002), special("LP", -2.66), special("NS", -2.65))
    ode = made("kelvin-voigt", special("LP", -2.7001), special("PD", -2.6))
    rows = {str(row[0]): row[1:] for row in structure_table(delay, [ode]).rows}
    assert (rows["Hopf point"], rows["fold 1"]) == ((-2.7, 0.0), (-2.7002, pytest.approx(1e-4)))
    assert (rows["fold 2"], rows["torus point 1"]) == ((-2.66, None), (-2.65, None))
    assert rows["period doubling 1"] == (None, None)


@pytest.mark.parametrize(("last", "outcome"), [(-2.7002 - 1e-7, "pass"), (-2.7002 - 9e-7, "fail")])
def test_modes_converge(last, outcome):
    delay, *modal = (made(f"modal:{n}", special("LP", place)) for n, place in enumerate((-2.7002, -2.7002 + 1e-6, last)))
    assert verdicts.modes_converge(delay, modal).outcome == outcome

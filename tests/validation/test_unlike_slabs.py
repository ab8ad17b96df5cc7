import numpy as np
import pytest
from roomy import too_roomy
from shown import quick

from validation.measure.cycle import Cycle
from validation.studies import study_called
from validation.studies.unlike_slabs import cost_verdicts, last_cycles
from validation.studies.unlike_slabs.runs import PairRun
from validation.study import Outcome

STUDY = study_called("unlike-slabs")


@pytest.fixture(scope="module")
def result():
    return quick("unlike-slabs")


def test_every_agreement_holds(result):
    agreements = [v for v in result.verdicts if not v.claim.startswith("Cost")]
    assert [v.claim for v in agreements if v.outcome is not Outcome.PASS] == []
    assert too_roomy(agreements) == []
    assert len(agreements) == 5


def test_states(result):
    assert result.numbers["unlike: ψ(600)"].value == pytest.approx(-5.25812015405, abs=2e-11)
    assert result.numbers["unlike-irrational: ψ(600)"].value == pytest.approx(-3.22732303547, abs=2e-11)


def two_pairs(psi, cells=4):
    """Runs of both scenes: the delay system, and models whose psi differs from its own by so much."""
    values = {"delay": 0.0} | psi
    runs = [PairRun(name.partition(",")[0], cells, {"psi": -5.0 + off, "period": 50.0}, None) for name, off in values.items()]
    return dict.fromkeys(("unlike", "unlike-irrational"), runs)


def test_cost_verdicts_look_at_ratios():
    alike = {"alike": 5.0, "commensurate": 10.0, "irrational": 51.0}
    outcomes = [v.outcome for v in cost_verdicts(dict.fromkeys(("delay", "dg:7", "dg:7, finer", "fd"), alike))]
    assert np.array_equal(outcomes, [Outcome.PASS, Outcome.FINDING, *[Outcome.PASS] * 3])


@pytest.mark.parametrize(
    ("verdicts", "psi", "cells", "outcome"),
    [
        ("_agreements", {"dg:7": 2.7e-11}, 4, "pass"),
        ("_agreements", {"dg:7": -9e-11}, 4, "fail"),
        ("_families", {"dg:7": 0.0, "fem:4": 0.0, "sbp:6": 0.9e-10}, 48, "pass"),
        ("_families", {"dg:7": 0.0, "fem:4": 0.0, "sbp:6": -3e-10}, 48, "fail"),
        ("_families", {"dg:7": 0.0, "fem:4": 0.0, "sbp:6": 1.1e-11}, 96, "pass"),
        ("_families", {"dg:7": 0.0, "fem:4": 0.0, "sbp:6": 4e-11}, 96, "fail"),
        *(
            ("_leapfrog", {"fd": ratio * 1e-6, "fd, finer": 1e-6}, 96, outcome)
            for ratio, outcome in ((4.14, "pass"), (3.86, "pass"), (4.4, "fail"), (3.6, "fail"))
        ),
    ],
)
def test_agreement_is_judged_on_both_sides(verdicts, psi, cells, outcome):
    assert {verdict.outcome for verdict in getattr(STUDY, verdicts)(two_pairs(psi, cells))} == {outcome}


def test_the_answer_tells_difference_and_cost():
    timed = {"delay": {"alike": 2.0, "commensurate": 4.0, "irrational": 6.0}}
    told = STUDY._answer(two_pairs({"dg:7": 3e-12}), timed)
    assert told.startswith(
        "They do: after 600 transits ψ of the delay network and of discontinuous Galerkin differ by 3 · 10^{−12}"
    )
    assert "~{2.0 times} as long as one of alike slabs, ~{3.0 times} where echoes never coincide" in told
    assert STUDY._answer(two_pairs({"dg:7": 3e-9}), timed).startswith("No: after 600 transits")


def test_the_figure_lays_points_over_lines():
    time = np.linspace(0.0, 130.0, 400)
    cycle = Cycle(time, 5.0 + np.sin(time), time, 0.4 + 1e-3 * time, time, 50.0)
    figure = last_cycles({"unlike": (cycle, cycle), "unlike-irrational": (cycle, cycle)})
    line, points = figure.axes[0].get_lines()
    assert np.array_equal(line.get_xdata(), time)
    assert np.array_equal(line.get_ydata(), cycle.stress)
    assert set(points.get_ydata()) <= set(line.get_ydata())

from dataclasses import replace

import numpy as np
import pytest
from roomy import too_roomy
from shown import quick

from validation.measure.cycle import Cycle
from validation.studies import load
from validation.studies.unlike_slabs.cost import cost_verdicts
from validation.studies.unlike_slabs.runs import PairRun
from validation.studies.unlike_slabs.shown import last_cycles
from validation.study import Outcome

STUDY = load("unlike-slabs")


@pytest.fixture(scope="module")
def result():
    return quick("unlike-slabs")


def test_every_agreement_holds(result):
    agreements = [v for v in result.verdicts if not v.claim.startswith("Cost")]
    assert [v.claim for v in agreements if v.outcome is not Outcome.PASS] == []
    assert too_roomy(agreements) == []
    assert len(agreements) == 6


def test_states(result):
    assert result.numbers["unlike: ψ(600)"].value == pytest.approx(-5.25812015405, abs=2e-11)
    assert result.numbers["unlike-irrational: ψ(600)"].value == pytest.approx(-3.22732303547, abs=2e-11)


def two_pairs(**psi):
    runs = {}
    for name in ("unlike", "unlike-irrational"):
        values = {"delay": -5.0} | {model: -5.0 + off for model, off in psi.items()}
        cells = {"sbp_6": 48}
        runs[name] = [
            PairRun(model.replace("_", ":").split(" ")[0], cells.get(model, 4), {"psi": value, "period": 50.0}, None)
            for model, value in values.items()
        ]
    return runs


def test_cost_verdicts_look_at_ratios():
    alike = {"alike": 5.0, "commensurate": 10.0, "irrational": 51.0}
    outcomes = [v.outcome for v in cost_verdicts(dict.fromkeys(("delay", "dg:7", "dg:7, finer", "fd"), alike))]
    assert np.array_equal(outcomes, [Outcome.PASS, Outcome.FINDING, *[Outcome.PASS] * 3])


@pytest.mark.parametrize(("off", "outcome"), [(2.7e-11, Outcome.PASS), (-9e-11, Outcome.FAIL)])
def test_delay_and_galerkin(off, outcome):
    assert {verdict.outcome for verdict in STUDY._agreements(two_pairs(dg_7=off))} == {outcome}


@pytest.mark.parametrize(
    ("cells", "off", "outcome"),
    [(48, 0.9e-10, "pass"), (48, -3e-10, "fail"), (96, 1.1e-11, "pass"), (96, 4e-11, "fail")],
)
def test_families_of_high_order(cells, off, outcome):
    runs = two_pairs(dg_7=0.0, sbp_6=off, fem_4=0.0)
    runs = {name: [replace(one, cells=cells) if one.model == "sbp:6" else one for one in some] for name, some in runs.items()}
    assert {verdict.outcome for verdict in STUDY._families(runs)} == {outcome}


@pytest.mark.parametrize(("ratio", "outcome"), [(4.14, "pass"), (3.86, "pass"), (4.4, "fail"), (3.6, "fail"), (2.0, "fail")])
def test_the_leapfrogs_error_falls_with_the_square(ratio, outcome):
    runs = {name: [one for one in some if one.model == "delay"] for name, some in two_pairs().items()}
    for some in runs.values():
        some += [PairRun("fd", n, {"psi": -5.0 + off, "period": 50.0}, None) for n, off in ((96, ratio * 1e-6), (192, 1e-6))]
    assert {verdict.outcome for verdict in STUDY._leapfrog(runs)} == {outcome}


def test_the_answer_tells_difference_and_cost():
    timed = {"delay": {"alike": 2.0, "commensurate": 4.0, "irrational": 6.0}}
    told = STUDY._answer(two_pairs(dg_7=3e-12), timed)
    assert told.startswith(
        "They do: after 600 transits ψ of the delay network and of discontinuous Galerkin differ by 3 · 10^{−12}"
    )
    assert "2.0 times as long as one of alike slabs, 3.0 times where echoes never coincide" in told
    assert STUDY._answer(two_pairs(dg_7=3e-9), timed).startswith("No: after 600 transits")


def test_the_figure_lays_points_over_lines():
    time = np.linspace(0.0, 130.0, 400)
    cycle = Cycle(time, 5.0 + np.sin(time), time, 0.4 + 1e-3 * time, time, 50.0)
    figure = last_cycles({"unlike": (cycle, cycle), "unlike-irrational": (cycle, cycle)})
    stress, rate = figure.axes[0], figure.axes[2]
    assert (stress.get_ylabel(), rate.get_ylabel()) == (r"stress $\mu$", r"slip rate $v/V^*$")
    assert rate.get_xlabel() == "time since the slip event (transits)"
    line, points = stress.get_lines()
    assert np.array_equal(line.get_xdata(), time)
    assert np.array_equal(line.get_ydata(), cycle.stress)
    assert set(points.get_ydata()) <= set(line.get_ydata())
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["delay system", "full wave"]

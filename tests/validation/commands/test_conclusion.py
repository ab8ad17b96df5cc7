"""What `compare` and `bench` say of their rows: errors, differences with margins, one line at the end, the overlay."""

import dataclasses
import math

import numpy as np
import pytest

import slipwave as sw
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.statistics import Margins, RunStatistics, Spread
from slipwave.observe.verdict import MotionVerdict
from slipwave.solve import follow
from validation.commands.cli import INPUT_WRONG, main
from validation.commands.comparison import conclusion, differences, in_json, nothing
from validation.models.build import build


def row(model, wall, error=1e-3, **more):
    return {"model": model, "wall_s": wall, "error": {"period": error}, "verdict": "periodic"} | more


FAILED, STEADY = row("quasistatic", 0.01, None, failed="it runs away"), row("block8", 0.01, None, verdict="steady")
APART = {
    "verdict": "irregular",
    "difference": {"period": 0.03, "stress_drop": -0.2},
    "margin": {"period": 0.004, "stress_drop": 0.1},
}


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ([row("delay", 1.0, 0.0), row("block8", 1.5), row("fd", 0.1), FAILED],
         "delay is cheaper than any reduction here and exact"),
        ([row("delay", 1.0), row("block8", 0.5), row("kelvin-voigt", 0.2, -0.037)],
         "kelvin-voigt is cheaper than delay, 5 times, with errors of 3.7 % in the period"),
        ([row("delay", 1.0), row("block8", 0.1, -0.051), row("kelvin-voigt", 0.2, -0.07)],
         "nothing cheaper than delay is within 5 %: the nearest is block8, 10 times cheaper, with errors of 5.1 % in the period"),
        ([row("delay", 1.0, None, **APART), row("modal:2", 0.5, None, **APART)],
         "nothing cheaper than delay is within 5 %: the nearest is modal:2, 2 times cheaper, off by 3 +- 0.4 % in the period and "
         "20 +- 10 % in the stress drop"),
        ([row("delay", 1.0, None, **APART), row("modal:2", 0.5, None, **APART | {"difference": {"period": -0.045}})],
         "modal:2 is cheaper than delay, 2 times, off by 4.5 +- 0.4 % in the period"),
        ([row("delay", 1.0), row("delay", 0.5), row("fd", 5.0), row("dg:7", 2.0), STEADY],
         "delay is exact and 4 times cheaper than the cheapest full wave here, dg:7"),
        ([row("delay", 1.0), FAILED, STEADY], ""),
    ],
)  # fmt: skip
def test_the_conclusion_is_that_of_the_rows(rows, told):
    assert conclusion(rows) == told


@pytest.fixture(scope="module")
def runs():
    found = sw.compare("paper", "delay,block8", until=200, **{"drive.velocity": 2000}).runs
    return found[0], found[1]


def changed(run, kind, period, margin):
    """A run of that verdict and mean period; the margin is that of every mean."""
    cycles = 9 if math.isfinite(period) else 0
    means = (Spread(period, 0.1), *[Spread(0.2 if cycles else math.nan, 0.1)] * 2)
    figures = RunStatistics(cycles, *means, 1.0, 1.0, 1.0, Margins(margin, margin, margin))
    return dataclasses.replace(run, verdict=MotionVerdict(kind, cycles), statistics=figures)


def test_differences_of_motions_that_never_repeat_have_margins_and_are_no_errors(runs):
    """The margin of a ratio a/b: (a/b) sqrt((da/a)^2 + (db/b)^2)."""
    ours, theirs = changed(runs[1], "irregular", 12.0, 0.6), changed(runs[0], "torus", 10.0, 0.4)
    found = differences(ours, theirs)
    assert found["period"] == pytest.approx((0.2, 1.2 * math.hypot(0.05, 0.04)))
    assert found["stress_drop"] == pytest.approx((0.0, math.hypot(3.0, 2.0)))
    shown = in_json(ours, theirs)
    assert shown["error"] == {"period": None, "stress_drop": None}
    assert (shown["difference"]["period"], shown["margin"]["period"]) == tuple(found["period"])
    beside = differences(ours, changed(runs[0], "periodic", 10.0, math.nan))
    assert beside["period"].margin == pytest.approx(1.2 * 0.05)


def test_an_empty_comparison_says_how_long_a_run_must_be(runs, capsys):
    assert nothing(runs[0]) == ""
    assert main(["bench", "paper", "--until", "40", "--json"]) == INPUT_WRONG
    printed = capsys.readouterr()
    told = "nothing to compare: the run of delay is too short; try --until 1100"
    assert (printed.out, printed.err.splitlines()[-1]) == ("", f"slipwave: until = 40: {told}")
    found = sw.compare("paper", "delay", until=40)
    assert found.notes == [told]
    assert told in [text.get_text() for text in found.plot().axes[0].texts]
    steady = sw.compare("paper", "delay", until=10, size=0, r=1e-3)
    assert steady.notes == ["nothing to compare: the second half of the run of delay is steady"]


def test_the_overlay_has_the_last_cycle_of_each_model():
    figure = sw.compare("paper", "delay,kelvin-voigt", until=2000).plot()
    above, below = figure.axes
    assert (above.get_ylabel(), below.get_ylabel()) == ("friction stress / normal stress", "slip rate / V*")
    assert below.get_xlabel() == "transits since v passed half its largest value in the slip event"
    assert [text.get_text().partition(":")[0] for text in figure.legends[0].get_texts()] == ["delay", "kelvin-voigt"]
    solver = build("delay", sw.read("paper"))
    watch, history = EventObserver(solver.scene, solver.nodes), HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, 2000.0, [watch, history])
    columns, events = history.columns(), watch.events()
    begin, period = events.time[-1], events.period[-1]
    inside = (columns["time"] >= begin) & (columns["time"] <= begin + period)
    for axes, name in ((above, "stress"), (below, "slip_rate")):
        time, values = axes.get_lines()[-1].get_data()  # the reference, on top
        np.testing.assert_allclose(time, columns["time"][inside] - begin, atol=1e-9)
        np.testing.assert_allclose(values, columns[name][inside], rtol=1e-9)
        assert len(axes.get_lines()) == 2

"""What the report's first two studies conclude from their numbers: outcomes on both sides of every limit, answers, figures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import slipwave
from slipwave.observe.statistics import Estimate, Orbit
from validation.measure.cycle import Cycle
from validation.references.published import reference_orbit
from validation.studies import one_cycle, scene_facts
from validation.studies.one_cycle import cycles_over_r, measured, over_r_table, overlay, panels, rates
from validation.studies.one_cycle.measured import AtR, CycleRun
from validation.study import Outcome

FIGURES = ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")
DELAY = reference_orbit("delay", -2.68)


def a_run(**changes: float) -> CycleRun:
    orbit = Orbit(*(Estimate(DELAY[name] * (1.0 + changes.get(name, 0.0)), 0.0) for name in FIGURES))
    time = np.linspace(-4.0, 80.0, 40)
    cycle = Cycle(time, 5.0 + np.cos(time) ** 2, np.zeros(40), 0.4 + 1e-3 * time, time, 80.0)
    return CycleRun(orbit, cycle)


def test_scenes_given_in_si_are_the_same_to_rounding():
    paper = slipwave.read("paper")

    def outcome(off):
        upper = SimpleNamespace(epsilon=paper.upper.epsilon * (1.0 + off))
        return scene_facts._verdicts(paper, SimpleNamespace(upper=upper, transit=paper.transit))[0].outcome

    assert [outcome(7e-16), outcome(3e-15)] == [Outcome.PASS, Outcome.FAIL]


def test_the_answer_tells_on_which_side_of_onset_the_scene_lies():
    assert "4.6 % beyond the onset" in scene_facts._answer(1.046)
    assert "4.6 % short of the onset" in scene_facts._answer(0.954)


# half of the last digit known, relative: 0.1739634131, 0.1547375, 4412.32, 2.860302; and 9e-11 for our own orbit
@pytest.mark.parametrize(
    ("figure", "limit"),
    [("period", 9e-11), ("stress_drop", 3.7e-10), ("elastic_stress_drop", 3.2e-7), ("v_max", 1.1e-6), ("v_min", 1.7e-7)],
)
def test_an_orbit_may_differ_by_the_digits_that_are_not_known(figure, limit):
    outcomes = [next(measured.verdicts({"delay": a_run(**{figure: off})}, "", "")).outcome for off in (0.9 * limit, -3.0 * limit)]
    assert outcomes == [Outcome.PASS, Outcome.FAIL]


@pytest.mark.parametrize(
    ("off", "quasistatic", "quasidynamic", "outcomes"),
    [
        (4.5e-4, "v grows", "steady", ["pass"] * 3),
        (-1.5e-3, "", "", ["fail"] * 3),
        (4.5e-4, "steady", "v grows", ["pass", "fail", "fail"]),
    ],
)
def test_the_leapfrog_and_what_ends_the_simplest_models(off, quasistatic, quasidynamic, outcomes):
    found = measured.verdicts({"delay": a_run(), "fd": a_run(v_min=off)}, quasistatic, quasidynamic)
    assert [verdict.outcome for verdict in found][1:] == outcomes


def test_the_answer_tells_every_error_with_its_sign():
    off = {"kelvin-voigt": -0.037, "block8": 0.043, "block12": 0.06, "modal:1": 6e-4, "modal:2": -6e-6}
    runs = {"delay": a_run()} | {model: a_run(period=value) for model, value in off.items()}
    told = one_cycle._answer(runs)
    assert told.startswith("In outline, with the period off by −3.7 % in the paper’s ODE, by +4.3 % and +6.0 % in the blocks")
    assert "by 6 · 10^{−4} with one exact mode" in told
    assert one_cycle._answer(runs | {"block8": a_run(period=0.5)}).startswith("No, with the period off by −3.7 %")


def test_figures_show_each_models_cycle():
    models = ("delay", "fd", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
    cycles = {model: a_run().cycle for model in models}
    figure = overlay(cycles)
    stress, zoomed, rate, _ = figure.axes
    assert [axes.get_ylabel() for axes in (stress, rate)] == [r"stress $\mu$", r"slip rate $v/V^*$"]
    assert rate.get_xlabel() == "time since the slip event (transits)"
    assert rate.get_yscale() == "log"
    assert len(stress.get_lines()) == len(zoomed.get_lines()) == len(figure.legends[0].get_texts()) == 5
    assert np.array_equal(stress.get_lines()[0].get_ydata(), cycles["delay"].stress)
    assert np.array_equal(rate.get_lines()[0].get_ydata(), cycles["delay"].slip_rate)
    small = panels(cycles, dict.fromkeys(models, -0.037)).axes
    assert len(small) == 6
    assert all(len(axes.get_lines()) == 2 for axes in small)
    assert small[0].get_title().endswith("$-3.7$ %")
    assert small[0].get_ylabel() == r"$\mu$"


def test_the_growth_shows_orbits_and_cycles_of_runs():
    """One thick curve of an orbit, thin ones of a run's cycles, each above its own least stress."""
    cycle = a_run().cycle._replace(elastic_stress=np.linspace(0.2, 0.5, 40))
    orbit, run = (
        AtR(Estimate(64.0, 1e-9), Estimate(0.12, 1e-9), [cycle]),
        AtR(Estimate(80.0, 0.1), Estimate(0.2, 0.01), [cycle] * 3, 90),
    )
    places = {-2.699: dict.fromkeys(one_cycle.COMPARED, orbit), -2.3: dict.fromkeys(one_cycle.COMPARED, run)}
    count, (first, last) = len(one_cycle.COMPARED), cycles_over_r(places).axes
    assert [axes.get_title() for axes in (first, last)] == [r"$\log_{10} r = -2.699$", r"$\log_{10} r = -2.3$"]
    assert [sum(line.get_ydata().size > 0 for line in axes.get_lines()) for axes in (first, last)] == [count, 3 * count]
    assert first.get_lines()[0].get_ydata()[[0, -1]] == pytest.approx([0.0, 0.3])
    assert first.get_lines()[0].get_linewidth() == 2.0 * last.get_lines()[0].get_linewidth()
    rows = over_r_table(places).rows
    assert rows[0] == (-2.699, "delay", 64.0, 1e-9, 0.12, 1e-9, None)
    assert rows[-1] == (-2.3, one_cycle.COMPARED[-1], 80.0, 0.1, 0.2, 0.01, 90)


def test_the_own_error_of_a_run_is_its_worst():
    run = a_run()
    worst = Estimate(DELAY["v_min"], 3e-9 * DELAY["v_min"])
    rows = rates({"delay": run._replace(orbit=replace(run.orbit, v_min=worst))}).rows
    assert rows[0][-1] == pytest.approx(3e-9)


def test_the_drawing_of_the_slabs_names_what_it_shows():
    written = [text.get_text() for text in scene_facts._draw().axes[0].texts]
    assert written.count("$V/2$") == written.count("$h/2$") == 2
    arrows = {(text.xy, text.xyann) for text in scene_facts._draw().axes[0].texts if text.get_text() == ""}
    upside_down = {tuple((x, -y) for x, y in arrow) for arrow in arrows}
    turned = {tuple((10 - x, -y) for x, y in arrow) for arrow in arrows}
    assert len(arrows) == 6
    assert len(arrows & turned) == 2  # the drive: opposite ways on opposite faces
    assert len(arrows & upside_down) == 4  # the pressure and the two heights
    assert {"out and back: one transit $h/c$", r"friction $F(v,\phi)$", r"$\sigma$", r"$\rho,\ c$"} <= set(written)

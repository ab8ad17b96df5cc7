"""What `compare` and `bench` say of their rows, the overlay, and a record beside models: its slip events, dated as by `fit`."""

import dataclasses
import json
import math
from dataclasses import replace

import numpy as np
import pytest

import slipwave as sw
from slipwave import SceneError
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.statistics import RunStatistics, Spread
from slipwave.observe.verdict import MotionVerdict
from slipwave.solve import follow
from tests.validation.records import written
from validation.commands.bench import _grids
from validation.commands.cli import INPUT_WRONG, main
from validation.commands.comparison import conclusion, differences, nothing
from validation.data.record_events import FALL, falls, measured_motion, noise_of, slip_events
from validation.data.series import Series
from validation.data.writing import _as_record
from validation.fit.records import experiment_of
from validation.models.build import build
from validation.models.by_name import honouring


def row(model, wall, error=1e-3, **more):
    return {"model": model, "wall_s": wall, "error": {"period": error}, "verdict": "periodic"} | more


FAILED, STEADY = row("quasistatic", 0.01, None, failed="it runs away"), row("block8", 0.01, None, verdict="steady")
APART = {"difference": {"period": 0.03, "stress_drop": -0.2}, "margin": {"period": 0.004, "stress_drop": 0.1}}
APART |= {"verdict": "irregular"}
TIMED = [{"wall_low_s": 0.9, "wall_high_s": 1.1}, {"wall_low_s": 0.5, "wall_high_s": 0.7}]
"""In several rounds, as by `bench`."""


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ([row("delay", 1.0, 0.0), row("block8", 2.5), row("fd", 0.1), FAILED],
         "delay is cheaper than any reduction here and exact"),
        ([row("delay", 1.0), row("block8", 1.5)], "delay is exact, and no reduction here is certainly cheaper"),
        ([row("delay", 1.0), row("modal:1", 0.6, 6e-4)], "delay is exact, and no reduction here is certainly cheaper"),
        ([row("delay", 1.0, **TIMED[0]), row("modal:1", 0.6, 6e-4, **TIMED[1])],
         "modal:1 is cheaper than delay, 1.7 times, with errors of 0.06 % in the period"),
        ([row("delay", 1.0), row("dg:7", 1.5)], ""),
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
    figures = RunStatistics(cycles, *means, 1.0, 1.0, 1.0, 1.0, dict.fromkeys(("period", "stress_drop"), margin))
    return dataclasses.replace(run, verdict=MotionVerdict(kind, cycles), statistics=figures)


def test_differences_of_motions_that_never_repeat_have_margins_and_are_no_errors(runs):
    """The margin of a ratio a/b: (a/b) sqrt((da/a)^2 + (db/b)^2)."""
    ours, theirs = changed(runs[1], "irregular", 12.0, 0.6), changed(runs[0], "torus", 10.0, 0.4)
    found = differences(ours, theirs)
    assert found["error"] == {"period": None, "stress_drop": None}
    assert found["difference"] == pytest.approx({"period": 0.2, "stress_drop": 0.0})
    assert found["margin"] == pytest.approx({"period": 1.2 * math.hypot(0.05, 0.04), "stress_drop": math.hypot(3.0, 2.0)})
    beside = differences(ours, changed(runs[0], "periodic", 10.0, math.nan))
    assert beside["margin"]["period"] == pytest.approx(1.2 * 0.05)


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
    stages = sw.compare("velocity-steps", "quasistatic")  # no longer run has cycles: steady sliding is stable
    assert stages.notes == ["nothing to compare: the second half of the run of quasistatic is protocol"]


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


def test_each_grid_of_a_layered_scene_is_tried_once():
    """A layer has a cell of an element at least, or 16 of a difference: fewer were the same grid under another number."""
    scene = sw.read("layered")
    tried = {one.name: [row["cells"] for row in _grids(scene, one)] for one in honouring(scene) if one.grids}
    assert tried == {"fd": [16, 32, 64], "sbp": [32, 64], "fem": [2, 4, 8], "dg": [2, 4]}


NAME, UNTIL = "steel-on-pmma", 90000.0


def recorded(model, rate):
    """A run with slip events as a record, its cycles, and its scene."""
    result = sw.run(NAME, model, until=UNTIL, rate=rate)
    assert result.records.history
    parts = [*_as_record(result.records.history.parts(), result.done.solver.scene)]
    columns = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    return Series("run.csv", columns), result.done.events, result.done.solver.scene


@pytest.fixture(scope="module")
def slips():
    return recorded("quasidynamic", "400kHz")


def sampled(series, scene, noise):
    """What a laboratory would record: a load cell in the drive at 10 kHz, with noise."""
    assert scene.units
    time = np.arange(0.0, series["time"][-1], 1e-4)
    held = (series["load_point_displacement"] - series["slip"]) / scene.units.memory_length / scene.transit
    friction = np.interp(time, series["time"], scene.steady_stress + scene.stiffness * held)
    friction += noise * np.random.default_rng(1).standard_normal(time.size)
    return Series("cell.csv", {"time": time, "load_point_displacement": 1e-3 * time, "friction": friction})


def later(cycles, found):
    """Those that a record has after its unsettled ones."""
    return cycles._make(column[found.early :] for column in cycles)


def test_events_in_the_record_of_a_run_are_those_of_the_run(slips):
    series, cycles, scene = slips
    found = measured_motion(series, scene)
    assert found.early == 1
    cycles = later(cycles, found)
    assert (found.noise, found.smoothing["samples"], found.dates.size) == (0.0, 1, cycles.time.size + 1)
    np.testing.assert_allclose(found.events.time, cycles.time, atol=1.0)  # friction is in the middle of its fall soon after v
    for name in ("period", "stress_drop", "v_max"):
        np.testing.assert_allclose(getattr(found.events, name), getattr(cycles, name), rtol=1e-4)
    without = Series("x", {key: series[key] for key in ("time", "slip", "friction")})
    np.testing.assert_allclose(measured_motion(without, scene).events.v_max[1:], cycles.v_max[1:], rtol=0.01)


def test_noise_adds_no_events_and_what_smoothing_does_is_told(slips):
    series, cycles, scene = slips
    quiet, noisy = (measured_motion(sampled(series, scene, noise), scene) for noise in (0.0, 1e-3))
    assert noise_of(noisy.time, sampled(series, scene, 1e-3)["friction"]) == pytest.approx(1e-3, rel=0.1)
    assert noisy.dates.size - 1 == later(cycles, noisy).time.size
    assert quiet.dates.size - 1 == later(cycles, quiet).time.size
    assert noisy.smoothing["samples"] > 3
    assert np.abs(noisy.dates[-9:] - quiet.dates[-9:]).max() < 2.0 * noisy.smoothing["dates"] < 0.02 * cycles.period[0]
    for name in ("period", "stress_drop", "v_max"):
        change = abs(getattr(noisy.events, name)[-9:].mean() / getattr(quiet.events, name)[-9:].mean() - 1.0)
        assert change < 1.5 * noisy.smoothing[name] + 1e-4, name
    assert quiet.events.stress_drop == pytest.approx(later(cycles, quiet).elastic_stress_drop, rel=2e-3)


def test_compare_and_fit_date_a_record_alike(slips):
    """With noise, in steps of an ADC, with gaps, in a machine that rings: as many slips as the run has."""
    series, cycles, scene = slips
    assert scene.units
    cell = sampled(series, scene, 5e-4)
    time, friction = cell["time"], cell["friction"]
    slips_at = scene.transit * np.append(cycles.time, cycles.time[-1:] + cycles.period[-1:])
    since = time - slips_at[np.maximum(np.searchsorted(slips_at, time) - 1, 0)]
    rings = friction + 0.012 * np.where(since > 0.0, np.exp(-since / 5e-3) * np.sin(2.0 * np.pi * since / 3e-3), 0.0)
    kept = np.random.default_rng(2).random(time.size) < 0.3
    for one in (
        cell,
        replace(cell, columns=cell.columns | {"friction": 4e-3 * np.round(friction / 4e-3)}),
        replace(cell, columns={key: row[kept] for key, row in cell.columns.items()}),
        replace(cell, columns=cell.columns | {"friction": rings}),
    ):
        compared, own, cycle = measured_motion(one, scene), one.of(scene), experiment_of(one, scene).cycle
        np.testing.assert_array_equal(slip_events(own["time"], own["friction"]).date[compared.early :], compared.dates)
        assert compared.dates.size - 1 == later(cycles, compared).time.size
        assert compared.events.period[1:] == pytest.approx(later(cycles, compared).period[1:], rel=5e-3)
        assert cycle
        assert cycle.early == compared.early
        assert cycle.period == pytest.approx(compared.events.period.mean() * scene.transit, rel=1e-9)


@pytest.mark.parametrize("known", ["slip", "slip_rate"])
def test_waves_that_ring_after_a_slip_are_no_events(known):
    """Before, 51 cycles of 15 ms instead of 3 of 250 ms: friction falls by half an event's fall a dozen times after each."""
    series, cycles, scene = recorded("fitted:2", "20kHz")
    friction = series["friction"]
    assert len(falls(friction, FALL * float(np.ptp(friction)))) > 8 * cycles.time.size
    record = Series("run.csv", {key: series[key] for key in ("time", "load_point_displacement", known, "friction")})
    found = measured_motion(record, scene, 1)
    assert found.events.period == pytest.approx(cycles.period, rel=1e-3)
    assert found.events.stress_drop == pytest.approx(cycles.stress_drop, rel=0.02)
    averaged = experiment_of(record, scene).cycle
    assert averaged
    assert averaged.period == pytest.approx(cycles.period[averaged.early :].mean() * scene.transit * scene.units.time, rel=1e-3)


def test_the_slip_rate_beside_a_record_is_a_mean_over_cycles_as_the_records(tmp_path):
    """Before, that of a model was its largest: 13 % above that of the record of the same irregular motion."""
    result = sw.run("paper-2.3", "delay", until=4000.0, rate=100, window=(2000.0, 4000.0))
    result.write_series(tmp_path / "irregular.csv")
    compared = sw.compare("paper-2.3", "delay", data=tmp_path / "irregular.csv", smooth=1, until=4000.0)
    (row,) = compared.rows
    assert row["v_max"] > 1.05 * compared.data.v_max.mean  # by 8 or 13 %, as numbers round
    assert row["against_data"] == pytest.approx({"period": 0.0, "stress_drop": 0.0, "v_max": 0.0}, abs=5e-3)
    chosen = sw.compare("paper-2.3", "delay", data=tmp_path / "irregular.csv", until=4000.0)
    assert chosen.data.smoothing.samples > 1
    assert chosen.rows[0]["against_data"] == pytest.approx({"period": 0.0, "stress_drop": 0.0, "v_max": 0.0}, abs=5e-3)
    assert f"{compared.runs[0].statistics.v_max_mean:.5g} (" in "\n".join(compared.lines(compared.summary | {"figure": ""}))


@pytest.mark.parametrize("name", ["paper", "grip"])
def test_cycles_in_which_a_record_settles_do_not_count_beside_a_model(name, tmp_path):
    """Before, the run that the record is of was 3 % off it in the period and 8 % in the drop, without a word."""
    sw.run(name, until=3000, rate=50).write_series(tmp_path / "from-the-start.csv")
    compared = sw.compare(name, "delay", data=tmp_path / "from-the-start.csv", until=3000)
    assert compared.rows[0]["against_data"] == pytest.approx({"period": 0.0, "stress_drop": 0.0, "v_max": 0.0}, abs=5e-3)
    assert f"in which the motion settles, are left out: {compared.data.early}" in "\n".join(
        compared.lines(compared.summary | {"figure": ""})
    )


def test_without_events_or_with_one_there_is_nothing_to_compare(slips):
    series, _, scene = slips
    cell = sampled(series, scene, 1e-3)
    for last, told in ((300, "no slip event: no fall of friction exceeds the range of noise"), (900, "one slip event only")):
        part = Series("cell.csv", {key: values[:last] for key, values in cell.columns.items()})
        with pytest.raises(SceneError, match=f"'cell.csv': {told}"):
            measured_motion(part, scene)
    steady = replace(cell, columns=cell.columns | {"friction": 0.36 + 1e-3 * np.random.default_rng(3).standard_normal(len(cell))})
    with pytest.raises(SceneError, match="no slip event: no fall of friction exceeds the range of noise, 0"):
        measured_motion(steady, scene)
    assert measured_motion(cell, scene, 1).smoothing["samples"] == 1
    for smooth in (0, 9999):
        with pytest.raises(SceneError, match=f"smooth = {smooth}: must be from 1 to"):
            measured_motion(cell, scene, smooth)


def test_a_record_beside_a_model(slips, tmp_path, capsys):
    series, cycles, scene = slips
    cell = sampled(series, scene, 2e-4)
    columns = 1e3 * cell["time"], 1e6 * cell["load_point_displacement"], cell["friction"]
    path = written(tmp_path / "cell.csv", "time [ms],disp_um,mu", *columns)
    words = ["compare", NAME, "--with", path, "--models", "quasidynamic", "--until", f"{UNTIL:g}"]
    assert main([*words, "--json", "--out", str(tmp_path / "x.svg")]) == 0
    facts = json.loads(capsys.readouterr().out)
    data, (row,) = facts["data"], facts["models"]
    assert data["period"]["mean"] == pytest.approx(cycles.period[1:].mean(), rel=2e-3)
    assert data["period"]["n"] == cycles.time.size - data["early"]
    assert data["si"]["period_s"] == pytest.approx(data["period"]["mean"] * scene.transit, rel=1e-6)  # L/V* is 1 s
    assert row["against_data"]["period"] == pytest.approx(row["period"]["mean"] / data["period"]["mean"] - 1.0, rel=1e-12)
    assert row["against_data"]["stress_drop"] > 0.2
    assert row["elastic_stress_drop"]["mean"] == pytest.approx(data["stress_drop"]["mean"], rel=0.02)
    assert (tmp_path / "x.svg").stat().st_size > 10_000
    result = sw.compare(NAME, "quasidynamic", data=path, until=UNTIL)
    above, middle, below = result.plot().axes[::2]
    (time, record), (_, model), _ = (line.get_data() for line in above.get_lines())
    np.testing.assert_allclose(middle.get_lines()[0].get_ydata(), record - model, atol=1e-15)
    assert time[np.argmax(np.asarray(below.get_lines()[1].get_ydata()))] == pytest.approx(0.0, abs=2e-4)
    assert result.data.period.n == data["period"]["n"]
    assert "its elastic stress, which a load cell in the drive measures, drops by" in "\n".join(
        result.lines(facts | {"figure": ""})
    )

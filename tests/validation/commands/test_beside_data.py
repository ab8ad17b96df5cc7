"""Slip events in records: those of runs, dated alike by compare and fit; a record beside models: its table, figure, refusals."""

import json
from dataclasses import replace

import numpy as np
import pytest

import slipwave as sw
from slipwave import SceneError
from tests.validation.records import written
from validation.commands.cli import main
from validation.data.events import measured_motion, noise_of
from validation.data.series import Series
from validation.data.writing import as_record
from validation.fit.cycles import dated_events
from validation.fit.records import experiment_of

NAME, UNTIL = "steel-on-pmma", 90000.0


@pytest.fixture(scope="module")
def slips():
    """A run with slip events as a record, its cycles, and its scene."""
    result = sw.run(NAME, "quasidynamic", until=UNTIL, rate="400kHz")
    assert result.records.history
    parts = [*as_record(result.records.history.parts(), result.done.solver.scene)]
    columns = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    return Series("run.csv", columns), result.done.events, result.done.solver.scene


def sampled(series, scene, noise):
    """What a laboratory would record: a load cell in the drive at 10 kHz, with noise."""
    assert scene.units
    time = np.arange(0.0, series["time"][-1], 1e-4)
    held = (series["load_point_displacement"] - series["slip"]) / scene.units.memory_length / scene.transit
    friction = np.interp(time, series["time"], scene.steady_stress + scene.stiffness * held)
    friction += noise * np.random.default_rng(1).standard_normal(time.size)
    return Series("cell.csv", {"time": time, "load_point_displacement": 1e-3 * time, "friction": friction})


def test_events_in_the_record_of_a_run_are_those_of_the_run(slips):
    series, cycles, scene = slips
    found = measured_motion(series, scene)
    assert (found.noise, found.smoothing.samples, found.dates.size) == (0.0, 1, cycles.time.size + 1)
    np.testing.assert_allclose(found.events.time, cycles.time, atol=1.0)  # friction is in the middle of its fall soon after v
    for name in ("period", "stress_drop", "v_max"):
        np.testing.assert_allclose(getattr(found.events, name), getattr(cycles, name), rtol=1e-4)
    without = Series("x", {key: series[key] for key in ("time", "slip", "friction")})
    np.testing.assert_allclose(measured_motion(without, scene).events.v_max[1:], cycles.v_max[1:], rtol=0.01)


def test_noise_adds_no_events_and_what_smoothing_does_is_told(slips):
    series, cycles, scene = slips
    quiet, noisy = (measured_motion(sampled(series, scene, noise), scene) for noise in (0.0, 1e-3))
    assert noise_of(noisy.time, sampled(series, scene, 1e-3)["friction"]) == pytest.approx(1e-3, rel=0.1)
    assert noisy.dates.size == quiet.dates.size == cycles.time.size + 1
    assert noisy.smoothing.samples > 3
    assert np.abs(noisy.dates - quiet.dates).max() < 2.0 * noisy.smoothing.dates < 0.02 * cycles.period[0]
    for name in ("period", "stress_drop", "v_max"):
        change = abs(getattr(noisy.events, name).mean() / getattr(quiet.events, name).mean() - 1.0)
        assert change < 1.5 * getattr(noisy.smoothing, name) + 1e-4, name
    assert quiet.events.stress_drop == pytest.approx(cycles.elastic_stress_drop, rel=2e-3)


def test_compare_and_fit_date_a_record_alike(slips):
    """With noise, in steps of an ADC, with gaps, in a machine that rings: as many slips as the run has."""
    series, cycles, scene = slips
    assert scene.units
    cell = sampled(series, scene, 5e-4)
    time, friction, slips_at = (
        cell["time"],
        cell["friction"],
        scene.transit * np.append(cycles.time, cycles.time[-1:] + cycles.period[-1:]),
    )
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
        np.testing.assert_array_equal(dated_events("cell", own["time"], own["friction"]).date, compared.dates)
        assert compared.dates.size == cycles.time.size + 1
        assert compared.events.period[1:] == pytest.approx(cycles.period[1:], rel=5e-3)
        assert cycle
        assert cycle.period == pytest.approx(compared.events.period[cycle.early :].mean() * scene.transit, rel=1e-9)


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
    assert measured_motion(cell, scene, 1).smoothing.samples == 1
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
    assert data["period"]["n"] == cycles.time.size
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

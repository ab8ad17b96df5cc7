"""What the commands print and write, number by number: by plain numpy from a recorded motion, closed forms, by hand."""

import io
import itertools
import json
import math
from contextlib import redirect_stdout
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import xarray

import slipwave as sw
from slipwave.observe.statistics import margin_of_mean
from validation.commands.cli import main
from validation.models.by_name import families

UNTIL = 4000.0
THICKNESS = 0.0805
"""Of one slab of `paper-si` (m), so that its cycles are irregular: their spread is 6 per cent."""
SPEED = math.sqrt(1e6 / 784.0)  # m/s
SECONDS = 2.0 * THICKNESS / SPEED  # one transit
LENGTH, RATE, PRESSURE = 0.9e-6, 1e-6, 1e3  # m, m/s, Pa
TRANSIT = SECONDS / (LENGTH / RATE)
RUN = ["run", "paper-si", "--model", "delay", "--tol", "1e-6", "--until", f"{UNTIL:g}", "--set", f"slab.thickness={THICKNESS}"]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    out = tmp_path_factory.mktemp("values") / "run.nc"
    with redirect_stdout(io.StringIO()) as printed:
        assert main([*RUN, "--json", "--out", str(out), "--set", 'run.record=["events", "interface"]']) == 0
    with xarray.open_dataset(out) as data:
        return json.loads(printed.getvalue()), data.load()


def test_statistics_are_those_of_the_second_half(told):
    result, data = told
    late = data["event_time"].values >= 0.5 * UNTIL
    assert late.sum() > 4
    for name in ("period", "stress_drop", "elastic_stress_drop"):
        rows = data[name].values[late]
        mean = sum(rows) / len(rows)
        assert result[name]["mean"] == pytest.approx(mean, rel=1e-12)
        assert result[name]["std"] == pytest.approx(math.sqrt(sum((row - mean) ** 2 for row in rows) / len(rows)), rel=1e-9)
        assert result[name]["std"] > 1e-3 * mean
        assert result["margins"][name] == pytest.approx(margin_of_mean(rows), rel=1e-9)
        assert float(data[f"{name}_margin"]) == result["margins"][name]
    assert float(data["period_margin_s"]) == pytest.approx(result["margins"]["period"] * SECONDS, rel=1e-12)
    assert float(data["stress_drop_margin_Pa"]) == pytest.approx(result["margins"]["stress_drop"] * PRESSURE, rel=1e-12)
    assert result["v_max"] == pytest.approx(max(data["v_max"].values[late]), rel=1e-14)
    assert result["v_min"] == pytest.approx(min(data["v_min"].values[late]), rel=1e-14)


def test_bench_errors_are_those_of_the_runs_it_timed(answer, monkeypatch):
    """|T/T_reference - 1| of each setting, of one cheap family and the delay system; runs made again here."""
    chosen = [family for family in families() if family.name in ("delay", "fd")]
    monkeypatch.setattr("validation.commands.bench.honouring", lambda _: chosen)
    found = answer("bench", "paper", "--until", "2000")
    tight = answer("run", "paper", "--until", "2000", "--model", "delay", "--tol", "1e-11")
    assert found["reference"] == "delay"
    options = {"cells": "--cells", "tolerance": "--tol"}
    for row in found["models"]:
        setting = [word for name, value in row["setting"].items() for word in (options[name], str(value))]
        alone = answer("run", "paper", "--until", "2000", "--model", row["model"], *setting)
        for key in ("period", "stress_drop"):
            wanted = abs(alone[key]["mean"] - tight[key]["mean"]) / tight[key]["mean"]
            assert row["error"][key] == pytest.approx(wanted, rel=1e-6, abs=1e-14)
        assert row["failures"] == 0
    errors = [row["error"]["period"] for row in found["models"] if row["model"] == "fd"]
    assert errors[0] / errors[-1] > 10.0


def assert_table(found, rows):
    """The dataset has what the rows have, by their dotted keys; NaN where these have nothing."""
    for number, row in enumerate(rows):
        for name, value in leaves(row).items():
            mine = found.dataset[name].values[number]
            assert mine == value if value is not None else np.isnan(mine), name


def leaves(row, above=""):
    flat = {}
    for key, value in row.items():
        flat |= leaves(value, f"{above}{key}_") if isinstance(value, dict) else {f"{above}{key}": value}
    return flat


def test_what_a_model_does_not_have_is_missing_in_the_table_of_compare():
    found = sw.compare("paper", ["delay", "quasidynamic"], until=200, **{"drive.velocity": 2000, "slab.r": 2.2e-3})
    rows = found.summary["models"]
    assert [row["error"]["period"] for row in rows] == [0.0, None]
    assert_table(found, rows)


def test_bench_times_all_runs_in_turn_and_gives_medians_with_quartiles(monkeypatch):
    """Runs take 1, 2, 4, ... s by a clock of their own; a round that takes longer than is worth repeating is the last."""
    chosen = [family for family in families() if family.name in ("block8", "delay")]
    monkeypatch.setattr("validation.commands.bench.honouring", lambda _: chosen)
    for enough, rounds in ((1e9, 3), (0.5, 1)):
        monkeypatch.setattr("validation.commands.bench._ENOUGH", enough)
        readings = itertools.accumulate(2.0 ** (n // 2) if n % 2 else 0.0 for n in itertools.count())
        monkeypatch.setattr("validation.commands.bench.time", SimpleNamespace(perf_counter=partial(next, readings)))
        rows = sw.bench("paper", until=200, **{"drive.velocity": 2000}).summary["models"]
        taken = [[2.0 ** (number + len(rows) * k) for k in range(rounds)] for number in range(len(rows))]
        assert [row["wall_s"] for row in rows] == [np.median(one) for one in taken]
        assert [row["wall_low_s"] for row in rows] == [np.quantile(one, 0.25) for one in taken]
        assert [row["wall_high_s"] for row in rows] == [np.quantile(one, 0.75) for one in taken]

"""What `run` prints and writes, number by number: recomputed from a recorded motion by plain numpy, units and clocks by hand."""

import io
import json
import math
import tomllib
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import slipwave
from slipwave.observe.statistics import margin_of_mean
from validation.cli import main

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
    """JSON, file and table of one run."""
    out = tmp_path_factory.mktemp("values") / "run.nc"
    with redirect_stdout(io.StringIO()) as printed:
        assert main([*RUN, "--json", "--out", str(out), "--set", 'run.record=["events", "interface"]']) == 0
    with redirect_stdout(io.StringIO()) as table:
        assert main(RUN) == 0
    with xarray.open_dataset(out) as data:
        return json.loads(printed.getvalue()), data.load(), table.getvalue().splitlines()


Told = tuple[dict[str, Any], xarray.Dataset, list[str]]


def test_statistics_are_those_of_the_second_half(told):
    result, data, _ = told
    late = data["event_time"].values >= 0.5 * UNTIL
    assert late.sum() > 4
    for name in ("period", "stress_drop", "elastic_stress_drop"):
        rows = data[name].values[late]
        mean = sum(rows) / len(rows)
        assert result[name]["mean"] == pytest.approx(mean, rel=1e-12)
        assert result[name]["std"] == pytest.approx(math.sqrt(sum((row - mean) ** 2 for row in rows) / len(rows)), rel=1e-9)
        assert result[name]["std"] > 1e-3 * mean
        assert result["margins"][name] == pytest.approx(margin_of_mean(rows), rel=1e-9)
    assert result["v_max"] == pytest.approx(max(data["v_max"].values[late]), rel=1e-14)
    assert result["v_min"] == pytest.approx(min(data["v_min"].values[late]), rel=1e-14)


def test_rows_of_events_are_those_of_the_recorded_motion(told):
    _, data, _ = told
    time, starts = data["time"].values, data["event_time"].values
    assert np.diff(starts) == pytest.approx(data["period"].values[:-1], rel=1e-12)
    for row, (start, period) in enumerate(zip(starts, data["period"].values, strict=True)):
        cycle = (time >= start) & (time <= start + period)
        assert data["v_max"].values[row] == pytest.approx(data["interface_slip_rate"].values[cycle].max(), rel=2e-2)
        around = (time >= start - 8.0) & (time <= start + period + 8.0)  # a cycle may begin a little before its date
        for name, recorded in (("stress_drop", "stress"), ("elastic_stress_drop", "elastic_stress")):
            values = data[f"interface_{recorded}"].values
            assert data[name].values[row] <= np.ptp(values[around]) * (1.0 + 1e-3)
            assert data[name].values[row] >= np.ptp(values[cycle & (time <= start + 0.5 * period)]) * (1.0 - 2e-2)
        lowest = data["interface_slip_rate"].values[cycle].min()
        assert data["v_min"].values[row] == pytest.approx(lowest, rel=5e-2)


def test_the_recorded_motion_obeys_the_equations(told):
    """psi' = r (e^-psi - v) and y' = eps (V - v) on the clock of transits, by differences between neighbouring samples; the
    friction law at every sample."""
    _, data, _ = told
    time, rate, psi, y, mu = (
        data[name].values
        for name in ("time", "interface_slip_rate", "interface_psi", "interface_elastic_stress", "interface_stress")
    )
    np.testing.assert_allclose(mu, 0.369 + 0.0349 * np.log(rate) + 0.0489 * psi, rtol=1e-9)
    slow = (np.abs(np.diff(np.log(rate))) < 0.02) & (time[1:] > 15.0) & (np.diff(time) > 1e-6)
    middle = 0.5 * (rate[1:] + rate[:-1])
    healing = TRANSIT * (np.exp(-0.5 * (psi[1:] + psi[:-1])) - middle)
    assert slow.sum() > 5000
    for found, wanted in ((np.diff(psi), healing), (np.diff(y), 2.8e-5 * (100.0 - middle))):
        misfit = found[slow] / np.diff(time)[slow] - wanted[slow]
        assert np.abs(misfit).max() < 2e-3 * np.abs(wanted[slow]).max()


def test_facts_of_the_file(told):
    result, data, _ = told
    facts = data.attrs
    assert facts["transit_in_friction_time"] == pytest.approx(TRANSIT, rel=1e-12)
    assert (facts["until_transits"], facts["failures"], facts["complete"]) == (UNTIL, 0, 1)
    assert facts["events"] == result["events"]
    assert result["events"] - data.sizes["event"] in (1, 2)  # complete cycles lie between events
    assert facts["scene_digest"] == slipwave.read("paper-si", [f"slab.thickness={THICKNESS}", f"run.until={UNTIL}"]).digest


def test_the_table_is_the_json_and_its_si_column_is_by_hand(told):
    result, _, lines = told
    wanted = {
        "period [transits]": (result["period"]["mean"], result["period"]["std"], SECONDS, "s"),
        "period [L/V*]": (TRANSIT * result["period"]["mean"], TRANSIT * result["period"]["std"], LENGTH / RATE, "s"),
        "stress drop": (*result["stress_drop"].values(), PRESSURE, "Pa"),
        "elastic stress drop": (*result["elastic_stress_drop"].values(), PRESSURE, "Pa"),
        "v_max [V*]": (result["v_max"], None, RATE, "m/s"),
        "v_min [V*]": (result["v_min"], None, RATE, "m/s"),
    }
    for label, (mean, std, unit, name) in wanted.items():
        (row,) = [line[len(label) :].split() for line in lines if line.startswith(f"{label} ")]
        assert float(row[0]) == pytest.approx(mean, rel=1e-8)
        assert row[1] == "-" if std is None else float(row[1]) == pytest.approx(std, rel=5e-3)
        assert (float(row[2]), row[3]) == (pytest.approx(mean * unit, rel=1e-5), name)
        assert row[4:] == ["-"] if std is None else (float(row[4]), row[5]) == (pytest.approx(std * unit, rel=5e-3), name)
    (margins,) = [line for line in lines if "95 %" in line]
    numbers = [float(word.strip("(,")) for word in margins.split() if word.strip("(,")[0].isdigit()]
    period, drop = result["margins"]["period"], result["margins"]["stress_drop"]
    assert numbers[1:] == pytest.approx([period, period * SECONDS, drop, drop * PRESSURE], rel=5e-3)
    spreads = {"period_std_s": result["period"]["std"] * SECONDS, "period_margin_s": period * SECONDS}
    spreads |= {"stress_drop_std_Pa": result["stress_drop"]["std"] * PRESSURE, "stress_drop_margin_Pa": drop * PRESSURE}
    assert {name: result["si"][name] for name in spreads} == pytest.approx(spreads)
    (transit,) = [line for line in lines if line.startswith("one transit = ")]
    assert float(transit.split("one transit = ")[1].split()[0]) == pytest.approx(SECONDS, rel=1e-5)
    slabs, _ = [line for line in lines if line.startswith("slabs:")]
    words = slabs.replace(",", "").split()
    assert float(words[2]) == pytest.approx(math.sqrt(784.0 * 1e6) * RATE / PRESSURE, rel=1e-8)
    assert float(words[4]) == pytest.approx(TRANSIT, rel=1e-8)
    (end,) = [line for line in lines if line.startswith("at the end:")]
    assert [float(part.split(" = ")[1]) for part in end.split(",")] == pytest.approx(list(result["final"].values()), rel=1e-10)


def test_scenes_are_listed_with_their_own_titles(capsys):
    assert main(["scenes"]) == 0
    folder = Path(slipwave.__file__).parent / "gallery"
    wanted = {path.stem: tomllib.loads(path.read_text())["title"] for path in folder.glob("*.toml")}
    lines = capsys.readouterr().out.splitlines()
    assert {line.split()[0]: line.split(maxsplit=1)[1] for line in lines} == wanted

"""What commands hand to people and scripts: the values themselves, held against the motion that they are about."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

import scene
from scene.observe import EventObserver, HistoryObserver, follow
from validation.cli import main
from validation.models import build

UNTIL = 1200.0
WORDS = ["--set", "slab.log10_r=-2.68", "--until", str(UNTIL)]
SI = {"stress drop": "normal_stress", "elastic stress drop": "normal_stress", "v_max [V*]": "reference_velocity"}


class Motion:
    """One march of the delay system: its events, its history, its end."""

    def __init__(self, name: str = "paper", settings: tuple[str, ...] = ("slab.log10_r=-2.68",)) -> None:
        self.scene = scene.read(name, list(settings))
        solver = build("delay", self.scene)
        watch, history = EventObserver(self.scene, solver.nodes), HistoryObserver(self.scene.law, solver.nodes)
        self.final = follow(solver, UNTIL, [watch, history])
        self.events, self.starts, self.history = watch.events(), watch.count, history.columns()

    def late(self, name: str) -> np.ndarray:
        """One figure of the cycles that begin in the second half."""
        values: np.ndarray = getattr(self.events, name)[self.events.time >= 0.5 * UNTIL]
        return values


@pytest.fixture(scope="module")
def motion() -> Motion:
    return Motion()


def printed(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    assert main(words) == 0
    return capsys.readouterr().out


def test_json_of_a_run(motion: Motion, capsys: pytest.CaptureFixture[str]) -> None:
    told = json.loads(printed(["run", "paper", *WORDS, "--json"], capsys))
    for name in ("period", "stress_drop", "elastic_stress_drop"):
        values = motion.late(name)
        assert told[name]["mean"] == pytest.approx(values.sum() / values.size, rel=1e-12)
        assert told[name]["std"] == pytest.approx(math.sqrt(((values - values.mean()) ** 2).sum() / values.size), rel=1e-6)
    late = motion.history["time"] >= motion.late("time")[0]
    assert told["v_max"] == pytest.approx(motion.history["slip_rate"][late].max(), rel=0.02)
    assert told["v_min"] == pytest.approx(motion.history["slip_rate"][late].min(), rel=0.02)
    assert told["v_max"] == pytest.approx(motion.late("v_max").max(), rel=1e-12)
    assert told["v_min"] == pytest.approx(motion.late("v_min").min(), rel=1e-12)
    law, final = motion.scene.law, told["final"]
    assert final == {"ln_v": motion.final.ln_v, "psi": motion.final.psi, "mu": motion.final.mu}
    assert final["mu"] == pytest.approx(law.a_star + law.a * final["ln_v"] + law.b * final["psi"], rel=1e-9)
    assert (told["events"], told["until"], told["failures"]) == (motion.starts, UNTIL, 0)
    assert motion.starts == motion.events.time.size + 1


def test_netcdf_of_a_run(motion: Motion, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "run.nc"
    printed(["run", "paper", *WORDS, "--set", 'run.record=["interface"]', "--out", str(out)], capsys)
    with xarray.open_dataset(out) as data:
        columns = {name: data[name].to_numpy() for name in data.variables}
        facts = dict(data.attrs)
    for name, values in motion.events._asdict().items():
        np.testing.assert_array_equal(columns["event_time" if name == "time" else name], values)
    law, time = motion.scene.law, columns["time"]
    rate, psi = columns["interface_slip_rate"], columns["interface_psi"]
    friction = law.a_star + law.a * np.log(rate) + law.b * psi
    np.testing.assert_allclose(columns["interface_stress"], friction, rtol=1e-9)
    loading = motion.scene.stiffness * (motion.scene.velocity - rate)
    loaded = motion.scene.steady_stress + np.concatenate([[0.0], np.cumsum(0.5 * (loading[1:] + loading[:-1]) * np.diff(time))])
    drop = float(np.ptp(columns["interface_elastic_stress"]))
    np.testing.assert_allclose(columns["interface_elastic_stress"], loaded, atol=0.05 * drop)
    assert columns["interface_elastic_stress"][0] == pytest.approx(motion.scene.steady_stress, rel=1e-6)
    assert (facts["events"], facts["failures"], facts["complete"]) == (motion.starts, 0, 1)
    assert facts["transit_in_friction_time"] == motion.scene.upper.round_trip
    assert (facts["scene_digest"], facts["until_transits"]) == (
        scene.read("paper", [*WORDS[1:2], f"run.until={UNTIL}"]).digest,
        UNTIL,
    )


def test_si_column(capsys: pytest.CaptureFixture[str]) -> None:
    motion = Motion("paper-si", ())
    assert motion.scene.units is not None
    out = printed(["run", "paper-si", "--until", str(UNTIL)], capsys)
    rows = {line.split("  ")[0]: line.split()[-2:] for line in out.splitlines()}
    units = motion.scene.units
    seconds = motion.scene.upper.round_trip * units.memory_length / units.reference_velocity
    expected = {
        "period [transits]": (motion.late("period").mean() * seconds, "s"),
        "period [L/V*]": (motion.late("period").mean() * seconds, "s"),
        "stress drop": (motion.late("stress_drop").mean() * units.normal_stress, "Pa"),
        "elastic stress drop": (motion.late("elastic_stress_drop").mean() * units.normal_stress, "Pa"),
        "v_max [V*]": (motion.late("v_max").max() * units.reference_velocity, "m/s"),
        "v_min [V*]": (motion.late("v_min").min() * units.reference_velocity, "m/s"),
    }
    for label, (value, unit) in expected.items():
        assert float(rows[label][0]) == pytest.approx(value, rel=1e-5), label
        assert rows[label][1] == unit


def test_roots_are_told_on_both_clocks(capsys: pytest.CaptureFixture[str]) -> None:
    told = json.loads(printed(["stability", "paper", "--json"], capsys))
    out = printed(["stability", "paper"], capsys)
    rows = [line.split() for line in out.partition("cycles per transit")[2].splitlines() if line.strip()]
    roots = [complex(*root) for root in told["leading_roots"] if root[1] >= 0.0]
    transit = scene.read("paper").upper.round_trip
    assert len(rows) == len(roots) > 1
    for row, root in zip(rows, roots, strict=True):
        assert float(row[-1]) == pytest.approx(root.imag * transit / (2.0 * math.pi), rel=1e-5)
        assert [float(row[0]), float(row[1])] == pytest.approx([root.real, root.imag], rel=1e-7)


def test_the_overlay_of_compare(motion: Motion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []

    def keep(figure: Figure, path: Path, **_: Any) -> None:
        drawn.append(figure)
        path.write_bytes(b"a figure")

    monkeypatch.setattr(Figure, "savefig", keep)
    assert main(["compare", "paper", "--models", "delay,kelvin-voigt", *WORDS, "--out", str(tmp_path / "x.png")]) == 0
    above, below = drawn[0].axes
    assert (above.get_ylabel(), below.get_ylabel()) == ("friction stress / normal stress", "slip rate / V*")
    assert below.get_xlabel() == "transits since the slip event's start"
    assert [text.get_text().partition(":")[0] for text in above.get_legend().get_texts()] == ["delay", "kelvin-voigt"]
    begin, period = motion.events.time[-1], motion.events.period[-1]
    keep_times = (motion.history["time"] >= begin) & (motion.history["time"] <= begin + period)
    for axes, name in ((above, "stress"), (below, "slip_rate")):
        time, values = axes.get_lines()[0].get_data()
        np.testing.assert_allclose(time, motion.history["time"][keep_times] - begin, atol=1e-9)
        np.testing.assert_allclose(values, motion.history[name][keep_times], rtol=1e-9)
        assert len(axes.get_lines()) == 2

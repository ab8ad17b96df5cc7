"""What `slipwave run` says of motions close to its own: the Lyapunov exponent on request, and the return map."""

import json

import numpy as np
import pytest

import slipwave
from slipwave.errors import NumericsError, SceneError
from validation.cli import INPUT_WRONG, main

FAST = {"model": "kelvin-voigt", "until": 200.0, "drive.velocity": 2000.0}
"""Cycles of four transits, which repeat."""


def test_an_exponent_on_request():
    """The run repeats: neither a motion ahead of it nor one behind comes nearer."""
    found = slipwave.run("paper", **FAST, lyapunov=True)
    assert found.done.kind == "periodic"
    told = found.summary["lyapunov"]
    assert abs(told["rate"]) <= 2.0 * told["margin"] < 0.05
    assert told["transits"] == 200 * 2.0 * round(found.done.events.period[-1] / 2.0)
    assert found.summary["final"] == slipwave.run("paper", **FAST).summary["final"]


@pytest.mark.parametrize(
    ("until", "verdict", "advice"), [(2000.0, "steady", "slipwave stability gives its rate"), (6.0, "too short", "run longer")]
)
def test_a_motion_without_cycles_has_none_but_the_run_is_kept(until, verdict, advice):
    """Steady sliding that a disturbance leaves has an exponent below zero, which the elastic stress, a mere sum, would hide."""
    with pytest.raises(NumericsError, match=f"this one is {verdict}: {advice}") as failed:
        slipwave.run("paper", "block8", until=until, lyapunov=True, **{"slab.log10_r": -3.5})
    assert failed.value.result.summary["verdict"] == verdict
    assert "lyapunov" not in failed.value.result.summary


def test_a_changing_drive_is_refused():
    with pytest.raises(SceneError, match=r"a Lyapunov exponent needs a constant drive\.velocity"):
        slipwave.run("ramp", lyapunov=True)


def test_the_return_map_shows_each_period_over_the_one_before(tmp_path, printed):
    found = slipwave.run("paper", **FAST)
    dots = found.plot_return_map().axes[0].get_lines()[0]
    late = found.done.events.period[found.done.events.time >= 100.0]
    np.testing.assert_array_equal(dots.get_xdata(), late[:-1])
    np.testing.assert_array_equal(dots.get_ydata(), late[1:])
    file = tmp_path / "map.svg"
    words = ["run", "paper", "--model", "kelvin-voigt", "--until", "200", "--set", "drive.velocity=2000", "--json"]
    assert json.loads(printed(*words, "--return-map", str(file)))["verdict"] == "periodic"
    assert file.read_text(encoding="utf-8").count("<use") >= late.size - 1
    assert main([*words[:-1], "--until", "5", "--return-map", str(file)]) == INPUT_WRONG

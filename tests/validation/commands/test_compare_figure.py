"""The overlay that `compare` draws: the last cycle of each model, with the right words on its axes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import slipwave
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.solve import follow
from validation.commands.cli import main
from validation.models.build import build

UNTIL = 2000.0
CHANGED = "slab.log10_r=-2.68"


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that are saved while a test runs."""
    figures: list[Figure] = []

    def keep(figure: Figure, path: Path, **_: Any) -> None:
        figures.append(figure)
        path.write_bytes(b"a figure")

    monkeypatch.setattr(Figure, "savefig", keep)
    return figures


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_overlay_of_compare(tmp_path: Path, drawn: list[Figure]) -> None:
    words = ["compare", "paper", "--models", "delay,kelvin-voigt", "--set", CHANGED, "--until", str(UNTIL)]
    assert main([*words, "--out", str(tmp_path / "x.png")]) == 0
    above, below = drawn[0].axes
    assert (above.get_ylabel(), below.get_ylabel()) == ("friction stress / normal stress", "slip rate / V*")
    assert below.get_xlabel() == "transits since v passed half its largest value in the slip event"
    assert [label.partition(":")[0] for label in legend(drawn[0])] == ["delay", "kelvin-voigt"]
    solver = build("delay", slipwave.read("paper", [CHANGED]))
    watch, history = EventObserver(solver.scene, solver.nodes), HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, UNTIL, [watch, history])
    columns = history.columns()
    events = watch.events()
    begin, period = events.time[-1], events.period[-1]
    inside = (columns["time"] >= begin) & (columns["time"] <= begin + period)
    for axes, name in ((above, "stress"), (below, "slip_rate")):
        time, values = axes.get_lines()[-1].get_data()  # the reference, on top
        np.testing.assert_allclose(time, columns["time"][inside] - begin, atol=1e-9)
        np.testing.assert_allclose(values, columns[name][inside], rtol=1e-9)
        assert len(axes.get_lines()) == 2

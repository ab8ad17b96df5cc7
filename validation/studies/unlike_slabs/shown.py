"""One cycle of two unlike pairs, the delay system under the full wave's points."""

from collections.abc import Mapping

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.cycle import Cycle
from validation.study.drawing import WIDTH, Drawing, canvas

_TITLES = {"unlike": "round trips 2 : 1", "unlike-irrational": r"round trips $\sqrt{2}$ : 1"}


def last_cycles(shown: Mapping[str, tuple[Cycle, Cycle]]) -> Drawing:
    """Columns: scenes; rows: stress and rate. Each entry holds (delay, full wave)."""
    figure = canvas(WIDTH, 4.8)
    grid = figure.subplots(2, len(shown), sharex="col", sharey="row", squeeze=False)
    for column, (pair, (exact, wave)) in zip(grid.T, shown.items(), strict=True):
        places = _spread(wave.time, wave.slip_rate)
        look = {"color": "#d55e00", "markersize": 3.6, "markerfacecolor": "none", "label": "full wave"}
        for axes, name in zip(column, ("stress", "slip_rate"), strict=True):
            axes.plot(exact.time, getattr(exact, name), color="#111111", linewidth=1.2, label="delay system")
            axes.plot(wave.time[places], getattr(wave, name)[places], "o", **look)
        column[0].set_title(_TITLES[pair])
        column[1].set(yscale="log", xlabel="time since the slip event (transits)")
    grid[0, 0].set_ylabel(r"stress $\mu$")
    grid[1, 0].set_ylabel(r"slip rate $v/V^*$")
    figure.legend(handles=grid[0, 0].get_lines(), loc="outside upper left", ncols=2)
    return figure


def _spread(time: Array, rate: Array) -> Array:
    """Indices evenly spaced along the curve of ln v over time, about 110 of them."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(time) / np.ptp(time), np.diff(np.log(rate)) / 12.0))])
    return np.unique(np.searchsorted(length, np.linspace(0.0, length[-1], 110)))

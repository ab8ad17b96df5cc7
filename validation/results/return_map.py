"""The return map of a run in a figure: the period of each cycle over that of the one before."""

from slipwave.observe import Events
from validation.study.drawing import Drawing, canvas

_SIZE = 4.6


def return_map(title: str, cycles: Events) -> Drawing:
    """One point for each cycle but the first, and the line on which cycles repeat: one point if they do, as many as there are
    events in a period, a closed curve on a torus, a curve or a cloud if they are irregular. Call it inside `styled()`."""
    figure = canvas(_SIZE, _SIZE)
    axes = figure.subplots()
    axes.plot(cycles.period[:-1], cycles.period[1:], ".", color="#111111", markersize=3.5)
    axes.axline((float(cycles.period[0]), float(cycles.period[0])), slope=1.0, color="#777777", linewidth=0.7)
    axes.set(title=title, xlabel="period / transits", ylabel="next period / transits")
    axes.grid(True)
    axes.set_aspect("equal", adjustable="datalim")
    return figure

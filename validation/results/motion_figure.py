"""The motion of the interface in a figure: stress and slip rate over time, with second axes in SI where the scene has units."""

from slipwave.observe.envelope import Ranges
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.results.quantities import INTERFACE, si_factor, stored_name
from validation.study.drawing import Axes, Drawing, canvas

_LABELS = {"time": "time / transits", "stress": "friction stress / normal stress", "slip_rate": "slip rate / V*"}
_SI_LABELS = {"time": "time / s", "stress": "friction stress / {}Pa", "slip_rate": "slip rate / (m/s)"}
_STRESS = 0.2  # of the normal stress: a small friction stress, by which the prefix of Pa is chosen


def motion_figure(scene: Scene, title: str, time: Array, stress: Ranges, rate: Ranges) -> Drawing:
    """Ranges of the stress and of the slip rate over time (transits). Call it inside `styled()`."""
    figure = canvas(height=5.2)
    above, below = figure.subplots(2, 1, sharex=True)
    above.set(title=title, ylabel=_LABELS["stress"])
    below.set(ylabel=_LABELS["slip_rate"], xlabel=_LABELS["time"], yscale="log")
    second_axis(above, "x", "time", scene)
    second_axis(above, "y", "stress", scene)
    second_axis(below, "y", "slip_rate", scene)
    band(above, time, stress)
    band(below, time, rate)
    return figure


def band(axes: Axes, places: Array, ranges: Ranges) -> None:
    """Ranges over `places`: a line where they are narrow."""
    low, high = ranges
    axes.fill_between(places, low, high, color="#a8a8a4", linewidth=0.0)
    axes.plot(places, low, places, high, color="#111111", linewidth=0.9)


def second_axis(axes: Axes, direction: str, name: str, scene: Scene) -> None:
    """The axis of a quantity in SI, opposite its own; nothing for a scene without units."""
    from validation.results.reasons import PREFIXES, power_of

    size = si_factor(INTERFACE[stored_name(name)], scene)
    if size is None:
        return
    power = power_of(_STRESS * size) if name == "stress" else 0
    factor = size / 10.0**power
    functions = (lambda values: values * factor, lambda values: values / factor)
    second = axes.secondary_xaxis("top", functions) if direction == "x" else axes.secondary_yaxis("right", functions)
    (second.set_xlabel if direction == "x" else second.set_ylabel)(_SI_LABELS[name].format(PREFIXES[power]))

"""Picture of the error laws: onset, left, and period of the cycle, right, over theta = r omega_c."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.study.drawing import WIDTH, canvas, pen

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def fall(onsets: Mapping[str, Any], cycles: Sequence[Any]) -> "Figure":
    """Log-log errors; `onsets` and `cycles` as `validation.studies.error_laws` measures them."""
    figure = canvas(WIDTH, 3.9)
    left, right = figure.subplots(1, 2, sharey=True)
    for model, one in onsets.items():
        style = pen(model)
        line = np.abs([one.law.at(float(theta)) for theta in one.theta])
        left.loglog(one.theta, line, color=style.color, linewidth=0.8)
        left.loglog(one.theta, np.abs(one.error), style.marker, color=style.color, markersize=4.5, label=style.label)
    theta = [one.theta for one in cycles]
    for model in cycles[0].errors:
        style = pen(model)
        errors = np.abs([one.errors[model] for one in cycles])
        right.loglog(theta, errors, style.marker, color=style.color, linestyle=style.dashes, linewidth=1.0, markersize=5)
    left.set_ylim(1e-12, 2.0)
    left.set_title("onset: critical $r$")
    right.set_title("cycle: period")
    right.set_xlim(left.get_xlim())
    left.set_ylabel("relative error")
    for axes in (left, right):
        axes.set_xlabel(r"$\theta=r\,\omega_c$ (radians per transit)")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper left", ncols=4, handletextpad=0.4)
    return figure

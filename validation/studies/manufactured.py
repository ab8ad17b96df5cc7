"""Every full wave against an exact solution with waves, friction and state, imposed by the drive."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array
from validation.compute.build import build
from validation.compute.models import grid_of
from validation.measure.manufactured import BEGIN, UNTIL, error_of_motion, exact_motion, given_scene
from validation.measure.order_fit import Fit, fit_order, shortfall
from validation.study import EXACT, Budget, Figure, Number, StudyResult, Verdict, claim
from validation.study.drawing import Drawing, style_of, subplots
from validation.study.known import of_order
from validation.study.text import plain

NAME = "manufactured"
QUESTION = "Does every full wave converge to an exact solution with friction and state?"
SCENES: tuple[str, ...] = ()
SECONDS = (3.0, 8.0)

_SECOND, _THIRD, _FOURTH = (32, 48, 64, 96, 128), (12, 16, 20, 24, 32), (10, 12, 14, 16, 18, 20)
GRIDS = {
    "fd": (_SECOND, 7e-5),
    "sbp:2": (_SECOND, 4e-4),
    "sbp:4": ((32, 40, 48, 64, 96), 4e-6),
    "sbp:6": ((36, 40, 44, 48, 56, 64), 8e-7),
    "fem:1": (_SECOND, 4e-4),
    "fem:2": (_THIRD, 1e-5),
    "fem:3": (_FOURTH, 3e-6),
    "fem:4": ((6, 8, 10, 12, 16), 8e-8),
    "dg:1": ((48, 64, 80, 96, 128), 4e-4),
    "dg:2": (_THIRD, 2e-5),
    "dg:3": (_FOURTH, 1.2e-6),
    "dg:4": ((6, 7, 8, 10, 12), 7e-7),
}
"""By model: cells per slab, and a bound of the error on the finest grid, twice that measured of unlike slabs."""

_MARCHES = {"alike": "exact", "unlike": "explicit"}
"""Pair of slabs -> march in time, except for the leapfrog, which has one."""

_MARKERS = "xosD^vP"  # by the number of the family's member
_CFL = 0.5  # of the leapfrog; at 1 it is the delay system


class Ladder(NamedTuple):
    """Errors of a model on its grids, for a pair of slabs, and their order."""

    model: str
    pair: str
    errors: Array
    order: Fit

    @property
    def declared(self) -> int:
        """The order of the outputs at the interface (elements: at least)."""
        family, number = grid_of(self.model)
        return family.order_interface(number)

    @property
    def shortfall(self) -> str:
        """Reason against the declared order, or empty. Schemes of order 2 must not be better either."""
        return shortfall(self.order, float(self.declared), at_least=self.declared != 2)


def run(budget: Budget) -> StudyResult:
    """Climb every ladder; the quick report those of alike slabs."""
    pairs = ["alike"] if budget.quick else list(_MARCHES)
    ladders = [climbed(model, pair) for model, pair in budget.each([(model, pair) for model in GRIDS for pair in pairs])]
    finest = min(float(ladder.errors[-1]) for ladder in ladders)
    return StudyResult(
        answer=f"Full waves reach an exact motion with friction and state at their orders, all {len(GRIDS)} tried, with "
        f"errors of down to {plain(finest, '.0e')} of its range.",
        figures=(
            Figure("motion", _MOTION, _draw_motion),
            Figure("errors", _ERRORS, lambda: _draw_errors(ladders)),
        ),
        verdicts=tuple(verdict for ladder in ladders for verdict in _verdicts(ladder)),
        notes=(
            "No equation has a source. The state is prescribed, ψ = ψ_{ss} − 1.2 e^{−x²}; the ageing law gives the slip rate, "
            "friction the stress, and d’Alembert’s solution in the slabs the V(t) of the outer faces that sends the waves which "
            "meet this motion at the interface. Friction, state and waves are those of every run.",
        ),
        numbers={f"error, {ladder.model}, {ladder.pair}": Number(float(ladder.errors[1]), 0.02) for ladder in ladders},
    )


def climbed(model: str, pair: str) -> Ladder:
    """The errors on all grids."""
    scene, (cells, _) = given_scene(pair == "unlike"), GRIDS[model]
    options = {"cfl": _CFL} if model == "fd" else {"time": _MARCHES[pair]}
    errors = np.array([error_of_motion(build(model, scene, cells=count, **options)) for count in cells])
    return Ladder(model, pair, errors, fit_order(np.array(cells), errors))


def _verdicts(ladder: Ladder) -> Iterator[Verdict]:
    where, title = (
        f"`{ladder.model}`, {ladder.pair} slabs",
        "Full waves converge at their orders to the exact solution with friction and state",
    )
    yield of_order(title, EXACT, ladder.order, ladder.declared, where, above=ladder.declared != 2)
    cells, bound = GRIDS[ladder.model]
    title = "On the finest grid the full wave makes the exact motion with friction and state"
    yield claim(title, EXACT, float(ladder.errors[-1]), bound, f"{where}, {cells[-1]} cells")


_ERRORS = (
    f"Root-mean-square errors of ln v, ψ and μ from t = {BEGIN:g} to {UNTIL:g} transits, each relative to its range, over cells "
    "per slab; lines: fits of the order. Alike slabs are marched exactly in time, unlike ones (round trips as 1 to 3, impedances "
    "as 2 to 3) by explicit steps, with the leapfrog by its own."
)
_MOTION = "The given motion: slip rate v and stress μ at the interface, and the drive V(t) that causes it."


def _draw_motion() -> Drawing:
    figure, panels = subplots(3.2, 1, 3, "time, transits")
    times = np.linspace(BEGIN, UNTIL, 400)
    for pair, style in (("alike", "-"), ("unlike", "--")):
        scene = given_scene(pair == "unlike")
        motion = exact_motion(scene, times)
        curves = np.exp(motion[:, 0]), motion[:, 2], np.array([scene.drive.at(time) for time in times.tolist()])
        for axes, values, name in zip(panels, curves, ("$v$", r"$\mu$", "$V$"), strict=True):
            axes.plot(times, values, style, color="#0072b2" if pair == "alike" else "#d55e00", label=f"{pair} slabs")
            axes.set_title(name)
    panels[2].legend()
    return figure


def _draw_errors(ladders: list[Ladder]) -> Drawing:
    pairs = list(dict.fromkeys(ladder.pair for ladder in ladders))
    figure, panels = subplots(3.6, 1, len(pairs), "cells per slab", "error", sharey=True)
    panels = np.ravel(panels)
    for ladder in ladders:
        axes, own = panels[pairs.index(ladder.pair)], style_of(ladder.model)
        marker = _MARKERS[int(ladder.model.partition(":")[2] or 0)]
        cells = np.array(GRIDS[ladder.model][0], dtype=float)
        axes.loglog(cells, ladder.errors, linestyle="none", marker=marker, color=own.color, label=ladder.model)
        used = cells[ladder.order.used]
        axes.loglog(used, ladder.order.constant * used**-ladder.order.order, color=own.color)
        axes.set_title(f"{ladder.pair} slabs")
    figure.legend(handles=panels[-1].get_legend_handles_labels()[0], loc="outside right center", fontsize=8)
    return figure

"""Every full wave at its order: in space against the delay system, against an exact motion, on its own orbits, in time. About
kernels, whose solvers it builds."""

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np

from validation.chart import Chart, Look, Panel, Scale, Trace
from validation.chart.looks import style_of
from validation.measure.grid_ladders import FLOOR_IN_SPACE, GENTLE, ROUGH, STEEP, LadderRun
from validation.measure.grids.in_space import climb_of
from validation.measure.manufactured import BEGIN, UNTIL
from validation.measure.orders import RESOLVED
from validation.report import Budget, Figure, Number, StudyAnswer, StudyResult, stated
from validation.report.grid_verdicts import ORDER, order_verdict
from validation.report.text import plain
from validation.studies.orders import given_motion, in_space, in_time, own_orbits, slip_event

NAME = "orders"
QUESTION = "Do four discretisations of the wave agree with the delay system, at the orders that they declare?"
SCENES = ("paper", "yardstick")
SECONDS = (25.0, 90.0)


class _Plan(NamedTuple):
    """Models whose order in space is fitted; cells of the leapfrog from a jump; by model, cells per slab of its own orbits; log10
    r of other orbits of the full wave, from the onset on, and of means; pairs of slabs of the exact motion."""

    in_space: tuple[str, ...]
    jump: tuple[int, ...]
    grids: dict[str, tuple[int, ...]]
    orbits_at: tuple[float, ...]
    means_at: tuple[float, ...]
    pairs: tuple[str, ...]


def _plan(budget: Budget) -> _Plan:
    few, many = ((48, 96, 192, 384, 768)[:n] for n in (4, 5))
    coarse: dict[str, tuple[int, ...]] = {"dg:7": (2, 3), "fem:4": (5, 8)}
    fine: dict[str, tuple[int, ...]] = {"dg:7": (2, 3, 4, 5, 6), "fem:4": (5, 8, 12, 16, 24), "sbp:6": (24, 32, 48, 64, 96, 160)}
    return budget.plan(
        quick=_Plan(in_space.judged_models(True), few, coarse, (), (-2.5,), ("alike",)),
        full=_Plan(in_space.judged_models(False), many, fine, (-2.699, -2.66, -2.65), (-2.5, -2.3), tuple(given_motion.MARCHES)),
    )


def run(budget: Budget) -> StudyResult:
    """Climb every ladder, find every orbit, march both ways, record one event."""
    plan = _plan(budget)
    climbs = [climb_of(model) for model in budget.each(plan.in_space, 0.4)]
    other_cfls = {cfl: in_space.leapfrog_at(cfl) for cfl in in_space.CFLS[1:]}
    jumps = {cfl: in_space.jump_errors(cfl, plan.jump) for cfl in in_space.CFLS}
    orbits = [own_orbits.grid_orbits(*grids) for grids in budget.each(plan.grids.items(), 0.6, 0.4)]
    others = [own_orbits.as_r_grows(log10_r) for log10_r in plan.orbits_at]
    means = [own_orbits.means_verdict(log10_r) for log10_r in plan.means_at]
    marches = [in_time.marches_of(model) for model in in_time.GRIDS]
    pairs = [(model, pair) for model in given_motion.GRIDS for pair in plan.pairs]
    ladders = [given_motion.climbed(*pair) for pair in budget.each(pairs, 0.9, 0.6)]
    event = slip_event.recorded_event()
    finest = ", ".join(f"{plain(max(one[-1].errors.values()), '.0e')} (`{one[-1].model}`)" for one in orbits)
    moved = plain(min(float(one.errors[-1]) for one in ladders), ".0e")
    return StudyResult(
        answers=(
            StudyAnswer(
                "Four kinds of full wave, which share no module of a solver with it, converge to the delay system at their "
                "orders in every output; period and stress drop of their own orbits are those of the delay system within "
                f"{finest}.",
                (ORDER, in_space.JUMP, in_space.INDEPENDENT, own_orbits.APPROACHES, own_orbits.AGREES, own_orbits.MEANS),
            ),
            StudyAnswer(
                f"They make an exact motion with waves, friction and state to {moved} of its range; the two marches of a grid "
                "agree, and waves cross the slabs unchanged.",
                (given_motion.MOTION, in_time.STEPS, in_time.MARCHES, in_time.KEEPS, slip_event.STRAIGHT, slip_event.ENDED),
            ),
        ),
        figures=(
            Figure("space", _SPACE, lambda: _errors_chart(in_space.space_errors(climbs))),
            Figure("motion", _MOTION, lambda: _errors_chart(given_motion.motion_errors(ladders))),
        ),
        verdicts=(
            *(order_verdict(climbed) for climbed in climbs),
            *(order_verdict(climbed, in_space.evidence_at(cfl)) for cfl, climbed in other_cfls.items()),
            *(in_space.jump_verdict(cfl, plan.jump, errors) for cfl, errors in jumps.items()),
            in_space.independence(),
            *map(own_orbits.orbit_verdict, orbits),
            *(verdict for one in (*orbits, *others) for verdict in own_orbits.agreement_verdicts(one)),
            *means,
            *(verdict for one in marches for verdict in in_time.time_verdicts(one)),
            *given_motion.motion_verdicts(ladders),
            *slip_event.event_verdicts(event),
        ),
        notes=_NOTES,
        numbers={
            f"{climbed.ladder.model} order": stated(together.order, together.half_width)
            for climbed in climbs
            if not climbed.lost
            for together in [climbed.fit_together()]
        }
        | {f"error, {one.model}, {one.pair}": Number(float(one.errors[1]), 0.02) for one in ladders if one.pair == "alike"},
    )


Curves: TypeAlias = Mapping[str, Mapping[str, tuple[np.ndarray, np.ndarray]]]
"""Panel -> model -> points per slab, errors."""


def _errors_chart(curves: Curves) -> Chart:
    """A panel for each group of models, a line for each."""
    points = Scale("points per slab", "log", ticks={n: f"{n:g}" for n in (10.0, 20.0, 50.0, 100.0, 200.0)})
    axes, panels = (points, Scale("error", "log", floor=1e-14)), list[Panel]()
    for title, models in curves.items():
        marks = {model: _MARKERS[int(model.partition(":")[2] or 0) % len(_MARKERS)] for model in models}
        lines = [Trace(model, *xy, Look(style_of(model).color, "-", marks[model], 1.0)) for model, xy in models.items()]
        panels.append(Panel(title, *axes, lines, grid=True))
    return Chart(panels, 4.3, len(panels), legend="outside upper left", legend_columns=6)


_MARKERS = "xosD^vP"  # by the number of a model
_SPACE = (
    "Geometric mean of the errors in every output against the delay system: relative root mean squares over all cycles, and of "
    "ψ, ln v and μ at the end."
)
_MOTION = (
    f"Root-mean-square errors of ln v, ψ and μ from t = {BEGIN:g} to {UNTIL:g} transits, relative to their ranges, against the "
    "exact motion. Unlike slabs: round trips as 1 to 3, impedances as 2 to 3, explicit steps."
)


def _run_text(run: LadderRun) -> str:
    return f"log_{{10}} r = {run.log10_r:g} for {run.until:g} transits".replace("-", "−")


_NOTES = (
    f"Orders in space: paper’s material, V = {GENTLE.scene.velocity:g}, smooth start, {_run_text(GENTLE)}; orders from 5 on "
    f"{_run_text(ROUGH)}, from 7 on {_run_text(STEEP)}; from order 3 on marched exactly in time. A fit begins with the coarsest "
    f"grid from which on every error is below {RESOLVED:g}^{{−order}} and ends above {plain(FLOOR_IN_SPACE, '.0e')}; coarse "
    "grids are left out while the logarithms are significantly curved. `fem:1` and `sbp:2` are algebraically the same scheme.",
    "In the exact motion no equation has a source: the state is prescribed, the ageing law gives the slip rate, friction the "
    "stress, and d’Alembert’s solution the V(t) of the outer faces that sends these waves.",
)

"""The rows of a full wave: orders, step limit, energy balance, noise, agreement with the delay system."""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

import slipwave
from slipwave.errors import NumericsError, SceneError
from slipwave.scene import Scene
from slipwave.solve import follow
from slipwave.solve.follow import DAY, in_days
from validation.measure.grid_ladders import ladder_of
from validation.measure.limits import (
    AROUND,
    BEYOND,
    FEW_MEDIA,
    growth_at,
    limit_at,
    locked_noise,
    rubbing,
    state_reach,
    stops_beyond,
)
from validation.measure.order_fit import fit_order, shortfall
from validation.measure.orders import climb_of
from validation.models.build import build, build_full_wave
from validation.models.by_name import DELAY, explicit_time, grid_of
from validation.models.progress import log
from validation.report import EXACT, SELF, WITNESS, Outcome, Verdict, Verdicts, claim, holding, judge
from validation.report.grid_verdicts import calm_verdict, limit_verdict, noise_verdict, order_verdict, state_verdict, stop_verdict
from validation.report.known import rounding

_DECADES = (-4, 0, 4)
_VISCOUS = {
    "name": "viscous unlike slabs",
    "upper.viscosity": {"kind": "standard-linear", "time": 2e-3, "ratio": 0.5},
    "lower.viscosity": {"kind": "kelvin-voigt", "time": 1e-7},
}
_SCENES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("paper", {}),
    ("unlike", {}),
    ("grip", {}),
    ("layered", {}),
    ("unlike", _VISCOUS),
)
_FINEST, _FINEST_CELLS = "dg:7", 14  # the reference where the delay system cannot do a scene; in exact steps
_NOISE_UNTIL = 200.0  # transits
_LEDGER_UNTIL, _GRIDS, _FINER = 40.0, 6, 1.5
_RESOLUTION = 1e-11
_MOMENTS = (6.0, 8.0, 12.0, 20.0, 40.0)  # transits at which psi is compared
_REACHED, _SHORT = 1e-8, 0.5
"""An error below the first is small enough, whatever the order; a fitted order may miss the declared one by the second."""
_LOST, _GAINED = 1e-9, 1e-11
"""Shares of the work: losses that are small enough, and gains that explicit steps on coarse grids leave (1e-12 was measured)."""
_WIDE = 2.0  # half-width of the interval of an order from few grids, from which on it tells nothing
_LONG = 300.0  # expected seconds of the rows on a scene from which on they are told


def rows_of_family(model: str) -> Verdicts:
    """The rows of the member of a family on a grid, on scenes of ours."""
    yield order_verdict(climb_of(model))
    yield limit_verdict(model, {decade: limit_at(model, decade) for decade in _DECADES})
    family, _ = grid_of(model)
    for medium in FEW_MEDIA:
        if not family.refusal(rubbing(0.0, medium)):
            yield calm_verdict(model, medium, growth_at(model, medium, *AROUND[0]))
    yield state_verdict(model, state_reach(model))
    yield stop_verdict({model: stops_beyond(model, BEYOND)})
    yield noise_verdict(model, locked_noise(model, _NOISE_UNTIL), _NOISE_UNTIL)
    for name, changes in _SCENES:
        scene = slipwave.read(name, changes)
        if not family.refusal(scene):
            yield from rows_on_scene(model, scene)


def rows_on_scene(model: str, scene: Scene) -> Verdicts:
    """Energy balance and order of the error of psi against the delay system. Where it cannot compute the scene, against another
    family, or for the family of that one against a finer grid."""
    family, number = grid_of(model)
    cells = [max(2, min(ladder_of(family, number).first, family.cells))]  # per slab, from the member's coarsest on
    while len(cells) < _GRIDS:
        cells.append(max(cells[-1] + 1, round(_FINER * cells[-1])))
    _require_day(model, scene, cells)
    yield _ledger_row(model, scene, cells)
    if not starts_smoothly(scene):
        return
    evidence, known_as = WITNESS, "that of the delay system"
    if not DELAY.refusal(scene):
        reference = build("delay", scene, tolerance=_RESOLUTION)
    elif family is not grid_of(_FINEST)[0]:
        reference, known_as = build_full_wave(_FINEST, scene, cells=_FINEST_CELLS), f"that of {_FINEST}"
        evidence = SELF if explicit_time(model) else WITNESS  # schemes by the method of lines share the viscous equations
    else:
        reference, evidence, known_as = _explicit(model, scene, 2 * cells[-1]), SELF, "that of a finer grid"
    true = np.array([follow(reference, moment).psi for moment in _MOMENTS])
    known, ended = _on_grids(model, scene, cells, lambda solver: _error(solver, true))
    remark = f"`{model}`, scene {scene.name}, up to t = {_MOMENTS[-1]:g}"
    yield _falling(
        holding(f"psi converges to {known_as}", evidence, "", "", False, remark),
        "errors",
        family.order_interface(number),
        {n: error for n, error in known.items() if math.isfinite(error)},
        _REACHED,
        ended,
    )


def _require_day(model: str, scene: Scene, cells: list[int]) -> None:
    """Raises SceneError if the grids that can start would take more than a day; says so if it is more than some minutes."""
    steps, seconds = math.inf, 0.0
    for n in cells:
        with suppress(SceneError):
            solver = _explicit(model, scene, n)
            steps = min(steps, solver.step)
            seconds += 2.0 * _LEDGER_UNTIL / solver.transits_per_piece * solver.seconds_per_piece  # for two rows
    told = f"verify: scene {scene.name!r}: explicit steps as short as {steps:.2g} transits make its rows take about"
    if seconds > DAY:
        raise SceneError(f"{told} {in_days(seconds)}: use a model or a scene that allows longer steps")
    if seconds > _LONG:
        log.info("%s %.2g minutes", told, seconds / 60.0)


def starts_smoothly(scene: Scene) -> bool:
    """Whether nothing jumps, at the start or later."""
    return scene.drive.is_constant and scene.start.kind == "nudge"


def _explicit(model: str, scene: Scene, cells: int) -> "slipwave.solve.FieldSolver":
    return build_full_wave(model, scene, cells=cells, time=explicit_time(model))


def _on_grids(
    model: str, scene: Scene, cells: list[int], measured: Callable[["slipwave.solve.FieldSolver"], float]
) -> tuple[dict[int, float], str]:
    """What is `measured` by cells, on the grids that can run; text on those whose run fails, with the last reason. Raises
    SceneError if every grid is refused."""
    sizes, refused, failed = dict[int, float](), list[SceneError](), list[NumericsError]()
    for n in cells:
        try:
            sizes[n] = measured(_explicit(model, scene, n))
        except SceneError as error:
            refused.append(error)
        except NumericsError as error:
            failed.append(error)
    if len(refused) == len(cells):
        raise refused[-1]
    return sizes, f"; the run fails on {len(failed)} of {len(cells)} grids: {failed[-1]}" if failed else ""


def _error(solver: "slipwave.solve.FieldSolver", true: np.ndarray) -> float:
    """Largest error of psi at the moments."""
    return float(max(abs(follow(solver, moment).psi - psi) for moment, psi in zip(_MOMENTS, true, strict=True)))


def _falling(row: Verdict, what: str, declared: float, sizes: dict[int, float], floor: float, ended: str) -> Verdict:
    """The row on sizes (by cells) that fall at the declared order or faster, or to below the `floor`, under which no order is
    fitted: rounding bends the line there. Not decided if the interval of the order is too wide to tell, or too few sizes are left
    because runs `ended`."""
    expected, cells = f"order {declared:g} or more, or {what} below {floor:.0e}", max(sizes, default=0)
    finest, above = sizes.get(cells, math.inf), {n: size for n, size in sizes.items() if size > floor}
    row = replace(row, expected=expected, remark=f"{row.remark}; {finest:.1e} on {cells} cells{ended}")
    try:
        fit = fit_order(np.array(list(above), dtype=float), np.array(list(above.values())))
    except ValueError:
        few = bool(ended) and finest >= floor
        return replace(row, ours=f"{finest:.1e}", outcome=Outcome.OPEN if few else judge(finest < floor))
    short, small = shortfall(fit, declared, _SHORT, at_least=True, widest=_WIDE), finest < floor
    unknown = fit.half_width > _WIDE and fit.order + fit.half_width >= declared
    ours = f"{finest:.1e}" if short and small else f"order {fit.rounded}"  # what holds
    return replace(row, ours=ours, outcome=Outcome.OPEN if short and unknown and not small else judge(small or not short))


def _ledger_row(model: str, scene: Scene, cells: list[int]) -> Verdict:
    """Whether the energy balance closes (work of the drive, dissipation by friction, faces and viscosity, stored energy) up to
    losses that decrease with the grid at the order of the fields."""
    family, number = grid_of(model)
    steps = dict[int, float]()

    def residual(solver: "slipwave.solve.FieldSolver") -> float:
        follow(solver, _LEDGER_UNTIL)
        steps[solver.cells], energy = solver.step, solver.energy()
        return math.nan if energy is None else energy.residual

    lost, ended = _on_grids(model, scene, cells, residual)
    if any(slab.viscosity for slab in scene.slabs):  # their heat is summed by the steps, whose error has either sign
        lost = {n: abs(share) for n, share in lost.items()}
    closed = rounding(_LEDGER_UNTIL / [*steps.values()][-1]) if lost else 0.0
    worst, least = max(map(abs, lost.values()), default=math.nan), min(lost.values(), default=math.nan)
    title, remark = (
        "The energy balance closes",
        f"`{model}`, scene {scene.name}, {_LEDGER_UNTIL:g} transits, relative to the work",
    )
    gained = least < -max(closed, _GAINED)
    if family.conserves or worst < closed or gained or not math.isfinite(worst):
        told = f"{remark}, worst of {len(lost)} grids{'; energy is gained' if gained else ''}{ended}"
        return claim(title, EXACT, least if gained else worst, closed, told)
    row = holding(title, EXACT, "", "", False, remark)
    return _falling(row, "losses", family.order_bulk(number) if starts_smoothly(scene) else 1, lost, _LOST, ended)

"""The rows of a full wave: orders, step limit, energy balance, noise, agreement with the delay system."""

import math
from collections.abc import Iterator

import numpy as np

import slipwave
from slipwave.errors import NumericsError, SceneError
from slipwave.scene import Scene
from slipwave.solve import follow
from validation.compute.build import build, build_full_wave
from validation.compute.models import DELAY, explicit_time, grid_of
from validation.measure.grid_ladders import ladder_of
from validation.measure.grids.in_space import climb_of
from validation.measure.grids.limits import (
    BEYOND,
    around_the_limit,
    limit_at,
    rubbing,
    state_reach,
    stops_beyond,
)
from validation.measure.grids.noise import locked_noise
from validation.measure.order_fit import fit_order, shortfall
from validation.study import EXACT, SELF, WITNESS, Evidence, Verdict, claim, holding
from validation.study.grid_verdicts import (
    limit_verdict,
    medium_verdict,
    noise_verdict,
    order_verdict,
    state_verdict,
    stop_verdict,
)
from validation.study.known import rounding

_DECADES = (-4, 0, 4)
_MEDIA = ("alike slabs", "impedances 1 : 1000", "layers 1 : 100", "Kelvin-Voigt, 0.02 transits")
_SCENES = ("paper", "unlike", "grip", "layered")
_NOISE_UNTIL = 200.0  # transits
_LEDGER_UNTIL, _GRIDS, _FINER = 40.0, 6, 1.5
_RESOLUTION = 1e-11
_MOMENTS = (6.0, 8.0, 12.0, 20.0, 40.0)  # transits at which psi is compared
_REACHED, _SHORT = 1e-8, 0.5
"""An error below the first is small enough, whatever the order; a fitted order may miss the declared one by the second."""
_WIDE = 2.0  # half-width of the interval of an order from few grids, from which on it tells nothing


def rows_of_family(model: str) -> Iterator[Verdict]:
    """The rows of the member of a family on a grid, on scenes of ours."""
    yield order_verdict(climb_of(model))
    yield limit_verdict(model, {decade: limit_at(model, decade) for decade in _DECADES})
    family, _ = grid_of(model)
    for medium in _MEDIA:
        if not family.refusal(rubbing(0.0, medium)):
            yield medium_verdict(medium, {model: around_the_limit(model, medium)})
    yield state_verdict(model, state_reach(model))
    yield stop_verdict({model: stops_beyond(model, BEYOND)})
    yield noise_verdict(model, locked_noise(model, _NOISE_UNTIL), _NOISE_UNTIL)
    for name in _SCENES:
        scene = slipwave.read(name)
        if not family.refusal(scene):
            yield from rows_on_scene(model, scene)


def rows_on_scene(model: str, scene: Scene) -> Iterator[Verdict]:
    """Energy balance and order of the error of psi against the delay system, or against a finer grid where it cannot compute the
    scene."""
    cells = grids_for(model)
    yield ledger_row(model, scene, cells)
    if not starts_smoothly(scene):
        return
    witness = not DELAY.refusal(scene)
    reference = build("delay", scene, tolerance=_RESOLUTION) if witness else _explicit(model, scene, 2 * cells[-1])
    true = np.array([follow(reference, moment).psi for moment in _MOMENTS])
    known = {n: error for n in cells if math.isfinite(error := _error(model, scene, n, true))}
    yield agreement_row(model, scene, known, WITNESS if witness else SELF)


def starts_smoothly(scene: Scene) -> bool:
    """Whether nothing jumps, at the start or later."""
    return scene.drive.is_constant and scene.start.kind == "nudge"


def grids_for(model: str) -> list[int]:
    """Cells per slab of a few grids, from the coarsest of the member's ladder on."""
    family, number = grid_of(model)
    cells = [max(2, min(ladder_of(family, number).first, family.cells))]
    while len(cells) < _GRIDS:
        cells.append(max(cells[-1] + 1, round(_FINER * cells[-1])))
    return cells


def _explicit(model: str, scene: Scene, cells: int) -> "slipwave.solve.FieldSolver":
    return build_full_wave(model, scene, cells=cells, time=explicit_time(model))


def _error(model: str, scene: Scene, cells: int, true: np.ndarray) -> float:
    """Largest error of psi at the moments; NaN where the grid is too coarse to run."""
    try:
        solver = _explicit(model, scene, cells)
        return float(max(abs(follow(solver, moment).psi - psi) for moment, psi in zip(_MOMENTS, true, strict=True)))
    except (NumericsError, SceneError):
        return math.nan


def agreement_row(model: str, scene: Scene, known: dict[int, float], evidence: Evidence) -> Verdict:
    """Whether errors (by cells) reach the declared order, or are too small to fit one."""
    family, number = grid_of(model)
    declared, other = family.order_interface(number), "the delay system" if evidence is WITNESS else "a finer grid"
    title = f"psi converges to that of {other}"
    finest = min(known.values(), default=math.inf)
    remark = f"`{model}`, scene {scene.name}, up to t = {_MOMENTS[-1]:g}; on {max(known, default=0)} cells off by {finest:.1e}"
    expected = f"order {declared:g} or more, or errors below {_REACHED:.0e}"
    try:
        above = {n: error for n, error in known.items() if error > _REACHED}
        found = fit_order(np.array(list(above), dtype=float), np.array(list(above.values())))
    except ValueError:
        return holding(title, evidence, expected, f"{finest:.1e}", finest < _REACHED, remark)
    holds = not shortfall(found, declared, _SHORT, at_least=True, widest=_WIDE) or finest < _REACHED
    return holding(title, evidence, expected, f"order {found.rounded}", holds, remark)


def ledger_row(model: str, scene: Scene, cells: list[int]) -> Verdict:
    """Whether the energy balance closes (work of the drive, dissipation by friction, faces and viscosity, stored energy) up to
    losses that decrease with the grid at the order of the fields."""
    family, number = grid_of(model)
    lost, closed = dict[int, float](), 0.0
    for n in cells:
        try:
            solver = _explicit(model, scene, n)
            follow(solver, _LEDGER_UNTIL)
        except (NumericsError, SceneError):
            continue
        energy, closed = solver.energy(), rounding(_LEDGER_UNTIL / solver.step)
        lost[n] = math.nan if energy is None else energy.residual
    worst, least = max(map(abs, lost.values()), default=math.nan), min(lost.values(), default=math.nan)
    title, remark = (
        "The energy balance closes",
        f"`{model}`, scene {scene.name}, {_LEDGER_UNTIL:g} transits, relative to the work",
    )
    if family.conserves or worst < closed or not least > -closed:
        gained = "; energy is gained" if least < -closed else ""
        shown = least if gained else worst
        return claim(title, EXACT, shown, closed, f"{remark}, worst of {len(lost)} grids{gained}")
    declared = family.order_bulk(number) if starts_smoothly(scene) else 1
    try:
        above = {n: loss for n, loss in lost.items() if loss > closed}
        found = fit_order(np.array(list(above), dtype=float), np.array(list(above.values())))
    except ValueError:
        return claim(title, EXACT, abs(list(lost.values())[-1]), closed, f"{remark}, on {max(lost)} cells")
    holds = not shortfall(found, declared, _SHORT, at_least=True, widest=_WIDE)
    ours = f"order {found.rounded}"
    return holding(
        title, EXACT, f"losses of order {declared:g} or more", ours, holds, f"{remark}, {max(lost)} cells lose {worst:.1e}"
    )

"""`slipwave.orbit`: the periodic orbit of a scene with its errors and its stability."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import TIME
from slipwave.input import SceneSource
from slipwave.input.relate import moment
from slipwave.input.stored import recall
from slipwave.input.wording import shorten
from slipwave.observe.history import named_columns
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from slipwave.step.flow import Cycle
from validation.branches.at_scene import orbit_of
from validation.door.checked import checked
from validation.door.result import Dataset, Place, Result, announced, finite, scene_of
from validation.registry.orbits import OrbitFound, flowing, orbit_at, require_tolerance
from validation.results.motion_figure import motion_figure
from validation.results.provenance import SCHEMA, provenance
from validation.results.quantities import EVENTS, INTERFACE, cycle_in_si, stored_name, variables
from validation.study.drawing import Drawing, styled

if TYPE_CHECKING:
    from reduced.stability.idle import IdleMode

TOLERANCE = 1e-8
"""Relative error of an orbit's figures if none is requested."""


@dataclass(frozen=True, repr=False, eq=False)
class OrbitResult(Result):
    """The orbit that was `found`."""

    found: OrbitFound
    options: Mapping[str, Any]

    @cached_property
    def dataset(self) -> Dataset:
        """The motion over a period by `time`, multipliers by `multiplier`, and the orbit's figures with their errors."""
        require("files", "a dataset")
        import xarray

        closed, scene = self.found.found.closed, self.found.scene
        columns = _motion(closed.cycle, closed.flow.nodes, scene)
        time = variables(TIME, {TIME: columns.pop(TIME)}, INTERFACE, scene)
        values = variables(TIME, columns, INTERFACE, scene)
        for name, value in self.found.found.orbit.values().items():
            values |= variables((), {name: value}, EVENTS, scene)
            error = getattr(self.found.found.orbit, name).error
            values[f"{name}_error"] = ((), error, {"long_name": f"estimated error of {name}", "units": "1"})
        roots = self.found.found.multipliers.values
        for part, numbers in (("real", roots.real), ("imaginary", roots.imag)):
            values[f"multiplier_{part}"] = ("multiplier", numbers, {"long_name": f"{part} part of the multiplier", "units": "1"})
        return xarray.Dataset(values, time, provenance("orbit", scene, self.found.flow.model, self.options))

    def plot(self) -> Drawing:
        """Stress and slip rate over one period."""
        found, scene = self.found.found, self.found.scene
        title = f"{scene.name}, {self.found.flow.model}: periodic orbit, T = {found.orbit.period.value:.6g} transits"
        columns = _motion(found.closed.cycle, found.closed.flow.nodes, scene)
        stress, rate = columns[stored_name("stress")], columns[stored_name("slip_rate")]
        with styled():
            return motion_figure(scene, title, columns[TIME], (stress, stress), (rate, rate))

    @property
    def multipliers(self) -> "np.ndarray[Any, np.dtype[np.complex128]]":
        """The Floquet multipliers, largest modulus first, without the trivial one."""
        return self.found.found.multipliers.values

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave orbit` (users rely on its keys); `si` is there only for scenes in SI."""
        done = self.found
        orbit, multipliers, scene = done.found.orbit, done.found.multipliers, done.scene
        result = {
            "schema": SCHEMA,
            "scene": scene.name,
            "model": done.flow.model,
            "clock": "transit",
            **orbit.values(),
            "period_time": orbit.period.value * scene.transit,
            "stable": multipliers.stable,
            "multipliers": [[value.real, value.imag] for value in multipliers.values.tolist()],
            "trivial_defect": multipliers.trivial_defect,
            "residual": done.found.closed.residual,
            "error_estimate": {name: getattr(orbit, name).error for name in ("period", "stress_drop")},
            "essential_radius": multipliers.essential_radius,
            "idle_modes": [_idle(mode, orbit.period.value) for mode in multipliers.idle],
            "wall_s": done.wall_s,
            "notes": [*doubts(scene), *done.notes],
        }
        return dict(finite(result | cycle_in_si(orbit.values(), scene)))


@checked
def orbit(
    source: SceneSource,
    model: str = "auto",
    *,
    tol: float | None = None,
    near_period: float | str | None = None,
    others: bool | None = None,
    cells: int | None = None,
    settings: Iterable[str] = (),
    **changes: Any,
) -> OrbitResult:
    """The periodic orbit that a run of the scene leads to, stable or not, to the relative error `tol` (default 1e-8), and its
    Floquet multipliers. Where several coexist, `others` names those of the branch of orbits that begins where steady sliding
    loses its stability, and `near_period` (in transits, or as "60 s") asks for the one with the period nearest to it; a run that
    leads to none gives way to that branch. The scene is changed by `settings` and `changes` as in `slipwave.run`; a netCDF file
    of an orbit is computed again; of a point of a branch it is the orbit there. A full wave (`cells` per
    slab) marches exactly in time.

    Raises SceneError for wrong input, NumericsError if there is no orbit.
    """
    if isinstance(source, Place):
        if source.closed is not None and not (tol or near_period or others or cells or settings or changes):
            return OrbitResult(
                orbit_at(source.closed, source.tolerance), {"tol": source.tolerance, "near_period": source["period"]}
            )
        near_period = _period_there(source) if near_period is None else near_period
        model = source.model if model == "auto" else model
    model, options = recall(source, "orbit", model, {"tol": tol, "cells": cells, "near_period": near_period, "others": others})
    tol, cells = options["tol"] or TOLERANCE, options["cells"]
    require_tolerance(tol)
    scene = scene_of(source, settings, changes)
    name = announced(*flowing(model, scene))
    near = _period(options["near_period"], scene)
    return OrbitResult(orbit_of(name, scene, tol, cells, near, bool(options["others"])), options | {"tol": tol})


def _period_there(point: Place) -> float:
    """The period of a point of a branch. Raises SceneError for one where the orbit has no size."""
    if point.get("type") == "HB":
        raise SceneError(
            "SCENE: at a Hopf point the orbit shrinks to steady sliding: its stability is that of slipwave.stability"
        )
    return float(point["period"])


def _idle(mode: "IdleMode", period: float) -> dict[str, Any]:
    """A mode that friction hardly damps, with its multiplier on an orbit of this `period` (transits)."""
    value = mode.multiplier(period)
    facts = {"quarter_waves": [mode.upper, mode.lower], "frequency": mode.frequency, "decay": mode.decay}
    return facts | {"multiplier": [value.real, value.imag]}


def _period(given: float | str | None, scene: Scene) -> float | None:
    """In transits. Raises SceneError for what is no positive time."""
    try:
        period = None if given is None else moment("near_period", given, scene)
    except SceneError:
        raise
    except ValueError:
        period = math.nan
    if period is None or period > 0.0:
        return period
    raise SceneError(f"near_period = {shorten(given)}: must be above 0, in transits or with a unit of time")


def _motion(cycle: Cycle, nodes: Array, scene: Scene) -> dict[str, Array]:
    """The interface at the nodes of the pieces, each time once."""
    pieces = cycle.pieces
    time = pieces.time[:, None] + pieces.length[:, None] * nodes
    rows = np.stack([values.ravel() for values in (time, *pieces[2:])])
    rows = rows[:, np.flatnonzero(np.diff(rows[0], prepend=-1.0) > 0.0)]
    return {stored_name(name): values for name, values in named_columns(scene.law, rows).items()}

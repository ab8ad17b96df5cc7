"""`slipwave orbit`: The periodic orbit that a run of the scene leads to, stable or not: figures with errors, and Floquet
multipliers.
"""

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from reduced.orbit import PeriodicOrbit
from reduced.orbit.multipliers import multipliers
from reduced.orbit.periodic import figures_of
from reduced.orbit.phase import PhaseResponse
from reduced.orbit.response import Responding
from slipwave.errors import NumericsError, SceneError
from slipwave.files import FIGURES, TIME
from slipwave.input.assemble import SceneSource, moment
from slipwave.input.wording import shorten
from slipwave.observe.history import named_columns, values_at
from slipwave.observe.pieces import SAME, Array, lagrange_basis
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.scene.scene import doubts
from validation.chart import Chart
from validation.commands.branch import tolerance_option
from validation.commands.figures import motion_chart
from validation.commands.options import ModelOptions, announced, command, option
from validation.commands.response import Response, response_lines, response_of, with_phase_response
from validation.commands.result import Output, PointOfBranch, Result, aligned, rounded
from validation.commands.wording import figure_rows, header
from validation.data.datasets import Dataset, new_dataset
from validation.data.variables import EVENTS, INTERFACE, PHASE, Meaning, cycle_in_si, stored_name, variables
from validation.models.at_scene import orbit_at_scene
from validation.models.orbits import SceneOrbit, flowing, refined_orbit, with_error_of_grid
from validation.models.provenance import provenance

if TYPE_CHECKING:
    from reduced.stability.idle import IdleMode

ORBIT_TOLERANCE = 1e-8
"""Relative error of an orbit's figures if none is requested."""

_SHOWN = 6  # multipliers in the table
_ROUNDING = 1e-12  # those below are noise


class _OrbitOptions(ModelOptions):
    """Options of `slipwave.orbit`."""

    EXAMPLES: ClassVar = ("slipwave orbit paper --set slab.log10_r=-2.65 --out orbit.nc",)
    DETAILS: ClassVar = (
        "Where several orbits coexist, a run leads to one at most: --others names the rest, --near-period finds them. A full "
        "wave marches exactly in time; its orbit is that of its grid, whose error is part of those stated: 1.5 times the change "
        "on a grid of two thirds of the cells."
    )

    tol: float | None = tolerance_option(ORBIT_TOLERANCE)
    near_period: float | str | None = option(
        "where orbits coexist: the one with the period nearest to this, in transits or as 60s", metavar="TIME", stored=True
    )
    others: bool | None = option("name the orbits that coexist with it, along the branch from the onset on", stored=True)
    cells: int | None = option("full wave: cells per slab", stored=True)
    response: bool | None = option(
        "what moves the orbit: derivatives by every key of the scene, and the response to short pulses"
    )

    @property
    def is_default(self) -> bool:
        """Whether no option is given."""
        return not (self.tol or self.near_period or self.others or self.cells or self.settings or self.set or self.changes)


class OrbitResult(Result):
    """The `scene_orbit` that was found, with the errors of its mesh alone, the options of the call, and run time in seconds."""

    scene_orbit: SceneOrbit
    options: Mapping[str, Any]
    wall_s: float
    shows_response: bool = False

    OUTPUTS: ClassVar = (
        Output("--out", (".nc",), "to_netcdf", "write the motion over one period and the multipliers", "FILE.nc"),
        Output("--plot", FIGURES, "save_plot", "draw the motion over one period: .png, .pdf or .svg"),
    )

    @cached_property
    def stated(self) -> SceneOrbit:
        """`scene_orbit`; of a full wave with the errors of its grid too, from an orbit on another one."""
        return with_error_of_grid(self.scene_orbit, self.options.get("cells"))

    @cached_property
    def dataset(self) -> Dataset:
        """The motion over a period by `time`, multipliers by `multiplier`, and the orbit's figures with their errors."""
        orbit, scene, columns = self.stated.periodic.orbit, self.scene_orbit.scene, self._motion()
        coordinate = variables(TIME, {TIME: columns.pop(TIME)}, INTERFACE, scene)
        values = variables(TIME, columns, INTERFACE, scene)
        if self._drawn is not None:
            curves = dict(zip(PHASE, self._drawn.at(coordinate[TIME][1]), strict=True))
            values |= variables(TIME, curves, PHASE, scene)
        for name, value in orbit.values().items():
            error, meaning = f"{name}_error", Meaning(f"estimated error of {name}", EVENTS[name].unit)
            values |= variables((), {name: value}, EVENTS, scene)
            values |= variables((), {error: getattr(orbit, name).error}, {error: meaning}, scene)
        for part, numbers in (("real", self.multipliers.real), ("imaginary", self.multipliers.imag)):
            values[f"multiplier_{part}"] = ("multiplier", numbers, {"long_name": f"{part} part of the multiplier", "units": "1"})
        return new_dataset(values, coordinate, provenance("orbit", scene, self.scene_orbit.flow.model, self.options))

    def chart(self) -> Chart:
        """Stress and slip rate over one period; with the response, the phase response below them."""
        periodic, scene, columns = self.scene_orbit.periodic, self.scene_orbit.scene, self._motion()
        title = f"{scene.name}, {self.scene_orbit.flow.model}: periodic orbit, T = {periodic.orbit.period.value:.6g} transits"
        stress, rate = columns[stored_name("stress")], columns[stored_name("slip_rate")]
        chart = motion_chart(scene, title, columns[TIME], (stress, stress), (rate, rate))
        return chart if self._drawn is None else with_phase_response(chart, scene, columns[TIME], self._drawn)

    def _motion(self) -> dict[str, Array]:
        """The interface's motion at the nodes of the pieces, without repeated times, and at the end of the period."""
        closed, law = self.scene_orbit.periodic.closed, self.scene_orbit.scene.law
        pieces, nodes, end = closed.cycle.pieces, closed.flow.nodes, np.array([closed.cycle.period])
        times = pieces.time[:, None] + pieces.length[:, None] * nodes
        rows = np.stack([values.ravel() for values in (times, *pieces[2:])])
        rows = rows[:, (np.diff(rows[0], prepend=-1.0) > 0.0) & (rows[0] < end - SAME)]  # the last step may end later
        rows = np.hstack([rows, [end, *values_at(pieces, lagrange_basis(nodes), end, law)]])
        return {stored_name(name): values for name, values in named_columns(law, rows).items()}

    @cached_property
    def response(self) -> Response:
        """Figure -> key of the scene -> derivative, and under `phase` the response to short pulses. Raises NumericsError on a
        fold, SceneError for a scene that was made in Python."""
        return response_of(self.scene_orbit, self._responding)

    @cached_property
    def _responding(self) -> Responding:
        return Responding(self.scene_orbit.periodic.closed)

    @cached_property
    def _drawn(self) -> PhaseResponse | None:
        """The phase response, for files, if it was asked for and there is one."""
        try:
            return self._responding.phase if self.shows_response else None
        except NumericsError:
            return None

    @property
    def multipliers(self) -> "np.ndarray[Any, np.dtype[np.complex128]]":
        """The Floquet multipliers, largest modulus first, without the trivial one."""
        return self.scene_orbit.periodic.multipliers.values

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`; `si` exists only for scenes in SI."""
        done = self.stated
        orbit, multipliers, scene = done.periodic.orbit, done.periodic.multipliers, done.scene
        result: dict[str, Any] = {
            "scene": scene.name,
            "model": done.flow.model,
            "clock": "transit",
            **orbit.values(),
            "period_time": orbit.period.value * scene.transit,
            "stable": multipliers.stable,
            "multipliers": [[value.real, value.imag] for value in multipliers.values.tolist()],
            "trivial_defect": multipliers.trivial_defect,
            "residual": done.periodic.closed.residual,
            "error_estimate": {name: getattr(orbit, name).error for name in ("period", "stress_drop")},
            "essential_radius": multipliers.essential_radius,
            "idle_modes": [_idle(mode, orbit.period.value) for mode in multipliers.idle],
            "wall_s": self.wall_s,
            "notes": [*doubts(scene), *done.notes],
        }
        if self.shows_response:
            try:
                result["response"] = self.response
            except NumericsError as reason:
                result |= {"response": None, "notes": [*result["notes"], f"no response: {reason}"]}
        return result | cycle_in_si(orbit.values(), scene)

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The scene, whether the orbit is stable, its figures with errors, and the largest multipliers."""
        done, multipliers = self.stated, self.scene_orbit.periodic.multipliers
        yield from header(done.scene, done.notes)
        if "response" in summary and summary["response"] is None:
            yield f"note: {summary['notes'][-1]}"
        verdict = {True: "stable", False: "unstable", None: "its stability is not decided"}[multipliers.stable]
        yield f"model {done.flow.model}: periodic orbit, {verdict}; it closes to {rounded(done.periodic.closed.residual, 2)}"
        yield ""
        figures = {field.name: getattr(done.periodic.orbit, field.name) for field in fields(done.periodic.orbit)}
        known = {name: (estimate.value, estimate.error) for name, estimate in figures.items()}
        yield from aligned(*figure_rows(("value", "error"), known, done.scene))
        yield ""
        shown = [value for value in multipliers.values.tolist() if value.imag >= 0.0 and abs(value) > _ROUNDING]
        rows = [
            [rounded(value.real, 8) + (f" +- {value.imag:.8g} i" if value.imag else ""), rounded(abs(value), 8)]
            for value in shown[:_SHOWN]
        ]
        none = ["no multiplier lies outside the essential radius"]
        yield from aligned(["largest multipliers", "modulus"], rows) if rows else none
        more = f"; {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
        radius = f"; essential radius {rounded(multipliers.essential_radius, 4)}" if multipliers.essential_radius else ""
        yield f"the trivial one is 1 within {rounded(multipliers.trivial_defect, 2)}{radius}{more}"
        if summary.get("response"):
            yield from response_lines(summary["response"], summary, done.scene)
        yield f"wall time {self.wall_s:.3g} s"


@command
def orbit(source: SceneSource, options: _OrbitOptions) -> OrbitResult:
    """The periodic orbit that a run of the scene leads to, stable or not, and its Floquet multipliers.

    Where several coexist, `others` names those of the branch of orbits that begins where steady sliding loses its stability, and
    `near_period` asks for the one with the period nearest to it; a run that leads to none gives way to that branch. A netCDF file
    of an orbit is computed again; of a point of a branch it is the orbit there. A full wave marches exactly in time.

    Raises SceneError for wrong input, NumericsError if there is no orbit.
    """
    began = time.perf_counter()
    if isinstance(source, PointOfBranch):
        known = _of_point(source, options)
        if known is not None:
            at = {"near_period": source["period"]} | ({"cells": source.followed.cells} if source.followed.cells else {})
            stored = {"tol": known.tolerance} | at
            return OrbitResult(known, stored, time.perf_counter() - began, bool(options.response))
        if source.get("type") == "HB" and options.near_period is None:
            raise SceneError(
                "SCENE: at a Hopf point the orbit shrinks to steady sliding: its stability is that of slipwave.stability"
            )
        near = float(source["period"]) if options.near_period is None else options.near_period
        options = replace(options, near_period=near)
        if options.model == "auto":
            options = replace(options, model=source.followed.model, cells=options.cells or source.followed.cells)
    options = options.recalled(source, "orbit")
    options = replace(options, tol=options.tol or ORBIT_TOLERANCE)
    scene = options.scene_of(source)
    name = announced(*flowing(options.model, scene))
    period = None if options.near_period is None else moment("near_period", options.near_period, scene)
    if period is not None and not 0.0 < period < math.inf:
        raise SceneError(f"near_period = {shorten(options.near_period)}: must be above 0, in transits or with a unit of time")
    scene_orbit = orbit_at_scene(name, scene, options.tol or ORBIT_TOLERANCE, options.cells, period, bool(options.others))
    return OrbitResult(scene_orbit, options.stored, time.perf_counter() - began, bool(options.response))


def _of_point(source: PointOfBranch, options: _OrbitOptions) -> SceneOrbit | None:
    """The orbit of a point of a branch that was computed in this process, if no option asks for another one. Raises NumericsError
    if it is none to the requested tolerance."""
    followed, scene = source.followed, source.scene  # whose keys are known
    if source.closed is not None and options.is_default:
        tolerance, flow = followed.tolerance, source.closed.flow.of(scene)
        closed = replace(source.closed, flow=flow, monodromy=flow.tangent(source.closed.cycle))
        figures = Orbit(**{name: Estimate(value, tolerance * abs(value)) for name, value in figures_of(closed).items()})
        periodic = PeriodicOrbit(closed, figures, multipliers(closed)._replace(stable=None), True)  # neutral: a special point
        return SceneOrbit(periodic, tolerance, "the special point of the branch: errors are its tolerance")
    wanted = replace(options, tol=None).is_default and options.model in ("auto", followed.model)
    guess = followed.guess_at(source.place, scene) if wanted and source.place is not None else None
    if guess is None:
        return None
    tolerance = options.tol or ORBIT_TOLERANCE
    return SceneOrbit(
        refined_orbit(scene, guess, tolerance), tolerance, "the point of the branch: other orbits may coexist with it"
    )


def _idle(mode: "IdleMode", period: float) -> dict[str, Any]:
    """A mode that friction hardly damps, with its multiplier on an orbit of this `period` (transits)."""
    value = mode.multiplier(period)
    facts = {"quarter_waves": [mode.upper, mode.lower], "frequency": mode.frequency, "decay": mode.decay}
    return facts | {"multiplier": [value.real, value.imag]}

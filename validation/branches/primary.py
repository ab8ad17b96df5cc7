"""Orbits of one scene on the primary branch: the one that begins where steady sliding loses its stability as r grows."""

import math
from typing import NamedTuple

from reduced.continuation.point import Point
from reduced.continuation.start import orbits_at
from reduced.orbit.closing import Closed
from reduced.parameters import with_parameter
from reduced.stability.critical import critical_round_trip
from slipwave.errors import NumericsError
from slipwave.scene import Scene
from validation.branches.follow import Limits, begin, follow
from validation.branches.parameter import Over
from validation.branches.record import Branch
from validation.registry.families import one_port_of
from validation.registry.orbits import most_transits
from validation.run.progress import progress

_NAME = "log10_r"
_BEYOND = 0.03  # in log10 r: how far a branch is followed beyond the scene's r, from which it may fold back
_BACK = 0.002  # how far back beyond the onset, where orbits of smaller r than the onset's were left behind
_MOST = 400  # points
_LONGEST = 600.0  # transits; one orbit of 22,444 takes 6 s, a branch hundreds of orbits
_TOLERANCE = 1e-6


class Primary(NamedTuple):
    """The `orbits` of the primary branch at the scene, in order along the branch; how far it was followed, in words."""

    orbits: list[Closed]
    searched: str


def primary(model: str, scene: Scene, cells: int | None, longest: float, reason: str = "") -> Primary:
    """All orbits of the primary branch at the scene up to the period `longest` (transits).

    Raises NumericsError if there is none; a `reason` why none was found before comes first."""
    here = math.log10(scene.transit)
    said = f"{reason}; " if reason else ""
    points, ended = _points(model, scene, cells, here, longest, said)
    orbits = orbits_at(points, here, scene)
    if not orbits:
        raise NumericsError(
            f"{said}the branch of orbits that begins where steady sliding loses its stability has none here: {ended}"
        )
    return Primary(orbits, ended)


def _points(model: str, scene: Scene, cells: int | None, here: float, longest: float, said: str) -> tuple[list[Point], str]:
    """The points of the primary branch, and how far it was followed, in words."""
    critical, omega = critical_round_trip(scene, one_port_of(model))
    if not critical > 0.0:
        raise NumericsError(f"{said}steady sliding of {model} never loses its stability as r grows: no branch of orbits begins")
    period = 2.0 * math.pi / (omega * critical)
    if period > _LONGEST:
        tried = f"a run of {most_transits(scene, model):g} transits leads to no orbit, and " if said else ""
        raise NumericsError(
            f"{model}: {tried}the branch of orbits that begins where steady sliding loses its stability is not followed: their "
            f"periods are {period:.3g} transits there, over {_LONGEST:g}, and for each of up to {_MOST} orbits Newton's method "
            "marches a dense derivative through every transit, in time proportional to the period; slipwave run, which leaps "
            f"over long sticks, gives period and drops at single values of the parameters (scene {scene.name!r})"
        )
    onset = math.log10(critical)
    first, last = (onset + _BACK, here - _BEYOND) if here < onset else (onset - _BEYOND, here + _BEYOND)
    branch = Branch(Over(scene, _NAME, first, last, lambda value: with_parameter(scene, _NAME, value)), model, _TOLERANCE, cells)
    try:
        first_head = begin(branch)
    except NumericsError as error:
        raise NumericsError(f"{said}no branch of orbits can be followed to it: {error}") from None
    points = [first_head.point]
    try:
        with progress(f"{scene.name}, {model}, points of the branch", _MOST) as report:
            for head in follow(branch, first_head, Limits(longest, _MOST)):
                points.append(head.point)
                report(len(points))
    except NumericsError:
        pass  # what is known of it will do
    low, high = (f"{end(point.parameter for point in points):.7g}" for end in (min, max))
    return (
        points,
        f"it was followed from log10_r = {onset:.7g} over {low} to {high}, to a period of {points[-1].closed.cycle.period:.4g}",
    )

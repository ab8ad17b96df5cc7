"""The periodic orbits of one scene, where several may coexist: those of the branch that begins where steady sliding loses its
stability as r grows (the primary branch), and the one that a run leads to."""

import math
import time

from reduced.continuation.crossing import orbits_at
from reduced.continuation.point import Point
from reduced.orbit.approach import MOST_TRANSITS, Guess
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, is_decided
from reduced.parameters import with_parameter
from reduced.stability.critical import critical_round_trip
from slipwave.errors import NumericsError
from slipwave.scene import Scene
from validation.branches.follow import Limits, begin, follow
from validation.branches.parameter import Over
from validation.branches.record import Branch
from validation.registry.families import one_port_of
from validation.registry.flows import moving
from validation.registry.orbits import OrbitFound, Other, find_orbit, orbits_near, refined
from validation.run.progress import progress

_NAME = "log10_r"
_BEYOND = 0.03  # in log10 r: how far a branch is followed beyond the scene's r, from which it may fold back
_BACK = 0.002  # how far back beyond the onset, where orbits of smaller r than the onset's were left behind
_LONGER = 5.0  # transits, beyond the period asked for: pairs of folds recur after about one
_MOST = 400  # points
_LONGEST = 600.0  # transits; a branch of such orbits takes minutes
_TOLERANCE = 1e-6
_SEVERAL = 1.5  # ratio of periods from which a motion of several cycles is meant
_FROM_BRANCH = "found on the branch of orbits that begins where steady sliding loses its stability as r grows"
_FROM_RUN = "found where a run of the scene comes back near to its own state"


def orbit_of(model: str, scene: Scene, tolerance: float, cells: int | None = None, near: float | None = None) -> OrbitFound:
    """The orbit whose period is nearest to `near` (transits); or else the one that the scene's own start leads to or comes near
    to, or else one of the primary branch, a stable one if there is any.

    Raises NumericsError if none is found, SceneError for wrong input."""
    if near is not None:
        return _nearest(model, scene, tolerance, cells, near)
    try:
        return find_orbit(moving(model, scene, tolerance, cells), tolerance)
    except NumericsError as reason:
        began = time.perf_counter()
        orbits = _primary(model, scene, cells, math.inf, str(reason))
        return _chosen(orbits, min(orbits, key=count_unstable), scene, tolerance, began, _FROM_BRANCH)


def _nearest(model: str, scene: Scene, tolerance: float, cells: int | None, near: float) -> OrbitFound:
    """The orbit of the primary branch with the period nearest to `near`; if it has none of this number of cycles, or is not known
    so far, the nearest of those to which the scene's own motion returns."""
    began, source = time.perf_counter(), _FROM_BRANCH
    try:
        orbits = _primary(model, scene, cells, near + _LONGER, "")
    except NumericsError:
        orbits = []
    if not orbits or near > _SEVERAL * max(one.cycle.period for one in orbits):
        orbits, source = [*orbits, *orbits_near(moving(model, scene, tolerance, cells), near)], _FROM_RUN
    return _chosen(orbits, min(orbits, key=lambda one: abs(one.cycle.period - near)), scene, tolerance, began, source)


def _chosen(orbits: list[Closed], one: Closed, scene: Scene, tolerance: float, began: float, source: str) -> OrbitFound:
    """One of several orbits to the requested tolerance; the others are named."""
    cycle = one.cycle
    found = refined(scene, Guess(one.flow.of(scene), cycle.start, cycle.period, False), tolerance)
    others = tuple(_other(orbit) for orbit in orbits if orbit is not one)
    return OrbitFound(found, tolerance, source, time.perf_counter() - began, others)


def _other(closed: Closed) -> Other:
    return Other(closed.cycle.period, count_unstable(closed) if is_decided(closed) else None)


def _primary(model: str, scene: Scene, cells: int | None, longest: float, reason: str) -> list[Closed]:
    """All orbits of the primary branch at the scene up to the period `longest` (transits), in order along the branch.

    Raises NumericsError if there is none; a `reason` why none was found before comes first."""
    here = math.log10(scene.transit)
    said = f"{reason}; " if reason else ""
    points, ended = _points(model, scene, cells, here, longest, said)
    orbits = orbits_at(points, here, scene)
    if not orbits:
        raise NumericsError(
            f"{said}the branch of orbits that begins where steady sliding loses its stability has none here: {ended}"
        )
    return orbits


def _points(model: str, scene: Scene, cells: int | None, here: float, longest: float, said: str) -> tuple[list[Point], str]:
    """The points of the primary branch, and how far it was followed, in words."""
    critical, omega = critical_round_trip(scene, one_port_of(model))
    if not critical > 0.0:
        raise NumericsError(f"{said}steady sliding of {model} never loses its stability as r grows: no branch of orbits begins")
    period = 2.0 * math.pi / (omega * critical)
    if period > _LONGEST:
        tried = f"a run of {MOST_TRANSITS:g} transits leads to no orbit, and " if said else ""
        raise NumericsError(
            f"{model}: {tried}the branch of orbits that begins where steady sliding loses its stability is not followed: their "
            f"periods are {period:.3g} transits there, over {_LONGEST:g}, and Newton's method needs the derivative of each "
            f"transit; slipwave run leaps over long sticks (scene {scene.name!r})"
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

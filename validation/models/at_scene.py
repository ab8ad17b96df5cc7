"""The periodic orbits of one scene, several of which may coexist: the one that a run leads to, and those of the primary branch,
which begins where steady sliding loses stability as r grows."""

import math
from contextlib import suppress
from dataclasses import replace

from reduced.continuation.point import OrbitPoint
from reduced.continuation.start import orbits_at
from reduced.orbit.approach import Guess
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, is_decided
from reduced.parameters import scaling
from reduced.stability.critical import critical_round_trip
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.law import ALWAYS_STABLE, friction_slopes
from slipwave.scene import Scene
from validation.models.branch import FollowedBranch
from validation.models.by_name import one_port_of
from validation.models.followed import ends_of
from validation.models.orbits import SceneOrbit, find_orbit, most_transits, moving, orbits_near, refined_orbit
from validation.models.parameter import ParameterRange, Variation
from validation.models.points import StopAt
from validation.models.progress import log

_LONGER = 5.0  # transits, beyond the period asked for: pairs of folds recur after about one
_SAME = 1e-5  # relative difference of periods, to which the orbits of a branch are known, that count as one orbit's
_SEVERAL = 1.5  # ratio of periods from which a motion of several cycles is meant
_FROM_BRANCH = "found on the branch of orbits that begins where steady sliding loses its stability as r grows"
_FROM_RUN = "found where a run of the scene comes back near to its own state"
_MAY_BE = "other orbits may coexist with this one: --others looks for them"  # a `source` says so too

_NAME = "log10_r"
_BEYOND = 0.03  # in log10 r: how far a branch is followed beyond the scene's r, from which it may fold back
_BACK = 0.002  # how far back beyond the onset, where orbits of smaller r than the onset's were left behind
_MOST = 400  # points
_LONGEST = 600.0  # transits; one orbit of 22,444 takes 6 s, a branch hundreds of orbits
_TOLERANCE = 1e-6
_FAR = 2e-3  # relative distance from the period that was asked for, of which a note tells


def orbit_at_scene(
    model: str, scene: Scene, tolerance: float, cells: int | None = None, near: float | None = None, others: bool = False
) -> SceneOrbit:
    """The orbit with the period nearest to `near` (transits), if given; else the orbit that the scene's own start leads to or
    comes near to, with the `others` of the primary branch if requested; else one of the primary branch, a stable one if there is
    any.

    Raises NumericsError if none is found, SceneError for wrong input."""
    if near is not None:
        return _nearest(model, scene, tolerance, cells, near)
    try:
        scene_orbit = find_orbit(model, scene, tolerance, cells)
    except NumericsError as reason:
        log.info("no orbit where the run of scene %r leads; following the branch from its onset may take minutes", scene.name)
        known, searched = _primary(model, scene, cells, math.inf, str(reason))
        return _chosen(min(known, key=count_unstable), known, scene, tolerance, _FROM_BRANCH, searched)
    return (
        _with_others(scene_orbit, model, cells)
        if others
        else scene_orbit
        if scene_orbit.source
        else replace(scene_orbit, searched=_MAY_BE)
    )


def _with_others(scene_orbit: SceneOrbit, model: str, cells: int | None) -> SceneOrbit:
    """`scene_orbit` with the other orbits of the primary branch."""
    try:
        known, searched = _primary(model, scene_orbit.scene, cells, math.inf)
    except NumericsError as reason:
        return replace(scene_orbit, searched=f"no other orbit was found: {reason}")
    others = [orbit for orbit in known if not _same(orbit, scene_orbit.periodic.closed)]
    return replace(scene_orbit, others=tuple(map(_in_words, others)), searched=searched)


def _nearest(model: str, scene: Scene, tolerance: float, cells: int | None, near: float) -> SceneOrbit:
    """The orbit with the period nearest to `near` among the run's own and those of the primary branch; if that branch has none
    with this number of cycles, or does not reach so far, also among the close returns of the scene's own motion."""
    known, searched, own, failed = list[Closed](), "", None, None
    with suppress(NumericsError, SceneError):  # the run may lead to none in reasonable time
        own = find_orbit(model, scene, tolerance, cells)
    with suppress(NumericsError):
        known, searched = _primary(model, scene, cells, near + _LONGER)
    candidates = [(orbit, _FROM_BRANCH) for orbit in known]
    if not candidates or near > _SEVERAL * max(orbit.cycle.period for orbit, _ in candidates):
        try:
            candidates += [(orbit, _FROM_RUN) for orbit in orbits_near(moving(model, scene, cells), tolerance, near)]
        except NumericsError as reason:
            failed = reason
    # the run's own as it was found by the search for others, if it was
    if own is not None and not any(_same(orbit, own.periodic.closed) for orbit, _ in candidates):
        candidates.append((own.periodic.closed, own.source))
    if failed is not None and not candidates:
        raise failed
    nearest, source = min(candidates, key=lambda known: abs(known[0].cycle.period - near))
    if abs(nearest.cycle.period / near - 1.0) > _FAR:
        source += f"; none was found that is nearer to a period of {near:.7g} transits, though there may be one"
    return _chosen(nearest, [orbit for orbit, _ in candidates], scene, tolerance, source, searched)


def _chosen(chosen: Closed, known: list[Closed], scene: Scene, tolerance: float, source: str, searched: str) -> SceneOrbit:
    """The orbit `chosen` of those `known`, refined to the tolerance; the others are listed with it."""
    periodic = refined_orbit(scene, Guess(chosen.flow.of(scene), chosen.cycle.start, chosen.cycle.period, False), tolerance)
    return SceneOrbit(periodic, tolerance, source, tuple(_in_words(orbit) for orbit in known if orbit is not chosen), searched)


def _same(orbit: Closed, other: Closed) -> bool:
    return abs(orbit.cycle.period / other.cycle.period - 1.0) < _SAME


def _in_words(closed: Closed) -> str:
    """Its period (transits) and stability."""
    stability = ("unstable" if count_unstable(closed) else "stable") if is_decided(closed) else "stability not decided"
    return f"{closed.cycle.period:.7g} ({stability})"


def _primary(model: str, scene: Scene, cells: int | None, longest: float, reason: str = "") -> tuple[list[Closed], str]:
    """All orbits of the primary branch at the scene up to the period `longest` (transits), in order along the branch, and a note
    on how far it was followed.

    Raises NumericsError if there is none; its message begins with `reason`, why none was found before."""
    here = math.log10(scene.transit)
    said = f"{reason}; " if reason else ""
    points, ended = _points(model, scene, cells, here, longest, said)
    orbits = orbits_at(points, here, scene)
    if not orbits:
        raise NumericsError(
            f"{said}the branch of orbits that begins where steady sliding loses its stability has none here: {ended}"
        )
    return orbits, f"others were looked for along the branch of orbits that begins where stability is lost: {ended}"


def _points(model: str, scene: Scene, cells: int | None, here: float, longest: float, said: str) -> tuple[list[OrbitPoint], str]:
    """The points of the primary branch, and a text on how far it was followed."""
    critical, omega = critical_round_trip(scene, one_port_of(model))
    if not friction_slopes(scene.law, scene.velocity).weakening:  # a reason says so already
        raise NumericsError(said.removesuffix("; ") or f"{model}: {ALWAYS_STABLE}: no branch of orbits begins")
    if not critical > 0.0:
        raise NumericsError(f"{said}steady sliding of {model} never loses its stability as r grows: no branch of orbits begins")
    period = 2.0 * math.pi / (omega * critical)
    if period > _LONGEST:
        tried = f"a run of {most_transits(scene):g} transits leads to no orbit, and " if said else ""
        raise NumericsError(
            f"{model}: {tried}the branch of orbits that begins where steady sliding loses its stability is not followed: their "
            f"periods are {period:.3g} transits there, over {_LONGEST:g}, and for each of up to {_MOST} orbits Newton's method "
            "marches a dense derivative through every transit, in time proportional to the period; slipwave run, which leaps "
            f"over long sticks, gives period and drops at single values of the parameters (scene {scene.name!r})"
        )
    onset = math.log10(critical)
    first, last = (onset + _BACK, here - _BEYOND) if here < onset else (onset - _BEYOND, here + _BEYOND)
    over = ParameterRange(_NAME, first=first, last=last, scenes=Variation(scaling(scene)))  # as for the onset
    points: list[OrbitPoint] = []
    try:
        for end in ends_of(FollowedBranch(over, model, _TOLERANCE, cells), StopAt(longest, _MOST, outside=0.0)):
            points.append(end.point)
    except NumericsError as error:
        if not points:
            raise NumericsError(f"{said}no branch of orbits can be followed to it: {error}") from None
        # what is known of it will do
    low, high = (f"{end(point.parameter for point in points):.7g}" for end in (min, max))
    reached = f"{low} to {high}, to a period of {points[-1].closed.cycle.period:.4g}"
    return points, f"it was followed from log10_r = {onset:.7g} over {reached}"

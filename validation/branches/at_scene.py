"""The periodic orbits of one scene, where several may coexist: the one that a run leads to, and those of the primary branch."""

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING

from reduced.orbit.approach import Guess
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, is_decided
from slipwave.errors import NumericsError, SceneError
from slipwave.scene import Scene
from validation.registry.orbits import OrbitFound, Other, find_orbit, moving, orbits_near, refined

if TYPE_CHECKING:
    from validation.branches.primary import Primary

_LONGER = 5.0  # transits, beyond the period asked for: pairs of folds recur after about one
_SAME = 1e-5  # relative difference of periods, to which the orbits of a branch are known, that count as one orbit's
_SEVERAL = 1.5  # ratio of periods from which a motion of several cycles is meant
_FROM_BRANCH = "found on the branch of orbits that begins where steady sliding loses its stability as r grows"
_FROM_RUN = "found where a run of the scene comes back near to its own state"
_MAY_BE = "other orbits may coexist with this one: --others looks for them"  # a `source` says so too


def orbit_of(
    model: str, scene: Scene, tolerance: float, cells: int | None = None, near: float | None = None, others: bool = False
) -> OrbitFound:
    """The orbit whose period is nearest to `near` (transits); or else the one that the scene's own start leads to or comes near
    to, with the `others` of the primary branch if asked for; or else one of the primary branch, a stable one if there is any.

    Raises NumericsError if none is found, SceneError for wrong input."""
    if near is not None:
        return _nearest(model, scene, tolerance, cells, near)
    try:
        found = find_orbit(moving(model, scene, tolerance, cells), tolerance)
    except NumericsError as reason:
        began = time.perf_counter()
        known = _primary(model, scene, cells, math.inf, str(reason))
        return _chosen(known, min(known.orbits, key=count_unstable), scene, tolerance, began, _FROM_BRANCH)
    return _with_others(found, model, cells) if others else found if found.source else replace(found, searched=_MAY_BE)


def _with_others(found: OrbitFound, model: str, cells: int | None) -> OrbitFound:
    """The same with those orbits of the primary branch that it is not."""
    began, period = time.perf_counter(), found.found.orbit.period.value
    try:
        known = _primary(model, found.scene, cells, math.inf)
    except NumericsError as reason:
        return replace(found, searched=f"no other orbit was found: {reason}", wall_s=found.wall_s + time.perf_counter() - began)
    others = tuple(_other(orbit) for orbit in known.orbits if abs(orbit.cycle.period / period - 1.0) > _SAME)
    return replace(found, others=others, searched=_extent(known), wall_s=found.wall_s + time.perf_counter() - began)


def _extent(known: "Primary") -> str:
    return f"others were looked for along the branch of orbits that begins where stability is lost: {known.searched}"


def _nearest(model: str, scene: Scene, tolerance: float, cells: int | None, near: float) -> OrbitFound:
    """The orbit with the period nearest to `near` among the run's own and those of the primary branch; if that branch has none of
    this number of cycles, or is not known so far, also among those to which the scene's own motion returns."""
    from validation.branches.primary import Primary

    began, own, failed = time.perf_counter(), _own(model, scene, tolerance, cells), None
    try:
        known = _primary(model, scene, cells, near + _LONGER)
    except NumericsError:
        known = Primary([], "")
    source = dict.fromkeys(map(id, known.orbits), _FROM_BRANCH)
    if not known.orbits or near > _SEVERAL * max(one.cycle.period for one in known.orbits):
        try:
            known = known._replace(orbits=[*known.orbits, *orbits_near(moving(model, scene, tolerance, cells), near)])
        except NumericsError as reason:
            failed = reason
    if own is not None:  # as it was found by the search for others, if it was
        closed = own.found.closed
        if not any(abs(one.cycle.period / closed.cycle.period - 1.0) < _SAME for one in known.orbits):
            known, source = known._replace(orbits=[*known.orbits, closed]), source | {id(closed): own.source}
    if failed is not None and not known.orbits:
        raise failed
    nearest = min(known.orbits, key=lambda one: abs(one.cycle.period - near))
    return _chosen(known, nearest, scene, tolerance, began, source.get(id(nearest), _FROM_RUN))


def _own(model: str, scene: Scene, tolerance: float, cells: int | None) -> OrbitFound | None:
    """The orbit that the run leads to, if it leads to one in reasonable time."""
    try:
        return find_orbit(moving(model, scene, tolerance, cells), tolerance)
    except (NumericsError, SceneError):
        return None


def _chosen(known: "Primary", one: Closed, scene: Scene, tolerance: float, began: float, source: str) -> OrbitFound:
    """One of several orbits to the requested tolerance; the others are named."""
    cycle = one.cycle
    found = refined(scene, Guess(one.flow.of(scene), cycle.start, cycle.period, False), tolerance)
    others = tuple(_other(orbit) for orbit in known.orbits if orbit is not one)
    searched = _extent(known) if known.searched else ""
    return OrbitFound(found, tolerance, source, time.perf_counter() - began, others, searched)


def _other(closed: Closed) -> Other:
    return Other(closed.cycle.period, count_unstable(closed) if is_decided(closed) else None)


def _primary(model: str, scene: Scene, cells: int | None, longest: float, reason: str = "") -> "Primary":
    """`primary`, whose continuation is imported only where a run does not do."""
    from validation.branches.primary import primary

    return primary(model, scene, cells, longest, reason)

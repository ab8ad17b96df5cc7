"""Floquet multipliers of a closed cycle: eigenvalues of its monodromy matrix, except the trivial one, which is 1."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.impedance.transmission_line import Complex
from reduced.orbit.closing import Closed
from slipwave.observe.pieces import Array
from slipwave.step.flow import eigenvalues_without

if TYPE_CHECKING:
    from reduced.stability.idle import IdleMode

_NEUTRAL = 1e-6
"""Distance of a multiplier's modulus from 1 below which stability is not decided."""

_AGREE = 1e-3  # relative; two meshes must agree so far on a multiplier: eigenvalues of the essential spectrum never do
_SMALLEST = 1e-6  # modulus below which a multiplier is lost in the errors of larger ones
_APART = 2.0  # times the essential radius; a multiplier beyond belongs to no essential spectrum
_NONE = np.zeros((0, 0))


class Multipliers(NamedTuple):
    """`values` (m,), largest modulus first, without the trivial one, whose distance from 1 is `trivial_defect`, and those of idle
    modes; `essential_radius`: that of the disk in which infinitely many accumulate (0 if there are finitely many); `stable` is
    None if the values do not decide, for the `reason`; where some modes are exactly idle it is said without them. `idle`: the
    modes that friction damps least, if the radius is 1."""

    values: Complex
    trivial_defect: float
    essential_radius: float
    stable: bool | None
    reason: str = ""
    idle: "tuple[IdleMode, ...]" = ()


def multipliers(closed: Closed, coarser: Closed | None = None) -> Multipliers:
    """Multipliers of `closed` outside the essential radius that a `coarser` mesh, if given, confirms."""
    values, defect = floquet(closed.monodromy, closed.flow.idle)
    radius = closed.flow.essential_radius(closed.cycle)
    isolated = values[np.abs(values) > max(radius, _SMALLEST)]
    if coarser is not None:
        isolated = isolated[_confirmed(isolated, coarser)]
    if not is_decided(closed):
        from reduced.stability.idle import idle_modes

        modes, rest = idle_modes(closed.flow.scene), np.abs(values)
        grows = bool(np.any(np.abs(isolated) > 1.0 + _AGREE))
        settles = not closed.flow.undecided and max(radius, rest.max(initial=0.0)) < 1.0 - _NEUTRAL
        reason = _undamped(modes, closed.cycle.period, grows, settles)
        return Multipliers(isolated, defect, max(radius, 1.0), False if grows else True if settles else None, reason, modes)
    largest = float(np.abs(isolated).max(initial=0.0))
    if abs(largest - 1.0) < _NEUTRAL:
        reason = f"the largest multiplier has modulus {largest:.9f}: neutral within the error of the computation"
        return Multipliers(isolated, defect, radius, None, reason)
    return Multipliers(isolated, defect, radius, largest < 1.0)


def has_leading(closed: Closed, coarser: Closed) -> bool:
    """Whether the `coarser` mesh confirms the largest multiplier of `closed`, if that is clear of the essential spectrum."""
    largest = floquet(closed.monodromy, closed.flow.idle)[0][:1]
    if _confirmed(largest, coarser).all():
        return True
    return float(np.abs(largest[0])) <= max(_APART * closed.flow.essential_radius(closed.cycle), _SMALLEST)


def _confirmed(values: Complex, coarser: Closed) -> NDArray[np.bool_]:
    """Which of the multipliers the `coarser` mesh has too."""
    others = floquet(coarser.monodromy, coarser.flow.idle)[0]
    nearest = [np.abs(others - multiplier).min() if others.size else np.inf for multiplier in values]
    return np.asarray(np.array(nearest, dtype=float) < _AGREE * np.abs(values))


def is_decided(closed: Closed) -> bool:
    """Whether multipliers decide the stability of `closed`: none accumulate at the unit circle and none are idle."""
    return not (closed.flow.undecided or closed.flow.idle.size)


def count_unstable(closed: Closed) -> int:
    """The number of multipliers of `closed` outside the unit circle, without those of idle modes."""
    return int((np.abs(floquet(closed.monodromy, closed.flow.idle)[0]) > 1.0).sum())


def floquet(monodromy: Array, idle: Array = _NONE) -> tuple[Complex, float]:
    """Eigenvalues without those of `idle` states and the one nearest to 1, largest modulus first; and the distance of the latter
    from 1."""
    values = eigenvalues_without(monodromy, idle)
    trivial = int(np.abs(values - 1.0).argmin())
    rest = np.delete(values, trivial)
    return rest[np.argsort(-np.abs(rest), kind="stable")], float(abs(values[trivial] - 1.0))


def _undamped(modes: "tuple[IdleMode, ...]", period: float, grows: bool, settles: bool) -> str:
    """Text: which modes friction does not damp, and, unless a multiplier `grows` or all else `settles`, that multipliers
    therefore do not decide."""
    from reduced.stability.idle import named

    exact = bool(modes) and not modes[0].decay
    said = "left out of the multipliers" if exact else "they lose little in a period, and others of high frequency less"
    listed = f" ({named(modes, period)}; {said})" if modes else ""
    decided = "but a multiplier outside of it decides" if grows else "and multipliers cannot decide stability"
    decided = "but for which the orbit is stable" if settles else decided
    return (
        "the waves' own multipliers reach a radius of 1: some motion of the slabs is never damped by friction, "
        f"{decided}: idle modes, in which both slabs swing alike without slip or stress at the interface{listed}"
    )

"""The slabs on either side of the interface: two that are marched, or one and its mirror image.

Alike slabs move antisymmetrically, so the lower is a `Mirror`: the kernel compiled for it marches one slab only.
"""

from typing import NamedTuple

from fullwave.leapfrog.faces import Grip, Rigid
from fullwave.leapfrog.media import Medium, accelerate, load, strain
from slipwave.compiled.dispatch import by_class


class Side(NamedTuple):
    """A slab that is marched."""

    medium: Medium
    face: Rigid | Grip


class Mirror(NamedTuple):
    """The lower slab of an alike pair: it moves as the upper slab does, and is not marched."""

    unused: float = 0.0


@by_class(inline=True)
def meet(lower: Side | Mirror, impedance: float, incoming: float, mean: float, following: float) -> tuple[float, float]:
    """(Z, S) of both slabs together, given those of the upper slab."""
    raise NotImplementedError(type(lower))


@by_class(inline=True)
def part(lower: Side | Mirror, impedance: float, incoming: float, stress: float, v: float) -> float:
    """The upper slab's velocity at the interface for the slip rate v."""
    raise NotImplementedError(type(lower))


@by_class(inline=True)
def follow_on(lower: Side | Mirror, rate: float, power: float, mean: float, following: float) -> float:
    """Advance the lower slab's velocities; returns the power of both faces together."""
    raise NotImplementedError(type(lower))


@by_class(inline=True)
def slip_rate(lower: Side | Mirror, own: float) -> float:
    """v at the half step, given the upper slab's velocity at the interface."""
    raise NotImplementedError(type(lower))


@by_class(inline=True)
def strain_lower(lower: Side | Mirror) -> None:
    """Advance the lower slab's stresses."""
    raise NotImplementedError(type(lower))


@meet.register(Side)
def _meet_side(lower, impedance, incoming, mean, following):  # type: ignore[no-untyped-def]
    own, other = load(lower.medium, lower.face, mean, following)
    total = impedance + own
    return impedance * own / total, (incoming * own + other * impedance) / total


@meet.register(Mirror)
def _meet_mirror(lower, impedance, incoming, mean, following):  # type: ignore[no-untyped-def]
    return 0.5 * impedance, incoming


@part.register(Side)
def _part_side(lower, impedance, incoming, stress, v):  # type: ignore[no-untyped-def]
    return (incoming - stress) / impedance


@part.register(Mirror)
def _part_mirror(lower, impedance, incoming, stress, v):  # type: ignore[no-untyped-def]
    return 0.5 * v


@follow_on.register(Side)
def _follow_side(lower, rate, power, mean, following):  # type: ignore[no-untyped-def]
    return power + accelerate(lower.medium, lower.face, rate, mean, following)


@follow_on.register(Mirror)
def _follow_mirror(lower, rate, power, mean, following):  # type: ignore[no-untyped-def]
    return 2.0 * power


@slip_rate.register(Side)
def _slip_side(lower, own):  # type: ignore[no-untyped-def]
    return own + lower.medium.velocity[0]


@slip_rate.register(Mirror)
def _slip_mirror(lower, own):  # type: ignore[no-untyped-def]
    return 2.0 * own


@strain_lower.register(Side)
def _strain_side(lower):  # type: ignore[no-untyped-def]
    strain(lower.medium)


@strain_lower.register(Mirror)
def _strain_mirror(lower):  # type: ignore[no-untyped-def]
    pass

"""The slabs on either side of the interface: two that are marched, or one and its mirror image.

Alike slabs move antisymmetrically, so the lower is a `Mirror`: the kernel compiled for it marches one slab only.
"""

from typing import NamedTuple

from fullwave.leapfrog.faces import Grip, Rigid
from fullwave.leapfrog.media import Medium, accelerate, load, strain
from slipwave.compiled.dispatch import dispatch


class Side(NamedTuple):
    """A slab that is marched."""

    medium: Medium
    face: Rigid | Grip


class Mirror(NamedTuple):
    """The lower slab of an alike pair: it does what the upper does, and is not marched."""

    unused: float = 0.0


def meet(lower: Side | Mirror, impedance: float, incoming: float, mean: float, following: float) -> tuple[float, float]:
    """(Z, S) of both slabs together, given the upper's."""
    raise NotImplementedError(type(lower))


def part(lower: Side | Mirror, impedance: float, incoming: float, stress: float, v: float) -> float:
    """The upper slab's interface velocity when the slip rate is v."""
    raise NotImplementedError(type(lower))


def follow_on(lower: Side | Mirror, rate: float, power: float, mean: float, following: float) -> float:
    """Move the lower slab; power of both faces together."""
    raise NotImplementedError(type(lower))


def slip_rate(lower: Side | Mirror, own: float) -> float:
    """v at the half step, given the upper slab's interface velocity."""
    raise NotImplementedError(type(lower))


def strain_lower(lower: Side | Mirror) -> None:
    """Stresses of the lower slab."""
    raise NotImplementedError(type(lower))


def _meet_side(lower, impedance, incoming, mean, following):  # type: ignore[no-untyped-def]
    own, other = load(lower.medium, lower.face, mean, following)
    total = impedance + own
    return impedance * own / total, (incoming * own + other * impedance) / total


def _meet_mirror(lower, impedance, incoming, mean, following):  # type: ignore[no-untyped-def]
    return 0.5 * impedance, incoming


def _part_side(lower, impedance, incoming, stress, v):  # type: ignore[no-untyped-def]
    return (incoming - stress) / impedance


def _part_mirror(lower, impedance, incoming, stress, v):  # type: ignore[no-untyped-def]
    return 0.5 * v


def _follow_side(lower, rate, power, mean, following):  # type: ignore[no-untyped-def]
    return power + accelerate(lower.medium, lower.face, rate, mean, following)


def _follow_mirror(lower, rate, power, mean, following):  # type: ignore[no-untyped-def]
    return 2.0 * power


def _slip_side(lower, own):  # type: ignore[no-untyped-def]
    return own + lower.medium.velocity[0]


def _slip_mirror(lower, own):  # type: ignore[no-untyped-def]
    return 2.0 * own


def _strain_side(lower):  # type: ignore[no-untyped-def]
    strain(lower.medium)


def _strain_mirror(lower):  # type: ignore[no-untyped-def]
    pass


dispatch(meet, {Side: _meet_side, Mirror: _meet_mirror}, inline=True)
dispatch(part, {Side: _part_side, Mirror: _part_mirror}, inline=True)
dispatch(follow_on, {Side: _follow_side, Mirror: _follow_mirror}, inline=True)
dispatch(slip_rate, {Side: _slip_side, Mirror: _slip_mirror}, inline=True)
dispatch(strain_lower, {Side: _strain_side, Mirror: _strain_mirror}, inline=True)

"""Divides a transit into equal steps, with cuts at the kinks of the drive, which return every transit.

A knot of the drive at t causes a kink of the load at t and, half a transit later, of the wave that reaches the interface. Its
echoes return every transit for ever. A polynomial across a kink is only first-order accurate, so steps must end on kinks.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import SAME, Array, interpolation_matrix, lagrange_basis
from slipwave.scene.drive import Drive

_SAME = 1e-7
"""Transits; cuts closer than this are one. Ignoring a kink this close to a step's end causes a relative error of that size."""


@dataclass(frozen=True, eq=False)
class TransitMesh:
    """`lengths` (steps,) and `starts` (steps,) of the steps of one transit; `count` is the requested number of equal steps. It is
    shared between solvers; do not write to its arrays."""

    count: int
    lengths: Array
    starts: Array

    @property
    def steps(self) -> int:
        """Steps per transit."""
        return int(self.lengths.size)

    def resample(self, values: Array, nodes: Array, finer: "TransitMesh") -> Array:
        """Values (..., finer.steps, s) at the nodes of `finer` of piecewise polynomials with nodal `values` (..., steps, s)."""
        step, weights = _read_at(self, tuple(nodes.tolist()), finer)
        return np.asarray(np.einsum("isk,...isk->...is", weights, np.ascontiguousarray(values[..., step, :])))


@lru_cache(maxsize=32)
def _read_at(coarse: TransitMesh, nodes: tuple[float, ...], finer: TransitMesh) -> tuple[NDArray[np.intp], Array]:
    """Index of the step of `coarse` that contains each node of `finer`, (finer.steps, s), and the rows that evaluate its
    polynomial there."""
    at = finer.starts[:, None] + np.array(nodes) * finer.lengths[:, None]
    step = np.clip(np.searchsorted(coarse.starts, at - SAME, side="left") - 1, 0, coarse.steps - 1)
    local = np.clip((at - coarse.starts[step]) / coarse.lengths[step], 0.0, 1.0)
    basis = lagrange_basis(np.array(nodes))
    return step, interpolation_matrix(basis, local.ravel()).reshape(*at.shape, len(nodes))


def cuts_of(drive: Drive) -> Array:
    """Fractions of the transit at which the drive's knots cause a kink of the load or of the wave at the interface, and 0."""
    knots = np.array(drive.knots)
    fractions = np.sort(np.concatenate(([0.0], knots % 1.0, (knots + 0.5) % 1.0)))
    fractions = fractions[fractions < 1.0 - _SAME]
    return fractions[np.concatenate(([True], np.diff(fractions) > _SAME))]


def transit_mesh(count: int, cuts: Array) -> TransitMesh:
    """Steps no longer than 1/`count`, equal between neighbouring `cuts` (sorted, the first 0)."""
    return _mesh_of(count, tuple(cuts.tolist()))


@lru_cache(maxsize=256)
def _mesh_of(count: int, cuts: tuple[float, ...]) -> TransitMesh:
    gaps = np.diff(np.append(cuts, 1.0))
    shares = [math.ceil(count * gap - 1e-6) or 1 for gap in gaps]
    lengths = np.concatenate([np.full(share, gap / share) for share, gap in zip(shares, gaps, strict=True)])
    starts = np.concatenate(([0.0], np.cumsum(lengths)[:-1]))
    if np.ptp(lengths) < 1e-14:  # equal steps begin exactly at whole multiples of their length
        starts, lengths = np.arange(lengths.size) / lengths.size, np.full(lengths.size, 1.0 / lengths.size)
    return TransitMesh(count, lengths, starts)

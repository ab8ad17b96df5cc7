"""Any pair of lossless slabs as transmission lines between the interface and the drive: the delay system as data.

A slab is a chain of layers. Each carries one wave inwards and one outwards, sigma +- e w, which arrive at the layer's other end
after its one-way travel time. At the ends of layers the waves obey (MODEL.md section 3), in deviations from steady sliding,

    joint      U from inside, D from outside:  w = (D - U)/(e_in + e_out),  back in U + 2 e_in w,  on out D - 2 e_out w
    top        P from inside:  m w' = y + Z_g (dV - w) - P - e w,  y' = K (dV - w),  back in P + 2 e w
    interface  S from outside: mu = Z (sum S_i/e_i - dv),  on out 2 mu - S

(K, Z_g, m) is the slab's `Termination`; a rigid top is Z_g -> infinity (w = dV). The sign of the lower slab's velocities is such
that the slip rate is the sum of both slabs' velocities. Slabs that have an `equivalent` are computed as that, counted twice.
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from reduced.commensurate import common_divisor
from reduced.delay.network_kernel import INWARD, Integers, Network
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array, Basis, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.scene.slab import Termination
from slipwave.step.collocation import from_moments, radau

NODES = 8
"""Nodes of a step of a network."""

COINCIDENT = 1e-9
"""Share of a step; two points of a step that differ by less are one."""

_MOST_DIVISIONS = 64


@dataclass(frozen=True)
class Lines:
    """Layers of all slabs, slab after slab, from the interface outwards.

    `impedance`, `travel` (one way, transits) per layer; per slab `first` and `last` layer index, and its `tops` (transit clock);
    `weight` is 2 for the slab that is equivalent to both, else 1.
    """

    impedance: Array
    travel: Array
    first: tuple[int, ...]
    last: tuple[int, ...]
    tops: tuple[Termination, ...]
    weight: float

    @property
    def apart(self) -> Array:
        """Waves (layers, 2) of slabs that move apart as a whole, each at half of a rate of 1."""
        return 0.5 * self.impedance[:, None] * np.where(np.arange(2) == INWARD, 1.0, -1.0)

    @cached_property
    def divisor(self) -> float | None:
        """Longest step (transits) that divides every travel time. None if there is none or it is too short: delayed values are
        then interpolated."""
        return common_divisor(self.travel, _MOST_DIVISIONS)


def lines_of(scene: Scene) -> Lines:
    """The scene's slabs as lines. Raises SceneError for viscous slabs, whose waves disperse: no finite set of delays is exact."""
    slabs = scene.slabs
    for slab in slabs:
        if slab.viscosity is not None:
            raise SceneError(
                f"model = delay: scene {scene.name!r} is viscous: its waves disperse, so that no finite set of delays is exact; "
                "use fitted:N or a full wave"
            )
    counts = [len(slab.layers) for slab in slabs]
    ends = np.cumsum(counts)
    return Lines(
        impedance=np.array([slab.epsilon * layer.impedance for slab in slabs for layer in slab.layers]),
        travel=np.array([0.5 * slab.round_trip / scene.transit * layer.fraction for slab in slabs for layer in slab.layers]),
        first=tuple(int(end - count) for end, count in zip(ends, counts, strict=True)),
        last=tuple(int(end - 1) for end in ends),
        tops=tuple(slab.termination.in_transits(scene.transit) for slab in slabs),
        weight=2.0 if len(slabs) == 1 else 1.0,
    )


def network_of(scene: Scene, lines: Lines, length: float, nodes: Array) -> Network:
    """The lines of `scene` in compiled form for equal steps of `length` (transits)."""
    back, weights = delay_rows(lines.travel / length, nodes)
    return Network(
        lines.impedance,
        back,
        weights,
        weights[:, 0, 0, 0] == 1.0,
        np.array(lines.first),
        np.array(lines.last),
        np.array([top.spring for top in lines.tops]),
        *tops_for(lines, length, nodes.size),
        np.array([top.spring > 0.0 or top.mass > 0.0 for top in lines.tops]),
        scene.impedance,
        scene.steady_stress + scene.impedance * scene.velocity,
        lines.weight,
    )


def tops_for(lines: Lines, length: float, stages: int) -> tuple[Array, Array]:
    """`compliance` and `inertia` of the outer faces in a step of `length` (`Network`), (slabs, s, s) each."""
    rule, identity = radau(stages), np.eye(stages)
    inertia = np.array([top.mass / length * rule.inverse for top in lines.tops])
    compliance = np.zeros_like(inertia)
    for slab, top in enumerate(lines.tops):
        if not top.is_rigid:
            resistance = (top.dashpot + lines.impedance[lines.last[slab]]) * identity
            compliance[slab] = np.linalg.inv(inertia[slab] + resistance + length * top.spring * rule.integral)
    return compliance, inertia


def delay_rows(steps_back: Array, nodes: Array) -> tuple[Integers, Array]:
    """For delays of `steps_back` (L,) steps: the two numbers of steps since the arriving wave was emitted, (L, 2), and their
    weights, (L, 2, s, s).

    The weights give nodal values of the L2 projection of the arriving wave. With interpolated values, noise in a lossless slab
    would grow at every arrival, for some delays by a fifth.
    """
    older = np.ceil(steps_back - COINCIDENT).astype(np.int64)
    weights = np.zeros((older.size, 2, nodes.size, nodes.size))
    for layer, share in enumerate(np.clip(older - steps_back, 0.0, 1.0)):
        if share < COINCIDENT:
            weights[layer, 0] = np.eye(nodes.size)
        else:
            weights[layer] = shifted_rows(float(share), nodes.size)
    return np.column_stack([older, older - 1]), weights


def shifted_rows(share: float, stages: int) -> Array:
    """Weights (2, s, s) of a step and of the next in the nodal values of the L2 projection of their polynomials on the step that
    begins the part `share` of a step after the first."""
    s, basis, project, points, parts = _projection(stages)
    weights = np.zeros((2, s, s))
    for which, (begin, length) in enumerate(((0.0, 1.0 - share), (1.0 - share, share))):
        at = begin + length * points
        moments = length * parts * np.polynomial.legendre.legvander(2.0 * at - 1.0, s - 1).T
        weights[which] = project @ moments @ interpolation_matrix(basis, at + share - which)
    return weights


@cache
def _projection(stages: int) -> tuple[int, Basis, Array, Array, Array]:
    """`stages`; the basis of the nodes and their values from moments; points and weights of a quadrature on the unit step."""
    nodes, (points, weights) = radau(stages).nodes, np.polynomial.legendre.leggauss(stages)
    return stages, lagrange_basis(nodes), from_moments(nodes), 0.5 * (points + 1.0), 0.5 * weights

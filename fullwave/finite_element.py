"""Finite elements assembled by scikit-fem: velocity and stress both continuous and of degree P, weak conditions at the faces.

Galerkin for the pair w_t = s_x, s_t = w_x in one layer, with the characteristic states w* at its ends:

    M w' = Q s + (w* - w)_ends,    M s' = Q w +- (w* - w)_ends,    Q_ij = integral of phi_i phi_j',   Q + Q^T = ends only,

so the energy w.M w + s.M s changes through the ends only, as in every family. Elements P1 and P2 are scikit-fem's, the others are
Lagrange polynomials on Gauss-Lobatto nodes (`gll_element`). mass = "lumped" computes M by quadrature in those nodes: M is
diagonal (spectral elements, Komatitsch and Vilotte, Bull. Seismol. Soc. Am. 88, 1998), and P1 is the same scheme as sbp:2.
"consistent" integrates M exactly and solves a banded system in every stage (P1: order 4 inside). A layer is one mesh; two layers
are coupled through upwind states. Energy never grows, because the penalties at the ends dissipate.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple, Unpack

import numpy as np
import scipy.linalg
import scipy.sparse
import skfem
from numpy.typing import NDArray

from fullwave.families import ELEMENTS
from fullwave.lines.blocks import Block, BlockGrid, Section, padded_half
from fullwave.lines.march import Marching, MethodOfLines, method_for
from fullwave.lines.scheme_limit import MARGIN, line_spectrum, longest_step
from fullwave.lines.system import apply, finish
from fullwave.operators.gll_element import ElementLineGLL
from fullwave.operators.lobatto import gauss_lobatto
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.slab import KelvinVoigtViscosity

MASSES = ("lumped", "consistent")
_SAMPLE_NODES = 56  # of the longest line from which a step limit is computed; LAPACK takes three times as long beyond 75


class Assembled(NamedTuple):
    """Rows of M^-1 Q (lumped) or Q (consistent) over all nodes, compressed; Cholesky factor of M in lower banded form, shape
    (bandwidth + 1, nodes), or (0, 0). The slot of w at node i is i, that of s is `half` + i."""

    pointer: NDArray[np.int64]
    column: NDArray[np.int64]
    value: Array
    factor: Array
    half: int


def element_of(degree: int) -> Any:
    """The scikit-fem element of `degree`."""
    return {1: skfem.ElementLineP1, 2: skfem.ElementLineP2}.get(degree, lambda: ElementLineGLL(degree))()


@skfem.BilinearForm  # type: ignore[untyped-decorator]
def _mass(u: Any, v: Any, _: Any) -> Any:
    return u * v


@skfem.BilinearForm  # type: ignore[untyped-decorator]
def _slope(u: Any, v: Any, _: Any) -> Any:
    return u.grad[0] * v


def assemble_layer(cells: int, degree: int, mass: str) -> tuple[Array, Any, Any]:
    """Depths of the nodes (n,), M and Q (sparse, n by n) of a layer of length 1; nodes are sorted by depth."""
    mesh = skfem.MeshLine(np.linspace(0.0, 1.0, cells + 1))
    points, weights = gauss_lobatto(degree)
    in_nodes = (0.5 * (points + 1.0)[None, :], 0.5 * weights)
    exact = skfem.Basis(mesh, element_of(degree), intorder=2 * degree)
    basis = skfem.Basis(mesh, element_of(degree), quadrature=in_nodes) if mass == "lumped" else exact
    order = np.argsort(exact.doflocs[0])
    matrices = [form.assemble(which).tocsr()[order][:, order] for form, which in ((_mass, basis), (_slope, exact))]
    return exact.doflocs[0][order], matrices[0], matrices[1]


def mesh_grid(sections: Sequence[Section], degree: int, mass: str) -> BlockGrid:
    """The grid with every section as one block."""
    layers = [assemble_layer(section.cells, degree, mass) for section in sections]
    first = np.cumsum([0] + [depth.size for depth, _, _ in layers])
    half = padded_half(int(first[-1]))
    blocks, norms, slopes = [], [], []
    for start, section, (depth, unit_mass, slope) in zip(first, sections, layers, strict=False):
        norm = section.length * unit_mass
        slots = start + np.arange(depth.size)
        diagonal = norm.diagonal()
        lumped = mass == "lumped"
        lift = (1.0 / diagonal[0], 1.0 / diagonal[-1]) if lumped else (1.0, 1.0)
        depths = section.start + section.length * depth
        blocks.append(Block(section, slots, half + slots, depths, diagonal if lumped else norm, lift))
        norms.append(norm)
        slopes.append(scipy.sparse.diags_array(1.0 / diagonal) @ slope if lumped else slope)
    rows = scipy.sparse.block_diag(slopes, format="csr")
    rows.data[np.abs(rows.data) < 1e-13 * np.abs(rows.data).max()] = 0.0
    rows.eliminate_zeros()
    factor = np.zeros((0, 0)) if mass == "lumped" else _banded_cholesky(scipy.sparse.block_diag(norms, format="csr"), degree)
    operator = Assembled(rows.indptr.astype(np.int64), rows.indices.astype(np.int64), rows.data, factor, half)
    return BlockGrid(operator, 2 * half, tuple(blocks))


def _banded_cholesky(matrix: Any, bandwidth: int) -> Array:
    bands = np.zeros((bandwidth + 1, matrix.shape[0]))
    for k in range(bandwidth + 1):
        diagonal = matrix.diagonal(-k)
        bands[k, : diagonal.size] = diagonal
    return np.ascontiguousarray(scipy.linalg.cholesky_banded(bands, lower=True))


@apply.register(Assembled)
def _apply(operator, state, rates, at):  # type: ignore[no-untyped-def]
    pointer, column, value, half = operator.pointer, operator.column, operator.value, operator.half
    for i in range(pointer.size - 1):
        strain = 0.0
        force = 0.0
        for k in range(pointer[i], pointer[i + 1]):
            strain += value[k] * state[column[k]]
            force += value[k] * state[half + column[k]]
        rates[at + i] = force
        rates[at + half + i] = strain


@finish.register(Assembled)
def _finish(operator, rates, at):  # type: ignore[no-untyped-def]
    factor = operator.factor
    bandwidth, nodes = factor.shape[0] - 1, factor.shape[1]
    for begin in (at, at + operator.half):
        for i in range(nodes):
            total = rates[begin + i]
            for k in range(1, min(bandwidth, i) + 1):
                total -= factor[k, i - k] * rates[begin + i - k]
            rates[begin + i] = total / factor[0, i]
        for i in range(nodes - 1, -1, -1):
            total = rates[begin + i]
            for k in range(1, min(bandwidth, nodes - 1 - i) + 1):
                total -= factor[k, i] * rates[begin + i + k]
            rates[begin + i] = total / factor[0, i]


def sample_cells(degree: int, cells: int) -> int:
    """Cells of the line that represents a layer of `cells`: with more, the limit changes by less than the margin."""
    return min(cells, max(6, _SAMPLE_NODES // degree))


@cache
def _courant_limit(degree: int, mass: str, cells: int) -> float:
    """Longest stable dt/h (h the length of an element in travel time) of a layer of `cells`."""
    _, norm, slope = assemble_layer(cells, degree, mass)
    inverse = np.linalg.inv(norm.toarray())
    spectrum = line_spectrum(inverse @ slope.toarray(), inverse[:, 0])
    return MARGIN * longest_step(spectrum, method_for(ELEMENTS, degree)) * cells


class FiniteElement(MethodOfLines):
    """`scene` by elements whose degree is the number (1 to 16), with `mass` "lumped" or "consistent". Raises SceneError for
    another mass, or naming the viscosity that it does not honour."""

    family = ELEMENTS
    mass: str

    def __init__(
        self, scene: Scene, number: int | None = None, cells: int | None = None, mass: str = "lumped", **march: Unpack[Marching]
    ) -> None:
        if mass not in MASSES:
            raise SceneError(f"mass = {mass!r}: must be one of {', '.join(MASSES)}")
        if mass == "consistent" and any(isinstance(s.viscosity, KelvinVoigtViscosity) for s in scene.slabs):
            raise SceneError(
                'mass = "consistent": cannot honour Kelvin-Voigt viscosity; fem with mass = "lumped", dg and sbp can'
            )
        self.mass = mass
        super().__init__(scene, number, cells, **march)

    def grid_of(self, sections: Sequence[Section]) -> BlockGrid:
        """As `MethodOfLines`."""
        return mesh_grid(sections, self.number, self.mass)

    def elastic_limit(self) -> float:
        """As `MethodOfLines`."""
        degree = self.number
        limits = (_courant_limit(degree, self.mass, sample_cells(degree, s.cells)) * s.length / s.cells for s in self.sections)
        return min(limits)

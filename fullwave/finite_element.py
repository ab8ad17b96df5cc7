"""Finite elements assembled by scikit-fem: velocity and stress both continuous and of degree P, weak conditions at the faces.

Galerkin for the pair w_t = s_x, s_t = w_x in one layer, with the characteristic states w* at its ends:

    M w' = Q s + (w* - w)_ends,    M s' = Q w +- (w* - w)_ends,    Q_ij = integral of phi_i phi_j',   Q + Q^T = ends only,

so the energy w.M w + s.M s changes through the ends only, as in every family. Elements P1 and P2 are scikit-fem's, the others are
Lagrange polynomials on Gauss-Lobatto nodes. M is computed by quadrature in those nodes, which makes it diagonal, and positive at
every degree (spectral elements, Komatitsch and Vilotte, Bull. Seismol. Soc. Am. 88, 1998); P1 is the same scheme as sbp:2. A
layer is one mesh; two layers are coupled through upwind states. Energy never grows, because the penalties at the ends dissipate.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse
import skfem
from numpy.typing import NDArray
from skfem.element import ElementH1
from skfem.refdom import RefLine

from fullwave.families import ELEMENTS
from fullwave.lines.blocks import Block, BlockGrid, Section, padded_half
from fullwave.lines.march import MethodOfLines
from fullwave.lines.system import apply
from fullwave.lobatto import gauss_lobatto
from slipwave.observe.pieces import Array, interpolation_matrix, lagrange_basis

_SAMPLE_NODES = 56  # of the longest line from which a step limit is computed; LAPACK takes three times as long beyond 75


class _ElementLineGLL(ElementH1):  # type: ignore[misc]
    """Lagrange polynomials of degree >= 1 on the Gauss-Lobatto nodes of the reference interval [0, 1]; vertices first, then the
    inner nodes from left to right."""

    nodal_dofs = 1
    refdom = RefLine

    def __init__(self, degree: int) -> None:
        nodes = 0.5 * (gauss_lobatto(degree)[0] + 1.0)
        self.interior_dofs = degree - 1
        self.maxdeg = degree
        self.dofnames = ["u"] * degree
        self._basis = lagrange_basis(nodes)
        self._order = np.concatenate(([0, degree], np.arange(1, degree)))
        self.doflocs = nodes[self._order][:, None]

    def lbasis(self, X: Array, i: int) -> tuple[Array, Array]:  # scikit-fem names X
        """Value and derivative of function `i` at the points X, shape (1, points)."""
        if i > self.maxdeg:
            self._index_error()
        values = interpolation_matrix(self._basis, X.ravel())
        k = self._order[i]
        slopes = values @ self._basis.derivative[:, k]
        return values[:, k].reshape(X.shape[1:]), slopes.reshape(X.shape)


class _Assembled(NamedTuple):
    """Rows of M^-1 Q over all nodes, compressed. The slot of w at node i is i, that of s is `half` + i."""

    pointer: NDArray[np.int64]
    column: NDArray[np.int64]
    value: Array
    half: int


@skfem.BilinearForm  # type: ignore[untyped-decorator]
def _mass(u: Any, v: Any, _: Any) -> Any:
    return u * v


@skfem.BilinearForm  # type: ignore[untyped-decorator]
def _slope(u: Any, v: Any, _: Any) -> Any:
    return u.grad[0] * v


def _assemble_layer(cells: int, degree: int) -> tuple[Array, Array, Any]:
    """Depths of the nodes (n,), sorted, the diagonal of M (n,) and Q (sparse, n by n) of a layer of length 1."""
    mesh = skfem.MeshLine(np.linspace(0.0, 1.0, cells + 1))
    points, weights = gauss_lobatto(degree)
    in_nodes = (0.5 * (points + 1.0)[None, :], 0.5 * weights)
    element = {1: skfem.ElementLineP1, 2: skfem.ElementLineP2}.get(degree, lambda: _ElementLineGLL(degree))
    exact = skfem.Basis(mesh, element(), intorder=2 * degree)
    lumped = skfem.Basis(mesh, element(), quadrature=in_nodes)
    order = np.argsort(exact.doflocs[0])
    mass = _mass.assemble(lumped).diagonal()[order]
    return exact.doflocs[0][order], mass, _slope.assemble(exact).tocsr()[order][:, order]


@apply.register(_Assembled)
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


class FiniteElement(MethodOfLines):
    """`scene` by elements whose degree is the number (1 to 16)."""

    family = ELEMENTS

    @property
    def most_sampled(self) -> int:
        """As `MethodOfLines`."""
        return max(6, _SAMPLE_NODES // self.number)

    def line_of(self, cells: int) -> tuple[Array, Array]:
        """As `MethodOfLines`, with what rounding leaves in entries that are zero: the march does without them."""
        _, mass, slope = _assemble_layer(cells, self.number)
        inverse = 1.0 / mass
        return inverse[:, None] * slope.toarray(), inverse[0] * np.eye(mass.size)[0]

    def grid_of(self, sections: Sequence[Section]) -> BlockGrid:
        """As `MethodOfLines`."""
        layers = [_assemble_layer(section.cells, self.number) for section in sections]
        first = np.cumsum([0] + [depth.size for depth, _, _ in layers])
        half = padded_half(int(first[-1]))
        blocks, slopes = [], []
        for start, section, (depth, mass, slope) in zip(first, sections, layers, strict=False):
            norm = section.length * mass
            slots = start + np.arange(depth.size)
            depths = section.start + section.length * depth
            blocks.append(Block(section, slots, half + slots, depths, norm, (1.0 / norm[0], 1.0 / norm[-1])))
            slopes.append(scipy.sparse.diags_array(1.0 / norm) @ slope)
        rows = scipy.sparse.block_diag(slopes, format="csr")
        rows.data[np.abs(rows.data) < 1e-13 * np.abs(rows.data).max()] = 0.0
        rows.eliminate_zeros()
        operator = _Assembled(rows.indptr.astype(np.int64), rows.indices.astype(np.int64), rows.data, half)
        return BlockGrid(operator, 2 * half, tuple(blocks))

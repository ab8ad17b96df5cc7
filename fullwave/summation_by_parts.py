"""Finite differences with the summation-by-parts property: order 2, 4 or 6 inside, characteristic penalties at the ends.

D = H^-1 Q with Q + Q^T = diag(-1, 0, ..., 0, 1), so that the discrete energy, of norm H, changes through the ends only. Inside, D
is the central difference of order 2m. Near each end 2m + 1 rows (one for order 2) have order 2m - 1, but the solution is of order
2m up to the ends. A diagonal H would be simpler, but would reduce orders 4 and 6 by one and two in the fields (measured 3.2 and
4.1). It is not needed, because media are uniform within a block. Strand, J. Comput. Phys. 110 (1994); penalties in characteristic
variables: Kozdon, Dunham and Nordstrom, J. Sci. Comput. 50 (2012).

The end rows are computed, not copied from a table (`closure`). A layer is one block; two layers are coupled through upwind
states, as are slab and interface. Energy never grows, because the penalties dissipate.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from fullwave.families import BY_PARTS
from fullwave.lines.blocks import Block, BlockGrid, Section, padded_half
from fullwave.lines.march import MethodOfLines, method_for
from fullwave.lines.scheme_limit import MARGIN, line_spectrum, longest_step
from fullwave.lines.system import apply
from fullwave.operators.closure import boundary_closure, central_coefficients, closure_rows
from slipwave.observe.pieces import Array

_SAMPLE_CELLS = 56  # of the longest line from which a step limit is computed; twice as many cells lower it by 0.2 per cent


class Differences(NamedTuple):
    """`first` (blocks + 1,): node at which each block begins; `scale` 1/h per block; central coefficients (3,); end rows (rows,
    columns) of D at h = 1. The slot of w at node i is i, that of s is `half` + i."""

    first: NDArray[np.int64]
    scale: Array
    central: Array
    closure: Array
    half: int


def difference_matrix(order: int, cells: int) -> tuple[Array, Any]:
    """(D, H) on [0, 1] with `cells` cells, both (nodes, nodes), D full and H sparse. For tests and step limits."""
    _, closure = boundary_closure(order)
    central = central_coefficients(order)
    nodes, (rows, columns) = cells + 1, closure.shape
    matrix = np.zeros((nodes, nodes))
    for i in range(rows, nodes - rows):
        for k in range(1, order // 2 + 1):
            matrix[i, i + k], matrix[i, i - k] = central[k - 1], -central[k - 1]
    matrix[:rows, :columns] = closure
    matrix[-rows:, -columns:] = -closure[::-1, ::-1]
    return matrix * cells, difference_norm(order, cells) / cells


def difference_norm(order: int, cells: int) -> Any:
    """H at h = 1: sparse (nodes, nodes), the identity except for a block at each end."""
    norm, _ = boundary_closure(order)
    inside = scipy.sparse.eye_array(cells + 1 - 2 * norm.shape[0])
    return scipy.sparse.block_diag((norm, inside, norm[::-1, ::-1]), format="csr")


@apply.register(Differences)
def _apply(operator, state, rates, at):  # type: ignore[no-untyped-def]
    firsts, scales, central, closure = operator.first, operator.scale, operator.central, operator.closure
    rows, columns = closure.shape
    half = operator.half
    for block in range(scales.size):
        scale = scales[block]
        c1, c2, c3 = scale * central[0], scale * central[1], scale * central[2]
        for source, target in ((0, at + half), (half, at)):
            begin, end = source + firsts[block], source + firsts[block + 1]
            shift = target - source
            for i in range(begin + rows, end - rows):
                rates[i + shift] = c1 * (state[i + 1] - state[i - 1])
            if c2 != 0.0:
                for i in range(begin + rows, end - rows):
                    rates[i + shift] += c2 * (state[i + 2] - state[i - 2])
            if c3 != 0.0:
                for i in range(begin + rows, end - rows):
                    rates[i + shift] += c3 * (state[i + 3] - state[i - 3])
            for i in range(rows):
                near = far = 0.0
                for j in range(columns):
                    near += closure[i, j] * state[begin + j]
                    far -= closure[i, j] * state[end - 1 - j]
                rates[begin + i + shift] = scale * near
                rates[end - 1 - i + shift] = scale * far


@cache
def _courant_limit(order: int, cells: int) -> float:
    """Longest stable dt/h of a layer of `cells`."""
    matrix, norm = difference_matrix(order, cells)
    lift = np.zeros(norm.shape[0])
    lift[0] = 1.0 / norm[0, 0]
    return MARGIN * longest_step(line_spectrum(matrix, lift), method_for(BY_PARTS, order)) * cells


class SummationByParts(MethodOfLines):
    """`scene` by differences whose order is the number: 2, 4 or 6."""

    family = BY_PARTS

    @property
    def fewest(self) -> int:
        """As `MethodOfLines`: with fewer the rows of both ends would overlap."""
        return 2 * closure_rows(self.number) + self.number // 2 - 1

    def grid_of(self, sections: Sequence[Section]) -> BlockGrid:
        """As `MethodOfLines`."""
        norm, closure = boundary_closure(self.number)
        first = np.cumsum([0] + [section.cells + 1 for section in sections])
        half = padded_half(int(first[-1]))
        blocks = []
        for start, section in zip(first, sections, strict=False):
            h = section.length / section.cells
            slots = start + np.arange(section.cells + 1)
            lift = 1.0 / (h * norm[0, 0])
            depth = section.start + h * (slots - start)
            blocks.append(
                Block(section, slots, half + slots, depth, h * difference_norm(self.number, section.cells), (lift, lift))
            )
        scale = np.array([section.cells / section.length for section in sections])
        return BlockGrid(Differences(first, scale, central_coefficients(self.number), closure, half), 2 * half, tuple(blocks))

    def elastic_limit(self) -> float:
        """As `MethodOfLines`."""
        return min(_courant_limit(self.number, min(s.cells, _SAMPLE_CELLS)) * s.length / s.cells for s in self.sections)

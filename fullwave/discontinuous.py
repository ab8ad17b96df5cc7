"""Discontinuous Galerkin elements of any degree in characteristic (upwind) form: the most accurate full wave.

Each slab is divided into `cells` elements. In each, w and s are polynomials of degree P, stored at the Gauss-Lobatto nodes, which
are also the quadrature points (collocation). The mass matrix is then diagonal, and the step is 1.8 (P = 7) to 2.7 (P = 1) times
as long as with exact mass. Neighbours are coupled only through upwind states (`fullwave.lines.system`). Layers begin and end on
elements, so impedance jumps cost no order. Hesthaven and Warburton, Nodal Discontinuous Galerkin Methods (2008), ch. 3; Kopriva
and Gassner, J. Sci. Comput. 44 (2010), for the collocation. Outputs at the interface are of order up to 2 P + 1. Energy never
grows, because upwind states dissipate.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fullwave.families import GALERKIN
from fullwave.lines.blocks import Block, BlockGrid, Section
from fullwave.lines.march import MethodOfLines
from fullwave.lines.panels import LANES, differentiate_rows
from fullwave.lines.system import apply
from fullwave.lobatto import gauss_lobatto
from slipwave.observe.pieces import Array, lagrange_basis

_ABREAST = LANES // 2  # elements that share a panel: their w, then their s


class _Elements(NamedTuple):
    """Nodes per element, derivative matrix on [-1, 1] (flat), and 2/h per column (width,), 0 in padding columns.

    The w of four elements and then the s of the same four form a panel of eight. The slot of w at node i of element m is
    width i + 8 (m // 4) + m % 4; that of s is 4 more."""

    nodes: int
    derivative: Array
    scale: Array


@apply.register(_Elements)
def _apply(operator, state, rates, at):  # type: ignore[no-untyped-def]
    width = operator.scale.size
    for panel in range(0, width, LANES):
        for i in range(operator.nodes):
            differentiate_rows(
                operator.derivative, i * operator.nodes, operator.nodes, state, panel, width,
                operator.scale, rates, at + i * width + panel,
            )  # fmt: skip


class DiscontinuousGalerkin(MethodOfLines):
    """`scene` by elements whose degree is the number (1 to 24). Explicit steps are of order 8 (of order 4 for degree 1), so that
    they do not limit the order of the elements."""

    family = GALERKIN

    def grid_of(self, sections: Sequence[Section]) -> BlockGrid:
        """As `MethodOfLines`: every cell of every section is one block."""
        nodes, weights = gauss_lobatto(self.number)
        total = sum(section.cells for section in sections)
        width = LANES * -(-total // _ABREAST)
        scale = np.zeros(width)
        rows = width * np.arange(nodes.size)
        blocks: list[Block] = []
        for section in sections:
            length = section.length / section.cells
            lift = 2.0 / (length * weights[0])
            for cell in range(section.cells):
                column = LANES * (len(blocks) // _ABREAST) + len(blocks) % _ABREAST
                scale[[column, column + _ABREAST]] = 2.0 / length
                depth = section.start + length * (cell + 0.5 * (nodes + 1.0))
                norm = 0.5 * length * weights
                blocks.append(Block(section, rows + column, rows + column + _ABREAST, depth, norm, (lift, lift)))
        elements = _Elements(nodes.size, lagrange_basis(nodes).derivative.ravel(), scale)
        return BlockGrid(elements, width * nodes.size, tuple(blocks))

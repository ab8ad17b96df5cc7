"""A correct scheme that is none of ours, for `slipwave verify --family`: finite volumes about the ends of the cells, h inside and
h/2 at both ends of a slab, of order 2. `test_verify_schemes` makes copies of this file with one mistake each."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwave.families import AttackCells, FullWave, Rungs
from fullwave.lines.blocks import Block, BlockGrid, padded_half
from fullwave.lines.march import MethodOfLines
from fullwave.lines.scheme_limit import line_spectrum, longest_step
from fullwave.lines.system import apply
from slipwave.family import ANYTHING

FAMILY = FullWave(
    "vertex",
    f"{__name__}:Vertex",
    "finite volumes",
    honours=ANYTHING - {"kelvin-voigt", "standard-linear"},
    order_interface=lambda p: 2,
    conserves=False,
    ladder={0: Rungs(24, 280, 1e-3)},
    attacks={0: AttackCells(8, 32)},
)


class Volumes(NamedTuple):
    """First node of each block, 1/h of each block, slots of w, share of dissipation."""

    first: NDArray[np.int64]
    scale: NDArray[np.float64]
    half: int
    damping: float


@apply.register(Volumes)
def fluxes(operator, state, rates, at):
    for block in range(operator.scale.size):
        scale = operator.scale[block]
        for source, target in ((0, operator.half), (operator.half, 0)):
            begin, end = source + operator.first[block], source + operator.first[block + 1]
            to, own = at + target - source, target - source
            rates[to + begin] = scale * (state[begin + 1] - state[begin])
            rates[to + end - 1] = scale * (state[end - 1] - state[end - 2])
            for i in range(begin + 1, end - 1):
                rates[to + i] = 0.5 * scale * (state[i + 1] - state[i - 1])
                rates[to + i] += operator.damping * scale * (state[own + i + 1] - 2.0 * state[own + i] + state[own + i - 1])


class Vertex(MethodOfLines):
    family = FAMILY

    def grid_of(self, sections):
        first = np.cumsum([0] + [section.cells + 1 for section in sections])
        half, blocks = padded_half(int(first[-1])), []
        for start, section in zip(first, sections, strict=False):
            h = section.length / section.cells
            slots = start + np.arange(section.cells + 1)
            norm = np.full(section.cells + 1, h)
            norm[[0, -1]] = h / 2
            blocks.append(Block(section, slots, half + slots, section.start + h * (slots - start), norm, (2 / h, 2 / h)))
        scale = np.array([section.cells / section.length for section in sections])
        return BlockGrid(Volumes(first, scale, half, 0.0), 2 * half, tuple(blocks))

    def elastic_limit(self):
        n = 40
        matrix = 0.5 * (np.eye(n + 1, k=1) - np.eye(n + 1, k=-1))
        matrix[0, :2], matrix[-1, -2:] = (-1, 1), (-1, 1)
        lift = np.zeros(n + 1)
        lift[0] = 2.0
        return longest_step(line_spectrum(matrix, lift), self.method) * min(s.length / s.cells for s in self.sections)

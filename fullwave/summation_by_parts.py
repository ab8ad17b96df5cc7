"""Finite differences with the summation-by-parts property: order 2, 4 or 6 inside, characteristic penalties at the ends.

D = H^-1 Q with H diagonal and Q + Q^T = diag(-1, 0, ..., 0, 1), so that the discrete energy changes through the ends only.
Inside, D is the central difference of order 2m; near each end 2m rows (one for order 2) have order m. Energy alone promises order
m + 1 in the solution; 2, 4 and between 5 and 6 are measured.
Strand, J. Comput. Phys. 110 (1994); penalties in characteristic variables: Kozdon, Dunham and Nordstrom (2012).

The end rows are not copied from a table but solved for: H and Q together from the accuracy conditions
Q x^k = k H x^(k-1), k = 0..m, linear in both. What they leave free at order 6 (one number) makes the error of x^(m+1) least.
A layer is one block; two layers meet through upwind states, as slab and interface do.
"""

from functools import cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwave.line import Block, Grid, Section, sections_of
from fullwave.march import March, method_for
from fullwave.stability import MARGIN, line_spectrum, longest_step
from fullwave.system import register_operator
from scene.errors import SceneError
from scene.observe.pieces import Array
from scene.scene import Scene

ORDERS = (2, 4, 6)
_SAMPLE_CELLS = 64  # of the longest line from which a step limit is computed


class Differences(NamedTuple):
    """`first` (blocks + 1,) node at which each block begins, `scale` 1/h per block, central coefficients (3,), end rows (rows,
    columns) of D at h = 1. Slot of w at node i: i; of s: `half` + i."""

    first: NDArray[np.int64]
    scale: Array
    central: Array
    closure: Array
    half: int


def central_coefficients(order: int) -> Array:
    """c_k of u'(0) = sum c_k (u_k - u_-k), k = 1..3 (zero beyond order/2), h = 1."""
    half = order // 2
    powers = 2 * np.arange(half) + 1
    offsets = np.arange(1, half + 1)
    known = np.zeros(half)
    known[0] = 0.5
    return np.concatenate((np.linalg.solve(offsets[None, :] ** powers[:, None].astype(float), known), np.zeros(3 - half)))


@cache
def boundary_closure(order: int) -> tuple[Array, Array]:
    """(H, D) near an end, h = 1: norm of the first `rows` nodes, and those rows of D, shape (rows, rows + order/2)."""
    rows = 1 if order == 2 else order
    unknowns, matrix, known = _accuracy_conditions(order, rows)
    found, _, rank, _ = np.linalg.lstsq(matrix, known, rcond=1e-11)
    solution: Array = np.asarray(found, dtype=np.float64)
    free = np.linalg.svd(matrix)[2][rank:].T
    if free.size:
        _, beyond, wanted = _accuracy_conditions(order, rows, (order // 2 + 1,))
        solution += free @ np.linalg.lstsq(beyond @ free, wanted - beyond @ solution, rcond=None)[0]
    norm: Array = solution[:rows]
    skew = np.zeros((rows, rows))
    for value, (i, j) in zip(solution[rows:], unknowns, strict=True):
        skew[i, j], skew[j, i] = value, -value
    skew[0, 0] = -0.5
    closure: Array = np.hstack((skew, _known_part(order, rows))) / norm[:, None]
    return norm, closure


def _known_part(order: int, rows: int) -> Array:
    """The part of Q that couples the end rows to the interior: its skew symmetry fixes it."""
    central = central_coefficients(order)
    part = np.zeros((rows, order // 2))
    for i in range(rows):
        for j in range(order // 2):
            if 0 < rows + j - i <= order // 2:
                part[i, j] = central[rows + j - i - 1]
    return part


def _accuracy_conditions(
    order: int, rows: int, degrees: tuple[int, ...] | None = None
) -> tuple[list[tuple[int, int]], Array, Array]:
    """Pairs (i, j) of the unknown q_ij, and the linear system in (h_0.., q_ij) that makes D exact for x^k, k in `degrees`."""
    pairs = [(i, j) for i in range(rows) for j in range(i + 1, rows)]
    points = np.arange(rows + order // 2, dtype=float)
    known_part = _known_part(order, rows)
    equations, right = [], []
    for degree in range(order // 2 + 1) if degrees is None else degrees:
        powers = points**degree
        slope = degree * points ** max(degree - 1, 0)
        for i in range(rows):
            row = np.zeros(rows + len(pairs))
            row[i] = -slope[i]
            for q, (a, b) in enumerate(pairs):
                row[rows + q] = powers[b] * (a == i) - powers[a] * (b == i)
            equations.append(row)
            right.append(-float(known_part[i] @ powers[rows:]) + 0.5 * powers[0] * (i == 0))
    return pairs, np.array(equations), np.array(right)


def difference_matrix(order: int, cells: int) -> tuple[Array, Array]:
    """(D, H) on [0, 1] with `cells` cells: (nodes, nodes) and (nodes,). For tests and step limits; the march never forms it."""
    norm, closure = boundary_closure(order)
    central = central_coefficients(order)
    nodes, (rows, columns) = cells + 1, closure.shape
    matrix = np.zeros((nodes, nodes))
    for i in range(nodes):
        for k in range(1, order // 2 + 1):
            if rows <= i < nodes - rows:
                matrix[i, i + k], matrix[i, i - k] = central[k - 1], -central[k - 1]
    matrix[:rows, :columns] = closure
    matrix[-rows:, -columns:] = -closure[::-1, ::-1]
    weights = np.ones(nodes)
    weights[:rows], weights[-rows:] = norm, norm[::-1]
    return matrix * cells, weights / cells


def fewest_cells(order: int) -> int:
    """Cells that keep the two ends' rows apart."""
    return 2 * (1 if order == 2 else order) + order // 2


def difference_grid(sections: list[Section], order: int) -> Grid:
    """Every section as one block."""
    norm, closure = boundary_closure(order)
    first = np.cumsum([0] + [section.cells + 1 for section in sections])
    half = -(-int(first[-1]) // 4) * 4
    blocks = []
    for start, section in zip(first, sections, strict=False):
        h = section.length / section.cells
        slots = start + np.arange(section.cells + 1)
        weights = np.full(slots.size, h)
        weights[: norm.size], weights[-norm.size :] = h * norm, h * norm[::-1]
        lift = 1.0 / weights[0]
        blocks.append(Block(section, slots, half + slots, section.start + h * (slots - start), weights, (lift, lift)))
    scale = np.array([section.cells / section.length for section in sections])
    return Grid(Differences(first, scale, central_coefficients(order), closure, half), 2 * half, tuple(blocks))


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


register_operator(Differences, _apply)


@cache
def courant_limit(order: int, cells: int = _SAMPLE_CELLS) -> float:
    """Longest stable dt/h of a layer of `cells`; beyond 64 of them it changes by less than the margin of a hundredth."""
    matrix, weights = difference_matrix(order, min(cells, _SAMPLE_CELLS))
    lift = np.zeros(weights.size)
    lift[0] = 1.0 / weights[0]
    return MARGIN * longest_step(line_spectrum(matrix, lift), method_for(order)) * min(cells, _SAMPLE_CELLS)


class SummationByParts(March):
    """`scene` by differences of `order` 2, 4 or 6 with `cells` per slab; `cfl` is the share (0, 1] of the longest stable step.

    Raises SceneError naming the option and its allowed range.
    """

    cfl_max = 1.0
    exact_when = "never: the error falls as h^2, h^4, h^5"
    conserves = "nothing; the penalties dissipate at the order of the scheme, so that energy never grows"

    def __init__(self, scene: Scene, order: int = 4, cells: int = 64, cfl: float = 0.9) -> None:
        if order not in ORDERS:
            raise SceneError(f"order = {order!r}: must be 2, 4 or 6")
        self.order_bulk = order
        self.order_interface = min(order, 5)
        sections = sections_of(scene, cells, fewest_cells(order))
        build = partial(difference_grid, order=order)
        limit = min(courant_limit(order, min(s.cells, _SAMPLE_CELLS)) * s.length / s.cells for s in sections)
        super().__init__(scene, f"sbp:{order}", build, sections, method_for(order), limit, cfl)

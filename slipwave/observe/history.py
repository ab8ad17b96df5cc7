"""Keeps the pieces of a window of a run and evaluates the interface's motion at any time in it; memory grows with the window."""

from collections.abc import Sequence

import numpy as np

from slipwave.compiled import njit
from slipwave.friction import Law, rates, resampled
from slipwave.observe.pieces import SAME, Array, Basis, Pieces, empty_pieces, interpolation_matrix, lagrange_basis


class HistoryObserver:
    """Keeps the pieces that touch the window from `start` to `end` (transits).

    Samples are tables of shape (5, samples): time (transits), rate unknown z, psi, mu and y.
    """

    def __init__(self, law: Law, nodes: Array, start: float = 0.0, end: float = np.inf) -> None:
        self._law, self._basis = law, lagrange_basis(nodes)
        self._start, self._end = start, end
        self._kept: list[Pieces] = []

    def scan(self, pieces: Pieces) -> None:
        """Keep those of the next pieces that touch the window."""
        touching = (pieces.time + pieces.length >= self._start) & (pieces.time <= self._end)
        if touching.any():
            self._kept.append(pieces.part(touching))

    def forget(self, before: float) -> None:
        """Let the window begin at `before` (transits) from now on."""
        self._start = before
        late = [part.time + part.length >= before for part in self._kept]
        parts = zip(self._kept, late, strict=True)
        self._kept = [part.part(some) for part, some in parts if some.any()]

    def __len__(self) -> int:
        return len(self._kept)

    def samples(self, per_piece: int | None = None) -> Array:
        """The window at the nodes of its pieces, or at `per_piece` equally spaced points of each piece's polynomial."""
        pieces = self.pieces()
        points = self._basis.nodes if per_piece is None else (np.arange(per_piece) + 0.5) / per_piece
        rows = interpolation_matrix(self._basis, points)
        time = pieces.time[:, None] + pieces.length[:, None] * points
        inside = (time >= self._start) & (time <= self._end)
        z = resampled(self._law, pieces.z, pieces.psi, lambda nodal: nodal @ rows.T)
        return np.stack([values[inside] for values in (time, z, *(values @ rows.T for values in pieces[3:]))])

    def at(self, times: Array) -> Array:
        """Samples at `times` (transits) within the window, from the pieces' polynomials."""
        return np.stack([times, *values_at(self.pieces(), self._basis, times, self._law)])

    def columns(self) -> dict[str, Array]:
        """time (transits), slip_rate (V*), psi, stress, elastic_stress at the nodes: arrays of equal length."""
        return named_columns(self._law, self.samples())

    def pieces(self) -> Pieces:
        """The kept pieces."""
        if len(self._kept) != 1:
            parts = self._kept or [empty_pieces(0, self._basis.nodes.size)]
            self._kept = [Pieces.joined(parts)]
        return self._kept[0]

    def state(self) -> dict[str, Array]:
        """The pieces, a row each, for a checkpoint."""
        return {"pieces": np.column_stack(self.pieces())}

    def restore(self, state: dict[str, Array]) -> None:
        """Continue from what `state` returned."""
        time, length, *values = np.split(state["pieces"], [1, 2, *(2 + np.arange(1, 4) * self._basis.nodes.size)], axis=1)
        self._kept = [Pieces(time[:, 0], length[:, 0], *values)] if time.size else []


def named_columns(law: Law, samples: Sequence[Array] | Array) -> dict[str, Array]:
    """Samples by name, with the slip rate (V*) instead of the rate unknown."""
    time, z, psi, mu, y = samples
    return {"time": time, "slip_rate": rates(law, z), "psi": psi, "stress": mu, "elastic_stress": y}


def values_at(pieces: Pieces, basis: Basis, times: Array, law: Law = None) -> list[Array]:
    """z, psi, mu and y at `times` (transits); where two pieces meet, the values at the end of the earlier one. `law`: of the
    motion, if v may change its sign. Raises ValueError for a time more than half a piece outside `pieces`."""
    which = np.maximum(pieces.time.searchsorted(times - SAME) - 1, 0)
    outside = np.abs(times - pieces.time[which] - 0.5 * pieces.length[which]) > pieces.length[which]
    if outside.any():
        raise ValueError(f"no piece contains t = {times[outside][0]:.9g} transits")
    points = np.minimum(1.0, (times - pieces.time[which]) / pieces.length[which])
    return evaluated([values[which] for values in pieces[2:]], basis, points, law)


def evaluated(nodal: Sequence[Array] | Array, basis: Basis, points: Array, law: Law) -> list[Array]:
    """z, psi, mu and y at `points` (m,) of pieces with these `nodal` values, (m, n), or (1, n) of a single piece; `law` as for
    `values_at`."""
    at = np.ascontiguousarray(points, dtype=float)

    def _sample(*values: Array) -> Array:
        sampled = np.empty((len(values), at.size, 1))
        _interpolate(basis.nodes, basis.weights, at, np.array(values), sampled)
        return sampled

    z, *others = nodal
    z = resampled(law, z, others[0], lambda values: _sample(values)[0])
    return [values[:, 0] for values in (z, *_sample(*others))]


@njit
def _interpolate(nodes: Array, weights: Array, points: Array, nodal: Array, sampled: Array) -> None:
    """`sampled` (k, m, 1): at its one of the `points` (m,), each row of `nodal` (k, m, n), or its only one, by the second
    barycentric formula (Berrut and Trefethen 2004)."""
    for i in range(points.size):
        row, total, hit = min(i, nodal.shape[1] - 1), 0.0, -1
        sampled[:, i, 0] = 0.0
        for n in range(nodes.size):
            gap = points[i] - nodes[n]
            if gap == 0.0:
                hit = n
                break
            total += weights[n] / gap
            for k in range(len(nodal)):
                sampled[k, i, 0] += weights[n] / gap * nodal[k, row, n]
        for k in range(len(nodal)):
            sampled[k, i, 0] = nodal[k, row, hit] if hit >= 0 else sampled[k, i, 0] / total

"""Keeps the interface's history for those who asked for it (record = ["interface"]); memory grows with the run."""

from collections.abc import Sequence

import numpy as np

from slipwave.friction import Law, rate_of
from slipwave.observe.pieces import Array, Pieces


class HistoryObserver:
    """Collects time, ln|v|, psi, mu and y at the nodes of every piece between `start` and `end` (transits)."""

    def __init__(self, law: Law, nodes: Array, start: float = 0.0, end: float = np.inf) -> None:
        self._law = law
        self._nodes = np.asarray(nodes)
        self._window = (start, end)
        self._chunks: list[tuple[Array, ...]] = []

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        start, end = self._window
        if pieces.time[-1] + pieces.length[-1] < start or pieces.time[0] > end:
            return
        times = pieces.time[:, None] + pieces.length[:, None] * self._nodes
        keep = (times >= start) & (times <= end)
        self._keep(tuple(a[keep] for a in (times, pieces.z, pieces.psi, pieces.mu, pieces.y)))

    def _keep(self, columns: tuple[Array, ...]) -> None:
        self._chunks.append(columns)

    def state(self) -> dict[str, Array]:
        """Everything collected, as arrays, for a checkpoint."""
        columns = [np.concatenate(part) for part in zip(*self._chunks, strict=True)]
        return {"columns": np.array(columns) if columns else np.empty((5, 0))}

    def restore(self, state: dict[str, Array]) -> None:
        """Go on from what `state` returned."""
        self._chunks = [tuple(state["columns"])] if state["columns"].size else []

    def columns(self) -> dict[str, Array]:
        """time (transits), slip_rate (V*), psi, stress, elastic_stress: arrays of equal length."""
        columns = [np.concatenate(part) for part in zip(*self._chunks, strict=True)] if self._chunks else [np.empty(0)] * 5
        return named_columns(self._law, columns)


def named_columns(law: Law, columns: Sequence[Array]) -> dict[str, Array]:
    """Time, rate unknown, psi, mu and y by name, with the slip rate (V*) in place of the unknown."""
    time, unknown, psi, stress, elastic = columns
    rate = np.array([rate_of(law, z) for z in unknown], dtype=float)
    return {"time": time, "slip_rate": rate, "psi": psi, "stress": stress, "elastic_stress": elastic}

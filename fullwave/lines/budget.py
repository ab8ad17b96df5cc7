"""Limits on the cost of a grid: its memory, counted before it is allocated, and the work between two points of interruption."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from fullwave.lines.blocks import BlockGrid, Section
from fullwave.options import CellsRefused

MOST_BYTES = 4e9
"""Memory that a solver may use: half of that of a small machine, so that a wrong number of cells is refused before the machine
swaps. On a grid of this size every step takes seconds, so no useful run needs more."""

MOST_UNKNOWNS = 2048
"""Most unknowns of the exact march, whose matrices are dense. Set-up and memory, measured: 0.2 s and 60 MB for 480 unknowns, 1.2
s and 0.25 GB for 1000, 23 s and 1 GB for 2000. In viscous slabs memory stresses count too: 13 s and 0.6 GB for 992 values of the
grid."""

MOST_WORK = 4e8
"""Products of a weight and a value in one call of compiled code, which neither reports progress nor can be interrupted: 0.2 to
0.8 s at the measured 0.5 to 2 products per nanosecond."""

PRODUCTS_PER_SECOND = 2e9
"""Speed of the marches (1.3 to 4e9 measured), for a rough prediction of the time of a run."""

_FEW_CELLS = 2000  # 20 kB each at most, so memory is not counted
_PROBE_CELLS = 16
_BLOCK_BYTES = 1200  # of Python objects for one block, including its joints (measured 1.1 to 1.2 kB)
_ASSEMBLY = 4.0  # copies of a sparse operator in memory during its assembly (measured 3.8 for fem:16)


def steps_at_once(work: float) -> int:
    """Steps of `work` products each in one call of compiled code; at least one."""
    return max(1, int(MOST_WORK / max(work, 1.0)))


@contextmanager
def enough_memory(cells: int) -> Iterator[None]:
    """Context that raises SceneError naming cells if memory runs out."""
    try:
        yield
    except MemoryError:
        raise CellsRefused(f"cells = {cells}: not enough memory on this machine; use fewer") from None


def require_memory(
    sections: Sequence[Section], build: Callable[[Sequence[Section]], BlockGrid], stages: int, viscous: bool
) -> None:
    """Raises SceneError naming cells, and the most that fit, if the march of `sections` would take more than MOST_BYTES.

    The count is exact for the stages and the arrays of the blocks, and within a third of measured values for the rest."""
    total = sum(section.cells for section in sections)
    if total <= _FEW_CELLS:
        return
    start = sections[0]
    few, more = (start._replace(cells=max(start.fewest, _PROBE_CELLS) + extra) for extra in (0, _PROBE_CELLS))
    grown = _bytes(build([more]), stages, viscous) - _bytes(build([few]), stages, viscous)
    require_bytes(start.asked, total * grown / _PROBE_CELLS)


def require_bytes(cells: int, needed: float) -> None:
    """Raises SceneError naming `cells`, and the most that fit, if `needed` is more than MOST_BYTES."""
    if needed > MOST_BYTES:
        most = int(float(f"{0.995 * cells * MOST_BYTES / needed:.2g}"))
        raise CellsRefused(
            f"cells = {cells}: would take {needed / 1e9:.1f} GB of memory, more than the {MOST_BYTES / 1e9:g} GB allowed; "
            f"at most some {most} fit"
        )


def require_few_unknowns(cells: int, unknowns: int) -> None:
    """Raises SceneError naming `cells`, and the most that are allowed, if dense matrices of `unknowns` rows would be too big."""
    if unknowns > MOST_UNKNOWNS:
        most = int(0.95 * cells * MOST_UNKNOWNS / unknowns)  # panels and layers are filled up
        raise CellsRefused(
            f"cells = {cells}: {unknowns} unknowns, more than the {MOST_UNKNOWNS} that the exact march allows (its matrices are "
            f"dense); use at most some {most} cells, or --time explicit"
        )


def _bytes(grid: BlockGrid, stages: int, viscous: bool) -> float:
    """Memory of a march of `grid`: `stages` and two copies of its state, the blocks and the operator."""
    copies = (stages + 2.0) * (2.0 if viscous else 1.0) + (6.0 if viscous else 0.0)
    blocks = sum(_BLOCK_BYTES + sum(_held(part) for part in block) for block in grid.blocks)
    return 8.0 * copies * grid.size + blocks * (2.0 if viscous else 1.0) + _ASSEMBLY * sum(_held(part) for part in grid.operator)


def _held(part: Any) -> float:
    """Bytes of an array or of a sparse matrix; 0 for anything else."""
    if isinstance(part, np.ndarray):
        return float(part.nbytes)
    if hasattr(part, "indptr"):
        return float(part.data.nbytes + part.indices.nbytes + part.indptr.nbytes)
    return 0.0

"""Write a solved collocation step as a piece of the interface's motion."""

from slipwave.compiled import inlined
from slipwave.observe.pieces import Array, Pieces
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Impedance, others, own
from slipwave.step.rows import DRIVE, PREVIOUS, RATE, STATE, UNKNOWN


@inlined
def emit(
    nodes: Nodes,
    stiffness: float,
    impedance: Impedance,
    start: float,
    length: float,
    integral: Array,
    incoming: Array,
    i: int,
    guess: Array,
    work: Array,
    elastic: float,
    pieces: Pieces,
    k: int,
) -> float:
    """Piece k <- the step that begins at `start`, with the stress S - K v and the elastic stress y' = stiffness (V - v), V in
    work[DRIVE]. `elastic` is y at the step's start; returns y at its end."""
    s = len(nodes)
    pieces.time[k] = start
    pieces.length[k] = length
    for j in range(s):
        pieces.z[k, j] = guess[UNKNOWN, j]
        pieces.psi[k, j] = guess[STATE, j]
        pieces.mu[k, j] = incoming[i, j] - own(impedance, j) * work[RATE, j] - others(impedance, nodes, j, work)
        work[PREVIOUS, j] = elastic
    for m in range(s):
        factor = length * stiffness * (work[DRIVE, m] - work[RATE, m])
        for j in range(s):
            work[PREVIOUS, j] += integral[m, j] * factor
    for j in range(s):
        pieces.y[k, j] = work[PREVIOUS, j]
    return float(work[PREVIOUS, s - 1])

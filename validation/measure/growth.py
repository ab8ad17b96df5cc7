"""Growth rate of a small disturbance, measured in a run."""

import dataclasses

import numpy as np
from scipy.interpolate import CubicSpline

from slipwave.observe import HistoryObserver
from slipwave.scene import Scene
from slipwave.scene.drive import Start
from slipwave.solve import Solver, follow

BEFORE, AFTER = 60.0, 160.0
STEP = 0.25


def nudged(scene: Scene, size: float = 1e-4) -> Scene:
    """`scene` with a nudge so small that its motion is linear."""
    return dataclasses.replace(scene, start=Start(size=size))


def measured_root(solver: Solver) -> complex:
    """Slow root s per transit of x = psi - psi_ss between BEFORE and AFTER, `solver` starting from a small nudge: by fitting
    x(t + 2h) - 2 e^(sigma h) cos(omega h) x(t + h) + e^(2 sigma h) x(t) = 0."""
    history = HistoryObserver(solver.scene.law, solver.nodes, BEFORE, AFTER)
    follow(solver, AFTER, [history])
    columns = history.columns()
    times, first = np.unique(columns["time"], return_index=True)
    grid = np.arange(BEFORE + 2.0, AFTER - 2.0, STEP)
    x = CubicSpline(times, columns["psi"][first] - solver.scene.steady_psi)(grid)
    gap = round(8.0 / STEP)
    rows = np.column_stack([x[gap:-gap], x[: -2 * gap]])
    twice_cosine, product = np.linalg.lstsq(rows, x[2 * gap :], rcond=None)[0]
    roots = np.roots([1.0, -twice_cosine, -product])
    return complex(np.log(roots[np.argmax(roots.imag)])) / (gap * STEP)

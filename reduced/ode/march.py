"""Marches any ODE reduction of a slab pair (MODEL.md section 3), all with the same stiff integrator."""

import math
from functools import lru_cache
from typing import Any

import numpy as np

from reduced.ode.port import ReducedPort
from reduced.ode.reduction import Reduction
from reduced.ode.step_tables import impedance_at, step_port
from slipwave.observe.ledger import Energy
from slipwave.observe.pieces import SAME, Pieces
from slipwave.observe.restoring import tables
from slipwave.observe.solver import State
from slipwave.scene import Scene
from slipwave.step.collocation import radau
from slipwave.step.stepper import Stepper

STAGES = 8
LONGEST = 2.0
"""Longest step (transits)."""

_LEVELS = 32
_FIRST = 0.125


class ReducedModel:
    """Marches `reduction` of the scene's slab pair to `tolerance`, the requested relative error of the cycle's figures.

    Radau IIA with 8 nodes (order 15 at step ends, L-stable), step lengths 2 / 2^level transits. Knots of the drive cause kinks of
    the motion; between two knots, step lengths are their distance over powers of two, so that a step ends on each. `failures`
    counts unconverged solves; a step that cannot be solved at the shortest length raises NumericsError naming time and scene (a
    quasi-static model runs away).
    """

    failed_at = math.nan
    failures = 0
    seconds_per_piece = 2e-6  # 1.2 to 2.4 measured
    transits_per_piece = math.nan

    def __init__(self, scene: Scene, reduction: Reduction, tolerance: float = 1e-9, stages: int = STAGES) -> None:
        self.scene, self.model, self.reduction = scene, reduction.name, reduction
        self.settings: dict[str, Any] = {"tolerance": tolerance, "stages": stages}
        modes = len(reduction.frequencies) + len(reduction.relaxations)
        self._modes, self._face = np.zeros((modes, 2)), np.array([scene.steady_stress, scene.velocity])
        self._stages = stages
        reason = "nothing limits its slip rate: it runs away" if reduction.runs_away else ""
        self._stepper = Stepper(scene, self.model, self, stages, tolerance, LONGEST, _FIRST, reason)
        self.nodes = self._stepper.nodes

    def port(self, longest: float) -> ReducedPort:
        """As `Ports`."""
        blank = _blank_port(self.reduction, self.scene.upper.epsilon, self._stages, longest)
        return blank._replace(modes=self._modes, face=self._face)

    def prepare(self, port: ReducedPort, level: int) -> None:
        """As `Ports`: all tables are made at once."""

    def resistance(self, port: ReducedPort, level: int, growth: float) -> float:
        """As `Ports`."""
        return self.scene.upper.epsilon * float(impedance_at(self.reduction, growth / port.length[[level]])[0])

    def next_break(self, time: float) -> float:
        """As `Ports`: the knots of the drive."""
        return min((knot for knot in self.scene.drive.knots if knot > time + SAME), default=math.inf)

    @property
    def time(self) -> float:
        """Transits since the start."""
        return self._stepper.time

    @property
    def iterations(self) -> int:
        """Newton iterations so far."""
        return self._stepper.iterations

    def energy(self) -> Energy | None:
        """None: a reduction's energy is not that of the slabs."""
        return None

    def advance(self, until: float) -> Pieces:
        """March to `until`, or at most one step beyond, but at most one chunk; see `Solver`."""
        return self._stepper.advance(until)

    def state(self) -> State:
        """As `Solver`: what the `Stepper` keeps, with `modes` and `face` of the port."""
        return self._stepper.state() | {"modes": self._modes.copy(), "face": self._face.copy()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        own = {"modes": self._modes, "face": self._face}
        saved = tables(state, {name: array.shape for name, array in own.items()}, self.model)
        self._stepper.restore(state)
        for name, array in own.items():
            array[...] = saved[name]


@lru_cache(maxsize=64)
def _blank_port(reduction: Reduction, epsilon: float, stages: int, longest: float) -> ReducedPort:
    return step_port(reduction, epsilon, radau(stages), _LEVELS, longest)

"""Marches any ODE reduction of a slab pair (MODEL.md section 3), all with the same stiff integrator."""

import math
from functools import cache, lru_cache
from typing import Any

import numpy as np

from reduced.ode.kernel import (
    ELASTIC,
    PSI,
    RATE,
    SAME,
    SPRING,
    TIME,
    UNKNOWN_END,
    Limits,
    ReducedMemory,
    Rule,
    march_ladder,
)
from reduced.ode.reduction import Reduction
from reduced.ode.step_tables import LONGEST, Tables, impedance_at, prediction_tables, step_tables
from reduced.step.collocation import Collocation, growth_limit, highest_coefficient, radau
from slipwave.errors import NumericsError
from slipwave.friction import rate_of, unknown_of
from slipwave.observe.ledger import Energy
from slipwave.observe.pieces import Pieces, empty_pieces
from slipwave.observe.restoring import tables, whole_numbers
from slipwave.observe.solver import State
from slipwave.scene import Scene

STAGES = 6
_CHUNK = 2048
_LEVELS = 32
_FIRST_LEVEL = 4


class ReducedModel:
    """Marches `reduction` of the scene's slab pair to `tolerance`, the requested relative error of the cycle's figures.

    Radau IIA with 6 nodes (order 11 at step ends, L-stable), step lengths 2 / 2^level transits. Knots of the drive cause kinks of
    the motion; between two knots, step lengths are their distance over powers of two, so that a step ends on each. `failures`
    counts unconverged solves; a step that cannot be solved at the shortest length raises NumericsError naming time and scene (a
    quasi-static model runs away).
    """

    failed_at = math.nan
    seconds_per_piece = 2e-6  # 1.2 to 2.4 measured
    transits_per_piece = math.nan

    def __init__(self, scene: Scene, reduction: Reduction, tolerance: float = 1e-9, stages: int = STAGES) -> None:
        self.scene, self.model = scene, reduction.name
        self.settings: dict[str, Any] = {"tolerance": tolerance, "stages": stages}
        self.failures = 0
        self.iterations = 0
        rule, self._rule, self._shape = _rule(stages)
        self.nodes = rule.nodes
        self._reduction, self._tolerance = reduction, tolerance
        self._memory = self._begin(stages)
        self._take_stretch(0.0, None)

    def _begin(self, stages: int) -> ReducedMemory:
        """Memory at the start: steady sliding, psi displaced if the start is a jump. Without mass the rate then jumps too."""
        scene = self.scene
        now = np.empty(6)
        now[TIME], now[PSI] = 0.0, scene.steady_psi + scene.start.jump_size
        now[SPRING], now[ELASTIC] = scene.steady_stress / scene.upper.epsilon, scene.steady_stress
        now[RATE], now[UNKNOWN_END] = scene.velocity, unknown_of(scene.law, scene.velocity)
        guess = np.repeat([[now[PSI]], [now[UNKNOWN_END]]], stages, axis=1)
        return ReducedMemory(
            np.zeros((len(self._reduction.frequencies) + len(self._reduction.relaxations), 2)),
            guess,
            now,
            np.array([_FIRST_LEVEL]),
        )

    @property
    def time(self) -> float:
        """Transits since the start."""
        return float(self._memory.now[TIME])

    def energy(self) -> Energy | None:
        """None: a reduction's energy is not that of the slabs."""
        return None

    def advance(self, until: float) -> Pieces:
        """March to `until`, or at most one step beyond, but at most one chunk; see `Solver`."""
        pieces = empty_pieces(_CHUNK, self.nodes.size)
        if self.time > self._stop - SAME:
            self._take_stretch(self._stop, float(self._tables.length[self._memory.level[0]]))
        steps, iterations, verdict = march_ladder(
            self._shape,
            self.scene.law,
            self.scene.upper.epsilon,
            self.scene.forcing,
            self.scene.drive.compiled,
            self._tables,
            self._rule,
            self._memory,
            until,
            self._stop,
            self._limits,
            pieces,
        )
        self.iterations += iterations
        if verdict and steps == 0:
            now = self._memory.now
            rate = rate_of(self.scene.law, float(now[UNKNOWN_END]))
            raise NumericsError(
                f"{self.model}: no step is short enough at t = {now[TIME]:.6g} transits, v = {rate:.3g} V*, psi = {now[PSI]:.4g}"
                f"{' (nothing limits its slip rate: it runs away)' if self._reduction.runs_away else ''}"
                f" (scene {self.scene.name!r}, digest {self.scene.digest})"
            )
        return Pieces(*(array[:steps] for array in pieces))

    def state(self) -> State:
        """As `Solver`: modes, guess and present state (`ReducedMemory`); `stretch`: the time from which the present tables of
        steps hold; `counts`: level of the next step, failures, iterations."""
        memory = self._memory
        return {
            "counts": np.array([memory.level[0], self.failures, self.iterations], dtype=float),
            "stretch": np.array([self._stretch]),
            "modes": memory.modes.copy(),
            "guess": memory.guess.copy(),
            "now": memory.now.copy(),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        level, failures, iterations = whole_numbers(state, "counts", (0, 0, 0))
        own = {"modes": self._memory.modes, "guess": self._memory.guess, "now": self._memory.now}
        shapes = {name: array.shape for name, array in own.items()}
        saved = tables(state, {"stretch": (1,), **shapes}, self.model)
        self._take_tables(float(saved["stretch"][0]))
        self.failures, self.iterations = failures, iterations
        self._memory = ReducedMemory(saved["modes"], saved["guess"], saved["now"], np.array([min(level, _LEVELS - 1)]))

    def _take_stretch(self, begin: float, before: float | None) -> None:
        """Begin a stretch between knots at `begin` (transits), with steps about as long as `before`."""
        self._take_tables(begin)
        longest, memory = float(self._tables.length[0]), self._memory
        memory.level[0] = max(0, math.ceil(math.log2(longest / before) - 1e-9)) if before else _FIRST_LEVEL
        memory.now[TIME] = begin

    def _take_tables(self, begin: float) -> None:
        """Take the tables for the steps from `begin` (transits) to the next knot of the drive."""
        knots = (knot for knot in self.scene.drive.knots if knot > begin + SAME)
        self._stretch, self._stop = begin, min(knots, default=math.inf)
        distance, stages = self._stop - begin, self.nodes.size
        longest = LONGEST if math.isinf(distance) else distance / 2 ** max(0, math.ceil(math.log2(distance / LONGEST)))
        self._tables = _tables(self._reduction, stages, longest)
        growth = growth_limit(stages, self._tolerance)
        self._limits = Limits(
            max(1e-2 * self._tolerance, 1e-14),
            max(self._tolerance ** (stages / (stages + 2.0)), 1e-10),
            growth,
            impedance_at(self._reduction, growth / self._tables.length),
        )


@cache
def _rule(stages: int) -> tuple[Collocation, Rule, tuple[float, ...]]:
    """Collocation rule, its compiled form, and its nodes as a tuple, from which the compiler knows their number."""
    rule = radau(stages)
    tail = highest_coefficient(rule.nodes)
    return rule, Rule(rule.integral, tail, *prediction_tables(rule, (1.0, 2.0))), tuple(float(x) for x in rule.nodes)


@lru_cache(maxsize=64)
def _tables(reduction: Reduction, stages: int, longest: float) -> Tables:
    return step_tables(reduction, radau(stages), _LEVELS, longest)

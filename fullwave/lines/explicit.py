"""The explicit march of a grid: Runge-Kutta steps of fixed length, samples of the interface at their ends; and the time
derivative of a `System`, the right-hand side that every stage of every family evaluates.

`rates` is flat: a stage's values begin at index `at`.
"""

import math

import numpy as np

from fullwave.lines.budget import PRODUCTS_PER_SECOND, enough_memory, steps_at_once
from fullwave.lines.matrix import motion_of
from fullwave.lines.panels import LANES
from fullwave.lines.runge_kutta import RungeKutta, combine_stages, scaled_method
from fullwave.lines.scheme_limit import longest_decay_step
from fullwave.lines.system import (
    ELASTIC,
    FRICTION,
    GRIP,
    INPUT,
    PSI,
    RADIATED,
    SCALARS,
    VISCOUS,
    GridInterface,
    OuterFaces,
    System,
    Traces,
    apply,
    dissipate,
    retard,
    total_stress,
)
from fullwave.sampling import pieces_until
from slipwave.compiled import inlined, njit
from slipwave.errors import NumericsError
from slipwave.friction import respond, unknown_of
from slipwave.friction.interface import solve_interface
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Forcing, nudge_rate, side_of, velocity_at
from slipwave.solve import State, take_back, whole_numbers
from slipwave.step.flow import InterfaceState

STEPS_PER_PIECE = 8
"""Steps in one piece: its nine samples make a polynomial of degree 8, so observers never limit a scheme of order 8 or less."""

MOST_PIECES = 512
"""Pieces in one chunk, fewer on big grids (`budget.MOST_WORK`): they take some 200 kB, and the cost of leaving compiled code is
shared by 4096 steps."""


@inlined
def _meet_joints(joints: int, traces: Traces, state: Array) -> None:
    """w* - w on both sides of each joint, from continuity of velocity and stress."""
    for near in range(0, 2 * joints, 2):
        far = near + 1
        pull = traces.impedance[far] * traces.arriving[far] - traces.impedance[near] * traces.arriving[near]
        both = traces.impedance[far] * traces.stiffened[far] + traces.impedance[near] * traces.stiffened[near]
        common = pull / both
        traces.jump[near] = common - state[traces.velocity[near]]
        traces.jump[far] = common - state[traces.velocity[far]]


@inlined
def _meet_interface(
    interface: GridInterface, forcing: Forcing, traces: Traces, state: Array, z: float
) -> tuple[float, float, float, int]:
    """Friction solve at the interface: returns (z, v, mu, iterations) and sets w* - w of each slab."""
    first = 2 * interface.joints
    free = forcing.velocity
    for k in range(first, first + interface.sides):
        free += interface.copies * traces.arriving[k] / traces.stiffened[k]
    incoming = forcing.steady_stress + interface.impedance * free
    psi = state[interface.size + PSI]
    z, iterations = solve_interface(interface.law, interface.impedance, incoming, psi, z)
    v = respond(interface.law, z, psi)[0]
    change = interface.impedance * (free - v)
    for k in range(first, first + interface.sides):
        own = (traces.arriving[k] - change / traces.impedance[k]) / traces.stiffened[k]
        traces.jump[k] = own - state[traces.velocity[k]]
    return z, v, forcing.steady_stress + change, iterations


@inlined
def _meet_tops(
    interface: GridInterface,
    forcing: Forcing,
    traces: Traces,
    tops: OuterFaces,
    drive: float,
    state: Array,
    rates: Array,
    at: int,
) -> None:
    """Sets w* - w at the outer faces, each driven at half of `drive`, and the rates of the springs' loads, of heavy faces'
    velocities, of the input and of the radiation."""
    first, load = 2 * interface.joints + interface.sides, interface.size + GRIP
    steady = 0.5 * forcing.velocity
    change = 0.5 * drive - steady
    power = lost = 0.0
    for side in range(interface.sides):
        k = first + side
        arriving, mass = traces.arriving[k], tops.mass[side]
        if mass > 0.0:
            face = state[interface.heavy + side]
        else:
            face = tops.driven[side] * change + tops.yielding[side] * (state[load + side] - arriving)
        slip = change - face
        rates[at + load + side] = tops.spring[side] * slip
        traction = traces.impedance[k] * (arriving + traces.stiffened[k] * face)
        if mass > 0.0:
            pull = traces.impedance[k] * state[load + side] + tops.dashpot[side] * slip
            rates[at + interface.heavy + side] = (pull - traction) / mass
            traction = pull
        power += (forcing.steady_stress + traction) * (0.5 * drive) - tops.dead[side] * forcing.steady_stress * slip
        lost += tops.dashpot[side] * slip * slip
        traces.jump[k] = face - state[traces.velocity[k]]
    scale = interface.copies * forcing.transit
    rates[at + interface.size + INPUT] = scale * power
    rates[at + interface.size + RADIATED] = scale * lost


@inlined
def _rates_of(
    system: System, time: float, middle: float, state: Array, rates: Array, at: int, z: float
) -> tuple[float, float, float, int]:
    """rates[at:] = d state/dt~ at `time` (transits) in a step with this `middle`. Returns (z, mu, state relaxation per transit,
    iterations of the solve)."""
    operator, medium, interface, forcing = system.operator, system.medium, system.interface, system.forcing
    traces, size, ends = system.traces, system.interface.size, system.traces.lift.size
    velocity = velocity_at(system.drive, time, side_of(system.drive, time, middle))
    apply(operator, state, rates, at)
    for k in range(ends):
        stress = total_stress(medium, traces.stress[k], state, rates, at)
        traces.arriving[k] = stress - traces.sign[k] * traces.stiffened[k] * state[traces.velocity[k]]
    _meet_joints(interface.joints, traces, state)
    _meet_tops(interface, forcing, traces, system.tops, velocity, state, rates, at)
    z, v, mu, iterations = _meet_interface(interface, forcing, traces, state, z)
    for k in range(ends):
        rates[at + traces.stress[k]] += traces.sign[k] * traces.lift[k] * traces.jump[k]
    retard(medium, operator, size, state, rates, at)
    for k in range(ends):
        rates[at + traces.velocity[k]] += traces.lift[k] * traces.jump[k]
    rates[at + size + VISCOUS] = interface.copies * forcing.transit * dissipate(medium, size, state, rates, at)
    rates[at + size + FRICTION] = forcing.transit * mu * v
    rates[at + size + ELASTIC] = forcing.stiffness * (velocity - v)
    answer = respond(interface.law, z, state[size + PSI])
    rates[at + size + PSI] = forcing.transit * answer[5] + nudge_rate(forcing.nudge, time)
    return z, mu, forcing.transit * abs(answer[7]), iterations


@njit
def _march_lines(
    system: System,
    method: RungeKutta,
    step: float,
    first: int,
    begin: int,
    end: int,
    values: tuple[Array, Array, Array, Array],
    pieces: Pieces,
    frames: Array,
) -> tuple[int, int, float]:
    """March steps `begin` to `end` (excluded) of those that fill `pieces`, which begin at step number `first`. The step after the
    last piece is evaluated only to record the last sample. `method` is that of steps of this length (`scaled_method`). `frames`,
    if it has rows, receives the state at the beginning of every step. Returns (failed solves, step n of the first one or -1,
    fastest relaxation of the state per transit).

    `values`: all integrated ones, `state` (n,), and z of the last three steps' stages, `unknowns` (3, stages), latest first: a
    parabola through them starts each friction solve, which saves two of four iterations. Scratch: the state of a stage, `trial`
    (n,), and the `rates` of all stages, flat (stages n,)."""
    weight, abscissae = method.weight, method.abscissae
    state, unknowns, trial, rates = values
    unknown, psis, stress, elastic = pieces.z, pieces.psi, pieces.mu, pieces.y
    stages, size, count = method.stages, system.interface.size, pieces.time.size
    failures, failed = 0, -1
    fastest = 0.0
    for n in range(begin, end):
        time = (first + n) * step
        if n < frames.shape[0]:
            for i in range(state.size):
                frames[n, i] = state[i]
        for stage in range(stages):
            combine_stages(weight, stages, stage, state, rates, trial)
            guess = 3.0 * (unknowns[0, stage] - unknowns[1, stage]) + unknowns[2, stage]
            at = stage * state.size
            now, middle = time + abscissae[stage], time + 0.5 * step
            z, mu, relaxation, iterations = _rates_of(system, now, middle, trial, rates, at, guess)
            fastest = max(fastest, relaxation)
            if stage == 0:
                sample = (z, state[size + PSI], mu, state[size + ELASTIC])
                for k in range(max(0, (n - 1) // STEPS_PER_PIECE), min(count, n // STEPS_PER_PIECE + 1)):
                    j = n - STEPS_PER_PIECE * k
                    unknown[k, j], psis[k, j], stress[k, j], elastic[k, j] = sample
                if n == STEPS_PER_PIECE * count:
                    return failures, failed, fastest  # the next call evaluates this step again and counts its failures
            if iterations == 0:
                failures += 1
                failed = n if failed < 0 else failed
            unknowns[2, stage] = unknowns[1, stage]
            unknowns[1, stage] = unknowns[0, stage]
            unknowns[0, stage] = z
        combine_stages(weight, stages, stages, state, rates, state)
    return failures, failed, fastest


def _room(size: int) -> Array:
    """Zeros that begin on a line of the cache, so that no panel of eight lies in two: `dg` takes a tenth less time."""
    room = np.zeros(size + LANES)
    first = -room.ctypes.data // room.itemsize % LANES
    return room[first : first + size]


class ExplicitMarch:
    """Marches `system` of `scene` from `layout` (state_size,), all that is integrated, in equal steps (transits). `work` is the
    number of products in a step and `cells` the requested number, for messages."""

    name = "explicit"
    bookkeeping = frozenset({"counts"})

    def __init__(
        self, scene: Scene, system: System, method: RungeKutta, step: float, values: Array, work: float, cells: int, model: str
    ) -> None:
        self._scene, self._system, self._method, self.step, self._model = scene, system, method, step, model
        self.nodes, self._scaled = np.linspace(0.0, 1.0, STEPS_PER_PIECE + 1), scaled_method(method, step)
        self._unknowns = np.full((3, method.stages), unknown_of(scene.law, scene.velocity))
        self.layout, scratch = _room(values.size), _room(method.stages * values.size)
        self._values = self.layout, self._unknowns, _room(values.size), scratch
        self.begin_from(values)
        self.failures, self.failed_at = 0, math.nan
        self._taken, self._cells, self._work = 0, cells, work
        self._frames, self._keeps_frames = np.empty((0, values.size)), False
        self._stride = steps_at_once(work)

    @property
    def settings(self) -> dict[str, float]:
        """As `Solver`, of the march."""
        return {"step": self.step}

    @property
    def transits_per_piece(self) -> float:
        """Length of the pieces that `advance` returns."""
        return STEPS_PER_PIECE * self.step

    @property
    def seconds_per_piece(self) -> float:
        """Approximate cost of a piece."""
        return STEPS_PER_PIECE * self._work / PRODUCTS_PER_SECOND

    @property
    def time(self) -> float:
        """Time reached, in transits."""
        return self._taken * self.step

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        most = min(MOST_PIECES, max(1, self._stride // STEPS_PER_PIECE))
        pieces = pieces_until(self._taken, self.step, until, STEPS_PER_PIECE, most)
        steps = STEPS_PER_PIECE * pieces.time.size
        with enough_memory(self._cells):
            self._frames = np.empty((self._keeps_frames * (steps + 1), self.layout.size))
        fastest = self._fill(pieces, steps)
        self._taken += steps
        if self.step > longest_decay_step(fastest, self._method):
            raise NumericsError(
                f"{self._model}: before t = {self.time:.6g} transits the frictional state relaxes at {fastest:.4g} per transit, "
                f"too fast for steps of {self.step:.4g}: more cells or a smaller cfl (scene {self._scene.name!r})"
            )
        return pieces

    def _fill(self, pieces: Pieces, steps: int) -> float:
        """March the `steps` of `pieces`, in parts so that the run can be interrupted; returns the state's fastest relaxation."""
        fastest = 0.0
        for begin in range(0, steps + 1, self._stride):
            failures, failed, relaxation = _march_lines(
                self._system,
                self._scaled,
                self.step,
                self._taken,
                begin,
                min(begin + self._stride, steps + 1),
                self._values,
                pieces,
                self._frames,
            )
            if failures and not self.failures:
                self.failed_at = (self._taken + failed) * self.step
            self.failures += failures
            fastest = max(fastest, relaxation)
        return fastest

    def keep_ledger(self) -> None:
        """Does nothing: the energy balance is always integrated with the motion, at hardly any cost."""

    def work_done(self) -> Array:
        """Work of the drive, heat of friction, radiation and viscous heat since t = 0, integrated with the motion."""
        size = self._system.interface.size
        return self.layout[size + INPUT : size + SCALARS]

    def begin_from(self, values: Array) -> None:
        """Set all integrated values."""
        self.layout[:] = values

    def keep_frames(self, interval: float) -> None:
        """Let `frames` return every step: high-order steps are long, and pieces of eight steps too long to show waves."""
        self._keeps_frames = True

    def frames(self) -> list[tuple[float, Array]]:
        """(time, values) at the ends of the steps of the last `advance`, if kept."""
        begin = self._taken - self._frames.shape[0] + 1
        return [((begin + k) * self.step, values) for k, values in enumerate(self._frames) if k]

    def state_at_start(self, values: Array, interface: InterfaceState) -> State:
        """The state, for `restore`, from the `values` that move (`LinearMotion.moving`), at the end of the first piece at or
        beyond `interface.time`."""
        whole = np.zeros_like(self.layout)
        whole[motion_of(self._system).moving] = values
        size = self._system.interface.size
        whole[size + PSI], whole[size + ELASTIC] = interface.psi, interface.elastic
        pieces = math.ceil(interface.time / self.transits_per_piece - 1e-9)
        counts = np.array([STEPS_PER_PIECE * pieces, 0.0])
        return {"counts": counts, "state": whole, "unknowns": np.full_like(self._unknowns, interface.z)}

    def state(self) -> State:
        """As `Solver`; `counts`: steps taken, failures."""
        counts = np.array([self._taken, self.failures], dtype=float)
        return {"counts": counts, "state": self.layout.copy(), "unknowns": self._unknowns.copy()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        taken, failures = whole_numbers(state, "counts", (0, 0))
        take_back({"state": self.layout, "unknowns": self._unknowns}, state, self._model)
        self._taken, self.failures = taken, failures

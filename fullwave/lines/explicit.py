"""The explicit march of a grid: Runge-Kutta steps of fixed length, samples of the interface at their ends."""

import math

import numpy as np

from fullwave.lines.budget import PRODUCTS_PER_SECOND, enough_memory, steps_at_once
from fullwave.lines.kernel import MOST_PIECES, STEPS_PER_PIECE, Integrated, march_lines
from fullwave.lines.matrix import motion_of
from fullwave.lines.panels import LANES
from fullwave.lines.runge_kutta import RungeKutta, scaled_method
from fullwave.lines.scheme_limit import longest_decay_step
from fullwave.lines.system import ELASTIC, FRICTION, INPUT, PSI, RADIATED, VISCOUS, System
from fullwave.sampling import pieces_until
from slipwave.errors import NumericsError
from slipwave.friction import unknown_of
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.solve import State, take_back, whole_numbers
from slipwave.step.flow import InterfaceState


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
        unknowns = np.full((3, method.stages), unknown_of(scene.law, scene.velocity))
        self._values = Integrated(_room(values.size), unknowns, _room(values.size), _room(method.stages * values.size))
        self.layout = self._values.state
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
            failures, failed, relaxation = march_lines(
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

    def work_done(self) -> tuple[float, float, float, float]:
        """Work of the drive, heat of friction, radiation and viscous heat since t = 0, integrated with the motion."""
        scalars = self.layout[self._system.interface.size :]
        return float(scalars[INPUT]), float(scalars[FRICTION]), float(scalars[RADIATED]), float(scalars[VISCOUS])

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
        return {"counts": counts, "state": whole, "unknowns": np.full_like(self._values.unknowns, interface.z)}

    def state(self) -> State:
        """As `Solver`; `counts`: steps taken, failures."""
        counts = np.array([self._taken, self.failures], dtype=float)
        return {"counts": counts, "state": self.layout.copy(), "unknowns": self._values.unknowns.copy()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        taken, failures = whole_numbers(state, "counts", (0, 0))
        take_back({"state": self.layout, "unknowns": self._values.unknowns}, state, self._model)
        self._taken, self.failures = taken, failures

"""The motion of a model over one period as a differentiable map, for computing periodic orbits."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Constant
from slipwave.solve import State
from slipwave.step.collocation import radau
from slipwave.threads import one_thread

_CHANGE = 1e-6  # of the period, relative


class Cycle(NamedTuple):
    """A motion over `period` (transits) from the state `start` (n,) to the state `end` (n,): its `pieces` from t = 0, and the
    `iterations` of Newton's method that its steps took."""

    period: float
    start: Array
    end: Array
    pieces: Pieces
    iterations: int


class Push(NamedTuple):
    """An extra shear stress on the interface and an extra velocity of the drive (V*) in the steps [begin, end) of a march."""

    begin: int = 0
    end: int = 0
    stress: float = 0.0
    drive: float = 0.0

    def parts(self, drive: Constant, steps: int) -> Iterator[tuple[slice, float, Constant]]:
        """The steps before, in and after it, in all `steps`, with the extra stress and V in them."""
        pushed = Constant(drive.velocity + self.drive)
        yield slice(0, self.begin), 0.0, drive
        yield slice(self.begin, self.end), self.stress, pushed
        yield slice(self.end, steps), 0.0, drive


NO_PUSH = Push()


class Pulses(NamedTuple):
    """Derivatives of a functional of the state at the end of a cycle by impulses (transits times normal stress, or times V*) in
    steps that begin at `time` and last `length` (k,), in transits: of shear `stress` on the interface and of the `drive`
    (k, s), at nodes. The steps end with the cycle and cover it; the first may begin before it, a period after the same phase."""

    time: Array
    length: Array
    stress: Array
    drive: Array


class InterfaceState(NamedTuple):
    """The interface at one time of a known motion, from which a run starts: `time` (transits), rate unknown `z`, `psi`, and
    `elastic` stress (normal stress)."""

    time: float
    z: float
    psi: float
    elastic: float


class Flow(Protocol):
    """A model's motion over a period on a mesh that does not depend on the motion, so that the state at the end is a smooth
    function of the state at the start, of the period and of the scene. Nothing of an earlier run is interpolated.

    A state is a vector of `size` values that determines the future motion, with psi as the last. Its meaning is the same for all
    scenes on one mesh (`of`); `remeshed` converts it to another mesh.
    """

    @property
    def scene(self) -> Scene:
        """The scene that is simulated; its drive is constant."""

    @property
    def model(self) -> str:
        """The model's name."""

    @property
    def size(self) -> int:
        """Number of values of a state."""

    @property
    def nodes(self) -> Array:
        """Nodes of the pieces in [0, 1]."""

    @property
    def steady(self) -> Array:
        """The state (n,) of steady sliding."""

    def march(self, start: Array, period: float, push: Push = NO_PUSH) -> Cycle:
        """The motion from `start` over `period`, pushed or not. Raises NumericsError if a step cannot be solved."""

    def velocity(self, cycle: Cycle) -> Array:
        """d end/d period (n,) at the end of `cycle`."""

    def tangent(self, cycle: Cycle) -> Array:
        """d end/d start (n, n) along `cycle`."""

    def pulses(self, cycle: Cycle, functional: Array) -> Pulses:
        """The derivatives of `functional` (n,) . end by pulses along a closed `cycle`: the exact adjoint of its steps."""

    def essential_radius(self, cycle: Cycle) -> float:
        """Radius of the disk in which infinitely many multipliers accumulate, those of `idle` states left out; 0 if there are
        finitely many."""

    @property
    def idle(self) -> Array:
        """Orthonormal basis (n, m) of the undamped modes that the interface does not excite; (n, 0) if there are none. The
        tangent maps their span to itself."""

    @property
    def undecided(self) -> bool:
        """Whether multipliers accumulate at the unit circle even without those of `idle` states: then they cannot be counted."""

    def of(self, scene: Scene) -> "Flow":
        """The same model and mesh for another scene."""

    def mesh_state(self) -> State:
        """The arrays, by name, that determine the mesh."""

    def on_mesh(self, state: State) -> "Flow":
        """The same model and scene on the mesh of a `mesh_state`."""

    def remeshed(self, cycle: Cycle, finer: float) -> "tuple[Flow, Array]":
        """A flow whose mesh suits the motion of `cycle`, with steps shorter by the factor `finer`, and the start of `cycle` as
        its state."""

    def loosened(self, start: Array, scenes: Sequence[Scene]) -> "tuple[Flow, Array]":
        """A flow whose motion is smooth between these `scenes`, itself if it is, and `start` as its state."""

    def roughness(self, cycle: Cycle, tolerance: float) -> float:
        """The largest highest Legendre coefficient of z and psi in a step of `cycle`, over the one that fits `tolerance`."""


def velocity_by_difference(flow: Flow, cycle: Cycle) -> Array:
    """d end/d period (n,) by the central difference of two marches: first-order differences would displace folds."""
    change = _CHANGE * cycle.period
    later, earlier = (flow.march(cycle.start, cycle.period + shift).end for shift in (change, -change))
    return (later - earlier) / (2.0 * change)


def impulses(time: Array, length: Array, nodes: Array, changes: Array) -> Pulses:
    """`Pulses` from the derivatives by stress and drive at the nodes, `changes` (2, k, s): over the weight of a node in time."""
    return Pulses(time, length, *(changes / (length[:, None] * radau(nodes.size).integral[-1])))


def eigenvalues_without(matrix: Array, idle: Array) -> NDArray[np.complex128]:
    """Eigenvalues of a `matrix` (n, n) without those of its invariant subspace spanned by the orthonormal `idle` states (n, m):
    those of the quotient map (n - m, n - m); on one thread, since the others cost a busy machine more than they gain."""
    with one_thread():
        if idle.size:
            rest = np.linalg.qr(idle, mode="complete")[0][:, idle.shape[1] :]
            matrix = rest.T @ matrix @ rest
        return np.linalg.eigvals(matrix).astype(np.complex128)

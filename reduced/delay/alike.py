"""The exact delay system (29, 35) for plain slabs of equal round trips, by Radau collocation whose steps divide the transit.

Steps (`TransitMesh`) are equal between the kinks of the drive, which return every transit, and halved where the motion needs it.

A knot of the drive at t causes a kink of the load at t and, half a transit later, of the wave that reaches the interface. Its
echoes return every transit for ever. A polynomial across a kink is only first-order accurate, so steps must end on kinks. The
front of a slip event of thick slabs takes a ten-thousandth of a transit and returns every transit too: only its steps are
halved, and joined when the wave has become smooth again.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from reduced.delay.march import Clock, DelayMarch, DelayMemory, alike_lines, dense_resolution, march_delay, next_count, present
from reduced.delay.transmission_lines import NODES
from slipwave.errors import SceneError
from slipwave.friction import allows_rest, rates, respond
from slipwave.observe.history import values_at
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.scene.drive import velocity_at
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.collocation import radau
from slipwave.step.flow import Cycle, InterfaceState
from slipwave.step.nodal import DONE, PSI, TIME, TOO_STEEP, Interface

_SAME = 1e-7
"""Transits; cuts closer than this are one. Ignoring a kink this close to a step's end causes a relative error of that size."""


@dataclass(frozen=True, eq=False)
class TransitMesh:
    """`lengths` (steps,) and `starts` (steps,) of the steps of one transit; `count` is the requested number of equal steps,
    `levels` (steps,) how often they were halved to give these. It is shared between solvers; do not write to its arrays."""

    count: int
    lengths: Array
    starts: Array
    levels: tuple[int, ...] = ()

    @property
    def steps(self) -> int:
        """Steps per transit."""
        return int(self.lengths.size)

    def resample(self, values: Array, nodes: Array, other: "TransitMesh") -> Array:
        """Values (..., other.steps, s) at the nodes of `other` of piecewise polynomials with nodal `values` (..., steps, s)."""
        step, weights = _read_at(self, tuple(nodes.tolist()), other)
        return np.asarray(np.einsum("isk,...isk->...is", weights, np.ascontiguousarray(values[..., step, :])))

    def halved(self, step: int) -> tuple[int, ...]:
        """The levels if a step is halved."""
        return (*self.levels[:step], *(self.levels[step] + 1,) * 2, *self.levels[step + 1 :])

    def joined(self, first: NDArray[np.intp]) -> tuple[int, ...]:
        """The levels if each of the steps `first` is joined with the next one, its other half."""
        levels = np.array(self.levels)
        levels[first] -= 1
        return tuple(np.delete(levels, first + 1).tolist())

    @property
    def halves(self) -> NDArray[np.intp]:
        """The steps that are the first half of a longer one whose other half is the next."""
        levels, (places, sizes) = np.array(self.levels), _places(self.levels)
        alike = (levels[1:] == levels[:-1]) & (levels[1:] > 0)
        return np.flatnonzero(alike & (places[:-1] % (2.0 * sizes[:-1]) == 0.0))


@lru_cache(maxsize=32)
def _read_at(coarse: TransitMesh, nodes: tuple[float, ...], finer: TransitMesh) -> tuple[NDArray[np.intp], Array]:
    """Index of the step of `coarse` that contains each node of `finer`, (finer.steps, s), and the rows that evaluate its
    polynomial there."""
    at = finer.starts[:, None] + np.array(nodes) * finer.lengths[:, None]
    step = np.clip(np.searchsorted(coarse.starts, at - SAME, side="left") - 1, 0, coarse.steps - 1)
    local = np.clip((at - coarse.starts[step]) / coarse.lengths[step], 0.0, 1.0)
    basis = lagrange_basis(np.array(nodes))
    return step, interpolation_matrix(basis, local.ravel()).reshape(*at.shape, len(nodes))


@lru_cache(maxsize=256)
def _transit_mesh(count: int, cuts: tuple[float, ...], levels: tuple[int, ...] = ()) -> TransitMesh:
    """Steps no longer than 1/`count`, equal between neighbouring `cuts` (sorted, the first 0), halved to `levels` if these are
    given. Raises SceneError if levels do not fit."""
    if levels:
        whole, (places, sizes) = _transit_mesh(count, cuts), _places(levels)
        if places[-1] + sizes[-1] != whole.steps:
            raise SceneError("levels do not fit the steps of a transit")
        step = places.astype(int)
        starts = whole.starts[step] + (places - step) * whole.lengths[step]
        return TransitMesh(count, whole.lengths[step] * sizes, starts, levels)
    gaps = np.diff(np.append(cuts, 1.0))
    shares = [math.ceil(count * gap - 1e-6) or 1 for gap in gaps]
    lengths = np.concatenate([np.full(share, gap / share) for share, gap in zip(shares, gaps, strict=True)])
    starts = np.concatenate(([0.0], np.cumsum(lengths)[:-1]))
    if np.ptp(lengths) < 1e-14:  # equal steps begin exactly at whole multiples of their length
        starts, lengths = np.arange(lengths.size) / lengths.size, np.full(lengths.size, 1.0 / lengths.size)
    return TransitMesh(count, lengths, starts, (0,) * lengths.size)


def _places(levels: tuple[int, ...]) -> tuple[Array, Array]:
    """Where steps of these levels begin, and their sizes, in undivided steps: sums of powers of 1/2, without rounding."""
    sizes = 0.5 ** np.array(levels)
    return np.append(0.0, np.cumsum(sizes)[:-1]), sizes


_CHUNK, _LONG_CHUNK = 4096, 1 << 16
_LOOSE_NODES, _TIGHT_NODES, _LOOSE = 6, 8, 3e-7
_FEWEST_STEPS, MOST_FIRST_STEPS = 3, 24
_MOST_EQUAL = 96  # steps per transit; where these are too long, single ones are halved
_SHORTEST = 2.0**-22  # transits
_OFTEN, _WORTH_JOINING = 16, 0.1  # transits between two looks for steps to join; at least so large a share of them is joined
_SHARE = 0.1  # of the tolerance: error of a joined step


class Delay(DelayMarch):
    """Marches the exact system to `tolerance`, the requested relative error of the outputs.

    With `emit` (the default) the outputs are the figures of the cycle, including extrema between nodes. With `emit=False` only
    the state at the end of the run is accurate: fewer steps, and `advance` returns the pieces of the last marched transit,
    without elastic stress. The solver marches whole transits and keeps the pieces beyond `until` for the next call. Where a
    step's polynomial is not resolved or Newton fails, there are more equal steps per transit or, beyond some number, that step is
    halved, until the waves need it no more. The march then goes back to the last whole transit. With `emit=False` the polynomials
    are not accurate enough for new nodes, so there are always equal steps, and it goes back to its beginning: the scene's start,
    or the beginning that `restore` was given. `nodes` and `steps` (a lower bound) may be given. `failures` counts unconverged
    solves; a step that cannot be solved with the shortest or with MAX_STEPS equal ones raises NumericsError instead.
    """

    def __init__(
        self, scene: Scene, nodes: int | None = None, steps: int | None = None, tolerance: float = 1e-9, emit: bool = True
    ) -> None:
        stages = nodes or (_LOOSE_NODES if tolerance > _LOOSE else _TIGHT_NODES)
        # where only the state at the ends of steps counts, which superconverges: with 5 and 8 nodes the error of psi, measured on
        # the reference scenes, is 0.02 coefficient^2 (for coefficients from 2e-2 down to 1e-5)
        at_ends = float(min(0.02, max((30.0 * tolerance) ** 0.5, 1e-6)))
        super().__init__(scene, stages, tolerance, dense_resolution(tolerance, stages) if emit else at_ends)
        self._emit, self._negligible = emit, _SHARE * tolerance
        self.settings = {"nodes": stages, "steps": steps, "tolerance": tolerance, "emit": emit}
        # fractions of the transit at which the drive's knots cause a kink of the load or of the wave at the interface, and 0
        knots = np.array(scene.drive.knots)
        fractions = np.sort(np.concatenate(([0.0], knots % 1.0, (knots + 0.5) % 1.0)))
        fractions = fractions[fractions < 1.0 - _SAME]
        self._cuts = tuple(fractions[np.concatenate(([True], np.diff(fractions) > _SAME))].tolist())
        mesh = _transit_mesh(steps or first_steps(scene, stages), self._cuts)
        self._impedance = plain_impedance(scene)
        start = present(0.0, scene.steady_psi + scene.start.jump_size, scene.steady_stress)
        self._remember(mesh, first_waves(scene, mesh, self.nodes), start)
        self._beginning = (mesh, self._lines.incoming.copy(), start)
        self._waiting = empty_pieces(0, stages)
        self._march(0, self._waiting)  # loads or compiles the march, so that a run's wall time does not include that

    @property
    def steps(self) -> int:
        """The present number of steps per transit."""
        return self._mesh.steps

    @property
    def time(self) -> float:
        """Transits since the start."""
        return float(self._waiting.time[0] if self._waiting.time.size else self._memory.now[TIME])

    def advance(self, until: float) -> Pieces:
        """March to the first end of a step at or beyond `until`, but at most one chunk; see `Solver`."""
        while not self._waiting.time.size:
            time, halved = self._memory.now[TIME], any(self._mesh.levels)
            most = min((_CHUNK if self._emit else _LONG_CHUNK) // self.steps, math.inf if not halved else _OFTEN - time % _OFTEN)
            transits = min(max(1, math.ceil(until - time - SAME)), max(1, int(most)))
            pieces = empty_pieces(self.steps * (transits if self._emit else 1), self._stages)
            kept, verdict = self._march(transits, pieces)
            if self._emit or verdict == DONE:
                self._waiting = pieces.part(slice(kept * self.steps))
            if halved and verdict == DONE and self._memory.now[TIME] % _OFTEN == 0.0:
                self._join_steps()
            if verdict != DONE and not self._waiting.time.size:  # return known pieces first: refining may raise an error
                self._refine(verdict)
        count = max(1, int(np.searchsorted(self._waiting.time, until - SAME)))
        first, self._waiting = (self._waiting.part(part) for part in (slice(count), slice(count, None)))
        return first

    def state(self) -> State:
        """As `Solver`: the memory at a whole transit (`counts`: requested steps per transit, failures, iterations, and those
        steps at the beginning; `levels` of the steps; `now`: `DelayMemory`; `incoming`, `guess`), the pieces `waiting` to be
        returned, and the beginning to which a march without `emit` goes back."""
        mesh, incoming, now = self._beginning
        state = {
            "counts": np.array([self._mesh.count, self.failures, self.iterations, mesh.count], dtype=float),
            "levels": np.array(self._mesh.levels, dtype=float)[:, None],
            "incoming": self._lines.incoming.copy(),
            "guess": np.stack(self._memory.guess),
            "now": self._memory.now.copy(),
            "waiting": np.column_stack(self._waiting),
        }
        return state if self._emit else state | {"beginning.incoming": incoming.copy(), "beginning.now": now.copy()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        count, failures, iterations, first = whole_numbers(state, "counts", (1, 0, 0, 1))
        levels = tables(state, {"levels": (-1, 1)}, self.model)["levels"].ravel()
        mesh = _transit_mesh(min(count, self._most_steps), self._cuts, tuple(levels.astype(int).tolist()))
        beginning = _transit_mesh(min(first, self._most_steps), self._cuts)
        shapes = {
            "incoming": (mesh.steps, self._stages),
            "guess": (2, self._stages),
            "now": (4,),
            "waiting": (-1, 2 + 4 * self._stages),
        }
        if not self._emit:
            shapes |= {"beginning.incoming": (beginning.steps, self._stages), "beginning.now": (4,)}
        saved = tables(state, shapes, self.model)
        self.failures, self.iterations = failures, iterations
        self._take(mesh, saved["incoming"], DelayMemory(Interface(*saved["guess"]), saved["now"]))
        time, length, *values = np.split(saved["waiting"], [1, 2, *(2 + self._stages * k for k in range(1, 4))], axis=1)
        self._waiting = Pieces(time.ravel(), length.ravel(), *(table.copy() for table in values))
        if not self._emit:
            self._beginning = (beginning, saved["beginning.incoming"], saved["beginning.now"])

    def state_at_start(self, cycle: Cycle, interface: InterfaceState) -> State:
        """The state, for `restore`, at the start of `cycle`, a motion of a `DelayFlow`, in steps that are at least as short;
        `interface.time` is a whole number of transits. Waves of the first transit: S = mu + eps v/2 of the motion itself."""
        saved, counts = self.state(), self.state()["counts"]
        counts[0] = max(int(counts[0]), round(1.0 / cycle.pieces.length[0]))
        mesh = _transit_mesh(int(counts[0]), self._cuts)
        times = mesh.starts[:, None] + self.nodes * mesh.lengths[:, None]
        basis = lagrange_basis(radau(NODES).nodes)
        z, psi, mu, _ = (values.reshape(times.shape) for values in values_at(cycle.pieces, basis, times.ravel(), self.scene.law))
        incoming = mu + self._lines.impedance * rates(self.scene.law, z)
        now = present(interface.time, interface.psi, interface.elastic)
        levels, waiting = np.array(mesh.levels, dtype=float)[:, None], np.empty((0, saved["waiting"].shape[1]))
        guess = np.stack([psi[0], z[0]])
        return saved | {"counts": counts, "levels": levels, "incoming": incoming, "guess": guess, "now": now, "waiting": waiting}

    def _march(self, transits: int, pieces: Pieces) -> tuple[int, int]:
        """March `transits` transits; returns (transits kept, verdict). A rejected step restores the memory of the transit's
        start."""
        clock = self._clock._replace(origin=float(self._memory.now[TIME]), times=transits)
        first = min(0, pieces.time.size - self.steps * transits)  # all steps or for those of the last transit
        march = (self._physics, self._lines, self._memory, self._nodal, clock, self._limits)
        done, iterations, verdict = march_delay(self._shape, *march, first, pieces)
        self.iterations += iterations
        self._rejected = done % self.steps
        return done // self.steps, verdict

    def _refine(self, verdict: int) -> None:
        """Take more equal steps per transit, or halve the rejected one; the polynomials of the incoming waves (now or at the
        beginning) give the new nodes."""
        old, incoming, now = (self._mesh, self._lines.incoming, self._memory.now) if self._emit else self._beginning
        # where v may change its sign, its bend travels with the waves through every step: equal ones resolve it
        may_halve = self._emit and not allows_rest(self.scene.law) and old.count >= _MOST_EQUAL
        if may_halve and (verdict != TOO_STEEP or any(old.levels)):
            new = _transit_mesh(old.count, self._cuts, old.halved(self._rejected))
            fits = new.lengths.min() >= _SHORTEST
        else:
            new = _transit_mesh(next_count(self._mesh.count), self._cuts)
            fits = new.count <= self._most_steps
        if not fits:
            raise self._unresolved(1.0 / old.lengths.min() if any(old.levels) else self.steps, verdict)
        self._change(new, old.resample(incoming, self.nodes, new), now)

    def _join_steps(self) -> None:
        """Join the halves of steps where the waves no longer need them, if these are many."""
        mesh, waves, now = self._mesh, self._lines.incoming, self._memory.now
        friction_z = respond(self.scene.law, float(self._memory.guess.z[0]), float(now[PSI]))[3]
        while (first := mesh.halves).size:
            longer = _transit_mesh(mesh.count, self._cuts, mesh.joined(first))
            changes = np.abs(longer.resample(mesh.resample(waves, self.nodes, longer), self.nodes, mesh) - waves).max(axis=1)
            first = first[np.maximum(changes[first], changes[first + 1]) < self._negligible * friction_z]
            if not first.size:
                break
            longer = _transit_mesh(mesh.count, self._cuts, mesh.joined(first))
            mesh, waves = longer, mesh.resample(waves, self.nodes, longer)
        if self.steps - mesh.steps > _WORTH_JOINING * self.steps:
            self._change(mesh, waves, now)

    def _change(self, mesh: TransitMesh, incoming: Array, now: Array) -> None:
        """Continue in the steps of another mesh."""
        self._remember(mesh, incoming, now)

    def _remember(self, mesh: TransitMesh, incoming: Array, now: Array) -> None:
        """Set the memory at a whole transit, with guesses for constant psi."""
        guess = self._first_guess(self._impedance, incoming[0], now[PSI])
        self._take(mesh, incoming, DelayMemory(guess, now.copy()))

    def _take(self, mesh: TransitMesh, incoming: Array, memory: DelayMemory) -> None:
        """Continue from this memory in the steps of `mesh`."""
        self._mesh, self._clock, self._memory = mesh, Clock(0.0, np.append(mesh.starts, 1.0), mesh.lengths), memory
        self._lines = alike_lines(self._impedance, incoming)


def plain_impedance(scene: Scene) -> float:
    """Z = epsilon/2 of plain slabs of equal round trips. Raises SceneError for all others."""
    (slab, *others) = scene.slabs
    if others or not slab.is_plain:
        raise SceneError(f"model = delay: scene {scene.name!r} is not a pair of plain slabs with equal round trips")
    return 0.5 * slab.epsilon


def first_waves(scene: Scene, mesh: TransitMesh, nodes: Array) -> Array:
    """S at the nodes of the first transit's steps (steps, s): that of steady sliding and, from half a transit on, what the drive
    has sent since t = 0."""
    impedance, drive, late = plain_impedance(scene), scene.drive.compiled, mesh.starts - 0.5
    times, middles = late[:, None] + nodes * mesh.lengths[:, None], late + 0.5 * mesh.lengths
    rates = [[velocity_at(drive, time, middle) for time in row] for row, middle in zip(times, middles, strict=True)]
    return scene.steady_stress + impedance * (2.0 * np.array(rates) - scene.velocity)


def first_steps(scene: Scene, stages: int) -> int:
    """First number of steps per transit, from the fastest possible acceleration: (ln v)' <= r b / Z where radiation limits v
    (with 8 nodes, in the paper's scene: 3 at log10 r = -2.68, 14 at -2.3)."""
    _, v_z, _, _, friction_psi, _, g_z, _ = scene.steady_response
    fastest = scene.transit * abs(friction_psi * g_z) / (scene.impedance * v_z)
    guess = 3.0 * (fastest / 7.3) ** 1.7 * math.sqrt(_TIGHT_NODES / stages)
    steps = int(np.clip(guess, _FEWEST_STEPS, MOST_FIRST_STEPS))
    return steps if steps < 5 else steps + steps % 2

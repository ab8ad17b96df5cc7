"""The exact march of a grid: the slabs are propagated without error in time (`propagator`), and steps only resolve friction.
Without a choice of the user, the march that is cheaper for scene and grid is taken (`cheaper_march`).
"""

import math
from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from fullwave.lines.budget import PRODUCTS_PER_SECOND, steps_at_once
from fullwave.lines.propagator import GridSlabs, halves
from fullwave.lines.system import System
from fullwave.slabs import marched_slabs
from slipwave.friction import rate_of
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import StartKind
from slipwave.scene.slab import Slab
from slipwave.solve import State, tables
from slipwave.step.port_march import CHUNK, PortMarch

TimeMarch: TypeAlias = Literal["exact", "explicit"]
"""How a grid is marched in time."""

MOST_BY_DEFAULT = 1000
"""Unknowns up to which the exact march is the default. Measured on the paper's scene, both marches with less error in time than
in space: from 130 unknowns on a transit costs a fifth of that by explicit steps, or less (a fortieth for elements of degree 4).
Tables take 40 ms for 270 unknowns, 0.2 to 0.5 s for 500, 0.7 to 1.8 s for 800, which pays after 20 to 150 transits (1600 for
`sbp:2`, whose explicit steps are cheapest); a scene of the gallery has 4000."""

STAGES = 8
LONGEST = 1.0
"""Longest step (transits)."""

EXACT_TOLERANCE = 1e-12
"""Relative error of the figures of a cycle to which steps resolve friction, far below that of the grid. 1e-9 would take half the
time."""

_FIRST = 0.125
_STEP_SECONDS = 2e-6


def cheaper_march(scene: Scene, unknowns: int) -> TimeMarch:
    """The exact march up to `MOST_BY_DEFAULT` unknowns. After a start with a jump both marches must resolve waves as short as the
    grid allows; then the explicit march is cheaper on most grids."""
    return "explicit" if unknowns > MOST_BY_DEFAULT or scene.start.kind is StartKind.JUMP else "exact"


def _settling(slab: Slab) -> float:
    """Time (L/V*) in which a mass on the outer face follows its dashpot and the slab; inf without one. It is that of the heat of
    the dashpot behind a step of V, which a projection onto the polynomials of a longer step does not hold."""
    face = slab.termination
    return face.mass / (face.dashpot + slab.epsilon) if face.mass > 0.0 and face.dashpot > 0.0 else math.inf


class ExactMarch(PortMarch):
    """Marches the grid that `grid` makes for `scene` from `values` (state_size,), in the layout of the explicit march."""

    name = "exact"
    slabs: GridSlabs
    failures, failed_at = 0, math.nan
    step = LONGEST
    transits_per_piece = math.nan
    bookkeeping = PortMarch.bookkeeping | {"ledger"}

    def __init__(
        self, scene: Scene, grid: Callable[[Scene], System], values: Array, model: str, tolerance: float = EXACT_TOLERANCE
    ) -> None:
        self._layout = values
        self.settings = {"stages": STAGES, "resolution": tolerance}
        self.slabs = GridSlabs(scene, grid, model, STAGES)
        at_once = min(CHUNK, steps_at_once(self._products))
        super().__init__(self.slabs, tolerance, LONGEST, _FIRST, most_steps=at_once)
        self.longest_after_break = min(map(_settling, marched_slabs(scene))) / scene.transit
        self._frames: list[tuple[float, Array]] = []
        self._frame = math.inf
        self.begin_from(values)

    @property
    def seconds_per_piece(self) -> float:
        """Approximate cost of a step."""
        return _STEP_SECONDS + self._products / PRODUCTS_PER_SECOND

    @property
    def _products(self) -> float:
        """Number of products in a step."""
        size = self.slabs.remembered
        return float(size * (size + 3 * STAGES))

    @property
    def layout(self) -> Array:
        """The grid's values, in the layout of all that the explicit march integrates."""
        self._layout[self.slabs.slots] = self.values / self.slabs.scale
        return self._layout

    def begin_from(self, values: Array) -> None:
        """Set the grid's values, in that layout."""
        self.values[:] = values[self.slabs.slots] * self.slabs.scale

    def advance(self, until: float) -> Pieces:
        """As `Solver`."""
        before = self.values / self.slabs.scale
        if math.isfinite(self._frame):  # frames are of steps whose lengths are halves of one
            until = min(until, self.slabs.next_break(self.time))
        pieces = super().advance(until)
        self._frames = self._between(before, pieces) if math.isfinite(self._frame) else []
        return pieces

    def keep_ledger(self) -> None:
        """Start to sum work and heat, step by step."""
        self.slabs.keep_ledger()

    def work_done(self) -> Array | None:
        """Work of the drive, heat of friction, radiation and viscous heat since t = 0; None unless summed."""
        return self.slabs.entries if self.slabs.is_kept[0] else None

    def state(self) -> State:
        """As `PortMarch`, with the `ledger`."""
        return super().state() | {"ledger": self.slabs.entries.copy()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        saved = tables(state, {"ledger": self.slabs.entries.shape}, self.slabs.model)
        super().restore(state)
        self.slabs.entries[:] = saved["ledger"]

    def keep_frames(self, interval: float) -> None:
        """Let `frames` return states within the steps, at most `interval` (transits) apart: steps are too long to show waves."""
        self._frame = interval

    def frames(self) -> list[tuple[float, Array]]:
        """(time, values) within and at the ends of the steps of the last `advance`, if kept."""
        return self._frames

    def _between(self, values: Array, pieces: Pieces) -> list[tuple[float, Array]]:
        """States at times at most `_frame` apart: the known slip rate drives steps of finer levels."""
        maps, _ = self.slabs.tables(self.longest)
        frames = []
        for time, length, z in zip(pieces.time, pieces.length, pieces.z, strict=True):
            depth = max(0, math.ceil(math.log2(length / self._frame) - 1e-9))
            fine = maps.find(round(math.log2(self.longest / length)) + depth)
            for k, part in enumerate(self._parts(float(time), float(length), z, depth)):
                values = values + fine.change @ values + fine.forced @ part
                shown = self._layout.copy()
                shown[self.slabs.slots] = values
                frames.append((float(time + length * (k + 1) / 2**depth), shown))
        return frames

    def _parts(self, time: float, length: float, z: Array, depth: int) -> list[Array]:
        """Coefficients of slip rate and drive on the 2^depth equal parts of a step with z at its nodes."""
        scene, to_legendre, terms = self.slabs.scene, self.slabs.to_legendre, self.slabs.drive_terms
        rates = np.array([rate_of(scene.law, float(unknown)) for unknown in z]) - scene.velocity
        drive = np.array([scene.drive.at(time + length * float(node)) for node in self.nodes])
        parts = [np.r_[to_legendre @ rates, to_legendre[:terms] @ (0.5 * (drive - scene.velocity))]]
        for _ in range(depth):
            parts = [half @ part for part in parts for half in halves((STAGES, terms))]
        return parts

"""Steps over one period for whatever a port may be: fixed fractions of the period, chosen by a march that follows the motion."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import NumericsError
from slipwave.friction import unknown_of
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.step.collocation import rule_of
from slipwave.step.guess import first_guess
from slipwave.step.impedance import full_impedance
from slipwave.step.linear_port import LinearPort
from slipwave.step.march import ANY_LENGTH, NEXT, NOT_READY, TIME, Limits, Memory, begin, march
from slipwave.step.rows import scratch_of

NEWTON = 1e-13
"""Allowed error of a step's iteration."""

_LEVELS = 32
_FIRST = 4  # level of the first step of a march that follows the motion
_MOST = 100_000  # steps in a period; a motion that runs away would take ever more


class Response(Protocol):
    """What a slab model is to a flow: linear in what it remembers, in deviations from steady sliding."""

    @property
    def scene(self) -> Scene:
        """Whose slabs."""

    @property
    def model(self) -> str:
        """The model's name."""

    @property
    def stages(self) -> int:
        """Nodes of a step."""

    @property
    def remembered(self) -> int:
        """Number of values."""

    def port(self, longest: float, levels: int) -> LinearPort:
        """Its port for steps of `longest` (transits) and its halves, `levels` in all."""

    def prepare(self, port: LinearPort, level: int) -> None:
        """Make the tables of a level that is not ready."""

    def resistance(self, port: LinearPort, level: int, growth: float) -> float:
        """Impedance Z at s = growth/length of a level, in units of the normal stress over V*."""

    def of(self, scene: Scene) -> "Response":
        """The same model of another scene."""


@dataclass(frozen=True)
class Mesh:
    """Steps of period/`count`/2^level, by the `levels` of all steps of a period; `longest`: length (transits) that a step may
    have; `resolution`: highest Legendre coefficient that a step was allowed; `growth`: largest growth in a step."""

    count: int
    levels: NDArray[np.int64]
    longest: float
    resolution: float
    growth: float


def mesh_of(response: Response, start: Array, period: float, longest: float, resolution: float, growth: float) -> Mesh:
    """The mesh (`Mesh`) of a march over `period` from `start` whose steps follow the motion."""
    count = math.ceil(period / longest - SAME)
    port = response.port(period / count, _LEVELS)
    limits = Limits(NEWTON, resolution, growth, np.full(_LEVELS, math.nan))
    for level in {_FIRST, *np.flatnonzero(port.ready)}:
        _prepare(response, port, limits, int(level))
    memory, pieces = begin_at(response, port, start, _FIRST), empty_pieces(_MOST, response.stages)
    steps, ended = 0, NOT_READY
    while ended == NOT_READY:
        rest = Pieces(*(array[steps:] for array in pieces))
        more, _, ended = march_on(response, port, memory, period, limits, ANY_LENGTH, rest)
        steps += more
        if ended == NOT_READY:
            _prepare(response, port, limits, int(memory.levels[NEXT]))
    if memory.now[TIME] < period - SAME:
        raise failure(response, float(memory.now[TIME]), period)
    levels = np.rint(np.log2(port.length[0] / pieces.length[:steps])).astype(np.int64)
    return Mesh(count, levels, longest, resolution, growth)


def _prepare(response: Response, port: LinearPort, limits: Limits, level: int) -> None:
    response.prepare(port, level)
    limits.impedance[level] = response.resistance(port, level, limits.growth)


def begin_at(response: Response, port: LinearPort, start: Array, level: int) -> Memory:
    """Memory of a march from the state `start`, whose first step has the length of `level`."""
    scene, stages = response.scene, response.stages
    port.values[:] = start[:-1]
    incoming = port.steady_stress + port.impedance[level].sum(axis=1) * port.velocity + port.values @ port.free[level]
    guess, z = np.empty(stages), unknown_of(scene.law, scene.velocity)
    first_guess(scene.law, float(port.impedance[level, 0].sum()), incoming, start[-1], z, guess)
    memory = begin(start[-1], scene.steady_stress, float(guess[0]), stages)
    memory.levels[NEXT] = level
    return memory


def march_on(
    response: Response, port: LinearPort, memory: Memory, until: float, limits: Limits, plan: NDArray[np.int64], pieces: Pieces
) -> tuple[int, int, int]:
    """`march` under the scene's constant drive."""
    scene = response.scene
    _, rule, nodes = rule_of(response.stages)
    scratch = (full_impedance(response.stages), scratch_of(response.stages))
    physics = (scene.law, scene.forcing._replace(nudge=0.0), scene.drive.compiled, port)
    return march(nodes, *physics, rule, memory, *scratch, until, 0.0, until, limits, plan, pieces)


def failure(response: Response, time: float, period: float) -> NumericsError:
    """The error of a march that cannot take a step at `time` of `period` (transits)."""
    scene = response.scene
    return NumericsError(
        f"{response.model}: the step at {time:.6g} of {period:.6g} transits cannot be solved (scene {scene.name!r}, digest "
        f"{scene.digest})"
    )

"""Steps over one period for whatever a port may be: fixed fractions of the period, chosen by a march that follows the motion."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import NumericsError
from slipwave.friction import unknown_of
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces
from slipwave.step.collocation import rule_of
from slipwave.step.guess import first_guess
from slipwave.step.impedance import full_impedance
from slipwave.step.march import ANY_LENGTH, NEXT, NOT_READY, TIME, Limits, Memory, begin, march
from slipwave.step.port import LEVELS, Port, Slabs
from slipwave.step.rows import scratch_of

NEWTON = 1e-13
"""Allowed error of a step's iteration."""

_FIRST = 4  # level of the first step of a march that follows the motion
_MOST = 100_000  # steps in a period; a motion that runs away would take ever more


@dataclass(frozen=True)
class Mesh:
    """Steps of period/`count`/2^level, by the `levels` of all steps of a period; `longest`: length (transits) that a step may
    have; `resolution`: highest Legendre coefficient that a step was allowed; `growth`: largest growth in a step."""

    count: int
    levels: NDArray[np.int64]
    longest: float
    resolution: float
    growth: float


def mesh_of(slabs: Slabs, start: Array, period: float, longest: float, resolution: float, growth: float) -> Mesh:
    """The mesh (`Mesh`) of a march over `period` from `start` whose steps follow the motion."""
    count = math.ceil(period / longest - SAME)
    port = slabs.port(period / count)
    limits = Limits(NEWTON, resolution, growth, np.full(LEVELS, math.nan))
    for level in {_FIRST, *np.flatnonzero(port.ready)}:
        _prepare(slabs, port, limits, int(level))
    memory, pieces = begin_at(slabs, port, start, _FIRST), empty_pieces(_MOST, slabs.stages)
    steps, ended = 0, NOT_READY
    while ended == NOT_READY:
        rest = Pieces(*(array[steps:] for array in pieces))
        more, _, ended = march_on(slabs, port, memory, period, limits, ANY_LENGTH, rest)
        steps += more
        if ended == NOT_READY:
            _prepare(slabs, port, limits, int(memory.levels[NEXT]))
    if memory.now[TIME] < period - SAME:
        raise failure(slabs, float(memory.now[TIME]), period)
    levels = np.rint(np.log2(port.length[0] / pieces.length[:steps])).astype(np.int64)
    return Mesh(count, levels, longest, resolution, growth)


def _prepare(slabs: Slabs, port: Port, limits: Limits, level: int) -> None:
    slabs.prepare(port, level)
    limits.impedance[level] = slabs.resistance(port, np.array([level]), limits.growth)[0]


def begin_at(slabs: Slabs, port: Port, start: Array, level: int) -> Memory:
    """Memory of a march from the state `start`, whose first step has the length of `level`."""
    scene, stages = slabs.scene, slabs.stages
    port.values[: slabs.remembered] = start[:-1]
    incoming = port.steady[level] + port.values @ port.free[level]
    guess, z = np.empty(stages), unknown_of(scene.law, scene.velocity)
    first_guess(scene.law, float(port.impedance[level, 0].sum()), incoming, start[-1], z, guess)
    memory = begin(start[-1], scene.steady_stress, float(guess[0]), stages)
    memory.levels[NEXT] = level
    return memory


def march_on(
    slabs: Slabs, port: Port, memory: Memory, until: float, limits: Limits, plan: NDArray[np.int64], pieces: Pieces
) -> tuple[int, int, int]:
    """`march` under the scene's constant drive."""
    scene = slabs.scene
    _, rule, nodes = rule_of(slabs.stages)
    scratch = (full_impedance(slabs.stages), scratch_of(slabs.stages))
    physics = (scene.law, scene.forcing._replace(nudge=0.0), scene.drive.compiled, port)
    return march(nodes, *physics, rule, memory, *scratch, until, 0.0, until, limits, plan, pieces)


def failure(slabs: Slabs, time: float, period: float) -> NumericsError:
    """The error of a march that cannot take a step at `time` of `period` (transits)."""
    scene = slabs.scene
    return NumericsError(
        f"{slabs.model}: the step at {time:.6g} of {period:.6g} transits cannot be solved (scene {scene.name!r}, digest "
        f"{scene.digest})"
    )

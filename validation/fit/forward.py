"""Predicts a record by a model, with its derivative by the free parameters."""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from reduced.delay.sensitivity import delay_sensitivity
from reduced.families import DELAY
from reduced.impedance.reduce import reduction_of
from reduced.ode.slabs import STAGES, ReducedSlabs
from slipwave.errors import NumericsError
from slipwave.observe.history import values_at
from slipwave.observe.pieces import SAME, Array, Basis, Pieces, lagrange_basis, slack
from slipwave.scene import Scene
from slipwave.solve.solver import Leaping
from slipwave.step.collocation import radau
from slipwave.step.sensitivity import port_sensitivity
from validation.fit.parameters import Variants, sizes
from validation.models.build import build
from validation.models.by_name import GRIDS

_MOST_STEPS = 400_000
_SAME_TIME = 1e-6  # transits; a sample so far beyond the end of a piece is at its end
_SHIFT = 1e-4  # of differences of marches


class Forward(ABC):
    """The friction of a `model` at the `times` of a record, over the free parameters of `variants`."""

    is_cheap: bool
    """Whether many starts may be tried."""

    def __init__(self, variants: Variants, times: Array, model: str, tolerance: float) -> None:
        self._variants, self._times, self._model, self._tolerance = variants, times, model, tolerance
        self._last: tuple[Array, Any] | None = None  # values, and what was computed for them

    def scene(self, inner: Array) -> Scene:
        """The scene with these parameter values."""
        return self._variants.scene(inner)

    @abstractmethod
    def friction(self, inner: Array) -> Array:
        """Friction at the times of the record. Raises NumericsError where the motion cannot be computed."""

    @abstractmethod
    def slopes(self, inner: Array) -> Array:
        """Derivative of `friction` (samples, parameters)."""


class OfReduction(Forward):
    """Friction by an ODE reduction at the times of the record, in steps as long as its motion allows, whatever a transit is. The
    derivative is exact for the steps that the march took."""

    is_cheap: bool = True

    def friction(self, inner: Array) -> Array:
        """As `Forward`."""
        slabs, pieces = self._known(inner)
        return self._seen(slabs.scene, pieces, [])[0]

    def slopes(self, inner: Array) -> Array:
        """As `Forward`."""
        slabs, pieces = self._known(inner)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # where v is next to 0, and a/v no number
            by_parameter = port_sensitivity(slabs, self._variants.neighbours(inner), pieces)
        if not np.isfinite(by_parameter).all():
            raise NumericsError(f"{self._model}: friction has no derivative by the parameters where v comes next to 0")
        return np.column_stack(self._seen(slabs.scene, pieces, [*np.moveaxis(by_parameter, 1, 0)])[1:])

    def _known(self, inner: Array) -> tuple[ReducedSlabs, Pieces]:
        if self._last is None or not np.array_equal(self._last[0], inner):
            slabs = ReducedSlabs(self.scene(inner), partial(reduction_of, name=self._model), STAGES)
            self._last = inner.copy(), (slabs, self._march(slabs.scene))
        slabs, pieces = self._last[1]
        return slabs, pieces

    def _march(self, scene: Scene) -> Pieces:
        """The motion that is to be seen."""
        return self._until(scene, self._times[-1] / sizes(scene)[0])

    def _until(self, scene: Scene, until: float) -> Pieces:
        """The motion up to `until` (transits). Raises NumericsError if it takes too many steps or is not finite."""
        parts, steps = [], 0
        for part in solved(self._model, scene, until, self._tolerance):
            parts.append(part)
            steps += part.time.size
            if steps > _MOST_STEPS or not math.isfinite(float(part.z[-1, -1])):
                raise NumericsError(f"{self._model}: more than {_MOST_STEPS} steps at t = {part.time[-1]:.6g} transits")
        return Pieces.joined(parts)

    def _seen(self, scene: Scene, pieces: Pieces, by: Sequence[Array]) -> list[Array]:
        """What the record would show of it, and its derivatives, where `by` (k, s) are those of mu at the nodes."""
        times = np.clip(self._times / sizes(scene)[0], 0.0, pieces.time[-1] + pieces.length[-1])
        return sampled(pieces, times, [pieces.mu, *by])


class OfSolver(Forward):
    """Friction by any other model. For alike plain slabs' delay system the derivative is exact for the steps of the march; for
    other models, and for parameters that change the transit, it is a difference of marches."""

    is_cheap: bool = False

    def friction(self, inner: Array) -> Array:
        """As `Forward`."""
        if self._last is None or not np.array_equal(self._last[0], inner):
            scene = self.scene(inner)
            parts = solved(self._model, scene, self._times[-1] / sizes(scene)[0], self._tolerance)
            self._last = inner.copy(), self._along(inner, ((pieces, [pieces.mu]) for pieces in parts))[:, 0]
        return np.asarray(self._last[1])

    def slopes(self, inner: Array) -> Array:
        """As `Forward`."""
        scene = self.scene(inner)
        if self._model == DELAY.name and scene.is_plain:
            sides = self._variants.neighbours(inner)
            of_one_wave = all(scene.is_plain for scenes, _, _ in sides for scene in scenes)
            if of_one_wave and all(abs(clock - 1.0) < SAME for _, clocks, _ in sides for clock in clocks):
                parts = delay_sensitivity(scene, sides, self._times[-1] / sizes(scene)[0], self._tolerance)
                return self._along(inner, ((pieces, [*np.moveaxis(by_parameter, 1, 0)]) for pieces, by_parameter in parts))
        shifts = _SHIFT * np.eye(inner.size)
        return np.column_stack([(self.friction(inner + s) - self.friction(inner - s)) / (2.0 * _SHIFT) for s in shifts])

    def _along(self, inner: Array, parts: Iterable[tuple[Pieces, list[Array]]]) -> Array:
        """Nodal values of every part at the times of the record, (samples, rows)."""
        times, samples, done = self._times / sizes(self.scene(inner))[0], [], 0
        for pieces, rows in parts:
            last = int(np.searchsorted(times, pieces.time[-1] + pieces.length[-1] + _SAME_TIME, side="right"))
            if last > done:
                samples.append(np.column_stack(sampled(pieces, times[done:last], rows)))
                done = last
        return np.concatenate(samples)


def solved(model: str, scene: Scene, until: float, tolerance: float) -> Iterator[Pieces]:
    """The motion of any model up to `until` (transits)."""
    has_grid = model.partition(":")[0] in [grid.name for grid in GRIDS]
    solver = build(model, scene) if has_grid else build(model, scene, tolerance=tolerance)
    end = float(np.ceil(until))
    while solver.time < end - slack(end):
        yield solver.leap(end, end, False) if isinstance(solver, Leaping) else solver.advance(end)


def sampled(pieces: Pieces, times: Array, rows: Sequence[Array]) -> list[Array]:
    """Values of each of `rows`, nodal values (k, s), at `times` (transits)."""
    samples: list[Array] = []
    basis = basis_of(pieces)
    for k in range(0, len(rows), 4):
        four = [*rows[k : k + 4], *[pieces.mu] * 3][:4]
        samples += values_at(Pieces(pieces.time, pieces.length, *four), basis, times)
    return samples[: len(rows)]


def basis_of(pieces: Pieces) -> Basis:
    """The polynomials of the pieces of any march."""
    return lagrange_basis(radau(pieces.z.shape[1]).nodes)

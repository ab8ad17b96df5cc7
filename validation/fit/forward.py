"""What a model says that a record would show, with its derivative by the free parameters."""

import math
from collections.abc import Sequence

import numpy as np

from reduced.impedance.reduce import reduction_of
from reduced.ode.march import STAGES
from reduced.ode.slabs import ReducedSlabs
from slipwave.errors import NumericsError
from slipwave.observe.pieces import SAME, Array, Pieces, lagrange_basis, values_at
from slipwave.scene import Scene
from slipwave.step.collocation import rule_of
from slipwave.step.port_march import PortMarch
from slipwave.step.sensitivity import port_sensitivity
from validation.fit.parameters import Variants, sizes

_FIRST = 0.125  # transits; length of the first step
_MOST_STEPS = 400_000


class OfReduction:
    """Friction by an ODE reduction, in steps as long as its motion allows, whatever a transit is."""

    def __init__(self, variants: Variants, times: Array, model: str, tolerance: float) -> None:
        self._variants, self._times, self._model, self._tolerance = variants, times, model, tolerance
        self._basis = lagrange_basis(rule_of(STAGES)[0].nodes)
        self._last: tuple[Array, ReducedSlabs, Pieces] | None = None

    def scene(self, inner: Array) -> Scene:
        """That of these values."""
        return self._variants.scene(inner)

    def friction(self, inner: Array) -> Array:
        """At the times of the record. Raises NumericsError where the motion cannot be computed."""
        _, slabs, pieces = self._marched(inner)
        return self._at_times(slabs.scene, pieces, [pieces.mu])[0]

    def slopes(self, inner: Array) -> Array:
        """Its derivative (samples, parameters), exact for the steps that the march took."""
        _, slabs, pieces = self._marched(inner)
        found = port_sensitivity(slabs, self._variants.beside(inner), pieces)
        return np.column_stack(self._at_times(slabs.scene, pieces, [*np.moveaxis(found, 1, 0)]))

    def _marched(self, inner: Array) -> tuple[Array, ReducedSlabs, Pieces]:
        if self._last is None or not np.array_equal(self._last[0], inner):
            scene = self._variants.scene(inner)
            slabs = ReducedSlabs(scene, lambda one: reduction_of(one, self._model), STAGES)
            self._last = inner.copy(), slabs, marched(slabs, self._times[-1] / sizes(scene)[0], self._tolerance)
        return self._last

    def _at_times(self, scene: Scene, pieces: Pieces, rows: Sequence[Array]) -> list[Array]:
        """Nodal values (k, s) at the times of the record."""
        times = np.clip(self._times / sizes(scene)[0], 0.0, pieces.time[-1] + pieces.length[-1])
        return sampled(pieces, self._basis, times, rows)


def sampled(pieces: Pieces, basis: object, times: Array, rows: Sequence[Array]) -> list[Array]:
    """Each of some nodal values (k, s) at `times` (transits)."""
    found: list[Array] = []
    for k in range(0, len(rows), 4):
        four = [*rows[k : k + 4], *[pieces.mu] * 3][:4]
        found += values_at(Pieces(pieces.time, pieces.length, *four), basis, times)  # type: ignore[arg-type]
    return found[: len(rows)]


def marched(slabs: ReducedSlabs, until: float, tolerance: float) -> Pieces:
    """The pieces of a march from the start to `until` (transits). Raises NumericsError if it cannot be done."""
    solver = PortMarch(slabs, tolerance, until, min(_FIRST, until), slabs.reduction.name)
    parts, steps = [solver.advance(until)], 0
    while solver.time < until - SAME * max(1.0, until):
        parts.append(solver.advance(until))
        steps += parts[-1].time.size
        if steps > _MOST_STEPS or not math.isfinite(float(parts[-1].z[-1, -1])):
            raise NumericsError(f"{slabs.model}: more than {_MOST_STEPS} steps at t = {solver.time:.6g} transits")
    return Pieces(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))

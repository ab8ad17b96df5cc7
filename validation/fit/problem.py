"""The residuals of a model over all records, as least squares takes them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from reduced.families import REDUCTIONS
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.fit.cycles import CycleOfReduction, CycleOfSolver, blurred, disturbed
from validation.fit.forward import Forward, OfReduction, OfSolver
from validation.fit.parameters import NUISANCES, Free, Variants, sizes
from validation.fit.records import Experiment
from validation.fit.starts import other_starts, sticking_starts
from validation.registry.families import requested


@dataclass
class FrictionProblem:
    """Friction of `records` against a model's, over the `free` keys, then the `nuisances` of each record."""

    free: tuple[Free, ...]
    records: Sequence[Experiment]
    models: Sequence[Forward]
    nuisances: tuple[str, ...]

    def __post_init__(self) -> None:
        names = [one.key for one in self.free]
        many = len(self.records) > 1
        self.own = [(k, name) for k in range(len(self.records)) for name in self.nuisances]
        self.names = [*names, *(f"{name}[{k + 1}]" if many else name for k, name in self.own)]
        bounds = [(one.inner(one.low), one.inner(one.high)) for one in self.free]
        low, high = zip(*bounds, *[(-np.inf, np.inf)] * len(self.own), strict=True)
        self.low, self.high = np.array(low), np.array(high)
        own = [float(np.ptp(self.records[k].friction[self.records[k].shown])) for k, _ in self.own]
        self.large = np.array([*(1.0 if one.is_positive else np.nan for one in self.free), *own])
        self.first = np.array([one.inner(one.start) for one in self.free])
        self.fineness = 1e-3 if any(isinstance(one, CycleOfSolver) for one in self.models) else 1e-10
        self._shapes = [self._columns(k) for k in range(len(self.records))]

    def _columns(self, k: int) -> Array:
        """What 1 of each nuisance adds to record `k` (samples, nuisances)."""
        one = self.records[k]
        along = (one.travel - one.travel.mean()) / max(float(np.ptp(one.travel)), 1e-300)
        is_friction = np.ones(one.travel.size)
        is_friction[0] = one.cycle is None
        kinds = {"level": is_friction, "drift": along * is_friction}
        return np.column_stack([kinds[name] * (own == k) for own, name in self.own] or [np.empty((one.travel.size, 0))])

    def friction(self, inner: Array) -> list[Array]:
        """Of the model, for each record."""
        keys, own = inner[: len(self.free)], inner[len(self.free) :]
        return [model.friction(keys) + shape @ own for model, shape in zip(self.models, self._shapes, strict=True)]

    def residual(self, inner: Array) -> Array:
        """Of the model minus what was measured, over the noise of each record."""
        pairs = zip(self.friction(inner), self.records, strict=True)
        return np.concatenate([one.weight * (friction - one.friction) for friction, one in pairs])

    def slopes(self, inner: Array) -> Array:
        """As `Problem`."""
        keys = inner[: len(self.free)]
        parts = [np.column_stack([m.slopes(keys), s]) for m, s in zip(self.models, self._shapes, strict=True)]
        return np.vstack([np.reshape(one.weight, (-1, 1)) * part for one, part in zip(self.records, parts, strict=True)])

    @property
    def noise(self) -> float:
        """The residual of a model that is right; 0 where the records have no noise."""
        return float(any(np.ndim(one.weight) or one.weight != 1.0 for one in self.records))

    def starts(self) -> Iterator[Array]:
        """The scene's values, then others."""
        first, low, high = (part[: len(self.free)] for part in (self.first, self.low, self.high))
        cycle = next((one.cycle for one in self.records if one.cycle), None)
        others = sticking_starts(self.free, first, cycle, self.models[0].scene) if cycle else other_starts(self.free, first)
        for start in chain([first], others):
            inside = np.clip(start, low, high)
            yield np.append(inside, self._levels(inside))

    def _levels(self, inner: Array) -> Array:
        """Nuisances of the start: means of what the scene's own steady friction leaves."""
        scene = self.models[0].scene(inner)
        return np.array(
            [
                float(self.records[k].friction[1:20].mean()) - scene.steady_stress if name == "level" else 0.0
                for k, name in self.own
            ]
        )


def problem_of(
    scene: Scene, free: tuple[Free, ...], words: Sequence[str], records: Sequence[Experiment], model: str, tolerance: float
) -> FrictionProblem:
    """The problem of fitting `records` by `model`. Raises SceneError for an unknown model and one that cannot do the scene."""
    family, _, number, _ = requested(model, scene, tolerance=tolerance)
    kind: type[OfReduction | OfSolver] = OfReduction if family in REDUCTIONS else OfSolver
    name = family.called(family.default if number is None else number)
    models: list[Forward] = []
    for one in records:
        variants = Variants(scene, free, one.schedule)
        if one.cycle is None:
            models.append(kind(variants, one.times, name, tolerance))
        else:
            cycle = CycleOfReduction if kind is OfReduction else CycleOfSolver
            models.append(cycle(disturbed(variants), one.cycle.period, name, tolerance))
    if kind is OfSolver:
        transit = sizes(scene)[0]
        records = [one._replace(weight=1.0 / blurred(one.cycle, transit)) if one.cycle else one for one in records]
    return FrictionProblem(free, records, models, tuple(name for name in NUISANCES if name in words))

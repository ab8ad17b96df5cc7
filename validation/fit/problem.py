"""The residuals of a model over all records, as least squares takes them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from reduced.families import REDUCTIONS
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.fit.cycles import CycleOfReduction, disturbed
from validation.fit.forward import Forward, OfReduction, OfSolver
from validation.fit.parameters import NUISANCES, Free, Variants
from validation.fit.records import Experiment
from validation.registry.choice import requested

_FACTORS = (
    (),
    ("memory_length", 0.1),
    ("memory_length", 10.0),
    ("memory_length", 0.3),
    ("memory_length", 3.0),
    ("ab", 0.4),
    ("ab", 2.5),
)


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
        """The scene's values, then others of the memory length, and of a and b."""
        first = np.array([one.inner(one.start) for one in self.free])
        groups = {"memory_length": ("memory_length",), "ab": ("a", "b")}
        for factor in _FACTORS:
            shift = np.zeros(first.size)
            if factor:
                words = groups[factor[0]]
                shift = np.array(
                    [np.log(factor[1]) if one.is_positive and one.key.rpartition(".")[2] in words else 0.0 for one in self.free]
                )
            if not factor or shift.any():
                inside = np.clip(first + shift, self.low[: first.size], self.high[: first.size])
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
    if kind is OfSolver and any(one.cycle for one in records):
        raise SceneError(f"model = {name!r}: stick-slip is fitted by ODE reductions only: quasidynamic, block8, modal:N, ...")
    models: list[Forward] = []
    for one in records:
        variants = Variants(scene, free, one.schedule)
        if one.cycle is None:
            models.append(kind(variants, one.times, name, tolerance))
        else:
            models.append(CycleOfReduction(disturbed(variants), one.cycle.period, name, tolerance))
    return FrictionProblem(free, records, models, tuple(name for name in NUISANCES if name in words))

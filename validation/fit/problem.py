"""The residuals of a model over all records, for least squares."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, product

import numpy as np
from scipy.optimize import brentq

from reduced.families import REDUCTIONS
from reduced.impedance.reduce import reduction_of
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.fit.cycles import CycleOfReduction, MeanCycle, disturbed, folded
from validation.fit.forward import Forward, OfReduction, OfSolver
from validation.fit.orbits import CycleOfOrbit
from validation.fit.parameters import NUISANCES, FreeParameter, Variants, sizes
from validation.fit.records import FINEST, Experiment
from validation.models.by_name import requested
from validation.models.parameter import Variation

_FACTORS = (
    ("memory_length", 0.1),
    ("memory_length", 10.0),
    ("memory_length", 0.3),
    ("memory_length", 3.0),
    ("ab", 0.4),
    ("ab", 2.5),
)
_GROUPS = {"memory_length": ("memory_length",), "ab": ("a", "b")}
_SPRINGS = ("stiffness", "shear_modulus", "thickness")
_LOGARITHM = 15.0  # of the slip rate in an event over that between two: friction falls by so many times b - a
_KAPPAS = (0.1, 0.3, 0.03, 0.6)  # of the critical stiffness
_BELOW = (0.93, 0.8, 0.5)
_RATIOS = (None, 0.6, 0.8)  # a/b; None: the scene's, if it can stick and slip


@dataclass
class FrictionProblem:
    """Friction of `records` against a model's, over the `free` keys, then the `nuisances` of each record."""

    free: tuple[FreeParameter, ...]
    records: Sequence[Experiment]
    models: Sequence[Forward]
    nuisances: tuple[str, ...]

    def __post_init__(self) -> None:
        names = [key.name for key in self.free]
        many = len(self.records) > 1
        self.own = [(k, name) for k in range(len(self.records)) for name in self.nuisances]
        self.names = [*names, *(f"{name}[{k + 1}]" if many else name for k, name in self.own)]
        bounds = [(key.inner(key.low), key.inner(key.high)) for key in self.free]
        low, high = zip(*bounds, *[(-np.inf, np.inf)] * len(self.own), strict=True)
        self.low, self.high = np.array(low), np.array(high)
        own = [float(np.ptp(self.records[k].friction[self.records[k].shown])) for k, _ in self.own]
        self.large = np.array([*(1.0 if key.is_positive else np.nan for key in self.free), *own])
        self.first = np.array([key.inner(key.start) for key in self.free])
        self.fineness = 1e-10
        self.shapes = [self._columns(k) for k in range(len(self.records))]

    def _columns(self, k: int) -> Array:
        """Derivatives of record `k` by the nuisances (samples, nuisances)."""
        record = self.records[k]
        along = (record.travel - record.travel.mean()) / max(float(np.ptp(record.travel)), 1e-300)
        is_friction = np.ones(record.travel.size)
        is_friction[0] = record.cycle is None
        kinds = {"level": is_friction, "drift": along * is_friction}
        return np.column_stack([kinds[name] * (own == k) for own, name in self.own] or [np.empty((record.travel.size, 0))])

    def friction(self, inner: Array) -> list[Array]:
        """Friction of the model for each record."""
        keys, own = inner[: len(self.free)], inner[len(self.free) :]
        return [model.friction(keys) + shape @ own for model, shape in zip(self.models, self.shapes, strict=True)]

    def residual(self, inner: Array) -> Array:
        """Friction of the model minus the measured one, over the noise of each record."""
        pairs = zip(self.friction(inner), self.records, strict=True)
        return np.concatenate([record.weighed(friction - record.friction) for friction, record in pairs])

    def slopes(self, inner: Array) -> Array:
        """As `Problem`."""
        keys = inner[: len(self.free)]
        parts = [np.column_stack([m.slopes(keys), s]) for m, s in zip(self.models, self.shapes, strict=True)]
        return np.vstack([record.weighed(part) for record, part in zip(self.records, parts, strict=True)])

    def far(self, residual: Array) -> float:
        """The `residual` over the noise, which is at least `FINEST` of each record's range of friction."""
        least = [
            FINEST * np.ptp(record.friction[record.shown]) * record.weight + 0.0 * record.friction for record in self.records
        ]
        size = float(np.linalg.norm(residual / np.maximum(np.concatenate(least), 1.0)))
        return size / math.sqrt(max(residual.size - len(self.names), 1))

    def starts(self) -> Iterator[Array]:
        """Start values: the scene's, then others."""
        first, low, high = (part[: len(self.free)] for part in (self.first, self.low, self.high))
        cycle = next((record.cycle for record in self.records if record.cycle), None)
        scene_of = self.models[0].scene
        others = _sticking_starts(self.free, first, cycle, scene_of) if cycle else _other_starts(self.free, first)
        if isinstance(self.models[0], CycleOfOrbit):
            others = chain(_unstable_starts(self.free, first, scene_of), others)
        for start in chain([first], others):
            inside = np.clip(start, low, high)
            yield np.append(inside, self._levels(inside))

    def _levels(self, inner: Array) -> Array:
        """Start values of the nuisances: mean residuals of the scene's steady friction."""
        scene = self.models[0].scene(inner)
        return np.array(
            [
                float(self.records[k].friction[1:20].mean()) - scene.steady_stress if name == "level" else 0.0
                for k, name in self.own
            ]
        )


def problem_of(
    scenes: Variation,
    free: tuple[FreeParameter, ...],
    words: Sequence[str],
    records: Sequence[Experiment],
    model: str,
    tolerance: float,
) -> FrictionProblem:
    """The problem of fitting `records` by `model`. Raises SceneError for an unknown model and one that cannot compute the
    scene."""
    family, _, number, _ = requested(model, scenes.base, tolerance=tolerance)
    kind: type[OfReduction | OfSolver] = OfReduction if family in REDUCTIONS else OfSolver
    name = family.called(family.default if number is None else number)
    with_waves = any(record.cycle for record in records) and (kind is OfSolver or _rings(scenes.base, name))
    if with_waves and len(records) > 1:
        raise SceneError(f"model = {name!r}: with every wave one record of stick-slip at a time can be fitted")

    def seen(record: Experiment) -> tuple[Experiment, Forward]:
        """A record as it is compared, and what is compared with it."""
        variants = Variants(scenes, free, record.schedule)
        if with_waves:
            return _with_waves(disturbed(variants), record, name)
        if (cycle := record.cycle) is None:
            return record, kind(variants, record.times, name, tolerance)
        if cycle.drift and "level" not in words:
            record = _of_unknown_level(record, cycle.drift)
        return record, CycleOfReduction(disturbed(variants), cycle.period, name, tolerance, cycle.phases)

    compared, models = zip(*map(seen, records), strict=True)
    return FrictionProblem(free, compared, models, tuple(name for name in NUISANCES if name in words))


def _of_unknown_level(record: Experiment, drift: float) -> Experiment:
    """The record with an error common to its friction: no one knows when within its `drift` the level was right."""
    common = np.append(0.0, np.full(record.friction.size - 1, drift / 12.0**0.5))
    return record._replace(together=np.column_stack([*([] if record.together is None else [record.together]), common]))


def _rings(scene: Scene, model: str) -> bool:
    """Whether the slabs of a reduction oscillate during stick without end."""
    reduction = reduction_of(scene, model)
    return bool(reduction.frequencies) and reduction.is_lossless


def _with_waves(variants: Variants, record: Experiment, model: str) -> tuple[Experiment, CycleOfOrbit]:
    """The record of stick-slip with all samples of its cycles, sorted by phase, and the orbit that is to be seen in it."""
    assert record.samples is not None
    cycles = folded(record.name, *record.samples, sizes(variants.scenes.base)[0])
    cycles = cycles._replace(noise=max(cycles.noise, FINEST * float(np.ptp(cycles.friction))))
    where = np.append(0.0, cycles.times - cycles.period * cycles.cycle)
    own = record._replace(
        times=where,
        friction=np.append(cycles.period, cycles.friction),
        travel=where * record.schedule.velocities[0],
        weight=np.append(0.0, np.full(where.size - 1, 1.0 / cycles.noise)),
        together=None,
    )
    return own, CycleOfOrbit(variants, cycles, model)


def _other_starts(free: Sequence[FreeParameter], first: Array) -> Iterator[Array]:
    """Start values with another memory length, and with other a and b."""
    for group, factor in _FACTORS:
        moves = [key.is_positive and _word(key) in _GROUPS[group] for key in free]
        if any(moves):
            yield first + np.log(factor) * np.array(moves, dtype=float)


def _sticking_starts(
    free: Sequence[FreeParameter], first: Array, cycle: MeanCycle, scene_of: Callable[[Array], Scene]
) -> Iterator[Array]:
    """Start values at which steady sliding is unstable, friction falls by about as much as in the mean cycle and, if the spring
    is free, rises before an event at the measured rate."""
    index = {_word(key): k for k, key in enumerate(free) if key.is_positive}
    size = cycle.friction.size
    middle = slice(size // 3, 2 * (size // 3))
    steep = float(np.polyfit(np.arange(size // 3) * cycle.period / size, cycle.friction[middle], 1)[0])
    for kappa, ratio in product(_KAPPAS, _RATIOS):
        inner = first.copy()
        for word in _SPRINGS:
            if word in index and steep > 0.0:
                inner[index[word]] = _as_stiff(free, inner, index[word], steep, scene_of)
                break
        a, b = _effects(scene_of(inner))
        share, weaker = ratio or (a / b if 0.0 < a < 0.9 * b else 0.7), cycle.drop / _LOGARITHM
        if "a" in index:
            inner[index["a"]] = np.log(weaker * share / (1.0 - share) if "b" in index else max(b - weaker, 0.1 * b))
        if "b" in index:
            inner[index["b"]] = np.log(weaker / (1.0 - share) if "a" in index else a + weaker)
        scene = scene_of(inner)
        a, b = _effects(scene)
        weaker = b - a
        if "memory_length" in index and weaker > 0.0:
            inner[index["memory_length"]] += np.log(kappa * weaker * scene.transit / scene.stiffness)
        yield inner


def _effects(scene: Scene) -> tuple[float, float]:
    """a and b of the scene's law; 0 where a law of the user's own has none."""
    parameters = scene.law._asdict()
    return parameters.get("a", 0.0), parameters.get("b", 0.0)


def _unstable_starts(free: Sequence[FreeParameter], first: Array, scene_of: Callable[[Array], Scene]) -> Iterator[Array]:
    """The first values with one of a, b and L changed, so that steady sliding is unstable: the stiffness is one of some shares of
    the critical one."""
    index = {_word(key): k for k, key in enumerate(free) if key.is_positive}
    scene = scene_of(first)
    a, b = _effects(scene)
    for kappa in _BELOW:
        inner, weaker = first.copy(), scene.stiffness / scene.transit / kappa
        if "a" in index and b > weaker:
            inner[index["a"]] = np.log(b - weaker)
        elif "b" in index:
            inner[index["b"]] = np.log(a + weaker)
        elif "memory_length" in index and b > a:
            inner[index["memory_length"]] += np.log((b - a) / weaker)
        else:
            return
        yield inner


def _as_stiff(free: Sequence[FreeParameter], inner: Array, k: int, steep: float, scene_of: Callable[[Array], Scene]) -> float:
    """The k-th value at which a locked interface is loaded at the rate `steep`; unchanged if there is none."""

    def short(x: float) -> float:
        scene = scene_of(np.where(np.arange(inner.size) == k, x, inner))
        return float(np.log(scene.stiffness * scene.velocity / sizes(scene)[0] / steep))

    low, high = free[k].inner(free[k].low), free[k].inner(free[k].high)
    with suppress(SceneError):  # there may be no scene so far away
        if short(low) * short(high) < 0.0:
            return float(brentq(short, low, high, xtol=1e-3))
    return float(inner[k])


def _word(key: FreeParameter) -> str:
    return key.name.rpartition(".")[2]

"""The plan of a sweep: the points of its axes, their scenes, and their order."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from reduced.parameters import PARAMETERS
from slipwave.errors import SceneError
from slipwave.input.overrides import apply_overrides
from slipwave.input.source import tables_of
from slipwave.scene import Scene
from validation.models.parameter import Variation
from validation.sweep.axes import Axis
from validation.sweep.measures import measure_of

MOST = 10**8
"""Most points of a sweep."""

Alone: TypeAlias = tuple[dict[str, Any], Scene]
"""The fields of a scene that a changed key affects, and whether that scene was read."""

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Plan:
    """`measure` of every model at every point of the `axes` over `scenes`. A point's number is its index in a flat array
    of shape (models, *axes). `rows`: the changes of listed scenes, instead of axes."""

    scenes: Variation
    axes: tuple[Axis, ...]
    models: tuple[str, ...]
    measure: str
    options: Mapping[str, Any] = field(default_factory=dict)
    rows: tuple[Mapping[str, float | str], ...] = ()
    _known: dict[tuple[str, float | str], Alone] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def base(self) -> Scene:
        """The scene that the axes change."""
        return self.scenes.base

    @property
    def lattice(self) -> tuple[int, ...]:
        """Points along each axis."""
        return (len(self.rows),) if self.rows else tuple(len(axis.values) for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Models and the points along each axis."""
        return (len(self.models), *self.lattice)

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def model(self, point: int) -> str:
        """The model of a point."""
        return self.models[point // math.prod(self.lattice)]

    def changes(self, point: int) -> dict[str, float | str]:
        """The keys of the scene that a point sets."""
        index = np.unravel_index(point % math.prod(self.lattice), self.lattice)
        if self.rows:
            return {self.scenes.key_of(key): value for key, value in self.rows[int(index[0])].items()}
        return {axis.name: axis.written(axis.values[int(number)]) for axis, number in zip(self.axes, index, strict=True)}

    def scene(self, point: int) -> Scene:
        """The scene of a point. Raises SceneError if its values are out of range.

        Where no two keys change the same field of a scene, scenes with one changed key are put together field by field: each is
        read and checked once, not once a point."""
        changes = self.changes(point)
        alone = [] if self.rows or self.scenes.sets else [self._alone(key, value) for key, value in changes.items()]
        if len(alone) == 1:
            return alone[0][1]
        merged = {name: value for differing, _ in alone for name, value in differing.items()}
        if not alone or len(merged) < sum(len(differing) for differing, _ in alone):
            return self.scenes.scene(changes)
        written = (
            apply_overrides(tables_of(self.base)[1], changes) if all(scene.tables is not None for _, scene in alone) else None
        )
        return replace(self.base, **merged, written=written)

    def _alone(self, key: str, value: float | str) -> Alone:
        if (key, value) not in self._known:
            scene = self.scenes.scene({key: value})
            now, before = vars(scene), vars(self.base)
            differ = {one.name: now[one.name] for one in fields(Scene) if one.init and now[one.name] != before[one.name]}
            self._known[key, value] = differ, scene
        return self._known[key, value]

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """All that determines the result except the program, for `manifest.json`."""
        return {
            "scene": self.base.name,
            "scene_digest": self.base.digest,
            "axes": [{"key": axis.name, "unit": axis.unit, "values": list(axis.values)} for axis in self.axes],
            "set": dict(self.scenes.sets),
            "rows": [dict(row) for row in self.rows],
            "models": list(self.models),
            "measure": self.measure,
            "options": dict(self.options),
        }


def require_plan(plan: Plan) -> None:
    """Raises SceneError for a plan without points or with too many, with a key twice, for an expression that is none, and for
    words and ends of axes over keys that the scene refuses."""
    if not plan.models or bool(plan.axes) == bool(plan.rows):
        raise SceneError("--vary: missing; must be KEY=FROM:TO:COUNT, as in log10_r=-2.75:-2.2:200")
    if plan.size > MOST:
        raise SceneError(f"--vary: {plan.size} points; must be at most 1e8; divide the sweep, or --refine")
    keys = [axis.name for axis in plan.axes]
    if len(set(keys)) < len(keys):
        raise SceneError(f"--vary: {max(keys, key=keys.count)} is given twice")
    for name in (axis.name for axis in plan.axes if "." not in axis.name):
        if name not in plan.scenes.variables and name not in PARAMETERS:
            raise SceneError(f"--vary {name}: is neither a key of the scene nor a variable that a --set names")
        if name in measure_of(plan.measure).columns:
            raise SceneError(f"--vary {name}: a variable must have a name that no figure of --measure {plan.measure} has")
    plan.scenes.require(plan.changes(0))
    scenes = Variation(plan.base) if plan.scenes.variables else plan.scenes
    words = {axis.name: axis.values[0] for axis in plan.axes if axis.is_of_words and scenes is plan.scenes}
    for axis in plan.axes:
        if axis.name in plan.scenes.variables or (axis.is_of_words and axis.name not in words):
            continue
        for value in axis.values if axis.is_of_words else (axis.values[0], axis.values[-1]):
            scenes.scene({**words, axis.name: axis.written(value)})


def order_of(plan: Plan) -> Indices:
    """All points of a plan in the order in which they are computed: all models at each point of the lattice."""
    return np.arange(plan.size).reshape(len(plan.models), -1).T.reshape(-1)

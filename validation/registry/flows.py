"""Every model's motion over one period as a map (`slipwave.step.flow.Flow`), by its command-line name."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.family import Family
from slipwave.scene import Scene
from slipwave.scene.start import StartKind
from validation.registry.build import families, honouring, requested, resolve
from validation.registry.families import DELAY, GRIDS, family_of, make

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipwave.observe.pieces import Array
    from slipwave.solve import Solver
    from slipwave.step.flow import Flow

_RUN = 1e-6
"""Tolerance of a run that only has to come near an orbit."""


class Moving(NamedTuple):
    """A `solver` at the scene's start, and `freeze` (solver, period), which gives its flow over a period and its present state;
    `why` `auto` took its model."""

    solver: "Solver"
    freeze: "Callable[[Any, float], tuple[Flow, Array]]"
    why: str


def has_flow(family: Family) -> bool:
    """Whether the motion of its members over a period is a differentiable map: the leapfrog's is not, for its steps cannot be
    fractions of a period."""
    return family not in GRIDS or "time" in family.options


def moving(model: str, scene: Scene, tolerance: float, cells: int | None = None) -> Moving:
    """The model called `model`, ready to look for an orbit to `tolerance`, the relative error of its figures. Full waves march
    exactly. A scene that starts on its orbit starts with the nudge.

    Raises SceneError if the drive changes, as `prepare` does, and for a model without flow.
    """
    model, why = flowing(model, scene)
    if scene.start.kind is StartKind.ORBIT:
        scene = replace(scene, start=replace(scene.start, kind=StartKind.NUDGE))
    asked = requested(model, scene, cells=cells, time="exact" if family_of(model) in GRIDS else None)
    known, scene, *_ = asked
    if known is DELAY:
        from reduced.delay.network import DelayNetwork
        from reduced.flows.delay import frozen as frozen_delay

        return Moving(DelayNetwork(scene, tolerance=_RUN), frozen_delay, why)
    return Moving(make(*asked).solver, lambda solver, period: solver.flow(period, tolerance), why)


def flowing(model: str, scene: Scene) -> tuple[str, str]:
    """As `resolve`, of the models that have a flow. Raises SceneError for another, and if the drive changes."""
    if not scene.drive.is_constant:
        raise SceneError(f"scene {scene.name!r}: a periodic orbit needs a constant drive.velocity")
    model, why = resolve(model, scene, [family for family in families() if has_flow(family)])
    family = family_of(model)
    if family is not None and not has_flow(family):
        able = ", ".join(other.pattern for other in honouring(scene) if has_flow(other))
        raise SceneError(
            f"model = {model!r}: its steps cannot be fractions of a period, so it gives no orbits; models that do: {able}"
        )
    return model, why

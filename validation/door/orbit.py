"""`slipwave.orbit`: the periodic orbit of a scene with its errors and its stability."""

from dataclasses import dataclass
from typing import Any

from slipwave.input import SceneSource
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.door.result import Result, finite, scene_of, told
from validation.registry.flows import moving
from validation.registry.orbits import OrbitFound, find_orbit, require_tolerance

SCHEMA = 1
"""Version of the keys of the JSON."""


@dataclass(frozen=True, repr=False, eq=False)
class OrbitResult(Result):
    """The orbit that was `found`."""

    found: OrbitFound

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave orbit` (users rely on its keys); `si` is there only for scenes in SI."""
        done = self.found
        orbit, multipliers, scene = done.found.orbit, done.found.multipliers, done.scene
        result = {
            "schema": SCHEMA,
            "scene": scene.name,
            "model": done.flow.model,
            "clock": "transit",
            **orbit.values(),
            "period_time": orbit.period.value * scene.transit,
            "stable": multipliers.stable,
            "multipliers": [[value.real, value.imag] for value in multipliers.values.tolist()],
            "trivial_defect": multipliers.trivial_defect,
            "residual": done.found.closed.residual,
            "error_estimate": {name: getattr(orbit, name).error for name in ("period", "stress_drop")},
            "essential_radius": multipliers.essential_radius,
            "wall_s": done.wall_s,
            "notes": [*doubts(scene), *done.notes],
        }
        return dict(finite(result | ({"si": _in_si(orbit.values(), scene)} if scene.units else {})))


def orbit(
    source: SceneSource, model: str = "auto", *, tol: float = 1e-8, cells: int | None = None, **changes: Any
) -> OrbitResult:
    """The periodic orbit that a run of the scene leads to, stable or not, to the relative error `tol`, and its Floquet
    multipliers; `changes` are those of `slipwave.read_scene`. A full wave (`cells` per slab) marches exactly in time.

    Raises SceneError for wrong input, NumericsError if there is no orbit.
    """
    require_tolerance(tol)
    chosen = moving(model, scene_of(source, changes), tol, cells)
    if chosen.why:
        told.info("model auto: %s (%s)", chosen.solver.model, chosen.why)
    return OrbitResult(find_orbit(chosen, tol))


def _in_si(values: dict[str, float], scene: Scene) -> dict[str, float]:
    units = scene.units
    assert units is not None
    transit = scene.transit * units.time
    return {
        "period_s": values["period"] * transit,
        **{f"{name}_Pa": values[name] * units.normal_stress for name in ("stress_drop", "elastic_stress_drop")},
        **{f"{name}_m_per_s": values[name] * units.reference_velocity for name in ("v_max", "v_min")},
        "transit_s": transit,
    }

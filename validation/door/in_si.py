"""The `si` of the JSON: figures of a cycle in seconds, pascals and metres per second."""

from collections.abc import Mapping

from slipwave.scene import Scene


def cycle_in_si(values: Mapping[str, float], scene: Scene) -> dict[str, dict[str, float]]:
    """{"si": the `values` of a cycle (period in transits) in SI} for a scene with units, else nothing."""
    units = scene.units
    if units is None:
        return {}
    transit = scene.transit * units.time
    return {
        "si": {
            "period_s": values["period"] * transit,
            **{f"{name}_Pa": values[name] * units.normal_stress for name in ("stress_drop", "elastic_stress_drop")},
            **{f"{name}_m_per_s": values[name] * units.reference_velocity for name in ("v_max", "v_min")},
            "transit_s": transit,
        }
    }

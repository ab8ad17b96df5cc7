"""What is said of a motion that repeats, by whatever way it was found."""

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Estimate:
    """A value and its error; of a settled run, half the spread of the last cycles about it."""

    value: float
    error: float


@dataclass(frozen=True)
class Orbit:
    """What a run is judged by (MODEL.md section 6): period in transits, drops in units of the normal stress, rates in V*."""

    period: Estimate
    stress_drop: Estimate
    elastic_stress_drop: Estimate
    v_max: Estimate
    v_min: Estimate

    def values(self) -> dict[str, float]:
        """Name -> value."""
        return {field.name: getattr(self, field.name).value for field in fields(self)}

"""The quantities of a motion that repeats, whichever method found it."""

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Estimate:
    """A value and its error; for a settled run the error is half of (max - min) over the last cycles."""

    value: float
    error: float


@dataclass(frozen=True)
class Orbit:
    """The outputs of a run (MODEL.md section 6): period in transits, drops in units of the normal stress, rates in V*."""

    period: Estimate
    stress_drop: Estimate
    elastic_stress_drop: Estimate
    v_max: Estimate
    v_min: Estimate

    def values(self) -> dict[str, float]:
        """Name -> value."""
        return {field.name: getattr(self, field.name).value for field in fields(self)}

"""Numbers of a scene file: finite and in a stated range. Integers are allowed; booleans and text are not."""

import math
import numbers
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError


@dataclass(frozen=True)
class Range:
    """The closed range [low, high], used as a pydantic validator."""

    low: float
    high: float

    def __call__(self, value: Any) -> float:
        """`value` as a float; raises the pydantic error that states the range."""
        if isinstance(value, numbers.Real) and not isinstance(value, bool):
            try:
                number = float(value)
            except (OverflowError, ValueError):
                number = math.inf
            if self.low <= number <= self.high:
                return number
        raise PydanticCustomError("range", "must be {allowed}", {"allowed": str(self)})

    def __str__(self) -> str:
        return f"a number from {self.low:g} to {self.high:g}"


EPSILON = Range(1e-12, 1e6)
ROUND_TRIP = Range(1e-9, 1e6)
VELOCITY = Range(1e-12, 1e12)
TIME = Range(0.0, 1e9)

Epsilon: TypeAlias = Annotated[float, BeforeValidator(EPSILON)]
RoundTrip: TypeAlias = Annotated[float, BeforeValidator(ROUND_TRIP)]
LogRoundTrip: TypeAlias = Annotated[float, BeforeValidator(Range(-9.0, 6.0))]
Physical: TypeAlias = Annotated[float, BeforeValidator(Range(1e-15, 1e15))]
"""A positive quantity in SI units."""

Relative: TypeAlias = Annotated[float, BeforeValidator(Range(1e-9, 1e9))]
"""A positive ratio."""

NON_NEGATIVE = Range(0.0, 1e9)
NonNegative: TypeAlias = Annotated[float, BeforeValidator(NON_NEGATIVE)]
Machine: TypeAlias = Annotated[float, BeforeValidator(Range(0.0, 1e15))]
"""In SI units where the scene has units; relative to the slab it must be in `NON_NEGATIVE`."""

Fraction: TypeAlias = Annotated[float, BeforeValidator(Range(1e-9, 1.0))]
Coefficient: TypeAlias = Annotated[float, BeforeValidator(Range(-1.0, 1.0))]
Relaxation: TypeAlias = Annotated[float, BeforeValidator(Range(1e-15, 1e9))]
Until: TypeAlias = Annotated[float, BeforeValidator(Range(1e-3, 1e9))]
Size: TypeAlias = Annotated[float, BeforeValidator(Range(-100.0, 100.0))]

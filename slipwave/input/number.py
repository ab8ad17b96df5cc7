"""Numbers of a scene file: finite and in a stated range, some of them with a unit. Integers are allowed; booleans are not."""

import math
import numbers
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, PlainValidator
from pydantic_core import PydanticCustomError

from slipwave.input.quantity import Quantity, examples, looks_measured, quantity


@dataclass(frozen=True)
class Range:
    """The closed range [low, high], used as a pydantic validator."""

    low: float
    high: float

    def __call__(self, value: Any) -> float:
        """`value` as a float; raises the pydantic error that states the range."""
        if not isinstance(value, bool) and isinstance(value, numbers.Real):
            try:
                number = float(value)
            except (OverflowError, ValueError):
                number = math.inf
            if self.low <= number <= self.high:
                return number
        raise PydanticCustomError("range", "must be {allowed}", {"allowed": str(self)})

    def __str__(self) -> str:
        return f"a number from {self.low:g} to {self.high:g}"


@dataclass(frozen=True)
class Measured(Range):
    """A number in [low, high], or a text with one of `units` ("5 MPa"), which becomes a `Quantity`; used as a pydantic
    validator."""

    units: tuple[str, ...]

    def __call__(self, value: Any) -> Any:
        """`value` as a float or a `Quantity`; raises the pydantic error that states what is allowed."""
        if not (isinstance(value, str) and looks_measured(value)):
            return super().__call__(value)
        try:
            return quantity(value, *self.units)
        except ValueError as error:
            raise PydanticCustomError("range", "{reason}", {"reason": str(error)}) from None

    def __str__(self) -> str:
        return f"{super().__str__()}, or with a unit, as in {examples(self.units)}"


@dataclass(frozen=True)
class Physical(Measured):
    """A number in SI units in [low, high], or a text with such a unit; both become a float in SI."""

    def __call__(self, value: Any) -> float:
        """As `Measured`, but a float in all cases."""
        given = super().__call__(value)
        return Range.__call__(self, given.value if isinstance(given, Quantity) else given)


def _physical(unit: str) -> Physical:
    return Physical(1e-15, 1e15, (unit,))


EPSILON = Range(1e-12, 1e6)
ROUND_TRIP = Range(1e-9, 1e6)
VELOCITY = Measured(1e-12, 1e12, ("m/s",))
LATER_VELOCITY = Measured(0.0, VELOCITY.high, VELOCITY.units)
TIME = Measured(0.0, 1e9, ("s",))
RELAXATION = Measured(1e-15, 1e9, ("s",))
RELATIVE = Range(1e-9, 1e9)
NON_NEGATIVE = Range(0.0, 1e9)
UNTIL = Measured(1e-3, 1e9, ("s",))

Epsilon: TypeAlias = Annotated[float, BeforeValidator(EPSILON)]
RoundTrip: TypeAlias = Annotated[float, BeforeValidator(ROUND_TRIP)]
LogRoundTrip: TypeAlias = Annotated[float, BeforeValidator(Range(-9.0, 6.0))]

Stress: TypeAlias = Annotated[float, BeforeValidator(_physical("Pa"))]
Length: TypeAlias = Annotated[float, BeforeValidator(_physical("m"))]
Area: TypeAlias = Annotated[float, BeforeValidator(_physical("m2"))]
Speed: TypeAlias = Annotated[float, BeforeValidator(_physical("m/s"))]
Density: TypeAlias = Annotated[float, BeforeValidator(_physical("kg/m3"))]

Relative: TypeAlias = Annotated[float, BeforeValidator(RELATIVE)]
"""A positive ratio."""

GripStiffness: TypeAlias = Annotated[float | Quantity, PlainValidator(Measured(RELATIVE.low, RELATIVE.high, ("Pa/m",)))]
GripImpedance: TypeAlias = Annotated[float | Quantity, PlainValidator(Measured(NON_NEGATIVE.low, NON_NEGATIVE.high, ("Pa s/m",)))]
MachineStiffness: TypeAlias = Annotated[float | Quantity, PlainValidator(Measured(0.0, 1e15, ("Pa/m", "N/m")))]
MachineImpedance: TypeAlias = Annotated[float | Quantity, PlainValidator(Measured(0.0, 1e15, ("Pa s/m", "N s/m")))]
MachineMass: TypeAlias = Annotated[float | Quantity, PlainValidator(Measured(0.0, 1e15, ("kg/m2", "kg")))]
"""Of a machine: in SI units where the scene has units; relative to the slab they must be in `NON_NEGATIVE`."""

Fraction: TypeAlias = Annotated[float, BeforeValidator(Range(1e-9, 1.0))]
Coefficient: TypeAlias = Annotated[float, BeforeValidator(Range(-1.0, 1.0))]
Relaxation: TypeAlias = Annotated[float | Quantity, PlainValidator(RELAXATION)]
Until: TypeAlias = Annotated[float | Quantity, PlainValidator(UNTIL)]
Size: TypeAlias = Annotated[float, BeforeValidator(Range(-100.0, 100.0))]

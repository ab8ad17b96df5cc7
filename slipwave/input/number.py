"""Numbers of a scene file: finite and in a stated range, some of them with a unit. Integers are allowed; booleans are not."""

import math
import numbers
from dataclasses import dataclass
from typing import Any

from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from slipwave.input.quantity import KINDS, Quantity, examples, looks_measured, quantity


@dataclass(frozen=True)
class Numbers:
    """The numbers from `low` to `high`, as metadata of a key's type: its validator and its JSON Schema.

    With `units` a text with one of them ("5 MPa") is allowed too and becomes a `Quantity`. `bare` says what numbers without a
    unit are in.
    """

    low: float
    high: float
    units: tuple[str, ...] = ()
    bare: str = ""

    def __call__(self, value: Any) -> Any:
        """`value` as a float or a `Quantity`; raises the pydantic error that states what is allowed."""
        if self.units and isinstance(value, str) and looks_measured(value):
            try:
                return quantity(value, *self.units)
            except ValueError as error:
                raise PydanticCustomError("range", "{reason}", {"reason": str(error)}) from None
        if not isinstance(value, bool) and isinstance(value, numbers.Real):
            try:
                number = float(value)
            except (OverflowError, ValueError):
                number = math.inf
            if self.low <= number <= self.high:
                return number
        raise self.refusal()

    def refusal(self) -> PydanticCustomError:
        """The error that states what is allowed."""
        return PydanticCustomError("range", "must be {allowed}", {"allowed": str(self)})

    def __str__(self) -> str:
        number = f"a number from {self.low:g} to {self.high:g}"
        return f"{number}, or with a unit, as in {examples(self.units)}" if self.units else number

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        return self.json_schema()

    def json_schema(self) -> dict[str, Any]:
        """The range, and a text that begins with a number if there are units, in the words of JSON Schema."""
        number = {"type": "number", "minimum": self.low, "maximum": self.high}
        measured = {"type": "string", "pattern": r"^\s*[-+]?\.?\d", "examples": [KINDS[unit][1] for unit in self.units]}
        return {"anyOf": [number, measured]} if self.units else number


class Physical(Numbers):
    """A number in SI units in the range, or a text with such a unit; both become a float in SI."""

    def __call__(self, value: Any) -> Any:
        """As `Numbers`, but a float in all cases."""
        given = super().__call__(value)
        return super().__call__(given.value) if isinstance(given, Quantity) else given


def physical(unit: str) -> Physical:
    """Any number that a laboratory may have, in the SI `unit`."""
    return Physical(1e-15, 1e15, (unit,))


EPSILON = Numbers(1e-12, 1e6)
ROUND_TRIP = Numbers(1e-9, 1e6)
VELOCITY = Numbers(1e-12, 1e12, ("m/s",), "in V*")
LATER_VELOCITY = Numbers(0.0, VELOCITY.high, VELOCITY.units, VELOCITY.bare)
TIME = Numbers(0.0, 1e9, ("s",), "of transits")
RELAXATION = Numbers(1e-15, 1e9, ("s",), "in L/V*")
UNTIL = Numbers(1e-3, 1e9, ("s",), "of transits")
RATIO = Numbers(1e-9, 1e9)
"""Of two quantities of the same kind."""

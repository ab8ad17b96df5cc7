"""Values that were given with a unit, in the units of the scene (15)."""

from fractions import Fraction

from slipwave.errors import SceneError
from slipwave.input.number import TIME, Range
from slipwave.input.quantity import Quantity, looks_measured, quantity
from slipwave.scene import Scene
from slipwave.scene.units import Units

UNIT_KEYS = ("normal_stress", "memory_length", "reference_velocity")


def require_units(key: str, given: str, units: Units | None, instead: str) -> Units:
    """`units`, if the scene has them. Raises SceneError for `key`, which is in SI, if it has none."""
    if units is None:
        keys = f"interface.{', '.join(UNIT_KEYS[:-1])} and {UNIT_KEYS[-1]}"
        raise SceneError(f"{key} = {given}: must come with {keys} (SI), or be {instead}")
    return units


def quotient(value: float, unit: float) -> float:
    """value/unit, correctly rounded, for the decimal numbers that they print as: 1e-5/1e-6 is 10, not 10.000000000000002."""
    return float(Fraction(repr(value)) / Fraction(repr(unit)))


def in_time(key: str, given: float | Quantity, units: Units | None, allowed: Range) -> float:
    """A time on the friction clock: a number is in L/V* already."""
    if not isinstance(given, Quantity):
        return given
    second = 1.0 / require_units(key, f'"{given.text}"', units, "a number in L/V*").time
    return _allowed(key, given, given.value * second, "L/V*", allowed)


def in_transits(key: str, given: float | Quantity, units: Units | None, transit: float, allowed: Range) -> float:
    """A time in transits of `transit` L/V*: a number is in transits already."""
    if not isinstance(given, Quantity):
        return given
    second = 1.0 / (require_units(key, f'"{given.text}"', units, "a number of transits").time * transit)
    return _allowed(key, given, given.value * second, "transits", allowed)


def moment(key: str, given: float | str, scene: Scene) -> float:
    """A time given to a command, a number or a text with or without a unit, in transits. Raises ValueError for what is no time,
    SceneError for a unit in a scene without units."""
    if isinstance(given, str) and looks_measured(given):
        return in_transits(key, quantity(given, "s"), scene.units, scene.transit, TIME)
    return float(given)


def in_reference_velocity(key: str, given: float | Quantity, units: Units | None, allowed: Range) -> float:
    """A velocity in V*: a number is in V* already."""
    if not isinstance(given, Quantity):
        return given
    one = require_units(key, f'"{given.text}"', units, "a number in V*").reference_velocity
    return _allowed(key, given, quotient(given.value, one), "V*", allowed)


def _allowed(key: str, given: Quantity, result: float, unit: str, allowed: Range) -> float:
    if not allowed.low <= result <= allowed.high:
        raise SceneError(
            f'{key} = "{given.text}": is {result:.9g} {unit}, which must be from {allowed.low:g} to {allowed.high:g}'
        )
    return result

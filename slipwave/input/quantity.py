"""Numbers with units, as in "5 MPa": read by pint, which is loaded with the first of them."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, lru_cache
from typing import TYPE_CHECKING

from slipwave.input.wording import choices, nearest

if TYPE_CHECKING:
    import pint

KINDS = {
    "Pa": ("stress", "5 MPa"),
    "m": ("length", "10 um"),
    "m2": ("area", "25 cm2"),
    "m/s": ("velocity", "1 um/s"),
    "s": ("time", "60 s"),
    "Hz": ("frequency", "1 kHz"),
    "N": ("force", "10 kN"),
    "kg": ("mass", "2 kg"),
    "kg/m2": ("mass per area", "400 kg/m2"),
    "kg/m3": ("density", "2.7 g/cm3"),
    "1/m": ("stiffness over normal stress", "2e-3 /um"),
    "N/m": ("stiffness", "100 kN/mm"),
    "N s/m": ("damping", "1 kN s/m"),
    "Pa/m": ("stiffness per area", "1 GPa/m"),
    "Pa s/m": ("damping per area", "1 MPa s/m"),
}
"""SI unit of a scene's keys -> the quantity it measures, and an example."""

_USUAL = tuple(
    "Pa kPa MPa GPa bar m km cm mm um nm s ms us min h kg g t N kN MN m2 cm2 mm2 m3 cm3 mm/s um/s nm/s mm/yr g/cm3".split()  # noqa: SIM905
)
_POWER = r"[^\W\d_]{1,20}(?:[²³]|(?:\^|\*\*)?-?[1-9])?"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?"
_TEXT = re.compile(rf"\s*({_NUMBER})\s*((?:(?<!\d)1?\s*/\s*)?{_POWER}(?:\s*[ */·]\s*{_POWER}){{0,5}})\s*")


@dataclass(frozen=True)
class Quantity:
    """A number that was given with a unit: its `value` in the SI `unit`, and the `text` itself."""

    value: float
    unit: str
    text: str


def looks_measured(text: str) -> bool:
    """Whether `text` is a number followed by something that may be a unit, which the e3 of 1e3 is not."""
    return _TEXT.fullmatch(text) is not None and re.fullmatch(_NUMBER, text.strip()) is None


def quantity(text: str, *units: str) -> Quantity:
    """`text`, as in "5 MPa", in the one of `units` (SI, of `KINDS`) that has its dimension.

    Raises ValueError for anything else; the message begins with what is wrong or with "must be".
    """
    wanted = f"must have a unit of {' or '.join(KINDS[unit][0] for unit in units)}, as in {examples(units)}"
    match = _TEXT.fullmatch(text)
    if match is None:
        raise ValueError(wanted)
    number, written = match.groups()
    for unit in units:
        value = _converted(number, written, unit)
        if value is not None:
            return Quantity(value, unit, text)
    # a unit of the right dimension that differs in the case of letters, else one that resembles what was written
    by_lower_case = {usual.lower(): usual for usual in _USUAL}
    recased = re.sub(r"[^\W\d_]+", lambda word: by_lower_case.get(word[0].lower(), word[0]), written)
    others = (guess for guess in (recased, nearest(written, _USUAL)) if guess and guess != written)
    meant = next((guess for guess in others if any(_converted("1", guess, unit) is not None for unit in units)), None)
    is_known = _converted("1", written, written) is not None
    reason = f'{wanted}, not "{written}"' if is_known else f'"{written}" is not a unit; {wanted}'
    raise ValueError(f'{reason}; did you mean "{number} {meant}"?' if meant else reason)


def examples(units: Iterable[str]) -> str:
    """Example texts in `units`, as in `"5 MPa" or "10 um"`."""
    return choices(KINDS[unit][1] for unit in units)


@lru_cache(maxsize=4096)
def _converted(number: str, written: str, unit: str) -> float | None:
    """Convert `number` from `written` to `unit`; None if impossible."""
    from pint.errors import PintError

    registry = _registry()
    try:
        given = registry.Quantity(Decimal(number), registry.parse_units(re.sub(r"^\s*/", "1/", written)))
        return float(given.to(registry.parse_units(unit)).magnitude)
    except (PintError, ArithmeticError, ValueError):  # pint's offset units and Decimal have errors of their own
        return None


@cache
def _registry() -> "pint.UnitRegistry[Decimal]":
    """All units that pint knows, and m2 for m**2; decimal, so that 2.7 g/cm3 are 2700 kg/m3 and not 2699.9999999999995."""
    import pint

    return pint.UnitRegistry(
        non_int_type=Decimal, preprocessors=[lambda text: re.sub(r"(?<=[^\W\d_])(-?[1-9])\b", r"**\1", text)]
    )

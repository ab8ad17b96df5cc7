"""The quantities of a record: names of their columns, units in SI and in a scene's own units."""

import math
import re
from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple, TypeAlias
from unicodedata import normalize

from slipwave.errors import SceneError
from slipwave.input.quantity import quantity
from slipwave.input.wording import choices, shorten
from slipwave.scene import Scene
from slipwave.scene.units import IN_SI


class _Measured(NamedTuple):
    """A quantity: its unit in SI, that in a scene's own units (both empty for a pure number), other names of its columns, and
    units to name in a refusal."""

    unit: str
    own: str
    names: tuple[str, ...]
    usual: str = ""


_PULLS = ("load_point", "loadpoint", "load", "loading", "lp", "vert", "vertical", "axial", "ram", "piston", "actuator", "stage")
_RATES = "m/s, mm/s, um/s, nm/s, V*"
_LENGTHS, _STRESSES = "m, mm, um, nm, L", "Pa, kPa, MPa, GPa, bar, psi, normal stress"

MEASURED = {
    "time": _Measured("s", "transit", ("t", "times", "elapsed_time", "seconds"), "s, ms, us, min, h, d, transits"),
    "load_point_displacement": _Measured(
        "m",
        "L",
        (
            *("disp", "displacement", "load_point", "loadpoint", "lp", "x_lp", "u_lp", "d_lp", "delta_lp", "lpdisp", "disp_lp"),
            *(f"{who}_{what}" for what in ("disp", "displacement") for who in _PULLS),
        ),
        _LENGTHS,
    ),
    "load_point_velocity": _Measured(
        "m/s",
        "V*",
        (
            *("load_velocity", "loading_velocity", "load_rate", "loading_rate", "drive_velocity", "driving_velocity"),
            *("v_lp", "vlp", "v_load", "load_point_rate"),
        ),
        _RATES,
    ),
    "slip": _Measured("m", "L", ("delta", "slip_2", "fault_slip", "slip_displacement", "onboard_disp", "obdisp"), _LENGTHS),
    "slip_rate": _Measured("m/s", "V*", ("v", "sliprate", "slip_rate_2", "slip_velocity"), _RATES),
    "shear_stress": _Measured("Pa", "normal stress", ("tau", "stress", "shear", "shear_stress_2"), _STRESSES),
    "friction": _Measured("", "", ("mu", "cof")),
    "normal_stress": _Measured("Pa", "normal stress", ("sigma", "sigma_n", "normal", "sn"), _STRESSES),
    "state": _Measured("s", "L/V*", ("theta", "state_variable"), "s, L/V*"),
}
"""Name of its column here -> quantity. Names are compared in lower case, with _ for other characters, in any order of words."""

_FILLERS = ("of", "the", "coefficient", "coeff", "coef", "eff", "effective")
_GREEK = {"μ": "mu", "τ": "tau", "σ": "sigma", "δ": "delta"}
_OWN = {"transits": "transit", **{quantity.own.lower(): quantity.own for quantity in MEASURED.values() if quantity.own}}
_PURE = ("", "-", "1", "none", "dimensionless")
_IN_BRACKETS = re.compile(r"(.*?)\s*[\[({]([^\])}]*)[\])}]\s*")
SEAS = {"t": "s", "slip": "m", "slip_rate": "log10 m/s", "shear_stress": "MPa", "state": "log10 s"}
"""Columns of a record of the SEAS benchmarks with the units that their headings leave out; those in two directions end in _2."""


class Unit(NamedTuple):
    """The size of a column's unit in SI, or in the scene's own units if it `is_own`; `is_log`: the column holds log10."""

    size: float
    is_own: bool = False
    is_log: bool = False


Heading: TypeAlias = tuple[str, str | None]
"""A column's quantity (a key of MEASURED; empty for one that is not read), and its unit as written, None where there is none."""


def _words(name: str) -> frozenset[str]:
    """The words of a name, regardless of order."""
    return frozenset(name.split("_")).difference(_FILLERS)


_NAMES = {_words(name): key for key, quantity in MEASURED.items() for name in (key, *quantity.names)}


def heading(text: str) -> Heading:
    """Quantity and unit of the heading of a column, as in "Time [s]", "tau(MPa)", "mu", "disp_um", "log10 slip rate [m/s]"."""
    text = text.strip().strip("\"'").strip()
    bracketed = _IN_BRACKETS.fullmatch(text)
    name, unit = (_plain(bracketed[1]), bracketed[2].strip()) if bracketed else (_plain(text), None)
    for prefix in ("log10_", "log_"):
        if name.startswith(prefix) and _words(name.removeprefix(prefix)) in _NAMES:
            name, unit = name.removeprefix(prefix), f"log10 {unit or ''}".strip()
    key = _NAMES.get(_words(name), "")
    return (key, unit) if key or unit is not None else next(_ending_in_unit(text), (key, unit))


def _plain(text: str) -> str:
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", normalize("NFKC", text)).lower()  # LoadPoint; two signs are called mu
    for letter, name in _GREEK.items():
        apart = apart.replace(letter, name)
    return re.sub(r"[\W_]+", "_", apart).strip("_")


def _ending_in_unit(text: str) -> Iterator[Heading]:
    """`text` cut in two at each separator, the longest beginning first, where these are a quantity and a unit of it."""
    for begin, end in reversed([separator.span() for separator in re.finditer(r"\s*[_/, ]\s*", text)]):
        key, unit = _NAMES.get(_words(_plain(text[:begin]))), text[end:].replace("_per_", "/").replace("_", " ")
        if key and unit and _size(unit, key) is not None:
            yield key, unit


def unit_of(written: str | None, key: str, where: str, area: float | None = None) -> Unit | None:
    """The unit that was `written` for a column of MEASURED[key]; None if none was written. A force is a stress on an `area` (m2).
    Raises SceneError, which begins with `where`, for one that does not fit."""
    if written is None:
        return None
    unit = _size(written, key)
    if unit is None and MEASURED[key].unit == "Pa":
        with suppress(ValueError):
            unit = Unit(quantity(f"1 {written}", "N").value / (area or math.nan))
        if unit and area is None:
            raise SceneError(f"{where}: unit {shorten(written)} is a force: --area says on what, as in --area='25 cm2'")
    if unit is None and not MEASURED[key].unit:
        raise SceneError(f"{where}: unit {shorten(written)} does not fit: it is a pure number")
    if unit is None:
        raise SceneError(f"{where}: unit {shorten(written)} is not known there: known are {MEASURED[key].usual}, log10 of them")
    return unit


def _size(written: str, key: str) -> Unit | None:
    """The unit; None if `written` is none of this quantity."""
    is_log = written.lower().startswith("log10")
    text, known = (written[5:].strip(" ()[]") if is_log else written.strip()), MEASURED[key]
    if not known.unit:
        return Unit(0.01 if text == "%" else 1.0, is_log=is_log) if text.lower() in (*_PURE, "%") else None
    if _OWN.get(text.lower(), "") == known.own:
        return Unit(1.0, True, is_log)
    if is_log and not text:
        return Unit(1.0, is_log=True)
    try:
        return Unit(quantity(f"1 {text}", known.unit).value, is_log=is_log)
    except ValueError:
        return None


def name_of_quantity(text: str, where: str) -> str:
    """The key of MEASURED named by a user's word. Raises SceneError, which begins with `where`, if there is none."""
    name, _ = heading(text)
    if not name:
        raise SceneError(f"{where}: {shorten(text)} is no quantity of a record: {choices(MEASURED, text)}")
    return name


def unit_sizes(scene: Scene) -> dict[str, float]:
    """SI size of each unit of a scene, 1 for a scene without SI."""
    known = scene.units
    if known is None:
        return dict.fromkeys((quantity.own for quantity in MEASURED.values()), 1.0)
    return {"": 1.0, "L/V*": known.time} | {unit: known.size(unit, scene.transit) for unit in IN_SI}

"""Reads a scene, from the gallery, a TOML file or a dictionary: validates its tables, combines keys that depend on each other and
converts SI (15) to a frozen `Scene`. Data only; nothing is executed.

Values that were given with a unit are converted to the units of the scene (`_in_scene`). A scene is also given by the tables that
it was read from: written as TOML, or read again with changes.
"""

import copy
import math
import numbers
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

import slipwave.input.schema as keys
from slipwave.errors import SceneError
from slipwave.friction import LAWS
from slipwave.friction.law import is_registered
from slipwave.input.complaint import complaint
from slipwave.input.overrides import apply_overrides, parse_toml
from slipwave.input.quantity import KINDS, Quantity, looks_measured, quantity
from slipwave.input.schema import Numbers, allowed_numbers
from slipwave.input.stored import read_stored
from slipwave.input.wording import nearest, one_line, sentence, shorten
from slipwave.observe.pieces import slack
from slipwave.scene import Scene
from slipwave.scene.drive import Drive, Start, StartKind
from slipwave.scene.scene import doubt
from slipwave.scene.slab import (
    FACES,
    VISCOSITIES,
    Face,
    Layer,
    MachineFace,
    Material,
    Slab,
    Viscosity,
    face_sizes,
)
from slipwave.scene.units import Units

SceneSource: TypeAlias = str | Path | Mapping[str, Any] | Scene
"""A gallery name, the path of a TOML file, a dictionary of the same shape, or a scene that was read before."""

LARGEST_FILE = 1_000_000
"""Bytes; a longer file is not a scene."""

_GALLERY = Path(__file__).resolve().parent.parent / "gallery"
_PER_AREA = {"N/m": "Pa/m", "N s/m": "Pa s/m", "kg": "kg/m2"}
_LARGEST_RATIO = 1e9


@cache
def gallery_names() -> tuple[str, ...]:
    """Names of the gallery's scenes, sorted."""
    return tuple(sorted(path.stem for path in _GALLERY.glob("*.toml")))


@cache
def _of_gallery(name: str) -> dict[str, Any]:
    """The tables of a scene of the gallery, cached; not to be changed."""
    return _parse(_GALLERY / f"{name}.toml")


def gallery_titles() -> dict[str, str]:
    """Name and one-line title of every scene of the gallery."""
    return {name: str(_of_gallery(name).get("title", "")) for name in gallery_names()}


def is_stored(source: object) -> bool:
    """Whether `source` is the path of a file of results."""
    return isinstance(source, str | Path) and Path(source).suffix == ".nc"


def load_tables(source: SceneSource) -> tuple[str, dict[str, Any]]:
    """(default name, raw tables) of a gallery name, the path of a file, a dictionary (copied) or a scene.

    Raises SceneError when there is no such scene, the file is not a TOML text under 1 MB with keys of 20 parts at most, or a key
    of the dictionary is no text.
    """
    if isinstance(source, Scene):
        return tables_of(source)
    if isinstance(source, Mapping):
        return "scene", _copied(source)
    if not isinstance(source, str | Path):
        raise SceneError(f"SCENE = {shorten(source)}: must be a gallery name, the path of a TOML file, or a dictionary")
    if isinstance(source, str) and source in gallery_names():
        return source, copy.deepcopy(_of_gallery(source))
    return one_line(Path(source).stem), read_stored(source).tables if is_stored(source) else _parse(Path(source))


def _copied(tables: Mapping[Any, Any], above: str = "") -> dict[str, Any]:
    """The tables of a dictionary as they would be in TOML: keys are texts, arrays and tuples are lists."""
    for key in tables:
        if not isinstance(key, str):
            raise SceneError(f"{above}{key!r}: must be a text, as every key of a scene")
    return {
        key: _copied(value, f"{above}{key}.") if isinstance(value, Mapping) else _listed(copy.deepcopy(value))
        for key, value in tables.items()
    }


def _parse(path: Path) -> dict[str, Any]:
    """The tables of a TOML file. Raises SceneError if it cannot be read, whatever the reason."""
    try:
        return parse_toml(_content(path).decode("utf-8-sig").replace("\r\n", "\n"))
    except SceneError:
        raise
    except UnicodeDecodeError as error:
        reason = f"must be a TOML file in UTF-8; byte {error.start} is not"
    except RecursionError:
        reason = "nested too deeply to be a scene file"
    except OSError as error:
        reason = f"cannot be read: {error.strerror or error}"
    except ValueError as error:  # TOMLDecodeError, and integers with too many digits
        reason = f"must be a TOML file; {sentence(str(error))}"
    raise SceneError(f"SCENE = {shorten(str(path))}: {reason}")


def _content(path: Path) -> bytes:
    """The bytes of a file. Raises SceneError if there is no such file or it is too long, OSError if it cannot be read."""
    try:
        if not path.is_file():
            raise SceneError(f"SCENE = {shorten(str(path))}: {_why_not_a_file(path)}")
    except ValueError as error:
        if isinstance(error, SceneError):
            raise
        # the path holds a character that none may have
        raise SceneError(f"SCENE = {shorten(str(path))}: cannot be read: {error}") from None
    with path.open("rb") as stream:
        content = stream.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        problem = f"longer than {LARGEST_FILE // 1_000_000} MB; a scene file is a short TOML text"
        raise SceneError(f"SCENE = {shorten(str(path))}: {problem}")
    return content


def _why_not_a_file(path: Path) -> str:
    if path.exists():
        return f"must be a TOML file or a gallery name; this is {'a folder' if path.is_dir() else 'not a regular file'}"
    what, known = f"neither a file nor one of the gallery: {', '.join(gallery_names())}", list(gallery_names())
    if path.suffix or len(path.parts) > 1:
        what, known = "no such file", [str(other) for other in path.parent.glob("*.toml") if other.exists()]
    guess = path.stem if path.stem in gallery_names() else nearest(str(path), known)
    return f'{what}; did you mean "{guess}"?' if guess else what


def tables_of(scene: Scene) -> tuple[str, dict[str, Any]]:
    """(name, tables) of a scene; the inner ones are its own, not to be changed. Raises SceneError if it was not read:
    `dataclasses.replace` drops the tables."""
    if scene.tables is None:
        raise SceneError(f"scene {scene.name!r}: was made in Python, not read, so its keys cannot be changed or written")
    return scene.name, dict(scene.tables)


def read(source: SceneSource, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Scene:
    """The `Scene` of a gallery name, a TOML file or a dictionary of the same shape, with single keys overridden.

    `overrides` is a list of "key=value" (dotted key, TOML value) or a dictionary {"slab.log10_r": -2.3}; see
    `slipwave.input.overrides`. A scene that was read before is read again from its tables, also without overrides if its law
    was loaded anew since. Reading runs no code. Raises SceneError: one line that names the key, the value and what is allowed.
    """
    if isinstance(source, Scene) and not overrides and (source.tables is None or is_registered(source.law)):
        return source
    name, data = load_tables(source)
    data = apply_overrides(data, overrides) if overrides else data
    tables = validate(data)
    run, start, interface = tables.run, tables.start, dict(tables.interface)
    in_si = {key: interface[key] for key in keys.UNIT_KEYS if interface[key] is not None}
    if in_si and len(in_si) < len(keys.UNIT_KEYS):
        missing = next(key for key in keys.UNIT_KEYS if key not in in_si)
        raise SceneError(f"interface.{missing}: missing; must be given with {' and '.join(sorted(in_si))} (all three or none)")
    units = Units(**in_si) if in_si else None
    law = LAWS[tables.interface.law].parameters
    upper, lower = _in_machine(tables, _slabs(tables, units), units)
    filled = {
        key: {name: value for name, value in table if value is not None} | data.get(key, {})
        for key, table in (("start", start), ("run", run))
    }
    return Scene(
        name=tables.name or name,
        law=law(**{key: _in_scene(f"interface.{key}", interface[key], units, keys.VELOCITY) for key in law._fields}),
        upper=upper,
        lower=lower,
        drive=drive_of(tables.drive, units, upper.round_trip),
        start=Start(StartKind(start.kind), _DEFAULT_SIZES[start.kind] if start.size is None else start.size),
        until=None if run.until is None else _in_scene("run.until", run.until, units, keys.UNTIL, upper.round_trip),
        record=frozenset(run.record),
        units=units,
        written={"name": tables.name or name} | data | filled,
    )


def read_scene(source: SceneSource, **changes: Any) -> Scene:
    """`read` with changes as keywords: tables, as slab={"log10_r": -2.6}, or dotted keys, as **{"slab.log10_r": -2.6}."""
    return read(source, dotted(changes))


def dotted(changes: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Every value of nested tables by its dotted key."""
    entries: dict[str, Any] = {}
    for key, value in changes.items():
        entries |= dotted(value, f"{above}{key}.") if isinstance(value, Mapping) else {f"{above}{key}": _listed(value)}
    return entries


def _listed(value: Any) -> Any:
    """`value` with arrays and tuples, also those in lists, as lists, as they are in TOML."""
    value = value.tolist() if hasattr(value, "tolist") else value
    return [*map(_listed, value)] if isinstance(value, list | tuple) else value


def validate(data: dict[str, Any]) -> keys.SceneTable:
    """Check every key of a scene's raw tables. Raises SceneError naming the first faulty key, its value and its range."""
    try:
        return keys.scene_keys().model_validate(data)
    except ValidationError as failure:
        raise SceneError(complaint(failure)) from None


def _require_units(key: str, given: str, units: Units | None, instead: str) -> Units:
    """`units`, if the scene has them. Raises SceneError for `key`, which is in SI, if it has none."""
    if units is None:
        units_of = f"interface.{', '.join(keys.UNIT_KEYS[:-1])} and {keys.UNIT_KEYS[-1]}"
        raise SceneError(f"{key} = {given}: must come with {units_of} (SI), or be {instead}")
    return units


def quotient(value: float, unit: float) -> float:
    """value/unit, correctly rounded, for the decimal numbers that they print as: 1e-5/1e-6 is 10, not 10.000000000000002."""
    return float(Fraction(repr(value)) / Fraction(repr(unit)))


def _in_scene(key: str, given: float | Quantity, units: Units | None, allowed: Numbers, transit: float = 1.0) -> float:
    """Convert a time or a velocity with a unit to the unit of the bare numbers of `allowed`: transits of `transit` L/V*, L/V* or
    V*. Bare numbers are returned as they are. Raises SceneError naming `key` if the result is not `allowed`, or the scene has no
    units."""
    if not isinstance(given, Quantity):
        return given
    known = _require_units(key, f'"{given.text}"', units, f"a number {allowed.bare}")
    if given.unit not in ("s", "m/s"):  # of a kind of the user's own
        raise SceneError(f'{key} = "{given.text}": must be a number; only times and velocities are converted from units')
    per_second = 1.0 / (known.time * transit)
    result = given.value * per_second if given.unit == "s" else quotient(given.value, known.reference_velocity)
    if not allowed.low <= result <= allowed.high:
        unit, limits = allowed.bare.partition(" ")[2], f"from {allowed.low:g} to {allowed.high:g}"
        raise SceneError(f'{key} = "{given.text}": is {result:.9g} {unit}, which must be {limits}')
    return result


def moment(key: str, given: float | str, scene: Scene) -> float:
    """Convert a time given to a command, a number or a text with or without a unit, to transits; NaN if it is no time. Raises
    SceneError for a unit in a scene without units."""
    try:
        time = quantity(given, "s") if isinstance(given, str) and looks_measured(given) else float(given)
    except ValueError:
        return math.nan
    return _in_scene(key, time, scene.units, keys.TIME, scene.transit)


def ends_of_window(
    window: str | Sequence[float | str], time_at: Callable[[float | str], float], first: float, must: str
) -> tuple[float, float]:
    """Times of the ends of a `window` "BEGIN:END", or of a pair, by `time_at`; an end that is left out is `first` or infinite.
    Raises SceneError, which says what it `must` be, for other ends and other numbers of them."""
    ends = window.split(":") if isinstance(window, str) else list(window)
    times = [side if end == "" else time_at(end) for end, side in zip(ends, (first, math.inf), strict=False)]
    if len(ends) != 2 or not first <= times[0] < times[1]:
        raise SceneError(f"window = {shorten(':'.join(map(str, ends)))}: must be BEGIN:END {must}; one of them may be left out")
    return times[0], times[1]


def _outer_face(key: str, table: keys.FaceTable, units: Units | None, epsilon: float, round_trip: float) -> Face:
    """The face of the table at `key` on a slab of `epsilon` and `round_trip`: springs, dashpots and masses in SI or in newtons
    become relative to the slab. Raises SceneError for a value out of range and for units that the scene lacks."""
    kind, slab = FACES[table.kind], face_sizes(epsilon, round_trip)
    given = {name: value for name, value in table if name != "kind"}
    area = None if "area" in kind.__dataclass_fields__ else given.pop("area", None)  # a user's own kind may mean another thing
    if area is not None:
        _require_units(f"{key}.area", f"{area:g}", units, "left out")
    own = {name for name, value in given.items() if isinstance(value, Quantity) or (kind.is_own and units and name in slab)}
    for name, value in given.items():
        is_measured = isinstance(value, Quantity)
        text = f'"{value.text}"' if is_measured else f"{value:g}"
        if is_measured:
            if name not in slab:  # of a kind of the user's own
                raise SceneError(
                    f"{key}.{name} = {text}: must be a number; of a face, only {', '.join(slab)} are converted from units"
                )
            _require_units(f"{key}.{name}", text, units, "relative to the slab")
        if is_measured or (kind.is_own and name in slab):
            per_area = _per_area(key, name, value, area)
            result = per_area / (slab[name] * units.face[name] if units else 1.0)
            numbers = allowed_numbers(table, name)
            allowed = Numbers(numbers.low, min(numbers.high, _LARGEST_RATIO))
            if not allowed.low <= result <= allowed.high:
                relative = "" if result == value else f" is {result:.9g} relative to the slab, which"
                raise SceneError(f"{key}.{name} = {text}:{relative} must be {allowed}")
            given[name] = result
    return kind(**given, own=frozenset(own))


def _per_area(key: str, name: str, given: float | Quantity, area: float | None) -> float:
    """`given` per area: a value in newtons or kilograms, or a bare number where there is an `area`, is that of the whole face."""
    if not isinstance(given, Quantity):
        return given if area is None else given / area
    if given.unit not in _PER_AREA:
        return given.value
    if area is None:
        example = KINDS[_PER_AREA[given.unit]][1]
        raise SceneError(f'{key}.{name} = "{given.text}": must come with {key}.area, or be per area, as in "{example}"')
    return given.value / area


_DEFAULT_SIZES = {"nudge": 0.5, "jump": 0.05, "orbit": 0.5}


def _slabs(tables: keys.SceneTable, units: Units | None) -> tuple[Slab, Slab]:
    given = {key: table for key in ("slab", "upper", "lower") if (table := getattr(tables, key)) is not None}
    match [*given]:
        case ["slab"]:
            slab = _slab("slab", given["slab"], units)
            return slab, slab
        case ["upper", "lower"]:
            return _slab("upper", given["upper"], units), _slab("lower", given["lower"], units)
        case ["slab", key, *_]:
            raise SceneError(f"{key}: must not be given together with slab: either [slab] or both [upper] and [lower]")
        case [present]:
            absent = "lower" if present == "upper" else "upper"
            raise SceneError(f"{absent}: missing; [{present}] needs [{absent}] too (or use [slab] for both)")
    raise SceneError("slab: missing; must be [slab] (both alike) or both [upper] and [lower]")


def _in_machine(tables: keys.SceneTable, slabs: tuple[Slab, Slab], units: Units | None) -> tuple[Slab, Slab]:
    """The slabs behind springs alike, with which they are as stiff in series as [machine] says."""
    if tables.machine is None:
        return slabs
    for key in ("slab", "upper", "lower"):
        if (table := getattr(tables, key)) is not None and "face" in table.model_fields_set:
            raise SceneError(f"{key}.face: must not be given together with machine.k, which is that of the whole sample")
    given = tables.machine.k
    text, value = (f'"{given.text}"', given.value) if isinstance(given, Quantity) else (f"{given:g}", given)
    if isinstance(given, Quantity):
        _require_units("machine.k", text, units, "a number in 1/L")
    length = units.memory_length if units else 1.0
    own = sum(slab.compliance for slab in slabs)
    left = 1.0 / (value * length) - own
    if left <= 1.0 / (_LARGEST_RATIO * value * length):
        unit = "1/m" if units else "1/L"
        raise SceneError(f"machine.k = {text}: must be below {1.0 / (own * length):.6g} {unit}, the stiffness of the slabs alone")
    springs = (MachineFace(2.0 / left * slab.round_trip / slab.epsilon, 0.0, 0.0, own=frozenset(["stiffness"])) for slab in slabs)
    upper, lower = (replace(slab, face=spring) for slab, spring in zip(slabs, springs, strict=True))
    return upper, lower


def _slab(key: str, table: keys.SlabTable, units: Units | None) -> Slab:
    material = {name: value for name in ("density", "shear_modulus") if (value := getattr(table, name)) is not None}
    in_si = material | ({} if table.thickness is None else {"thickness": table.thickness})
    for name, value in in_si.items():
        _require_units(f"{key}.{name}", f"{value:g}", units, "replaced by epsilon and r")
    epsilon = _epsilon(key, table.epsilon, material, units)
    round_trip = _round_trip(key, table, material, units)
    face = _outer_face(f"{key}.face", table.face, units, epsilon, round_trip)
    made_of = Material(**material) if len(material) == 2 else None
    return Slab(epsilon, round_trip, face, _viscosity(key, table, units), _layers(key, table.layers), made_of)


def _epsilon(key: str, given: float | None, material: dict[str, float], units: Units | None) -> float:
    if given is not None:
        for name, value in material.items():
            raise SceneError(f"{key}.{name} = {value:g}: must not be given together with {key}.epsilon")
        return given
    if units is None or not material:
        raise SceneError(f"{key}.epsilon: missing; must be {keys.EPSILON}, or give density and shear_modulus in SI")
    if len(material) == 1:
        absent = "shear_modulus" if "density" in material else "density"
        raise SceneError(f"{key}.{absent}: missing; density and shear_modulus [SI] must both be given")
    sources = {f"{key}.{name}": value for name, value in material.items()}
    return _in_range("epsilon", units.epsilon(**material), keys.EPSILON, sources | _named(units, "normal_stress"))


def _round_trip(key: str, table: keys.SlabTable, material: dict[str, float], units: Units | None) -> float:
    given = {name: value for name in ("r", "log10_r", "thickness") if (value := getattr(table, name)) is not None}
    if not given:
        raise SceneError(f"{key}.r: missing; must be r ({keys.ROUND_TRIP}), log10_r, or in SI thickness")
    (name, value), *others = given.items()
    if others:
        raise SceneError(f"{key}.{others[0][0]} = {others[0][1]:g}: must not be given together with {key}.{name}")
    if name != "thickness":
        return value if name == "r" else float(10.0**value)
    if units is None or len(material) < 2:
        raise SceneError(f"{key}.thickness = {value:g}: must come with density and shear_modulus, or be replaced by r")
    sources = {f"{key}.{name}": value for name, value in (given | material).items()}
    return _in_range("r", units.round_trip(**given, **material), keys.ROUND_TRIP, sources | _named(units, "memory_length"))


def _named(units: Units, key: str) -> dict[str, float]:
    return {f"interface.{key}": getattr(units, key), "interface.reference_velocity": units.reference_velocity}


def _in_range(quantity: str, result: float, allowed: Numbers, sources: dict[str, float]) -> float:
    """`result`, derived from the keys `sources`. Raises SceneError for a result outside `allowed`, which names all keys, since
    any may be wrong, and the doubts about them."""
    if not allowed.low <= result <= allowed.high:
        given = ", ".join(f"{key} = {value:g}" for key, value in sources.items())
        odd = "".join(f"; {line}" for key, value in sources.items() for line in doubt(key, value))
        raise SceneError(f"{given}: result in {quantity} = {result:.9g}, which must be {allowed}{odd}")
    return result


def _viscosity(key: str, table: keys.SlabTable, units: Units | None) -> Viscosity | None:
    viscosity = table.viscosity
    if viscosity is None:
        return None
    given = {name: value for name, value in viscosity if name != "kind"}
    measured = {
        name: _in_scene(f"{key}.viscosity.{name}", value, units, allowed_numbers(viscosity, name))
        for name, value in given.items()
        if isinstance(value, Quantity)
    }
    return VISCOSITIES[viscosity.kind](**given | measured)


def _layers(key: str, tables: list[keys.LayerTable] | None) -> tuple[Layer, ...]:
    if tables is None:
        return (Layer(1.0, 1.0),)
    total = math.fsum(table.fraction for table in tables)
    if abs(total - 1.0) > 1e-9:
        fractions = shorten([table.fraction for table in tables])
        raise SceneError(f"{key}.layers = {fractions}: must be fractions of the round trip that add up to 1, not {total:.10g}")
    return tuple(Layer(table.fraction / total, table.impedance) for table in tables)


def drive_of(table: keys.DriveTable, units: Units | None, transit: float) -> Drive:
    """The drive of a table, in transits of the upper slab; times that differ by rounding are the same, as for every march.
    Raises SceneError for values out of range, and times that fall."""
    key, given = "drive.velocity", table.velocity
    times = list[float]()
    for written, _ in given:
        time = _in_scene(key, written, units, keys.TIME, transit)
        times.append(times[-1] if times and abs(time - times[-1]) <= slack(time) else time)
    velocities = [_in_scene(key, v, units, keys.LATER_VELOCITY if k else keys.VELOCITY) for k, (_, v) in enumerate(given)]
    is_rising = all(earlier <= later for earlier, later in pairwise(times))
    if not is_rising or any(times[k] == times[k - 2] for k in range(2, len(times))):
        given_times = f"{key}: times = {shorten(times)} (transits of the upper slab)"
        raise SceneError(f"{given_times}: must be rising; the same time twice is a step")
    return Drive(tuple(times), tuple(velocities))


def to_toml(scene: Scene) -> str:
    """The scene as TOML: reading it gives the same scene. Raises SceneError for a scene that was not read, and for values that
    TOML does not have."""
    import tomli_w

    name, tables = tables_of(scene)
    try:
        return tomli_w.dumps(_plain(tables))
    except TypeError as error:
        raise SceneError(f"scene {name!r}: cannot be written as TOML: {error}") from None


def _plain(value: Any) -> Any:
    """`value` with numbers and lists of other libraries replaced by those of Python."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bool | int | str):
        return value
    return float(value) if isinstance(value, numbers.Real) else value

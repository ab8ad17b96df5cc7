"""Reads a time record, measured or written by a run, from CSV or columns of text, as named columns.

The names and units of columns are in a heading (`validation.data.quantities`), or are given. Lines that begin with # or % are
comments. Numbers without any unit are in SI, or, for a scene without SI, in its own units.
"""

import csv
import hashlib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import SceneError
from slipwave.files import content_of
from slipwave.input.quantity import quantity
from slipwave.input.wording import listed, shorten
from slipwave.scene import Scene
from validation.data.quantities import MEASURED, SEAS, Heading, Unit, heading, name_of_quantity, unit_of, unit_sizes

Array = NDArray[np.float64]

UNREAD = "not read"
"""Beginning of the note on columns without a known name."""

_COMMENTS = ("#", "%")
_SKIP = ("", "_", "-")
_SCALE = re.compile(r"([^=]*)=\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(.*)")
_ONE_RANGE = ("friction", "shear_stress", "load_point_displacement")  # in which no value is far from all others
_LEAST, _MOST = 1e-4, 1e3  # friction of any interface
_FAR = 5.0  # times the range of the others
_PAUSE = 3.0  # ticks of a clock without a sample
_BEFORE = 20  # lines, than all of which a last one that does not end is shorter if it is cut off


@dataclass(frozen=True)
class Series:
    """A record: columns by the names of MEASURED, arrays of equal length, time rising. `is_own`: in the units of a scene
    (transits, L, V*, normal stress) instead of SI; None if no column had a unit. `notes`: how the file was read; `there`: the
    columns of the file in words; `digest` of its content, which a pipe gives only once."""

    source: str
    columns: Mapping[str, Array]
    is_own: bool | None = False
    notes: Sequence[str] = ()
    there: str = ""
    digest: str = ""

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def __getitem__(self, name: str) -> Array:
        """A column. Raises SceneError, naming the existing columns, if it is missing."""
        if name not in self.columns:
            read = f"the columns read are {', '.join(self.columns)}{self.there and f' of {self.there}'}"
            raise SceneError(f"{self.source!r}: has no column {name}; {read}; --columns names them in order")
        return self.columns[name]

    def of(self, scene: Scene) -> "Series":
        """The same record in the units of `scene`. Raises SceneError for a record in SI and a scene without."""
        if self.is_own or (self.is_own is None and scene.units is None):
            return replace(self, is_own=True)
        if scene.units is None:
            keys = "interface.normal_stress, memory_length and reference_velocity"
            raise SceneError(f"{self.source!r}: is in SI; scene {scene.name!r} is not: give {keys}, or a record in its own units")
        sizes = unit_sizes(scene)
        columns = {name: values / sizes[MEASURED[name].own] for name, values in self.columns.items()}
        return replace(self, columns=columns, is_own=True)

    def friction(self, normal_stress: float | None = None) -> Array:
        """The friction coefficient: its column, or shear over normal stress, which is a column or, else, `normal_stress` (1 in a
        scene's own units)."""
        if "friction" in self or "shear_stress" not in self:
            return self["friction"]
        below = self.columns.get("normal_stress", 1.0 if self.is_own else normal_stress)
        if below is None:
            raise SceneError(f"{self.source!r}: shear stress without normal stress gives no friction: name a column of it")
        friction = np.asarray(self["shear_stress"] / below)
        if not _LEAST < (usual := float(np.median(np.abs(friction)))) < _MOST:
            units = f"--units=shear_stress=MPa, or another, says it; {self.there}" if self.there else "is the unit another?"
            raise SceneError(f"{self.source!r}: shear over normal stress is {usual:.2g}, which is no friction: {units}")
        return friction


class _Text(NamedTuple):
    """A file's lines of numbers with their line `numbers`, the separator `between` columns (None: blanks), and the cells of the
    heading and of the units below it."""

    lines: list[str]
    numbers: list[int]
    between: str | None
    cells: list[str]
    units: list[str]

    @property
    def there(self) -> str:
        """The file's columns in words."""
        return f"its columns: {', '.join(self.cells)}" if self.cells else f"its {self.width} columns have no names"

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(_cells(self.lines[0], self.between))


def read_series(
    path: Path | str,
    columns: str | None = None,
    units: str | None = None,
    missing: str | None = None,
    area: str | None = None,
    scale: str | None = None,
) -> Series:
    """Read a record. `columns` are the quantities in the order of the file ("time,stress,_", _ for one that is not read), `units`
    those of its columns in this order, or pairs ("s,MPa" or "time=s,stress=MPa"); both override the file. Lines with one of the
    words or numbers in `missing` ("nan,-999") in a column that is read are left out. Forces are divided by `area` ("25 cm2").
    `scale`: what one unit of a column's numbers stands for ("disp=0.02mm"), or, without a unit, a factor of the column.

    Raises SceneError: a file that cannot be read or is empty, no heading and no `columns`, no column of time, a cell that is no
    finite number or far from all others (which line), a time that falls (which line), a unit that is not known.
    """
    label = str(path)
    raw = content_of(Path(path), repr(label))
    text = _parted(label, _lines_of(label, raw))
    headings = _headings(label, text, columns)
    chosen = _chosen(label, headings, text)
    factors, scaled = _scales(label, scale, chosen, text)
    given = _given_units(label, units, [*headings.values()]) | scaled
    on = _area(area)
    column_units = {
        key: unit_of(given.get(key, headings[index][1]), key, f"{label!r}, column {index + 1}, {key}", on)
        for key, index in chosen.items()
    }
    text, gaps = _without_missing(text, list(chosen.values()), missing)
    values = _numbers(label, text, list(chosen.values()))
    for (key, index), column in zip(chosen.items(), values.T, strict=True):
        if key in _ONE_RANGE:
            _require_no_mark(f"{label!r}, column {index + 1}", key, column, text.numbers)
    kinds = {key: unit.is_own for key, unit in column_units.items() if unit and MEASURED[key].unit}
    if len(set(kinds.values())) > 1:
        own = listed(key for key, is_own in kinds.items() if is_own)
        raise SceneError(f"{label!r}: {own} in the units of a scene, the rest in SI: must be all of one kind")
    series = dict[str, Array]()
    for key, column in zip(chosen, values.T, strict=True):
        unit = column_units[key] or Unit(1.0)
        series[key] = np.asarray((10.0**column if unit.is_log else column) * unit.size * factors.get(key, 1.0))
    series, dropped = _rising(label, series, text.numbers)
    measured = {key: unit for key, unit in column_units.items() if MEASURED[key].unit}
    is_own = any(kinds.values()) if kinds else None
    notes = [*_notes_on(headings, chosen, measured, text), *gaps, *dropped]
    return Series(label, series, is_own, notes, text.there, hashlib.sha256(raw).hexdigest()[:12])


def _scales(label: str, scale: str | None, chosen: Mapping[str, int], text: "_Text") -> tuple[dict[str, float], dict[str, str]]:
    """The factors of --scale and the units behind them, by quantity."""
    factors, units = dict[str, float](), dict[str, str]()
    for part in scale.split(",") if scale else ():
        match = _SCALE.fullmatch(part)
        if match is None or not math.isfinite(factor := float(match[2])) or factor == 0.0:
            raise SceneError(f"--scale = {shorten(part)}: must be COLUMN=FACTOR or COLUMN=FACTOR and a unit, as in disp=0.02mm")
        key = name_of_quantity(match[1], "--scale")
        if key not in chosen:
            raise SceneError(f"--scale = {shorten(part)}: {label!r} has no column {key}; {text.there}")
        factors[key] = factor
        if match[3].strip():
            units[key] = match[3].strip()
    return factors, units


def _area(text: str | None) -> float | None:
    """An area in m2."""
    try:
        if text is None or (area := quantity(text, "m2").value) > 0.0:
            return None if text is None else area
        raise ValueError("must be above 0")
    except ValueError as error:
        raise SceneError(f"--area = {shorten(text)}: {error}") from None


def _lines_of(label: str, raw: bytes) -> list[str]:
    """The lines of a file in UTF-8, UTF-16 or Latin-1. Raises SceneError if it is no text or empty."""
    wide = raw.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in raw and not wide:
        raise SceneError(f"{label!r}: is no file of text: CSV, or columns of numbers between blanks")
    try:
        text = raw.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    if not text.strip():
        raise SceneError(f"{label!r}: is empty")
    lines = text.splitlines()
    is_cut = not text.endswith(("\n", "\r")) and len(lines) > _BEFORE and len(lines[-1]) < min(map(len, lines[-_BEFORE:-1]))
    return lines[:-1] if is_cut else lines


def _parted(label: str, lines: list[str]) -> _Text:
    """Split a file into heading, which may be a comment, units, which may be a second heading line, and lines of numbers."""
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith(_COMMENTS)]
    first = next((k for k, (_, line) in enumerate(rows) if _has_numbers(line)), None)
    if first is None:
        raise SceneError(f"{label!r}: has no line of numbers")
    between = _between(rows[first][1])
    width = len(_cells(rows[first][1], between))
    above = [line for _, line in rows[:first]]
    if not above:  # a heading within a comment
        above = [line.lstrip().lstrip("#% ") for line in lines[: rows[0][0] - 1] if line.strip()]
        above = [line for line in above[-1:] if len(_words(line, between, width)) == width]
    cells = [_words(line, between, width) for line in above[-2:]]
    of_units = len(cells) == 2 and not any(heading(cell)[0] for cell in cells[1]) and len(cells[0]) == len(cells[1])
    names = (cells[0] if of_units else cells[-1]) if cells else []
    data = rows[first:]
    return _Text([line for _, line in data], [number for number, _ in data], between, names, cells[1] if of_units else [])


def _has_numbers(line: str) -> bool:
    """Whether most of a line's cells are numbers."""
    cells = [cell for cell in _cells(line, _between(line)) if cell]
    return sum(map(_is_number, cells)) > len(cells) / 2


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _between(line: str) -> str | None:
    return next((sign for sign in (";", "\t", ",") if sign in line.strip()), None)


def _cells(line: str, between: str | None) -> list[str]:
    return line.split() if between is None else [cell.strip() for cell in next(csv.reader([line], delimiter=between))]


def _words(line: str, between: str | None, width: int) -> list[str]:
    """The cells of a heading; between blanks a unit in brackets belongs to the name before it."""
    if between is not None and (between in line or width == 1):
        return _cells(line, between)
    for pattern in (r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", r"(?:\S+\s)*?\S+(?=\s{2,}|\s*$)", r"[^,;\t]+"):
        words = [word.strip() for word in re.findall(pattern, line.strip())]
        if len(words) == width:
            return words
    return line.split()


def _headings(label: str, text: _Text, columns: str | None) -> dict[int, Heading]:
    """Index of a column -> its heading, from the file or, in the order of `columns`, with its unit in the file."""
    if not text.cells and columns is None:
        form = "--columns, as in time,friction,_ (_: not read)"
        raise SceneError(f"{label!r}: has no heading: name its {text.width} columns by {form}")
    below = dict(enumerate(text.units))
    cells = enumerate(map(heading, text.cells))
    headings: dict[int, Heading] = {index: (key, below.get(index, unit) or unit) for index, (key, unit) in cells}
    plain = {re.sub("_2$", "", name.strip().lower()): index for index, name in enumerate(text.cells)}
    if SEAS.keys() <= plain.keys() and not any(unit for _, unit in headings.values()):
        headings |= {plain[name]: (headings[plain[name]][0], unit) for name, unit in SEAS.items()}
    if columns is None:
        return headings
    words = [word.strip() for word in columns.split(",")]
    if len(words) > text.width:
        raise SceneError(f"--columns = {shorten(columns)}: names {len(words)} columns; {label!r} has {text.width}; {text.there}")
    if len(text.cells) != text.width:
        headings = {}  # which of these a unit belongs to is not known
    named = {index: heading(word) for index, word in enumerate(words)}
    for index, word in enumerate(words):
        if word not in _SKIP:
            name_of_quantity(word, "--columns")
            if named[index][1] is None and index in headings:
                named[index] = named[index][0], headings[index][1]
    return named


def _chosen(label: str, headings: Mapping[int, Heading], text: _Text) -> dict[str, int]:
    """Quantity -> index of its column. Raises SceneError if two columns are the same quantity, and if none is time."""
    indices: dict[str, int] = {}
    for index, (key, _) in headings.items():
        if key in indices:
            both = f"columns {indices[key] + 1} and {index + 1} are both {key}"
            raise SceneError(f"{label!r}: {both}; {text.there}; --columns says which is which (_: not read)")
        if key:
            indices[key] = index
    if "time" not in indices:
        raise SceneError(f"{label!r}: has no column time; {text.there}; --columns names them in order, as in time,friction,_")
    return indices


def _given_units(label: str, units: str | None, headings: Sequence[Heading]) -> dict[str, str]:
    """The units of --units, by quantity."""
    if units is None:
        return {}
    parts = [part.strip() for part in units.split(",")]
    if all("=" in part for part in parts):
        pairs = (part.split("=", 1) for part in parts)
        return {name_of_quantity(name, "--units"): unit.strip() for name, unit in pairs}
    if len(parts) > len(headings):
        raise SceneError(f"--units = {shorten(units)}: has {len(parts)} units; {label!r} has {len(headings)} columns")
    return {key: unit for (key, _), unit in zip(headings, parts, strict=False) if key and unit not in _SKIP}


def _without_missing(text: _Text, indices: Sequence[int], missing: str | None) -> tuple[_Text, list[str]]:
    """The lines without a mark of a missing value, and a note on the number of omitted lines."""
    if missing is None:
        return text, []
    marks = {_as_mark(mark) for mark in missing.split(",")}
    rows = (_cells(line, text.between) for line in text.lines)
    kept = [not any(_as_mark(row[index]) in marks for index in indices if index < len(row)) for row in rows]
    lines, numbers = [*compress(text.lines, kept)], [*compress(text.numbers, kept)]
    return text._replace(lines=lines, numbers=numbers), [f"{len(kept) - len(lines)} lines with {missing} left out"]


def _as_mark(cell: str) -> str:
    """Numbers that are equal are equal marks."""
    return f"{float(cell.replace(',', '.')):g}" if _is_number(cell) else cell.strip().lower()


def _require_no_mark(where: str, key: str, values: Array, numbers: Sequence[int]) -> None:
    """Raises SceneError if one number far outside the range of all others occurs in a few lines: it probably marks missing
    values."""
    for end in (values.min(), values.max()):
        others = values[values != end]
        low, high = (others.min(), others.max()) if others.size >= 0.9 * values.size > 9.0 else (end, end)
        if max(low - end, end - high) > _FAR * (high - low) > 0.0:
            which = f"line {numbers[int(np.argmax(values == end))]}: {key} is {end:g}, all others are from {low:g} to {high:g}"
            raise SceneError(f"{where}, {which}: if it stands for a missing value, --missing={end:g} leaves such lines out")


def _numbers(label: str, text: _Text, indices: list[int]) -> Array:
    """The columns with these indices, of shape (samples, columns). Raises SceneError naming the first line with a cell that is no
    finite number."""
    lines = [line.replace(",", ".") for line in text.lines] if text.between == ";" else text.lines
    try:
        values = np.loadtxt(lines, delimiter=text.between, usecols=indices, ndmin=2, comments=None, quotechar='"')
    except ValueError:
        values = np.full((1, 1), math.nan)
    if np.isfinite(values).all():
        if len(values) < 2:
            raise SceneError(f"{label!r}: has {len(values)} line of numbers; a record has 2 or more")
        return np.asarray(values, dtype=float)
    for number, line in zip(text.numbers, lines, strict=True):
        cells = _cells(line, text.between)
        for index in indices:
            cell = cells[index] if index < len(cells) else ""
            if not (_is_number(cell) and math.isfinite(float(cell.replace(",", ".")))):
                which = f"is {shorten(cell)}: must be a finite number" if cell else "is missing"
                way = " (--missing=nan leaves such lines out)" if cell.lower() == "nan" else ""
                raise SceneError(f"{label!r}, line {number}: column {index + 1} {which}{way}")
    raise SceneError(f"{label!r}: cannot be read as columns of numbers")


def _rising(label: str, columns: dict[str, Array], numbers: Sequence[int]) -> tuple[dict[str, Array], list[str]]:
    """The columns without repeated lines, and with several samples at one time spread evenly: between two pauses if the clock's
    ticks allow that, else up to the next time; notes on these. Raises SceneError where time falls."""
    steps = np.diff(columns["time"])
    if (steps < 0.0).any():
        at = int(np.argmax(steps < 0.0)) + 1
        before, after = columns["time"][at - 1 : at + 1]
        raise SceneError(f"{label!r}, line {numbers[at]}: time falls from {before:.9g} to {after:.9g}: must rise")
    if not steps.any():
        raise SceneError(f"{label!r}: time is {columns['time'][0]:g} in every line: must rise")
    new = np.concatenate(([True], np.any([np.diff(values) != 0.0 for values in columns.values()], axis=0)))
    columns = {key: values[new] for key, values in columns.items()}
    notes = [f"{(~new).sum()} lines that are written twice left out"] if not new.all() else []
    ticks, first, counts = np.unique(columns["time"], return_index=True, return_counts=True)
    if ticks.size < new.sum():
        index, time, tick = np.arange(new.sum()), columns["time"], np.median(np.diff(ticks))
        gap = np.minimum(np.diff(ticks, append=np.inf), tick)
        columns["time"] = time + (index - np.repeat(first, counts)) * np.repeat(gap / counts, counts)
        for part in np.split(index, np.flatnonzero(np.diff(time) > _PAUSE * tick) + 1):
            if part.size < 3:
                continue
            even = np.polyval(np.polyfit(part, time[part], 1), part)
            if np.ptp(time[part] - even) < 0.5 * _PAUSE * tick:
                columns["time"][part] = even
        notes.append(f"{new.sum() - ticks.size} samples at the time of the one before: taken as spread evenly")
    return columns, notes


def _notes_on(
    headings: Mapping[int, Heading], chosen: Mapping[str, int], units: Mapping[str, Unit | None], text: _Text
) -> Iterable[str]:
    """Notes on how the columns were read."""
    parts = [f"{key} from column {index + 1}" for key, index in chosen.items()]
    yield f"read {', '.join(parts)}"
    bare = [key for key, unit in units.items() if unit is None]
    if bare:
        yield f"{', '.join(bare)} without a unit: taken as SI, or as the units of a scene without SI (--units says others)"
    left = [text.cells[index] for index, (key, _) in headings.items() if not key and index < len(text.cells)]
    if left:
        yield f"{UNREAD}: {', '.join(left)}"

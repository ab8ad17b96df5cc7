"""The options of a command, each declared once, as a field of a dataclass: type, default, help, and allowed values.

The Python function (`command`), the command line (`validation.commands.cli`), the attribute `options` of files and the refusal of
wrong values follow from the field.
"""

import inspect
import math
import numbers
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, wraps
from inspect import Parameter, Signature, get_annotations
from itertools import zip_longest
from pathlib import Path
from types import FunctionType, NoneType
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Self,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from numba.core.errors import NumbaError

from slipwave.errors import NumericsError, SceneError
from slipwave.friction.own import load_laws, refused_by_compiler
from slipwave.input.assemble import SceneSource, dotted, is_stored, moment, read, read_scene, tables_of
from slipwave.input.schema import UNTIL, SceneTable
from slipwave.input.stored import read_stored
from slipwave.input.wording import listed, nearest, shorten
from slipwave.packages import ended
from slipwave.scene import Scene
from slipwave.scene.scene import doubts
from slipwave.solve.follow import DAY
from validation.commands.result import Frozen, PointOfBranch, Result, Stopped
from validation.models.by_name import FAMILIES, GRIDS, Options
from validation.models.own import load_families, own_family
from validation.models.progress import log

if TYPE_CHECKING:
    from validation.models.parameter import Variation

_WORDS = {bool: "True or False", int: "a whole number", float: "a number", str: "a text", NoneType: "None"}
_WORDS |= {Path: "a text, a path", FunctionType: "a function", object: "values"}
_KINDS: dict[Any, Any] = {bool: bool, int: numbers.Integral, float: numbers.Real, Path: (str, Path)}

_OF_A_GRID = ("cells", "cfl", "time")  # options that belong to the model with which they were given

_Answer = TypeVar("_Answer")


def option(help: str, default: Any = None, /, **more: Any) -> Any:
    """A field of a class of options, with `more` properties of the `Option`."""
    return field(default=default, metadata={"help": help, **more})


@dataclass(frozen=True)
class Option:
    """A declared option: the Python type and the default of its value, and its help.

    Where they are not the usual: `flag` on the command line (`--name`) and `metavar`; `positional` in Python, or `python_only`;
    `stored`: files of results store it, for a call that computes such a file again; `least` and `most`, and the text of what a
    value `must` be; `suffixes` of a file that the command writes; `words` for the shell's completion; the value that a
    flag `stands_for`."""

    name: str
    hint: Any
    default: Any
    help: str
    flag: str = ""
    metavar: str | None = None
    positional: bool = False
    python_only: bool = False
    stored: bool = False
    least: float = -math.inf
    most: float = math.inf
    must: str = ""
    suffixes: tuple[str, ...] = ()
    words: Callable[[], list[str]] | None = None
    stands_for: Any = None

    @property
    def stored_as(self) -> str:
        """Its name in files."""
        return self.flag.removeprefix("--").replace("-", "_")

    def checked(self, value: Any) -> Any:
        """`value` converted from numpy, text to a path where declared. Raises SceneError for a wrong type and a value out of
        range."""
        value = _plain(value, self.hint)
        if not _fits(value, self.hint):
            raise SceneError(f"{self.name} = {shorten(value)}: must be {listed(dict.fromkeys(_words(self.hint)))}")
        if value is not None and self.must and not self.least <= value <= self.most:
            shown = f"{value:g}" if isinstance(value, float) else value
            raise SceneError(f"{self.name} = {shown}: must {self.must}")
        return Path(value) if isinstance(value, str) and Path in get_args(self.hint) else value


_STEPS = dict.fromkeys(
    f"{family.step} ({', '.join(other.name for other in GRIDS if other.step == family.step)})" for family in GRIDS
)


class SceneOptions(Frozen):
    """Options of every command on a scene. `EXAMPLES`, `DETAILS` and `SOURCE` are for its help on the command line."""

    EXAMPLES: ClassVar[tuple[str, ...]] = ()
    DETAILS: ClassVar[str] = ""
    SOURCE: ClassVar[str] = "a gallery name (see `slipwave scenes`), a TOML file, or a netCDF file of results"

    settings: Iterable[str] = option(
        "change one key of the scene, as in slab.log10_r=-2.3, or by an expression in what the command varies; may be repeated",
        (),
        flag="--set",
        metavar="KEY=VALUE ...",
    )
    law: Path | None = option("run this Python file, which registers a friction law", metavar="FILE.py")
    family: Path | None = option("run this Python file, which declares a family of models", metavar="FILE.py")
    set: Mapping[str, object] | None = option(
        "changes of keys of the scene; a text that names a variable of the command is an expression", python_only=True
    )
    changes: Mapping[str, Any] = field(default_factory=dict)

    def load_own(self) -> Self:
        """Load the user's own law and family; returns itself. Raises SceneError for a file that cannot be run or declares
        none."""
        if self.law is not None:
            load_laws(self.law)
        if self.family is not None:
            load_families(self.family)
        return self

    @property
    def varied(self) -> tuple[str, ...]:
        """What the command varies, by name."""
        return ()

    def require_unset(self, names: Iterable[str], gives: str) -> None:
        """Raises SceneError if a key of the scene is set, or an option of these names: what `gives` the scene gives them."""
        known = options_of(type(self))
        for option in (known[name] for name in names):
            if getattr(self, option.name) != option.default:
                raise SceneError(f"{option.flag}: leave it out; {gives}")
        for key, value in self._pairs:
            guess = nearest(key, known)
            hint = f"; did you mean {guess}?" if guess else ""
            raise SceneError(f"{shorten(key)[1:-1]} = {shorten(value)}: leave it out; {gives}{hint}")

    def scene_of(self, source: SceneSource, until: float | str | None = None) -> Scene:
        """The scene of a call: `source` with `settings`, `set` and `changes` and, if given, another length. Doubts about it are
        logged."""
        from slipwave.input.overrides import apply_overrides, endings

        source = source.scene if isinstance(source, PointOfBranch) else source
        if isinstance(source, Scene) and source.tables is None and until is not None:  # no tables to write the length into
            transits = moment("run.until", until, source)
            if not UNTIL.low <= transits <= UNTIL.high:
                raise SceneError(f"run.until = {shorten(until)}: must be {UNTIL}")
            source, until = replace(source, until=transits), None
        length = [] if until is None else [f"run.until={until}"]
        given = read(source, [*self._texts, *length])
        changes = {**(self.set or {}), **self.changes}
        law = {key: value for key, value in dotted(changes).items() if key.rpartition(".")[2] == "law"}  # its keys are known then
        tables = tables_of(given)[1] if changes else {}
        tables = apply_overrides(tables, law) if law else tables
        for key, value in changes.items():
            if not endings(key.split("."), tables):
                guess = nearest(key, [*options_of(type(self)), *SceneTable.model_fields])
                hint = f"; did you mean {guess}?" if guess else ""
                raise SceneError(f"{shorten(key)[1:-1]} = {shorten(value)}: neither an option nor a key of a scene{hint}")
        scene = read_scene(given, **changes)
        for line in doubts(scene):
            log.warning("note: %s", line)
        return scene

    def with_expressions(self, stored: Mapping[str, str]) -> Self:
        """The options with expressions of a file of results, where these name what is varied and none is given."""
        whole = replace(self, set={**stored, **(self.set or {})})
        return whole if whole.expressions and not self.expressions else self

    @property
    def _texts(self) -> list[str]:
        return [self.settings] if isinstance(self.settings, str) else [*self.settings]

    @property
    def _pairs(self) -> list[tuple[str, Any]]:
        """Key and value of all that is set."""
        texts = [(key.strip(), value.strip()) for key, _, value in (text.partition("=") for text in self._texts)]
        return [*texts, *{**(self.set or {}), **self.changes}.items()]

    def scenes_of(self, source: SceneSource, until: float | str | None = None) -> "Variation":
        """The scenes of a call over what is `varied`: settings that name a variable, and those in the table of a kind or law that
        is varied, are set at each of its values."""
        from slipwave.input.assemble import load_tables
        from slipwave.input.overrides import full_key, toml_value
        from validation.models.parameter import Variation, is_expression, scenes_with, variables_of

        variables = variables_of(self.varied, self._pairs)
        words = [name.split(".") for name in self.varied if name.rpartition(".")[2] in ("kind", "law")]
        data = load_tables(source.scene if isinstance(source, PointOfBranch) else source)[1] if words else {}
        tables = [full_key(word, "", data)[:-1] for word in words]
        now, others, waiting = list[str](), dict[str, Any](), dict[str, Any]()
        for text, (key, value) in zip_longest(self._texts, self._pairs):  # changes have no text
            if key in variables or is_expression(value, variables):
                waiting[key] = value
            elif tables and full_key(key.split("."), value, data)[:-1] in tables:
                waiting[key] = value if text is None else toml_value(key, value)
            elif text is None:
                others[key] = value
            else:
                now.append(text)
        base = replace(self, settings=now, set=None, changes=others).scene_of(source, until)
        known = Variation(base)
        sets = {key if key in variables else known.key_of(key): value for key, value in waiting.items()}
        return scenes_with(base, self.varied, sets)

    @property
    def stored(self) -> dict[str, Any]:
        """Name in files -> value, of the options that a file of results stores."""
        known = {option.stored_as: getattr(self, option.name) for option in options_of(type(self)).values() if option.stored}
        return known | ({"set": self.expressions} if self.varied and self.expressions else {})

    @property
    def expressions(self) -> dict[str, str]:
        """The settings that name a variable."""
        from validation.models.parameter import is_expression, variables_of

        variables = variables_of(self.varied, self._pairs)
        return {key: value for key, value in self._pairs if key in variables or is_expression(value, variables)}


def model_option(auto: str = "the cheapest that is exact for the scene") -> Any:
    """The model of a command, and what it takes as `auto`."""
    return option(
        f"{', '.join(family.pattern for family in FAMILIES)} (without P, it is chosen by --tol), or auto: {auto}",
        "auto",
        positional=True,
        words=lambda: ["auto", *(family.example for family in FAMILIES)],
    )


class ModelOptions(SceneOptions):
    """Options of every command that computes with a model."""

    model: str = model_option()

    def recalled(self, source: SceneSource, command: str, without: Sequence[str] = ()) -> Self:
        """The options completed by the model and the options (except `without`) of a file of results of the same `command`.
        Raises SceneError for a file of another command, or of another family of that name."""
        if not is_stored(source):
            return self
        stored = read_stored(str(source), command=command)
        model = stored.model if self.model == "auto" else self.model
        ours, theirs = own_family(model), stored.facts.get("family_digest")
        if ours and theirs and ours.digest != theirs:
            other = f"digest {theirs}; that of --family is {ours.digest}"
            raise SceneError(f"SCENE = {shorten(str(source))}: was computed with another family of {model!r}: {other}")
        known = {name: value for name, value in stored.options.items() if model == stored.model or name not in _OF_A_GRID}
        wanted = [option for option in options_of(type(self)).values() if option.stored and option.name not in without]
        checked = {
            option.name: option.checked(known.get(option.stored_as)) for option in wanted if getattr(self, option.name) is None
        }
        return replace(self, model=model, **checked).with_expressions(known.get("set", {}))


class LengthOptions(SceneOptions):
    """Options of every command that runs models."""

    until: float | str | None = option(
        "length of the run, in transits or, in scenes with SI units, as 60s (default: the scene's, else until the motion is "
        "settled)",
        metavar="TRANSITS|TIME",
    )
    most_seconds: float = option("run it even if it is expected to take more than a day", DAY, flag="--yes", stands_for=math.inf)


class NumericalOptions(SceneOptions):
    """Numerical options of a model: cells, step and march of a full wave, and the relative error."""

    cells: int | None = option("full wave: cells per slab", stored=True)
    cfl: float | None = option(f"full wave: time step, above 0 to 1, in units of {' or '.join(_STEPS)}", stored=True)
    time: str | None = option(
        "full wave: propagate the slabs exactly in time, in steps that resolve friction, or by explicit steps; by default "
        "exactly, but explicitly with --cfl, after a jump and on large grids",
        metavar="exact|explicit",
        stored=True,
    )
    tol: float | None = option(
        "requested relative error; a full wave chooses cells and steps for it and estimates the error that it reached; with "
        "--cells it is for the steps of the exact march only",
        stored=True,
    )

    @property
    def numerical(self) -> Options:
        """The options for `validation.models.build`."""
        return Options(cells=self.cells, cfl=self.cfl, tolerance=self.tol, time=self.time)


class RecordOptions(SceneOptions):
    """Options for reading a measured record."""

    columns: str | None = option("the record's columns in their order (_: not read)", metavar="time,disp,friction,_", stored=True)
    units: str | None = option("the units of these columns, in order or by name", metavar="s,um,1|time=ms", stored=True)
    missing: str | None = option("what stands for a missing value: lines with it are left out", metavar="nan,-999", stored=True)

    area: str | None = option("the area on which a column of forces acts", metavar='"25 cm2"', stored=True)
    scale: str | None = option(
        "what one unit of a column's numbers stands for, or a factor of the column",
        metavar="disp=0.02mm,friction=1.1",
        stored=True,
    )

    @property
    def reading(self) -> dict[str, str | None]:
        """The options for `validation.data.series.read_series`."""
        return {name: getattr(self, name) for name in ("columns", "units", "missing", "area", "scale")}


def options_of(kind: type[SceneOptions]) -> Mapping[str, Option]:
    """The options that a class declares, by name: those that are positional in Python first, then its own, then inherited
    ones."""
    declared: Any = kind
    return _options_of(declared)


@cache
def _options_of(kind: Any) -> Mapping[str, Option]:
    hints, known = get_type_hints(kind), {declared.name: declared for declared in fields(kind)}
    names = [name for base in kind.__mro__ for name in get_annotations(base) if name in known and known[name].metadata]
    flags: dict[str, dict[str, Any]] = {name: {"flag": f"--{name.replace('_', '-')}"} for name in names}
    options = [
        Option(name, hints[name], known[name].default, **flag | dict(known[name].metadata)) for name, flag in flags.items()
    ]
    return {option.name: option for option in sorted(options, key=lambda option: not option.positional)}


def announced(model: str, why: str) -> str:
    """`model`; logs why `auto` chose it, if it did."""
    if why:
        log.info("model auto: %s (%s)", model, why)
    return model


def _plain(value: Any, hint: Any) -> Any:
    """Convert numpy numbers to Python's, and iterators to lists; a path is a list of one."""
    if get_origin(hint) is Iterable and isinstance(value, Path):
        return [value]
    are_listed = get_origin(hint) is Iterable and isinstance(value, Iterable) and not isinstance(value, str | Mapping)
    if are_listed or isinstance(value, Iterator):
        return list(value)
    return value.item() if isinstance(value, np.generic) else value


def _fits(value: Any, hint: Any) -> bool:
    """Whether `value` is of the annotated type."""
    kind, parts = get_origin(hint), get_args(hint)
    if kind is tuple:
        pairs = isinstance(value, tuple | list) and len(value) == len(parts)
        return pairs and all(map(_fits, value, parts))
    if kind is Mapping:
        return isinstance(value, Mapping) and all(_fits(key, parts[0]) and _fits(item, parts[1]) for key, item in value.items())
    if kind in (Iterable, Sequence):
        return isinstance(value, kind) and not isinstance(value, Mapping) and all(_fits(item, parts[0]) for item in value)
    if parts:
        return any(_fits(value, part) for part in parts)
    return isinstance(value, _KINDS.get(hint, hint)) and (hint is bool or not isinstance(value, bool))


def _words(hint: Any) -> Iterable[str]:
    """The types of an annotation in words."""
    kind, parts = get_origin(hint), get_args(hint)
    if kind is tuple:
        yield f"({', '.join(' or '.join(_words(part)) for part in parts)})"
    elif kind is Mapping:
        yield f"{{a text: {next(iter(_words(parts[1])))}}}"
    elif kind in (Iterable, Sequence):
        yield f"a list of {next(iter(_words(parts[0])))}s".replace("a list of a ", "a list of ")
    elif parts:
        for part in parts:
            yield from _words(part)
    else:
        yield _WORDS.get(hint) or f"of the class {hint.__name__}"


def command(compute: Callable[[Any, Any], _Answer]) -> Callable[..., _Answer]:
    """`compute` (source, options) as a function of a source and keywords; `__wrapped__` is `compute` itself.

    The function raises SceneError for unknown arguments and for wrong types. For a failed result it raises NumericsError, or
    Stopped if the user stopped it, with the result as `result`."""
    kind: type[SceneOptions] = compute.__annotations__["options"]
    known = options_of(kind)
    first = inspect.signature(compute).parameters["source"]
    keywords = [
        Parameter(
            option.name,
            Parameter.POSITIONAL_OR_KEYWORD if option.positional else Parameter.KEYWORD_ONLY,
            default=option.default,
            annotation=option.hint,
        )
        for option in known.values()
    ]
    signature = Signature([first, *keywords, Parameter("changes", Parameter.VAR_KEYWORD, annotation=Any)])

    @wraps(compute)
    def call(*given: Any, **named: Any) -> _Answer:
        try:
            bound = signature.bind(*given, **named).arguments
        except TypeError as error:
            raise SceneError(f"{compute.__name__}: {error}") from None
        source, changes = bound.pop("source", first.default), bound.pop("changes", {})
        for name in [name for name, value in bound.items() if isinstance(value, Mapping) and name in SceneTable.model_fields]:
            changes[name] = bound.pop(name)  # `interface` is an option of `run` and a table of the scene
        options = kind(**{name: known[name].checked(value) for name, value in bound.items()}, changes=changes)
        try:
            result = compute(source, options.load_own())
        except SystemExit as end:
            raise ended(end) from end
        except NumbaError as error:
            raise refused_by_compiler(error) from error
        except SceneError as error:
            names = {option.flag: option.name for option in known.values()}
            text = re.sub(r"(?<![\w-])--[a-z][a-z-]*", lambda flag: names.get(flag[0], flag[0]), str(error))
            raise type(error)(text).with_traceback(error.__traceback__) from None
        if isinstance(result, Result) and (result.failed or result.stopped):
            raise (Stopped if result.stopped else NumericsError)(result.failed, result)
        return result

    call.__signature__ = signature.replace(return_annotation=compute.__annotations__["return"])  # type: ignore[attr-defined]
    call.__doc__ = f"{inspect.cleandoc(compute.__doc__ or '')}\n\n{_section(known)}"
    return call


def _section(known: Mapping[str, Any]) -> str:
    """The section of a docstring on the options."""
    lines = [f"{option.name}: {option.help}" for option in known.values()]
    lines.append("changes: of the scene, as those of `slipwave.read_scene`")
    return "\n".join(
        ["Options:", *(textwrap.fill(line, 120, initial_indent="    ", subsequent_indent="        ") for line in lines)]
    )

"""A command on the command line, made from what it declares: its options, and the files and the table of its result."""

from collections.abc import Callable, Mapping
from contextlib import closing
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any, get_args

import typer

import slipwave
from validation.output import conclude, deliver, print_json, require_writable
from validation.results.options import Option, SceneOptions, options_of
from validation.results.result import Output, Result


def _gallery() -> list[str]:
    """Names for the shell's completion."""
    from slipwave.input.source import gallery_names

    return gallery_names()


SCENE = typer.Argument(
    metavar="SCENE",
    help="a gallery name (see `slipwave scenes`), a TOML file, or a netCDF file of results",
    autocompletion=_gallery,
)
_JSON = typer.Option("--json", help="print JSON instead of a table")


def command_line(name: str) -> tuple[Callable[..., None], str, tuple[str, ...]]:
    """The command as a function whose parameters are those of the command line, the details of its help, and examples."""
    compute = getattr(slipwave, name).__wrapped__
    kind: type[SceneOptions] = compute.__annotations__["options"]
    made: type[Result] = compute.__annotations__["return"]
    known = {one.name: one for one in options_of(kind).values() if one.is_in("command line")}

    def call(source: str, json: bool, **words: Any) -> None:
        if words.get("law"):
            from slipwave.friction.own import load_laws

            load_laws(words["law"])
        files = {one: _place_of(one, words.pop(one.name), json) for one in made.OUTPUTS}
        given = {name: _value(known[name], word) for name, word in words.items() if word is not None}
        given |= made.wanted_for({one.name: path for one, path in files.items()})
        options = kind(**given)
        _finish(compute(source, options), options, files, json)

    parameters = [
        _parameter("source", Annotated[str, SCENE], Parameter.empty),
        *(_parameter(one.name, *_in_words(one)) for one in known.values()),
        *(_parameter(one.name, Annotated[Path | None, _file(one)], None) for one in made.OUTPUTS),
        _parameter("json", Annotated[bool, _JSON], False),
    ]
    call.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {one.name: one.annotation for one in parameters}
    return call, kind.DETAILS, kind.EXAMPLES


def _parameter(name: str, hint: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def _in_words(one: Option) -> tuple[Any, Any]:
    """The type and the default of an option on the command line: texts where Python takes several types."""
    notes = typer.Option(one.flag, metavar=one.more.get("metavar"), help=one.help, autocompletion=one.more.get("words"))
    if one.hint is bool or "stands_for" in one.more:
        return Annotated[bool, notes], False
    parts = {one.hint, *get_args(one.hint)}
    word: Any = next(kind for kind in (Path, str, float, int) if kind in parts)
    if one.is_required or isinstance(one.default, str):
        return Annotated[word, notes], Parameter.empty if one.is_required else one.default
    return Annotated[list[str] if one.default == () else word | None, notes], None


def _value(one: Option, word: Any) -> Any:
    """What was given on the command line as it is given in Python."""
    if "stands_for" in one.more:
        word = one.more["stands_for"] if word else one.default
    path = one.checked(word)
    if "suffixes" in one.more:
        require_writable(path, one.more["suffixes"], one.flag)
    return path


def _file(one: Output) -> Any:
    return typer.Option(one.flag, metavar=one.metavar, help=one.help)


def _place_of(one: Output, path: Path | None, json: bool) -> Path | None:
    """Where the file is written. Raises SceneError, before anything is computed, if it cannot be."""
    if path is None and one.default and not json:
        path = Path(one.default)
    require_writable(path, one.suffixes, one.flag)
    return path


def _finish(result: Result, options: SceneOptions, files: Mapping[Output, Path | None], json: bool) -> None:
    """Print the result and write its files; raise what went wrong, in one line."""
    problems = []
    with closing(result):
        if not result.is_empty:
            summary = result.summary | {one.key: str(path) for one, path in files.items() if one.key and path}
            writers = [(getattr(result, one.method), path) for one, path in files.items()]
            problems = deliver(lambda: print_json(summary) if json else print("\n".join(result.lines(summary))), *writers)
    to_go_on = [result.to_go_on(options)] if result.stopped else []
    conclude("; ".join([result.failed, *to_go_on]), problems, result.stopped)

"""A command on the command line, generated from its declarations: options, output files and table of its result."""

import os
import sys
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import replace
from functools import partial
from importlib import import_module
from inspect import Parameter, Signature, signature
from json import dumps
from pathlib import Path
from typing import Annotated, Any, TypeAlias, get_args

import typer
from numba.core.errors import NumbaError

from slipwave.errors import Interrupted, NumericsError, SceneError
from slipwave.files import reason_of, require_writable
from slipwave.friction.own import refused_by_compiler
from slipwave.input.assemble import gallery_names
from slipwave.packages import ended
from validation.commands.options import Option, SceneOptions, options_of
from validation.commands.result import Output, Result

Files: TypeAlias = Mapping[Output, Path | None]
Act: TypeAlias = Callable[[Any, Any, Files, bool], None]


_JSON = typer.Option("--json", help="print JSON instead of a table")


def command_line(module: str, name: str) -> tuple[Callable[..., None], str, tuple[str, ...]]:
    """The command `name` of a `module`: its function of the command line's words, the details of its help, and examples. It is
    made of the function of this name, or stands in the module's `COMMAND_LINE`."""
    known: Any = import_module(module)
    if name in getattr(known, "COMMAND_LINE", {}):
        function, examples = known.COMMAND_LINE[name]
        return function, "", examples
    compute = getattr(known, name).__wrapped__
    made: type[Result] = compute.__annotations__["return"]

    def act(source: str | None, options: SceneOptions, files: Files, json: bool) -> None:
        """Compute, print, write."""
        needed = made.wanted_for({output.name: path for output, path in files.items()}, options)
        options = replace(options, **needed)
        _finish(compute(source, options), options, files, json)

    optional = signature(compute).parameters["source"].default is None
    kind: type[SceneOptions] = compute.__annotations__["options"]
    return on_a_scene(kind, act, made, optional), kind.DETAILS, kind.EXAMPLES


def on_a_scene(
    kind: type[SceneOptions], act: Act, made: type[Result] | None = None, optional: bool = False
) -> Callable[..., None]:
    """A function of the command line's words that calls `act` with a scene, which may be `optional`, its options and the output
    files of the result that is `made`, if any."""
    outputs = () if made is None else made.OUTPUTS
    known = {option.name: option for option in options_of(kind).values() if not option.python_only}
    scene = typer.Argument(metavar="SCENE", help=kind.SOURCE, autocompletion=gallery_names)

    def call(source: str | None = None, json: bool = False, **words: Any) -> None:
        """Take the words of the command line."""
        files = {output: _path_of(output, words.pop(output.name), json) for output in outputs}
        given = {name: _value(known[name], word) for name, word in words.items() if word is not None}
        taken = dict[str, str]()
        for output, path in files.items():
            if path is not None and (flag := taken.setdefault(os.path.realpath(path), output.flag)) != output.flag:
                raise SceneError(f"{output.flag} {path}: must be another file than that of {flag}")
        try:
            act(source, kind(**given).load_own(), files, json)
        except SystemExit as end:
            raise ended(end) from end
        except NumbaError as error:
            raise refused_by_compiler(error) from error

    parameters = [
        _parameter("source", *((Annotated[str | None, scene], None) if optional else (Annotated[str, scene], Parameter.empty))),
        *(_parameter(option.name, *_in_words(option)) for option in known.values()),
        *(
            _parameter(
                output.name, Annotated[Path | None, typer.Option(output.flag, metavar=output.metavar, help=output.help)], None
            )
            for output in outputs
        ),
        *([] if made is None else [_parameter("json", Annotated[bool, _JSON], False)]),
    ]
    call.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return call


def _parameter(name: str, hint: Any, default: Any) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def _in_words(option: Option) -> tuple[Any, Any]:
    """Type and default of an option on the command line: text where Python takes several types."""
    notes = typer.Option(option.flag, metavar=option.metavar, help=option.help, autocompletion=option.words)
    parts = {option.hint, *get_args(option.hint)}
    if bool in parts or option.stands_for is not None:
        return Annotated[bool | None, notes], None
    word: Any = next((kind for kind in (Path, str, float, int) if kind in parts), str)
    if isinstance(option.default, str):
        return Annotated[word, notes], option.default
    return Annotated[list[str] if option.default == () else word | None, notes], None


def _value(option: Option, word: Any) -> Any:
    """A value given on the command line as its Python equivalent."""
    if option.stands_for is not None:
        word = option.stands_for if word else option.default
    path = option.checked(word)
    if option.suffixes and path is not None:
        require_writable(path, option.suffixes, option.flag)
    return path


def _path_of(output: Output, path: Path | None, json: bool) -> Path | None:
    """Path of the output file, None if not written. Raises SceneError, before anything is computed, if it cannot be written."""
    if path is None and output.default and not json:
        path = Path(output.default)
    if path is not None:
        require_writable(path, output.suffixes, output.flag)
    return path


def _finish(result: Result, options: SceneOptions, files: Files, json: bool) -> None:
    """Print the result, then write its files, each even if another fails (full disk). Raises one error, in one line, for all
    failures: Interrupted if the user stopped it, NumericsError if the numerics failed, else SceneError."""
    problems = [result.failed, result.to_go_on(options) if result.stopped else ""]
    with closing(result):
        summary = (
            {}
            if result.is_empty
            else result.summary | {output.key: str(path) for output, path in files.items() if output.key and path}
        )

        def show() -> None:
            """Print JSON or the table."""
            print(dumps(summary, indent=2, allow_nan=False) if json else "\n".join(result.lines(summary)))

        writers = [partial(getattr(result, output.method), path) for output, path in files.items() if path]
        for write in (partial(printed, show), *writers) if summary else ():
            try:
                write()
            except SceneError as error:
                problems.append(str(error))
    if any(problems):
        kind = Interrupted if result.stopped else NumericsError if result.failed else SceneError
        raise kind("; ".join(filter(None, problems)))


def printed(show: Callable[[], None]) -> None:
    """Call `show` and check that its output reached stdout. Raises SceneError if stdout cannot be written (a full disk)."""
    try:
        show()
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has closed the pipe
        return
    except OSError as error:
        raise SceneError(f"the result cannot be written to stdout: {reason_of(error)}") from None

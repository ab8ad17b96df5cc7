"""The `slipwave` command: parses the command line, runs one command, turns failures into exit statuses.

0 done; 2 the user's input is wrong or a result cannot be written (one line); 3 the numerics failed (one line); 130 interrupted
(one line); 1 a bug (traceback).
"""

import io
import logging
import os
import re
import sys
import threading
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import slipwave
from slipwave.errors import Interrupted, NumericsError, SceneError
from slipwave.files import reason_of
from slipwave.packages import line_of_user

_ROOT = Path(__file__).parents[2]
_SOON = 0.05  # seconds, in which a callback has returned
INPUT_WRONG, NUMERICS_FAILED, INTERRUPTED = 2, 3, 130
_SPREAD: dict[str, Callable[[str], bool]] = {
    "--set": lambda word: "=" in word,
    "--vary": lambda word: "=" in word,
    "--only": lambda word: True,
    "--data": lambda word: True,
    "--free": lambda word: True,
    "--curve": lambda word: True,
}

_REPORT = "validation.report.command"  # it uses the commands


def _told() -> Iterator[tuple[str, tuple[str, str]]]:
    """Name -> module and line of help of each command: a paragraph of the docstring of a file of `slipwave.__init__.pyi`, or of
    the report's. Files are read as text, and imported when the command is called, so that `slipwave --help` is fast."""
    for module in (_REPORT, *dict.fromkeys(place for place in slipwave._PLACES.values() if place.startswith("validation."))):
        docstring = _ROOT.joinpath(*module.split(".")).with_suffix(".py").read_text(encoding="utf-8").split('"""')[1]
        for name, text in re.findall(r"^`slipwave (\w+)`: (.+?)(?:\n\n|\Z)", docstring, re.MULTILINE | re.DOTALL):
            yield name, (module, " ".join(text.split()))


COMMANDS = dict(_told())
"""Command -> its module, and what it does."""


class _Commands(TyperGroup):
    """Imports a command when it is called."""

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        self.commands: Any = dict.fromkeys(COMMANDS)

    def get_command(self, context: Any, name: str) -> Any:
        """The command of this name, ready to parse its words."""
        if name not in COMMANDS:
            return None
        from validation.commands.command_line import command_line

        module, told = COMMANDS[name]
        function, details, examples = command_line(module, name)
        alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
        shown = "\n".join(f"  {line}" for line in examples)
        alone.command(name, help="\n\n".join(filter(None, [told, details])), epilog=f"\b\nExamples:\n{shown}")(function)
        return typer.main.get_command(alone)

    def parse_args(self, context: Any, args: list[str]) -> list[str]:
        """Take `--set a=1 b=2` and `--only x y` as one option per value; `--set a -1` and `--set a= -1` as `--set a=-1`."""
        words: list[str] = []
        option = ""
        for word in args:
            if option == "--set" and words[-1] != option and _is_negative(word) and words[-1].partition("=")[2] == "":
                words[-1] = f"{words[-1].rstrip('=')}={word}"
                continue
            if option and words[-1] != option and not word.startswith("-") and _SPREAD[option](word):
                words.append(option)
            elif word in _SPREAD:
                option = word
            elif option and words[-1] != option:
                option = ""
            words.append(word)
        return super().parse_args(context, words)

    def format_commands(self, context: Any, formatter: Any) -> None:
        """All commands with what they do."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, told) for name, (_, told) in COMMANDS.items()])


app = typer.Typer(
    cls=_Commands,
    help="How far is each simplified model of two sliding elastic slabs from the wave physics, and what does each answer cost?",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        from importlib.metadata import version

        print(f"slipwave {version('slipwave')}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[bool, typer.Option("--version", help="print the version", callback=_print_version, is_eager=True)] = False,
) -> None:
    """Options without a command."""


class _OnStderr(logging.Handler):
    """Prints what is logged, line by line."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one message."""
        with suppress(OSError):  # a full disk, or a terminal that was closed, ends no run
            typer.echo(record.getMessage(), err=True)


_ON_STDERR = _OnStderr()


def main(arguments: list[str] | None = None) -> int:
    """Run the command given by `arguments` (default: the process's own) and return the exit status."""
    _prepare_streams()
    words = sys.argv[1:] if arguments is None else arguments
    if arguments is None and words[:1] == ["sweep"]:
        from validation.sweep.workers import start_early  # imported here to keep the start of other commands fast

        start_early(words)
    command: Any = typer.main.get_command(app)
    try:
        names = [word.partition("=")[0] for word in words if word.startswith("--") and word != "--"]
        twice = next((name for name in names if names.count(name) > 1 and name not in _SPREAD), None)
        if twice is not None:  # one of both values would be ignored silently
            raise SceneError(f"{twice}: is given more than once")
        status = command(words or ["--help"], prog_name="slipwave", standalone_mode=False)
        sys.stdout.flush()
    except SceneError as error:
        return _say(error, INPUT_WRONG)
    except NumericsError as error:
        return _say(error, NUMERICS_FAILED)
    except Interrupted as error:
        return _say(error, INTERRUPTED)
    except (KeyboardInterrupt, typer.Abort):
        return _say("interrupted", INTERRUPTED)
    except (BrokenPipeError, SystemExit) as end:  # SystemExit 0: the shell's completion is done; else typer found a closed pipe
        if not isinstance(end, SystemExit) or end.code:
            _abandon_stdout()
        return 0
    except Exception as error:
        if isinstance(error, OSError) and error.errno and error.filename is None:  # no file: a stream
            return _say(f"the result cannot be written to stdout: {reason_of(error)}", INPUT_WRONG)
        explain: Callable[[], str] | None = getattr(error, "format_message", None)  # typer's own complaints have one
        if explain is None and (where := line_of_user(error)):
            return _say(f"{where}: {type(error).__name__}: {error}", NUMERICS_FAILED)
        if explain is None:
            raise
        return _say(explain(), INPUT_WRONG)
    if status == INTERRUPTED:  # typer catches the KeyboardInterrupt of a command
        return _say("interrupted", INTERRUPTED)
    return status if isinstance(status, int) else 0


def _is_negative(word: str) -> bool:
    try:
        return word.startswith("-") and float(word) <= 0.0
    except ValueError:
        return False


def _prepare_streams() -> None:
    """Discard output to a closed stream, escape characters that the terminal's encoding lacks, and lose no Ctrl-C."""
    sys.unraisablehook = _hear_again
    sys.stdout = sys.stdout or io.StringIO()
    sys.stderr = sys.stderr or io.StringIO()
    log = logging.getLogger("slipwave")
    log.addHandler(_ON_STDERR)
    log.setLevel(logging.INFO)
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it tells where it cannot keep its fonts
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _hear_again(lost: Any) -> None:
    """Repeat a Ctrl-C that fell into a library's callback (numba's, where it loads code), from which no error gets out."""
    if lost.exc_type is KeyboardInterrupt:
        threading.Timer(_SOON, interrupt_main).start()
    else:
        sys.__unraisablehook__(lost)


def _abandon_stdout() -> None:
    """Discard buffered output, which Python would otherwise try to write when it exits."""
    with suppress(OSError), open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _say(message: object, status: int) -> int:
    """Print one line on stderr, without control characters of a terminal."""
    line = " ".join(str(message).split())
    with suppress(OSError):  # a terminal that was closed
        print("slipwave: " + "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in line), file=sys.stderr)
    try:
        sys.stdout.flush()
    except OSError:
        _abandon_stdout()
    return status


if __name__ == "__main__":
    sys.exit(main())

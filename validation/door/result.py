"""What the functions of the door have in common: results, and how one that ended early is handed over."""

import html
import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from slipwave.errors import NumericsError
from slipwave.input import SceneSource, read_scene
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts

told = logging.getLogger("slipwave")
"""What is chosen for the user and how far long work has come, at level INFO; the command line prints it on stderr."""


class Result(ABC):
    """A result of the door: `summary` is the JSON of the command as a dictionary."""

    @property
    @abstractmethod
    def summary(self) -> dict[str, Any]:
        """All figures by the keys of the command's JSON; None where there is no value."""

    def __repr__(self) -> str:
        shown = (f"{name} = {value}" for name, value in _scalars(self.summary))
        return f"<{type(self).__name__}: {', '.join(shown)}>"

    def _repr_html_(self) -> str:
        rows = (f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>" for name, value in _scalars(self.summary))
        return f"<table><caption>{type(self).__name__}</caption>{''.join(rows)}</table>"


Delivered = TypeVar("Delivered", bound=Result)


class Stopped(KeyboardInterrupt):
    """The user stopped the work; `result` is what was known by then."""

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result


def scene_of(source: SceneSource, changes: Mapping[str, Any], until: float | None = None) -> Scene:
    """The scene of a call: `source` with `changes` and, if given, another length of the run (transits). Tells what is doubtful
    about it."""
    scene = read_scene(source, **changes, **({} if until is None else {"run.until": until}))
    for line in doubts(scene):
        told.warning("note: %s", line)
    return scene


def deliver(result: Delivered, failed: str, stopped: bool = False) -> Delivered:
    """`result`. Raises NumericsError if `failed` says what failed, Stopped if the user stopped it; both hold the result."""
    if stopped:
        raise Stopped(failed, result)
    if failed:
        error = NumericsError(failed)
        error.result = result
        raise error
    return result


def delivered(work: Callable[[], Delivered]) -> tuple[Delivered, str, bool]:
    """The inverse of `deliver`: the result of `work`, what failed, and whether the user stopped it. An error without a result is
    raised again."""
    try:
        return work(), "", False
    except (NumericsError, Stopped) as error:
        if error.result is None:
            raise
        return error.result, str(error), isinstance(error, Stopped)


def finite(value: Any) -> Any:
    """`value` with None in place of NaN and infinity, which JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _scalars(facts: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Every single value among `facts` that there is, with its dotted key; numbers to six digits."""
    for key, value in facts.items():
        if isinstance(value, Mapping):
            yield from _scalars(value, f"{above}{key}.")
        elif isinstance(value, float):
            yield f"{above}{key}", f"{value:.6g}"
        elif isinstance(value, str | int) and key != "schema":
            yield f"{above}{key}", str(value)

"""What the functions of the door have in common: results, and how one that ended early is handed over."""

from collections.abc import Callable, Iterable, Mapping
from inspect import signature
from pathlib import Path
from typing import Any, TypeVar

from slipwave.errors import NumericsError, SceneError
from slipwave.input import SceneSource, read, read_scene
from slipwave.input.wording import nearest, shorten
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.results.facts import Facts, Place, finite
from validation.results.options import log
from validation.results.result import Dataset, Result, Stopped, save_drawing

__all__ = ["Dataset", "Facts", "Place", "Result", "Stopped", "finite", "log", "save_drawing"]


Delivered = TypeVar("Delivered", bound=Result)


def as_path(path: str | Path | None) -> Path | None:
    """A path of the user's as a `Path`."""
    return None if path is None else Path(path)


def _options() -> list[str]:
    """What the functions of the door take besides the tables of a scene."""
    import slipwave

    door = [found for name in slipwave.__all__ if (found := getattr(slipwave, name)).__module__.startswith("validation.")]
    return sorted({name for function in door for name in signature(function).parameters} - {"changes"})


def _require_known(changes: Mapping[str, Any], tables: Mapping[str, Any]) -> None:
    """Raises SceneError for a keyword that is neither an option nor a key of a scene with these `tables`; it names the
    nearest."""
    from slipwave.input.overrides import endings
    from slipwave.input.schema import SceneTable

    for key in changes:
        if not endings(key.split("."), tables):
            guess = nearest(key, [*_options(), *SceneTable.model_fields])
            hint = f"; did you mean {guess}?" if guess else ""
            raise SceneError(f"{shorten(key)[1:-1]} = {shorten(changes[key])}: neither an option nor a key of a scene{hint}")


def _as_list(settings: Iterable[str]) -> Iterable[str]:
    return [settings] if isinstance(settings, str) else settings


def scene_of(source: SceneSource, settings: Iterable[str], changes: Mapping[str, Any], until: float | str | None = None) -> Scene:
    """The scene of a call: `source` with `settings` ("key=value"), `changes` and, if given, another length (transits, or a text
    with a unit of time). Tells what is doubtful about it."""
    length = [] if until is None else [f"run.until={until}"]
    given = read(source.scene if isinstance(source, Place) else source, [*_as_list(settings), *length])
    _require_known(changes, given.tables or {})
    scene = read_scene(given, **changes)
    for line in doubts(scene):
        log.warning("note: %s", line)
    return scene


def announced(model: str, why: str) -> str:
    """`model`; the log says why `auto` chose it, if it did."""
    if why:
        log.info("model auto: %s (%s)", model, why)
    return model


def deliver(result: Delivered, failed: str, stopped: bool = False) -> Delivered:
    """`result`. Raises NumericsError if `failed` says what failed, Stopped if the user stopped it; both hold the result."""
    if stopped:
        raise Stopped(failed, result)
    if failed:
        raise NumericsError(failed, result)
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

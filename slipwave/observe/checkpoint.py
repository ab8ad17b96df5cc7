"""Checkpoints: a run killed at any moment goes on from the last one and ends with the same bits as if nothing had happened.

A solver that can be saved has `state() -> dict of arrays`, `restore(dict)` and `settings` (all that shapes its numbers besides
the scene and the model's name: cells of every section, Courant number, step, ...); an observer has the first two. The file is
.npz, whole or absent, and carries the scene's digest (without `until`, so a run may be prolonged), the model, its settings, a
digest of the solver rooms' sources and one of its own contents: a checkpoint of anything else, or a damaged one, is refused,
never misread.
"""

import dataclasses
import hashlib
import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import SceneError
from slipwave.files import whole_or_absent
from slipwave.observe import Final, follow
from slipwave.observe.follow import Observer, Solver
from slipwave.sources import source_digest

FORMAT = 2
_LONGEST_VALUE = 60  # characters of a fact in a message
State = dict[str, NDArray[Any]]


class ResumableObserver(Observer, Protocol):
    """An observer that can be saved."""

    def state(self) -> State:
        """Everything remembered."""

    def restore(self, state: State) -> None:
        """Go on from `state`."""


class ResumableSolver(Solver, Protocol):
    """A solver that can be saved."""

    step: float

    @property
    def settings(self) -> dict[str, Any]:
        """All that shapes its numbers besides the scene and the model's name; goes into a file as JSON."""

    def state(self) -> State:
        """Everything that changes during a run."""

    def restore(self, state: State) -> None:
        """Go on from `state`."""


def save(path: Path, solver: ResumableSolver, observers: Mapping[str, ResumableObserver] | None = None) -> None:
    """Write the run as it stands to `path`. Raises SceneError if the file cannot be written."""
    arrays = {f"solver/{name}": array for name, array in solver.state().items()}
    for label, observer in (observers or {}).items():
        arrays |= {f"observer/{label}/{name}": array for name, array in observer.state().items()}
    facts = _facts(solver) | {"time": solver.time, "observers": sorted(observers or {})}
    text = json.dumps(facts | {"contents": _digest(facts, arrays)})
    with whole_or_absent(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, facts=np.array(text), **arrays)


def load(path: Path, solver: ResumableSolver, observers: Mapping[str, ResumableObserver] | None = None) -> None:
    """Bring `solver` and `observers` to where the run in `path` stood.

    Raises SceneError, one line naming the file, if it is not a checkpoint, damaged or inconsistent, or if it belongs to another
    scene, model, setting, version of the solvers or set of observers. What was given is then of no further use.
    """
    facts, arrays = _read(path)
    wanted = json.loads(json.dumps(_facts(solver) | {"observers": sorted(observers or {})}))
    for key, value in wanted.items():
        if facts[key] != value:
            raise SceneError(f"checkpoint {str(path)!r}: {_difference(key, facts[key], value)}")
    watching = {f"observer/{label}/": observer for label, observer in (observers or {}).items()}
    try:
        for prefix, part in ({"solver/": solver} | watching).items():
            found = _under(arrays, prefix)
            _require_layout(found, part.state())
            part.restore(found)
    except (SceneError, ValueError, LookupError, TypeError, OverflowError) as error:
        reason = str(error).removeprefix("checkpoint: ")
        raise SceneError(f"checkpoint {str(path)!r}: inconsistent: {reason}") from None


def saved_time(path: Path) -> float:
    """Where the run in `path` stood (transits). Raises SceneError if it is not a checkpoint."""
    return float(_read(path)[0]["time"])


def follow_with_checkpoints(
    solver: ResumableSolver,
    until: float,
    path: Path,
    every: float = 1000.0,
    observers: Mapping[str, ResumableObserver] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Final:
    """As `slipwave.observe.follow`, saving to `path` about every `every` transits, and starting from `path` if it exists.

    Raises SceneError as `load` does, and if the checkpoint is later than `until`.
    """
    watching = dict(observers or {})
    if path.exists():
        load(path, solver, watching)
        if solver.time >= until - 1e-9:
            raise SceneError(f"until = {until:g}: checkpoint {str(path)!r} is already at t = {solver.time:g}")
    piece = solver.step * solver.nodes.size
    mark = every * (np.floor(solver.time / every + 1e-9) + 1)
    while mark < until - piece:
        if mark > solver.time:
            follow(solver, mark, list(watching.values()), progress)
            save(path, solver, watching)
        mark += every
    return follow(solver, until, list(watching.values()), progress)


@cache
def _sources() -> str:
    """Digest of the solvers as this process found them."""
    return source_digest()


def _facts(solver: ResumableSolver) -> dict[str, Any]:
    """What a checkpoint and the run that goes on from it must have in common; the first that differs is told."""
    return {
        "format": FORMAT,
        "scene": dataclasses.replace(solver.scene, until=0.0).digest,
        "model": solver.model,
        "settings": solver.settings,
        "sources": _sources(),
    }


def _difference(key: str, found: Any, wanted: Any) -> str:
    """One line on what sets the run in the file apart from this one."""
    if key == "sources":
        return f"was written by another version of the solvers ({_short(found)}; this one is {wanted!r}): start the run afresh"
    if key == "settings" and isinstance(found, dict):
        apart = [name for name in wanted if found.get(name) != wanted[name]] or sorted(found.keys() - wanted.keys())
        listed = ", ".join(f"{name} is {_short(found.get(name))}, not {_short(wanted.get(name))}" for name in apart)
        return f"settings differ from this run's: {listed}"
    return f"{key} is {_short(found)}; this run needs {_short(wanted)}"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "..."


def _digest(facts: Mapping[str, Any], arrays: State) -> str:
    """Hash of all that a checkpoint says."""
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _read(path: Path) -> tuple[dict[str, Any], State]:
    """(facts, arrays) of a file that says of itself what its contents are; SceneError if it cannot be read or they are not."""
    unreadable = f"checkpoint {str(path)!r} cannot be read"
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        facts = json.loads(str(arrays.pop("facts")))
        contents = facts.pop("contents", None)
        if facts["format"] == FORMAT and contents != _digest(facts, arrays):
            raise SceneError(f"{unreadable}: its contents are not what was written")
        if facts["format"] != FORMAT:
            raise SceneError(f"{unreadable}: format is {_short(facts['format'])}; this version reads {FORMAT}")
    except SceneError:
        raise
    except OSError as error:
        raise SceneError(f"{unreadable}: {(error.strerror or 'it is not a checkpoint, or damaged').lower()}") from None
    except Exception:  # a damaged zip, header or text fails in a dozen ways, all of which mean this
        raise SceneError(f"{unreadable}: it is not a checkpoint, or damaged") from None
    return facts, arrays


def _require_layout(found: State, own: State) -> None:
    """The same names and kinds of arrays as `own`; tables may differ in one of their axes, along which they grow."""
    if found.keys() != own.keys():
        raise ValueError(f"holds {', '.join(sorted(found)) or 'nothing'}; this run needs {', '.join(sorted(own))}")
    for name, array in own.items():
        other = found[name]
        alike = array.dtype == other.dtype and array.ndim == other.ndim
        changed = sum(a != b for a, b in zip(array.shape, other.shape, strict=False))
        if not alike or changed > (array.ndim > 1):
            raise ValueError(f"{name} is {other.dtype} {other.shape}; this run needs {array.dtype} {array.shape}")


def _under(arrays: State, prefix: str) -> State:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}

"""Checkpoints: a run killed at any moment goes on from the last one and ends with the same bits as if nothing had happened.

Saved are the solver and, by labels, whatever else has a `state()` (`slipwave.observe.solver.Resumable`): observers, records of
fields. The file is .npz, whole or absent, and carries the scene's digest (without `until`, so a run may be prolonged), the
model, its settings, a digest of the solver rooms' sources and one of its own contents: a checkpoint of anything else, or a
damaged one, is refused, never misread.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import SceneError
from slipwave.files import whole_or_absent
from slipwave.observe.solver import Resumable, Solver
from slipwave.sources import source_digest

FORMAT = 2
_LONGEST_VALUE = 60  # characters of a fact in a message
_Arrays: TypeAlias = dict[str, NDArray[Any]]


def save(path: Path, solver: Solver, observers: Mapping[str, Resumable] | None = None) -> None:
    """Write the run as it stands to `path`. Raises SceneError if the file cannot be written."""
    arrays = {f"solver/{name}": array for name, array in solver.state().items()}
    for label, observer in (observers or {}).items():
        arrays |= {f"observer/{label}/{name}": array for name, array in observer.state().items()}
    facts = _facts(solver) | {"time": solver.time, "observers": sorted(observers or {})}
    text = json.dumps(facts | {"contents": _digest(facts, arrays)})
    with whole_or_absent(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, facts=np.array(text), **arrays)


def load(path: Path, solver: Solver, observers: Mapping[str, Resumable] | None = None) -> None:
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


class Checkpoints:
    """Marks of a run to `until` (transits): saves `solver` and `observers` to `path` every `every` transits."""

    def __init__(
        self, solver: Solver, observers: Mapping[str, Resumable], path: Path, until: float, every: float = 1000.0
    ) -> None:
        self._solver, self._observers, self._path, self._until, self._every = solver, observers, path, until, every
        self._due = 0.0
        self._schedule()

    @property
    def due(self) -> float:
        """As `Mark`."""
        return self._due if self._due < self._until else math.inf

    def act(self) -> None:
        """As `Mark`; a run that is over leaves no checkpoint: nothing goes on from there."""
        if self._solver.time < self._until - 1e-9:
            save(self._path, self._solver, self._observers)
        self._schedule()

    def resume(self) -> None:
        """Bring the run to where it stood in `path`; SceneError as `load` has it, and if that is later than `until`."""
        load(self._path, self._solver, self._observers)
        if self._solver.time >= self._until - 1e-9:
            raise SceneError(f"until = {self._until:g}: checkpoint {str(self._path)!r} is already at t = {self._solver.time:g}")
        self._schedule()

    def _schedule(self) -> None:
        """The next whole multiple of `every`."""
        self._due = self._every * (math.floor(self._solver.time / self._every + 1e-9) + 1)


@cache
def _sources() -> str:
    """Digest of the solvers as this process found them."""
    return source_digest()


def _facts(solver: Solver) -> dict[str, Any]:
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


def _digest(facts: Mapping[str, Any], arrays: _Arrays) -> str:
    """Hash of all that a checkpoint says."""
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _read(path: Path) -> tuple[dict[str, Any], _Arrays]:
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


def _require_layout(found: _Arrays, own: _Arrays) -> None:
    """The same names and kinds of arrays as `own`; tables may differ in one of their axes, along which they grow."""
    if found.keys() != own.keys():
        raise ValueError(f"holds {', '.join(sorted(found)) or 'nothing'}; this run needs {', '.join(sorted(own))}")
    for name, array in own.items():
        other = found[name]
        alike = array.dtype == other.dtype and array.ndim == other.ndim
        changed = sum(a != b for a, b in zip(array.shape, other.shape, strict=False))
        if not alike or changed > (array.ndim > 1):
            raise ValueError(f"{name} is {other.dtype} {other.shape}; this run needs {array.dtype} {array.shape}")


def _under(arrays: _Arrays, prefix: str) -> _Arrays:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}

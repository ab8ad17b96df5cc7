"""Checkpoints: a run killed at any moment continues from the last one and gives bit-identical results.

A checkpoint holds the solver and, by labels, everything else that has a `state()` (`slipwave.solve.Resumable`), such as
observers and records of fields. The .npz file is written whole or not at all. It also holds the scene's digest (without `until`,
so a run may be prolonged), the model, its settings, digests of the solver packages' sources and of the user's own files, and one
of its own contents. A checkpoint of another run, or a damaged one, is refused.

Restores a solver's state from a checkpoint: all of it or, with one line that says what is wrong, nothing.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipwave.errors import SceneError
from slipwave.files import going_on, whole_or_absent
from slipwave.observe.pieces import SAME, Array
from slipwave.solve.solver import Resumable, Solver
from slipwave.sources import source_digest

FORMAT = 3
_LONGEST_VALUE = 60  # characters of a fact in a message
_Arrays: TypeAlias = dict[str, NDArray[Any]]


def saved_time(path: Path) -> float:
    """Time of the run saved in `path` (transits). Raises SceneError if it is not a checkpoint."""
    return float(_read(path)[0]["time"])


class Checkpoints:
    """Marks of a run to `until` (transits): saves `solver` and `observers` to `path` every `every` transits. `files`: digests of
    the user's files that the run depends on."""

    def __init__(
        self,
        solver: Solver,
        observers: Mapping[str, Resumable],
        path: Path,
        until: float,
        every: float,
        files: Mapping[str, str] | None = None,
    ) -> None:
        self.until = until
        self._solver, self._path, self._every = solver, path, every
        named = {f"observer/{label}/": observer for label, observer in observers.items()}
        self._parts: dict[str, Resumable] = {"solver/": solver, **named}
        self._observers, self._files = sorted(observers), dict(files or {})
        self._schedule()

    @property
    def due(self) -> float:
        """As `Mark`."""
        return self._due if self._due < self.until else math.inf

    def act(self) -> None:
        """As `Mark`. At the end of the run nothing is saved; the mark stays due for a run that continues. A file that cannot be
        written does not end the run."""
        if self._solver.time < self.until - SAME:
            with going_on():
                self.save()
            self._schedule()

    def save(self) -> None:
        """Write the present state of the run to `path`. Raises SceneError if the file cannot be written."""
        arrays = {prefix + name: array for prefix, part in self._parts.items() for name, array in part.state().items()}
        facts = self._facts() | {"time": self._solver.time}
        text = json.dumps(facts | {"contents": _digest(facts, arrays)})
        with whole_or_absent(self._path) as temporary, temporary.open("wb") as file:
            np.savez(file, allow_pickle=False, facts=np.array(text), **arrays)

    def resume(self) -> None:
        """Restore the run from `path`.

        Raises SceneError, one line naming the file, if it is not a checkpoint, damaged or inconsistent, if it belongs to another
        scene, model, setting, version of the solvers or of the user's files, or set of observers, and if that run has reached
        `until`. Solver and observers must not be used after that.
        """
        facts, arrays = _read(self._path)
        for key, value in json.loads(json.dumps(self._facts())).items():
            if facts[key] != value:
                raise SceneError(f"checkpoint {str(self._path)!r}: {_difference(key, facts[key], value, self._path)}")
        try:
            for prefix, part in self._parts.items():
                saved = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
                _require_layout(saved, part.state())
                part.restore(saved)
        except (SceneError, ValueError, LookupError, TypeError, OverflowError) as error:
            reason = str(error).removeprefix("checkpoint: ")
            raise SceneError(f"checkpoint {str(self._path)!r}: inconsistent: {reason}") from None
        if self._solver.time >= self.until - SAME:
            raise SceneError(f"until = {self.until:g}: checkpoint {str(self._path)!r} is already at t = {self._solver.time:g}")
        self._schedule()

    def _facts(self) -> dict[str, Any]:
        """Facts in which a checkpoint and the run that continues from it must agree; the first difference is reported."""
        return {
            "format": FORMAT,
            "scene": dataclasses.replace(self._solver.scene, until=0.0).digest,
            "model": self._solver.model,
            "settings": self._solver.settings,
            "sources": source_digest(),
            "files": self._files,
            "observers": self._observers,
        }

    def _schedule(self) -> None:
        self._due: float = self._every * (math.floor(self._solver.time / self._every + 1e-9) + 1)


def _difference(key: str, saved: Any, wanted: Any, path: Path) -> str:
    """One line that states how the run in the file `path` differs from this one."""
    if key == "files":
        changed = ", ".join(sorted(name for name in {*saved, *wanted} if saved.get(name) != wanted.get(name)))
        return f"{changed} changed since it was written: delete {str(path)!r} to begin again"
    if key == "sources":
        return f"was written by another version of the solvers ({_short(saved)}; this one is {wanted!r}): start the run again"
    if key == "settings":
        differing = [name for name in wanted if saved.get(name) != wanted[name]] or sorted(saved.keys() - wanted.keys())
        listed = ", ".join(f"{name} is {_short(saved.get(name))}, not {_short(wanted.get(name))}" for name in differing)
        return f"settings differ from this run's: {listed}"
    return f"{key} is {_short(saved)}; this run needs {_short(wanted)}"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "..."


def _digest(facts: Mapping[str, Any], arrays: _Arrays) -> str:
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _read(path: Path) -> tuple[dict[str, Any], _Arrays]:
    """(facts, arrays) of a file. Raises SceneError if it cannot be read or if its contents do not match its own digest."""
    unreadable = f"checkpoint {str(path)!r} cannot be read"
    try:
        # opened here, because numpy leaves a damaged file open
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        facts = json.loads(str(arrays.pop("facts")))
        contents = facts.pop("contents", None)
        if facts["format"] != FORMAT:
            raise SceneError(f"{unreadable}: format is {_short(facts['format'])}; this version reads {FORMAT}")
        if contents != _digest(facts, arrays):
            raise SceneError(f"{unreadable}: its contents have changed since it was written")
    except SceneError:
        raise
    except OSError as error:
        raise SceneError(f"{unreadable}: {(error.strerror or 'it is not a checkpoint, or damaged').lower()}") from None
    except Exception:  # a damaged zip, header or text raises errors of many kinds
        raise SceneError(f"{unreadable}: it is not a checkpoint, or damaged") from None
    return facts, arrays


def _require_layout(saved: _Arrays, own: _Arrays) -> None:
    """Raises ValueError unless `saved` has the names and kinds of arrays of `own`. Tables may differ in the axis that grows."""
    if saved.keys() != own.keys():
        raise ValueError(f"holds {', '.join(sorted(saved)) or 'nothing'}; this run needs {', '.join(sorted(own))}")
    for name, array in own.items():
        other = saved[name]
        alike = array.dtype == other.dtype and array.ndim == other.ndim
        changed = sum(a != b for a, b in zip(array.shape, other.shape, strict=False))
        if not alike or changed > (array.ndim > 1):
            raise ValueError(f"{name} is {other.dtype} {other.shape}; this run needs {array.dtype} {array.shape}")


def whole_numbers(state: Mapping[str, NDArray[Any]], name: str, least: tuple[int, ...]) -> list[int]:
    """The counts in `state[name]`, one per entry of `least`. Raises SceneError unless each is a whole number >= that entry."""
    counts = state.get(name)
    if counts is None or counts.shape != (len(least),) or counts.dtype.kind not in "if":
        raise SceneError(f"{name} is missing or does not hold {len(least)} numbers")
    for count, lowest in zip(counts.tolist(), least, strict=True):
        if not (lowest <= count <= 2**53 and count == int(count)):
            raise SceneError(f"{name} holds {count!r}: must be a whole number from {lowest}")
    return [int(count) for count in counts.tolist()]


def tables(state: Mapping[str, NDArray[Any]], shapes: Mapping[str, tuple[int, ...]], model: str) -> dict[str, Array]:
    """Copies of the arrays of `state` named in `shapes` (-1: any length). Raises SceneError unless they are finite and fit."""
    saved = {}
    for name, shape in shapes.items():
        array = state.get(name, np.empty(0, dtype=bool))
        fits = len(shape) == array.ndim and all(wanted in (-1, size) for wanted, size in zip(shape, array.shape, strict=True))
        if array.dtype != np.float64 or not fits:
            raise SceneError(f"checkpoint: {name} does not fit this scene with model {model}")
        if not np.isfinite(array).all():
            raise SceneError(f"checkpoint: {name} holds numbers that are not finite")
        saved[name] = array.copy()
    return saved


def take_back(own: Mapping[str, Array], state: Mapping[str, NDArray[Any]], model: str) -> None:
    """own[name][...] = state[name] for every name. Raises SceneError before any is set unless all fit and are finite."""
    saved = tables(state, {name: array.shape for name, array in own.items()}, model)
    for name, array in own.items():
        array[...] = saved[name]

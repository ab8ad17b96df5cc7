"""Checkpoints: a run killed at any moment goes on from the last one and ends with the same bits as if nothing had happened.

A solver that can be saved has `state() -> dict of arrays` and `restore(dict)`, and may have `settings` (what it was built with
besides the scene; its step stands for them if not); an observer has the first two. The file is .npz, whole or absent, and
carries the scene's digest (without `until`, so a run may be prolonged), the model and its settings: a checkpoint of anything
else is refused, never misread.
"""

import dataclasses
import json
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scene.errors import SceneError
from scene.files import whole_or_absent
from scene.observe import Final, follow
from scene.observe.follow import Observer, Solver

FORMAT = 1
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

    def state(self) -> State:
        """Everything that changes during a run."""

    def restore(self, state: State) -> None:
        """Go on from `state`."""


def save(path: Path, solver: ResumableSolver, observers: Mapping[str, ResumableObserver] | None = None) -> None:
    """Write the run as it stands to `path`. Raises SceneError if the file cannot be written."""
    arrays = {f"solver/{name}": array for name, array in solver.state().items()}
    for label, observer in (observers or {}).items():
        arrays |= {f"observer/{label}/{name}": array for name, array in observer.state().items()}
    facts = json.dumps(_facts(solver) | {"time": solver.time, "observers": sorted(observers or {})})
    with whole_or_absent(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, facts=np.array(facts), **arrays)


def load(path: Path, solver: ResumableSolver, observers: Mapping[str, ResumableObserver] | None = None) -> None:
    """Bring `solver` and `observers` to where the run in `path` stood.

    Raises SceneError if the file is not a checkpoint or belongs to another scene, model, setting or set of observers.
    """
    facts, arrays = _read(path)
    wanted = _facts(solver) | {"observers": sorted(observers or {})}
    for key, value in wanted.items():
        if facts.get(key) != value:
            raise SceneError(f"checkpoint {str(path)!r}: {key} is {facts.get(key)!r}; this run needs {value!r}")
    solver.restore(_under(arrays, "solver/"))
    for label, observer in (observers or {}).items():
        observer.restore(_under(arrays, f"observer/{label}/"))


def follow_with_checkpoints(
    solver: ResumableSolver,
    until: float,
    path: Path,
    every: float = 1000.0,
    observers: Mapping[str, ResumableObserver] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Final:
    """As `scene.observe.follow`, saving to `path` about every `every` transits, and starting from `path` if it exists.

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


def _facts(solver: ResumableSolver) -> dict[str, Any]:
    digest = dataclasses.replace(solver.scene, until=0.0).digest
    return {
        "format": FORMAT,
        "scene": digest,
        "model": solver.model,
        "settings": getattr(solver, "settings", {"step": solver.step}),
    }


def _read(path: Path) -> tuple[dict[str, Any], State]:
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(str(arrays.pop("facts"))), arrays
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise SceneError(f"checkpoint {str(path)!r} cannot be read: {str(error).splitlines()[0]}") from None


def _under(arrays: State, prefix: str) -> State:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}

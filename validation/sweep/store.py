"""The folder of a sweep: `manifest.json` says what is computed, each file in `parts` holds finished points.

A part is written to a temporary name, flushed to disk and renamed, and the folder is flushed too: after any crash a part exists
whole or not at all, and the remaining work follows from the existing points. Its name contains a digest of its manifest, so that
parts of a former sweep, which another process still writes or left behind, are never taken for those of the present one.
"""

import hashlib
import json
import math
import os
import shutil
import uuid
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from slipwave.errors import SceneError
from slipwave.files import reason_of, whole_or_absent
from validation.sweep.measures import MOST_CYCLES, measure_of
from validation.sweep.plan import MOST, Indices, Plan

STATUS = ("done", "refused", "failed", "died")
"""Status of a point: computed; refused as a scene; numerics failed; process killed three times in a row."""

MANIFEST, _PARTS = "manifest.json", "parts"
_OURS = (".", _PARTS, MANIFEST)  # another process may begin a sweep here between a look for the manifest and a look around
_SHOWN, _LONG = 3, 40
_LARGEST = 8 * MOST  # bytes of an unpacked part: a number at each of the most points of a plan
Columns = Mapping[str, npt.NDArray[Any]]


class Store:
    """The parts of one sweep in `folder`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._digest = ""  # of the manifest of the sweep that was begun here

    @property
    def manifest(self) -> dict[str, Any] | None:
        """The manifest in the folder; None if there is no sweep. Raises SceneError for a damaged manifest."""
        path, known = self.folder / MANIFEST, None
        try:
            known = json.loads(path.read_text(encoding="utf-8")) if path.is_file() or not path.exists() else None
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:  # as of a ring of links
            raise SceneError(f"{str(path)!r} cannot be read: {reason_of(error)}") from None
        except (ValueError, RecursionError):
            pass
        if isinstance(known, dict):
            return known
        raise SceneError(f"{str(path)!r} is damaged: it is no manifest of a sweep")

    def begin(self, manifest: Mapping[str, Any], anew: bool = False) -> None:
        """Begin or continue the sweep of `manifest`. Raises SceneError if the folder holds another one, naming the differences,
        unless `anew`; and for a folder with other files."""
        present = self.manifest
        if anew and present is not None:
            (self.folder / MANIFEST).unlink(missing_ok=True)  # first: parts of a sweep that has none are nobody's
            shutil.rmtree(self.folder / _PARTS, ignore_errors=True)
        elif present is None:
            if self.folder.exists() and (
                not self.folder.is_dir() or any(not path.name.startswith(_OURS) for path in self.folder.iterdir())
            ):
                raise SceneError(f"--out = {str(self.folder)!r}: must be a new or empty folder, or one of a sweep")
        elif differing := [key for key in manifest if present.get(key) != manifest[key]]:
            differences = "; ".join(_difference(key, present.get(key), manifest[key]) for key in differing[:_SHOWN])
            raise SceneError(
                f"--out = {str(self.folder)!r}: holds another sweep ({differences}); another folder, or --anew to begin again"
            )
        else:
            self._make_parts()
            self._digest = _digest(present)
            return
        self._make_parts()
        temporary = self.folder / f".{uuid.uuid4().hex}.json"
        try:
            with temporary.open("w", encoding="utf-8") as file:
                json.dump(manifest, file, indent=1, ensure_ascii=False)
                os.fsync(file.fileno())
            os.link(temporary, self.folder / MANIFEST)  # fails where another process has begun a sweep here just now
            self._digest = _digest(manifest)
        except FileExistsError:
            self.begin(manifest)
        except OSError as error:
            raise SceneError(f"--out = {str(self.folder)!r}: cannot be written: {reason_of(error)}") from None
        finally:
            temporary.unlink(missing_ok=True)

    def _make_parts(self) -> None:
        try:
            (self.folder / _PARTS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SceneError(f"--out = {str(self.folder)!r}: cannot be made: {reason_of(error)}") from None

    def write(self, points: Indices, columns: Columns) -> None:
        """Add finished points of the sweep. Raises SceneError if the part cannot be written, or if another process has begun
        another sweep here."""
        present = self.manifest
        if present is None or _digest(present) != self._digest:
            raise SceneError(f"--out = {str(self.folder)!r}: another process has begun another sweep there; this one ends")
        path = self.folder / _PARTS / f"{points[0]:012d}-{self._digest}-{uuid.uuid4().hex[:12]}.npz"
        with whole_or_absent(path) as temporary, temporary.open("wb") as file:
            np.savez(file, allow_pickle=False, **{"point": points, **columns})
        if os.name == "posix":  # flush the names in the folder too
            number = os.open(path.parent, os.O_RDONLY)
            try:
                os.fsync(number)
            finally:
                os.close(number)

    def parts(self, plan: Plan) -> Iterator[tuple[Indices, Columns]]:
        """Every whole part: its points and their columns. Damaged parts and those of another manifest count as absent. A sweep of
        an earlier version, whose parts have no digest, can be read but not continued."""
        ours = self._digest or _digest(self.manifest or {})
        for path in sorted((self.folder / _PARTS).glob("[0-9]*.npz")):
            whose = path.stem.split("-")[1:-1]
            if whose != [ours] and (whose or self._digest):
                continue
            columns = _read(path, plan)
            if columns is not None:
                yield columns.pop("point"), columns

    def done(self, plan: Plan) -> npt.NDArray[np.bool_]:
        """Which points of `plan` are finished."""
        finished = np.zeros(plan.size, dtype=bool)
        for points, _ in self.parts(plan):
            finished[points] = True
        return finished


def _read(path: Path, plan: Plan) -> dict[str, npt.NDArray[Any]] | None:
    """The columns of a part; None if it is damaged: no zip, or with kinds, shapes, points or words that the plan has not. Kinds,
    shapes and sizes are read from the headers, before anything is unpacked."""
    measure = measure_of(plan.measure)
    words = {**measure.words, "status": STATUS}
    try:
        with path.open("rb") as file, zipfile.ZipFile(file) as packed:
            if not path.is_file() or sum(member.file_size for member in packed.infolist()) > _LARGEST:
                return None
            kinds, size = {}, 0
            for name in packed.namelist():
                with packed.open(name) as stream:
                    if np.lib.format.read_magic(stream) != (1, 0):
                        return None
                    shape, _, kind = np.lib.format.read_array_header_1_0(stream)
                kinds[name.removesuffix(".npy")] = shape, kind.kind
                size += math.prod(shape) * kind.itemsize
            count = kinds["point"][0][0]
            shapes = {name: (count, *[MOST_CYCLES] * bool(measure.lists and name.startswith(measure.lists))) for name in kinds}
            wanted = {name: "i" if name in ("point", *words) else "U" if name == "reason" else "f" for name in kinds}
            if size > _LARGEST or "status" not in kinds or kinds != {name: (shapes[name], wanted[name]) for name in kinds}:
                return None
            file.seek(0)
            with np.load(file, allow_pickle=False) as data:
                columns = {name: data[name] for name in data.files}
    except Exception:  # a damaged zip, header or text raises errors of many kinds
        return None
    limits = {"point": (0, plan.size), **{name: (-1, len(known)) for name, known in words.items() if name in columns}}
    inside = (((columns[name] >= low) & (columns[name] < high)).all() for name, (low, high) in limits.items())
    return columns if all(inside) else None


def _digest(manifest: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(manifest, sort_keys=True).encode()).hexdigest()[:8]


def _difference(key: str, before: Any, now: Any) -> str:
    if isinstance(before, dict) and isinstance(now, dict):
        inner = [name for name in {*before, *now} if before.get(name) != now.get(name)]
        return f"{key}: {', '.join(sorted(inner))} changed"
    short = all(isinstance(value, str | int | float | None) and len(str(value)) < _LONG for value in (before, now))
    return f"{key} = {before}, now {now}" if short else f"{key} changed"

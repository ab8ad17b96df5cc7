"""The interface's history of a run, written to disk during the run: only one chunk is in memory, whatever the length of the
run."""

import math
import os
import shutil
import weakref
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Literal, NamedTuple, Self, TypeAlias

import numpy as np

from slipwave.errors import SceneError
from slipwave.files import part_of, reason_of, remove_leftovers
from slipwave.friction import Law
from slipwave.input.assemble import ends_of_window, moment
from slipwave.input.quantity import looks_measured, quantity
from slipwave.input.wording import shorten
from slipwave.observe.history import named_columns, values_at
from slipwave.observe.pieces import Array, Pieces, lagrange_basis
from slipwave.scene import Scene

_COLUMNS = 5
_BLOCK = 50_000  # samples that are read back at a time: 2 MB
_EARLY = 0.01  # share of the run after which its size is known well enough to compare it with the disk
_LARGE = 1e8  # bytes, and twice as many each time, after which it is compared anyway
_ROUNDING = 1e-12  # of a time
_MOST = 1e9  # samples
_SHARE = 0.25  # of the memory: the longest history that a user can still look at


Window: TypeAlias = str | Sequence[float | str]
"""(20, 45) or "20:45" in transits, or times with a unit: "10s:60s"."""


class Thinning(NamedTuple):
    """Which samples are kept: each `every`-th of those between the times `begin` and `end` (transits); with a `step` (transits)
    even ones, from `begin` on, instead of the solver's own."""

    every: int = 1
    begin: float = 0.0
    end: float = math.inf
    step: float = 0.0

    @classmethod
    def of(cls, every: int | None, window: Window | None, scene: Scene, rate: float | str | None = None) -> Self:
        """One in `every` samples from the beginning of the `window` to its end, or even ones at a `rate`; all of them where None.
        Raises SceneError for a choice that makes no sense, and for a unit of time in a scene without one."""
        step = 0.0 if rate is None else _step(rate, scene)
        if window is None:
            return cls(every or 1, 0.0, math.inf, step)
        must = "in transits or with a unit of time, BEGIN before END and not negative"
        return cls(every or 1, *ends_of_window(window, lambda end: moment("window", end, scene), 0.0, must), step)


ALL = Thinning()


def temporary_samples() -> Path:
    """A new, empty file for the samples of a run, in the folder for temporary files."""
    import tempfile

    folder = Path(tempfile.gettempdir())
    remove_leftovers(folder)
    handle, name = tempfile.mkstemp(prefix=".slipwave-", suffix=part_of(folder, ".samples").name)
    os.close(handle)
    return Path(name)


class HistoryFile:
    """Observer that appends the `kept` samples to the file `path`, rows of five doubles. The file is removed when this is closed
    or garbage-collected, unless it `stays` for continued runs. A checkpoint holds the number of samples and their checksum; a
    continued run drops later samples. On a full disk the run continues without further samples; `problem` describes it. Raises
    SceneError, early in a run of `until` transits, if the history (here and once more in the user's file) will not fit on the
    disk, would fill a quarter of the memory or have 1e9 samples. Gaps are refused within the window of `kept`.
    """

    def __init__(self, law: Law, nodes: Array, path: Path, until: float, stays: bool = True, kept: Thinning = ALL) -> None:
        self._law, self._nodes, self._basis = law, np.asarray(nodes), lagrange_basis(nodes)
        self.path, self.problem = path, ""
        self._kept, self._seen = kept, 0
        self._until = min(until, kept.end)
        self._judged, self._large = kept.begin >= self._until, _LARGE
        self._reached = 0.0
        self._samples, self._checksum = 0, 0
        self._file: BinaryIO | None = None
        self._remove = None if stays else weakref.finalize(self, path.unlink, missing_ok=True)

    def __getstate__(self) -> dict[str, Any]:
        """For copies and pickles, which hold the samples themselves."""
        return vars(self) | {"_file": None, "_remove": None, "_content": b"".join(block.tobytes() for block in self._blocks())}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy has a temporary file of its own."""
        content = state.pop("_content")
        vars(self).update(state, path=temporary_samples())
        self._remove = weakref.finalize(self, self.path.unlink, missing_ok=True)
        self._append(content)

    @property
    def whole_from(self) -> float:
        """As `slipwave.solve.Spanning`."""
        return self._kept.begin if self._reached <= self._kept.end else math.inf

    def expect(self, samples: float) -> None:
        """Raises SceneError if a history of `samples` samples of the solver's own, before thinning, is too large."""
        if self._kept.step:
            samples = (self._until - self._kept.begin) / self._kept.step
        self._require_space(samples / self._kept.every * _COLUMNS * 8)

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        rows = self._even(pieces) if self._kept.step else self._own(pieces)
        self._keep(rows[-self._seen % self._kept.every :: self._kept.every])
        self._seen += len(rows)
        self._reached = float(pieces.time[-1] + pieces.length[-1])
        share = (self._reached - self._kept.begin) / (self._until - self._kept.begin)
        if self._bytes > self._large:
            self._large *= 2.0
            self._require_space(self._bytes)
        elif not self._judged and share > _EARLY:
            self._judged = True
            self._require_space(self._bytes / min(share, 1.0))

    def _own(self, pieces: Pieces) -> Array:
        """The solver's own samples in the window."""
        time = pieces.time[:, None] + pieces.length[:, None] * self._nodes
        rows = np.stack([values.ravel() for values in (time, *pieces[2:])], axis=1)
        return rows[(rows[:, 0] >= self._kept.begin) & (rows[:, 0] <= self._kept.end)]

    def _even(self, pieces: Pieces) -> Array:
        """The next samples, a step apart, that lie within the pieces and the window."""
        end = min(float(pieces.time[-1] + pieces.length[-1]), self._kept.end)
        count = math.floor((end - self._kept.begin) / self._kept.step * (1.0 + _ROUNDING)) + 1
        times: Array = self._kept.begin + self._kept.step * np.arange(self._seen, count, dtype=np.float64)
        if not times.size:
            return np.empty((0, _COLUMNS))
        return np.stack([times, *values_at(pieces, self._basis, times, self._law)], axis=1)

    def state(self) -> dict[str, Array]:
        """Number of samples on the disk, and their checksum."""
        if self._file is not None:
            self._attempt(lambda: os.fsync(self._opened().fileno()))
        return {
            "samples": np.array([self._samples, self._checksum, self._seen], dtype=np.int64),
            "reached": np.array(self._reached),
            "kept": np.array(self._kept, dtype=float),
        }

    def restore(self, state: dict[str, Array]) -> None:
        """Continue after the samples counted in `state`. Raises SceneError if the file does not hold them, or others were
        kept."""
        kept = Thinning(*state["kept"].tolist())
        if kept != self._kept:
            raise SceneError(f"{self._label} keeps {_in_words(kept)}; this run asks for {_in_words(self._kept)}")
        self._reached = float(state["reached"])
        samples, checksum, self._seen = (int(number) for number in state["samples"])
        try:
            self._hold("r+b")
        except OSError as error:
            raise SceneError(f"{self._label} is gone: {reason_of(error)}") from None
        file = self._opened()
        self._samples, self._checksum = samples, 0
        if file.seek(0, os.SEEK_END) >= self._bytes:
            for block in self._blocks():
                self._checksum = zlib.crc32(block.tobytes(), self._checksum)
        if self._checksum != checksum:
            raise SceneError(f"{self._label} is not the one that belongs to it")
        file.truncate(file.seek(self._bytes))

    def __len__(self) -> int:
        """Number of samples recorded."""
        return self._samples

    def parts(self) -> Iterator[dict[str, Array]]:
        """All columns by name, as `HistoryObserver.columns`, a block of samples at a time."""
        for block in self._blocks():
            yield named_columns(self._law, block.T)

    def close(self) -> None:
        """Close the file, and remove it unless it stays."""
        if self._file is not None:
            self._file.close()
        if self._remove is not None:
            self._remove()

    @property
    def _label(self) -> str:
        return f"the interface's history in {str(self.path)!r}"

    @property
    def _bytes(self) -> int:
        return self._samples * _COLUMNS * 8

    def _keep(self, rows: Array) -> None:
        if self.problem:
            return
        content = rows.tobytes()
        if self._attempt(lambda: self._append(content)):
            self._samples += len(rows)
            self._checksum = zlib.crc32(content, self._checksum)

    def _append(self, content: bytes) -> None:
        file = self._opened()
        file.write(content)
        file.flush()

    def _opened(self) -> BinaryIO:
        return self._file or self._hold("w+b")

    def _hold(self, mode: Literal["r+b", "w+b"]) -> BinaryIO:
        """Open the file until this is closed or no longer used."""
        self._file = self.path.open(mode)
        weakref.finalize(self, self._file.close)
        return self._file

    def _attempt(self, action: Callable[[], None]) -> bool:
        try:
            action()
        except OSError as error:
            self.problem = f"{self._label} cannot be written: {reason_of(error)}"
        return not self.problem

    def _blocks(self) -> Iterator[Array]:
        left = self._samples
        if left:
            self._opened().seek(0)
        while left:
            count = min(left, _BLOCK)
            yield np.frombuffer(self._opened().read(count * _COLUMNS * 8)).reshape(count, _COLUMNS)
            left -= count

    def _require_space(self, expected: float) -> None:
        """Raises SceneError if a history of `expected` bytes is too large."""
        further, free = 2.0 * expected - self._bytes, shutil.disk_usage(self.path.parent).free
        most = _SHARE * _memory()
        if further > free:
            disk = f"the disk of {str(self.path.parent)!r}, which has {free / 1e9:.2g} GB left"
            problem = f"would take {further / 1e9:.2g} GB more of {disk}"
        elif expected >= _MOST * _COLUMNS * 8:
            problem = f"would have {expected / (_COLUMNS * 8):.2g} samples, more than {_MOST:g}"
        elif expected > most:
            problem = f"would take {expected / 1e9:.2g} GB, more than a quarter of the memory, {most / 1e9:.2g} GB"
        else:
            return
        raise SceneError(
            f'run.record: "interface" {problem}; shorten the run, record events only, or keep fewer samples by --every N, '
            "--rate RATE or --window A:B"
        )


def _step(rate: float | str, scene: Scene) -> float:
    """Transits between two samples. Raises SceneError unless the rate is a positive number per transit or a frequency."""
    measured = isinstance(rate, str) and looks_measured(rate)
    try:
        per = quantity(str(rate), "Hz").value if measured else float(rate)
    except ValueError:
        per = math.nan
    if not 0.0 < per < math.inf:
        raise SceneError(f"rate = {shorten(rate)}: must be a positive number of samples per transit, or a frequency as in 1kHz")
    if not measured:
        return 1.0 / per
    if scene.units is None:
        raise SceneError(f"rate = {shorten(rate)}: needs a scene in SI; here it is a number of samples per transit")
    return moment("rate", f"{1.0 / per:.17g} s", scene)


def _memory() -> float:
    """Bytes of the machine's memory."""
    return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))


def _in_words(kept: Thinning) -> str:
    evenly = f", {kept.step:g} apart," if kept.step else ""
    return f"one in {kept.every:g} samples{evenly} from t = {kept.begin:g} to {kept.end:g}"

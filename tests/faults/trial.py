"""A copy of the checkout in which faults are tried one at a time; the original is never touched."""

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.faults.planting import ROOT

WHOLE_SUITE = ("tests", "--ignore=tests/faults")
_WAITING = 10.0  # seconds on the clock for one of processor time, on a machine that does other things too
_ENDINGS = {
    -signal.SIGXCPU: "endless",
    1: "tests fail",
    2: "the tests cannot be collected",
    4: "the check does not exist",
    5: "no test was run",
}


@dataclass(frozen=True)
class Outcome:
    """What a run of tests showed. `caught` is the first failure that says what is wrong; `trouble` any other ending."""

    seconds: float
    caught: dict[str, str] | None = None
    accidents: tuple[dict[str, str], ...] = ()
    trouble: str = ""

    @property
    def is_green(self) -> bool:
        """Every test passed."""
        return not (self.caught or self.accidents or self.trouble)


def tracked_files(root: Path = ROOT) -> list[Path]:
    """Files of the checkout as they stand, those not yet committed included."""
    told = subprocess.run(
        ["git", "-C", str(root), "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True, check=True
    )
    return [path for name in told.stdout.splitlines() if (path := root / name).is_file()]


class Copy:
    """A copy in `folder` with a cache of compiled code of its own, which starts with what `cache` holds."""

    def __init__(self, folder: Path, root: Path = ROOT, cache: Path | None = None) -> None:
        self.tree = folder / "tree"
        self._note, self._cache = folder / "witness.json", folder / "cache"
        self._clean: dict[tuple[str, ...], Outcome] = {}
        for path in tracked_files(root):
            target = self.tree / path.relative_to(root)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, target)
        if cache is not None and cache.is_dir():
            shutil.copytree(cache, self._cache, ignore=lambda _, names: [n for n in names if not n.endswith(".compiled")])

    @contextmanager
    def with_text(self, file: str, text: str) -> Iterator[None]:
        """The copy with another text in `file`, for a while."""
        path = self.tree / file
        kept = path.read_text(encoding="utf-8")
        path.write_text(text, encoding="utf-8")
        try:
            yield
        finally:
            path.write_text(kept, encoding="utf-8")

    def run_clean(self, tests: Sequence[str], limit: float) -> Outcome:
        """As `run`, once for each set of tests: the copy has no fault in it."""
        if tuple(tests) not in self._clean:
            self._clean[tuple(tests)] = self.run(tests, limit)
        return self._clean[tuple(tests)]

    def run(self, tests: Sequence[str], limit: float) -> Outcome:
        """Run pytest in the copy for at most `limit` seconds of processor time, until one failure says what is wrong."""
        self._note.unlink(missing_ok=True)
        begun = time.monotonic()
        command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.faults.witness", "-p", "no:cacheprovider", "-m", "not slow"]
        own = {
            "PYTHONPATH": self.tree,
            "NUMBA_CACHE_DIR": self._cache,
            "WITNESS": self._note,
            "WITNESS_SECONDS": math.ceil(limit),
            "PYTHONDONTWRITEBYTECODE": "1",  # Python tells byte code from the source by second and size, which a fault may share
        }
        environment, most = os.environ | {name: str(value) for name, value in own.items()}, _WAITING * limit
        try:
            done = subprocess.run([*command, *tests], cwd=self.tree, env=environment, capture_output=True, timeout=most)
        except subprocess.TimeoutExpired:
            return Outcome(time.monotonic() - begun, trouble=f"no end after {most:.0f} s")
        seconds = time.monotonic() - begun
        if done.returncode > 1 or (done.returncode and not self._note.exists()):
            return Outcome(seconds, trouble=_ENDINGS.get(done.returncode, f"pytest ended with {done.returncode}"))
        noted: dict[str, Any] = json.loads(self._note.read_text(encoding="utf-8"))
        return Outcome(seconds, noted["caught"], tuple(noted["accidents"]))

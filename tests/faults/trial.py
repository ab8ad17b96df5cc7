"""A copy of the checkout in which faults are tried one at a time; the original is never touched."""

import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.faults.planting import ROOT

_SECONDS = 900.0  # for one check; what ends no earlier is endless
_ASSERTS = (
    "assert ",
    "AssertionError",
    "Failed: ",
)  # how the message of an assertion begins, or of an exception that did not come
_ENDINGS = {2: "the tests cannot be collected", 4: "the check does not exist", 5: "no test was run"}


@dataclass(frozen=True)
class Outcome:
    """What a run of tests showed: the test whose assertion failed first and what it says, all that failed, any other ending."""

    caught_by: str = ""
    says: str = ""
    accidents: tuple[str, ...] = ()
    trouble: str = ""

    @property
    def is_green(self) -> bool:
        return not (self.caught_by or self.accidents or self.trouble)


def tracked_files(root: Path = ROOT) -> list[Path]:
    """Files of the checkout as they stand, those not yet committed included."""
    told = subprocess.run(
        ["git", "-C", str(root), "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True, check=True
    )
    return [path for name in told.stdout.splitlines() if (path := root / name).is_file()]


class Copy:
    """A copy in `folder` with a cache of compiled code of its own, which starts with what the folder `known` holds."""

    def __init__(self, folder: Path, root: Path = ROOT, known: Path | None = None) -> None:
        self.tree, self.cache, self._note = folder / "tree", folder / "cache", folder / "note.xml"
        for path in tracked_files(root):
            target = self.tree / path.relative_to(root)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, target)
        if known is not None and known.is_dir():
            shutil.copytree(known, self.cache, ignore=lambda _, names: [n for n in names if not n.endswith(".compiled")])

    @contextmanager
    def with_text(self, file: str, text: str) -> Iterator[None]:
        path = self.tree / file
        kept = path.read_text(encoding="utf-8")
        path.write_text(text, encoding="utf-8")
        try:
            yield
        finally:
            path.write_text(kept, encoding="utf-8")

    def run(self, tests: Sequence[str], *options: str, limit: float = _SECONDS) -> Outcome:
        self._note.unlink(missing_ok=True)
        told = [f"--junitxml={self._note}", "--override-ini=junit_family=xunit1", "-p", "no:cacheprovider", "-m", "not slow"]
        environment = os.environ | {
            "PYTHONPATH": str(self.tree),
            "NUMBA_CACHE_DIR": str(self.cache),
            "PYTHONDONTWRITEBYTECODE": "1",  # Python tells byte code from the source by second and size, which a fault may share
        }
        command = [sys.executable, "-m", "pytest", "-q", *told, *options, *tests]
        try:
            done = subprocess.run(command, cwd=self.tree, env=environment, capture_output=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return Outcome(trouble=f"no end after {limit:.0f} s")
        if done.returncode > 1 or not self._note.exists():
            return Outcome(trouble=_ENDINGS.get(done.returncode, f"pytest ended with {done.returncode}"))
        return _outcome(self._note)


def _outcome(note: Path) -> Outcome:
    failures = []
    for case in ElementTree.parse(note).iter("testcase"):
        for problem in (*case.findall("failure"), *case.findall("error")):
            failures.append((f"{case.get('file')}::{case.get('name')}", problem.get("message", "").partition("\n")[0]))
    said = [(test, message) for test, message in failures if message.startswith(_ASSERTS)]
    return Outcome(*(said or [("", "")])[0], tuple(f"{message.partition(':')[0]} in {test}" for test, message in failures))

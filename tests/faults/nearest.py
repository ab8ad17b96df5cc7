"""Which tests to try on a mutant: those that run what it changes, the nearest first."""

import json
from functools import cache
from pathlib import Path
from typing import Any

from slipwave.sources import imported_names
from tests.faults.mutations import Mutant
from tests.faults.planting import ROOMS, ROOT

_FIRST_SECONDS, _ALL_SECONDS = 20.0, 180.0
_FIRST_TESTS, _ALL_TESTS = 60, 400


class Reach:
    """What `reach` wrote: for every test its seconds and functions."""

    def __init__(self, folder: Path, still_there: set[str]) -> None:
        noted: dict[str, Any] = {}
        for path in folder.glob("*.json"):
            noted |= json.loads(path.read_text(encoding="utf-8"))
        self._tests = {test: facts for test, facts in noted.items() if test in still_there}

    def tests_for(self, mutant: Mutant) -> tuple[list[str], list[str]]:
        """Tests near the mutant, the nearest and most specific first: some seconds of them, and those of some minutes more."""
        room, far = Path(mutant.file).parts[0], self._distances(mutant)

        def order(test: str) -> tuple[int, bool, int, float]:
            """The nearest first, then those of the same room, of few functions and of little time."""
            facts = self._tests[test]
            return far[test], f"tests/{room}/" not in test, len(facts["functions"]), facts["seconds"]

        chosen = sorted(far, key=order)
        first = self._within(chosen, _FIRST_SECONDS, _FIRST_TESTS)
        return first, self._within([test for test in chosen if test not in first], _ALL_SECONDS, _ALL_TESTS)

    def _distances(self, mutant: Mutant) -> dict[str, int]:
        """0 for tests that run the mutant's function; 1 for those beside them, which may share a result with them.

        A function that no test runs in Python is compiled, or runs at import: then 1 for tests that run a function of its file,
        and one more for each import between them and it.
        """
        place = f"{mutant.file}::{mutant.function}"
        found = {test: 0 for test, facts in self._tests.items() if place in facts["functions"]}
        if found:
            beside = {test.partition("::")[0] for test in found}
            return {test: 1 for test in self._tests if test.partition("::")[0] in beside} | found
        far = _imports_between(mutant.file)
        for test, facts in self._tests.items():
            steps = [far[file] for name in facts["functions"] if (file := name.partition("::")[0]) in far]
            found |= {test: 1 + min(steps)} if steps else {}
        return found

    def _within(self, tests: list[str], seconds: float, count: int) -> list[str]:
        """At most `count` of `tests`, in their order, that take less than `seconds` together."""
        chosen: list[str] = []
        for test in tests:
            if self._tests[test]["seconds"] < seconds and len(chosen) < count:
                chosen.append(test)
                seconds -= self._tests[test]["seconds"]
        return chosen


def _imports_between(file: str, root: Path = ROOT) -> dict[str, int]:
    """The files that import `file`, with the number of imports on the way to it; itself at 0."""
    steps = {file: 0}
    reached = [file]
    for one in reached:
        for user in _users(root)[one] - steps.keys():
            steps[user] = steps[one] + 1
            reached.append(user)
    return steps


@cache
def _users(root: Path) -> dict[str, set[str]]:
    """The files that import a file of the four rooms by its name."""
    files = [path for room in ROOMS for path in (root / room).rglob("*.py")]
    users: dict[str, set[str]] = {path.relative_to(root).as_posix(): set() for path in files}
    modules = {name.removesuffix(".py").removesuffix("/__init__").replace("/", "."): name for name in users}
    for path in files:
        for name in imported_names(path):
            if name in modules:
                users[modules[name]].add(path.relative_to(root).as_posix())
    return users

"""A random sample of small changes: how many does the test suite notice?  `make mutants`, or `python -m tests.faults.mutants`.

Every place of the four rooms where an operator of `mutations` applies is equally likely, and so is each of its changes there;
mutants listed as equivalent are left out. The sample depends on the seed only. Tests that run the changed function (`reach` says
which) and those beside them are tried, some seconds of them first and then the others; with `--whole` the whole suite too.
"""

import argparse
import math
import random
import subprocess
import sys
import tomllib
from itertools import islice
from pathlib import Path

from tests.faults.mutations import Mutant, all_places
from tests.faults.nearest import Reach
from tests.faults.planting import FOLDER, ROOT
from tests.faults.programme import CHECK_SECONDS, SUITE_SECONDS, Record, Store, run_all
from tests.faults.trial import WHOLE_SUITE, Copy

RESULT = ROOT / "reports" / "mutants.json"
EQUIVALENT = FOLDER / "equivalent.toml"


def try_mutant(mutant: Mutant, copy: Copy, reach: Reach, whole: bool) -> Record:
    """The record of one mutant: noticed or not, by which test, and whether by an assertion."""
    text = (copy.tree / mutant.file).read_text(encoding="utf-8")
    where = f"{mutant.file}:{mutant.line_number(text)}"
    record: Record = {"name": mutant.name, "room": mutant.file.partition("/")[0], "where": where, "what": mutant.what}
    nearest, others = reach.tests_for(mutant)
    found = None
    with copy.with_text(mutant.file, text[: mutant.begin] + mutant.new + text[mutant.end :]):
        for tests, limit in ((nearest, CHECK_SECONDS), (others, SUITE_SECONDS), (WHOLE_SUITE if whole else [], SUITE_SECONDS)):
            if tests and (found is None or found.is_green):
                found = copy.run(tests, limit)
    if found is None or found.is_green:
        said = "the whole suite stays green" if whole else f"{len(nearest) + len(others)} tests stay green"
        return record | {"caught": False, "says": said, "seconds": round(found.seconds, 1) if found else 0.0}
    by = found.caught or (found.accidents[0] if found.accidents else {"test": "", "says": found.trouble})
    return record | {"caught": True, "caught_by": by["test"], "says": by["says"], "seconds": round(found.seconds, 1)}


def collected() -> set[str]:
    """All tests of the checkout, by their node ids."""
    command = [sys.executable, "-m", "pytest", "--override-ini=addopts=", "--collect-only", "-q", "tests"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return {line for line in told.stdout.splitlines() if "::" in line}


def sample(count: int, seed: int, listed: list[dict[str, str]], root: Path = ROOT) -> list[Mutant]:
    """`count` mutants in random order, without those that are `listed` as equivalent."""
    places, chance = all_places(root), random.Random(seed)
    chance.shuffle(places)
    drawn = (chance.choice(place) for place in places)
    return list(islice((mutant for mutant in drawn if not is_equivalent(mutant, listed, root)), count))


def is_equivalent(mutant: Mutant, listed: list[dict[str, str]], root: Path = ROOT) -> bool:
    """Whether a mutant is listed: by its file, its change and, where the same change can be made in several lines, a text that
    occurs in its line."""
    found = [one.get("line", "") for one in listed if (one["file"], one["what"]) == (mutant.file, mutant.what)]
    if not found:
        return False
    text = (root / mutant.file).read_text(encoding="utf-8")
    line = text.splitlines()[mutant.line_number(text) - 1]
    return any(one in line for one in found)


def wilson(noticed: int, of: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927)."""
    z = 1.959964
    share, scale = noticed / of, 1.0 + z * z / of
    half = z * math.sqrt(share * (1.0 - share) / of + z * z / (4.0 * of * of))
    return (share + z * z / (2.0 * of) - half) / scale, (share + z * z / (2.0 * of) + half) / scale


def main() -> int:
    """Try a sample of mutants and print the score with its interval."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults.mutants", description="Score of a random sample of mutants.")
    parser.add_argument("--count", type=int, default=150, metavar="N", help="size of the sample (default: 150)")
    parser.add_argument("--seed", type=int, default=8, metavar="N", help="of the sample (default: 8)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="tried at a time (default: 2)")
    parser.add_argument("--reach", type=Path, required=True, metavar="FOLDER", help="what the plugin `reach` wrote")
    parser.add_argument("--whole", action="store_true", help="the whole suite for those that survive the tests nearest to them")
    options = parser.parse_args()
    drawn = sample(options.count, options.seed, tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["equivalent"])
    reach = Reach(options.reach, collected())
    store = Store(RESULT, "mutants")
    if options.whole:
        store.forget_survivors()
    records = run_all(drawn, lambda mutant, copy: try_mutant(mutant, copy, reach, options.whole), options.jobs, store)
    noticed = sum(record["caught"] for record in records)
    low, high = wilson(noticed, len(records))
    print(f"{noticed} of {len(records)} mutants noticed: {noticed / len(records):.3f}, 95 % interval {low:.3f} to {high:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

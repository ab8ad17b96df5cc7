"""python -m validation.coverage orbits 20       # the first 20 computations of a kind, as a table
python -m validation.coverage --record        # all kinds into reports/baseline/coverage-record.json; resumes
python -m validation.coverage --record means  # one kind
"""

import sys

from validation.coverage.held import coverage_of
from validation.coverage.record import KINDS, computation, make_record
from validation.results.result import aligned


def main(words: list[str]) -> None:
    """Run the command line `words`."""
    if words[0] == "--record":
        return make_record(words[1:] or KINDS)
    kind, count = words
    found = coverage_of(computation(kind, number) for number in range(int(count)))
    rows = [
        [one.figure, str(one.many), f"{one.share:.3f}", f"{one.low:.3f} .. {one.high:.3f}", f"{one.width:.1f}"] for one in found
    ]
    print("\n".join(aligned([kind, "number", "held", "95 % interval", "bar / error"], rows)))


if __name__ == "__main__":
    main(sys.argv[1:])

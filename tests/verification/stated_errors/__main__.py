"""python -m tests.verification.stated_errors orbits 20       # the first 20 computations of a kind, as a table
python -m tests.verification.stated_errors --record        # all kinds into reports/baseline/coverage-computations.json; resumes
python -m tests.verification.stated_errors --record means  # one kind
"""

import json
import sys

from tests.verification.stated_errors.held import coverage_of
from tests.verification.stated_errors.record import KINDS, SUMMARY, computation, known_computations, make_record, summary
from validation.commands.result import aligned


def main(words: list[str]) -> None:
    if words[0] == "--record":
        make_record(words[1:] or KINDS)
        SUMMARY.write_text(json.dumps(summary(known_computations()), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        return
    kind, count = words
    found = coverage_of(computation(kind, number) for number in range(int(count)))
    rows = [
        [one.figure, str(one.many), f"{one.share:.3f}", f"{one.low:.3f} .. {one.high:.3f}", f"{one.width:.1f}"] for one in found
    ]
    print("\n".join(aligned([kind, "number", "held", "95 % interval", "bar / error"], rows)))


if __name__ == "__main__":
    main(sys.argv[1:])

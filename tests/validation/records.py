"""What the commands print, held against the committed lines of `tests/validation/printed.txt`.

Words must be equal and numbers close: BLAS and processor move errors of 1e-12.
"""

import itertools
import math
import re
from difflib import SequenceMatcher

RELATIVE, ABSOLUTE = 1e-5, 1e-9
_NUMBER = re.compile(r"([-−]?\b\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?|\bnan\b|[-−]?\binf\b)")


def differences(expected: list[str], got: list[str]) -> list[str]:
    """Where the lines differ: words must be equal, numbers close."""
    old, new = ([_NUMBER.sub("#", line) for line in lines] for lines in (expected, got))
    found = []
    for kind, first, end, new_first, new_end in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        pairs = itertools.zip_longest(expected[first:end], got[new_first:new_end], fillvalue="nothing")
        found += [
            f"line {count}: expected {one.strip()}\n  got {other.strip()}"
            for count, (one, other) in enumerate(pairs, first + 1)
            if kind != "equal" or not _close(one, other)
        ]
    return found


def _close(one: str, other: str) -> bool:
    """Whether all numbers of two lines of the same words are close."""
    return all(
        math.isclose(a, b, rel_tol=RELATIVE, abs_tol=ABSOLUTE) or (math.isnan(a) and math.isnan(b))
        for a, b in zip(_numbers(one), _numbers(other), strict=True)
    )


def _numbers(line: str) -> list[float]:
    return [float(text.replace("−", "-").replace(",", "")) for text in _NUMBER.findall(line)]

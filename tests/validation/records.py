"""What studies show, held against the committed lines of `tests/validation/shown/NAME.txt` (made by `shown`).

Words must be equal and numbers close: BLAS and processor move errors of 1e-12 and what is fitted to them.
"""

import itertools
import math
import re
from difflib import SequenceMatcher
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "shown"
RELATIVE, ABSOLUTE = 1e-5, 1e-9
_TOLD = 8
_PROMISES = "expected"
_FITTED, _LOG_LIMITS, _ROUGH = 0.025, 0.2, 0.45
"""Allowed of a fitted order and its interval (absolute), of the ends of a logarithmic axis and of chaotic motion (relative):
rounding moved them by 0.02, 0.06 and 0.3 from one processor to another."""
_CHAOTIC = re.compile(r"(deep|irregular|over-r|returns): |ours: .*(\d cycles|spreads)|omission: Quasi-static curve")
"""Lines on motion that amplifies rounding: the paper's irregular cycles, and the model that runs away."""
_BESIDE = re.compile(r"beside: |ours: .*relative difference, \d+ sides")
"""Lines on runs begun 1e-6 off an orbit, which see its multiplier but for rounding over 1e-6."""
_CHAOTIC_HEIGHTS = re.compile(r"irregular: +(y |line )")
"""Of a chaotic curve, whose ends and extremes lie anywhere between its least and its largest value."""
_WORST_OF_ROUNDING = re.compile(r"(?<=worst of sbp:4, sbp:6, fem:4, dg:4, dg:7: )`\S+`")
"""Where rounding chooses the word."""
_FIT = re.compile(r"(\d+\.\d+)\s±\s(\d+\.\d+)")
_NUMBER = re.compile(r"([-−]?\b\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?(?: · 10\^\{[-−]?\d+\})?|\bnan\b|[-−]?\binf\b)")


def assert_as_recorded(name: str, lines: list[str]) -> None:
    """Hold the lines against the committed ones; says which differ."""
    differ = differences((FOLDER / f"{name}.txt").read_text(encoding="utf-8").splitlines(), lines)
    assert not differ, "\n".join([*differ[:_TOLD], f"{len(differ)} differences from {name}.txt; meant? pytest --record-shown"])


def differences(expected: list[str], got: list[str]) -> list[str]:
    """Where the lines differ: words must be equal, numbers close."""
    expected, got = ([_WORST_OF_ROUNDING.sub("…", line) for line in lines] for lines in (expected, got))
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
    fits = (np.ravel([[float(text) for text in fit] for fit in _FIT.findall(line)]) for line in (one, other))
    values = (np.array(_numbers(_FIT.sub("±", line))) for line in (one, other))
    relative, absolute = _allowed(one)
    if _CHAOTIC_HEIGHTS.match(one.strip()):
        absolute = _ROUGH * max(_numbers(one)[-2:])
    return np.allclose(*fits, rtol=0.0, atol=_FITTED) and all(
        math.isclose(a, b, rel_tol=relative, abs_tol=absolute) or (math.isnan(a) and math.isnan(b))
        for a, b in zip(*values, strict=True)
    )


def _allowed(line: str) -> tuple[float, float]:
    """Relative and absolute; a number that the baseline remembers brings its own, promises allow nothing."""
    told = line.strip()
    if told.startswith(_PROMISES):
        return RELATIVE, 0.0
    if _CHAOTIC.match(told):
        return _ROUGH, ABSOLUTE
    if _BESIDE.match(told):
        return RELATIVE, 1e-6
    if told.startswith("number"):
        return max(RELATIVE, _numbers(told)[-1]), ABSOLUTE
    return _LOG_LIMITS if ", log, from (" in told else RELATIVE, ABSOLUTE


def _numbers(line: str) -> list[float]:
    texts = (text.replace("−", "-").replace(",", "").replace("}", "") for text in _NUMBER.findall(line))
    return [float(text.replace(" · 10^{", "e")) for text in texts]

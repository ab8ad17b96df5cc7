"""What counts as a difference from the one recorded page."""

import pytest
from records import differences


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("T | 73.47 | 1e-3", "T | 73.48 | 1e-3"),
        ("after 600 transits", "after 600 cycles"),
        ("at −2.68", "at 2.68"),
        ("y nan", "y 1"),
    ],
)
def test_a_difference_is_told(old, new):
    assert differences(["first", old], ["first", new]) == [f"line 2: expected {old}\n  got {new}"]


@pytest.mark.parametrize(("old", "new"), [("T 73.47214", "T 73.47221"), ("size: 3e-12", "size: -8e-13"), ("nan", "nan")])
def test_rounding_is_no_difference(old, new):
    assert differences([old], [new]) == []


def test_a_line_more_or_less_hides_no_other():
    assert differences(["a", "b 1", "c"], ["a", "c"]) == ["line 2: expected b 1\n  got nothing"]
    assert differences(["a", "c"], ["a", "b 1", "c"]) == ["line 2: expected nothing\n  got b 1"]

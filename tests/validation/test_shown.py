"""What every study shows, held against the record, for studies whose quick run no other test needs; and that the record sees."""

import numpy as np
import pytest
from drawn import drawn
from records import FOLDER, differences
from shown import quick

from validation.studies import STUDIES
from validation.study.drawing import canvas


@pytest.mark.parametrize(
    "name", ["leapfrog-convergence", "grid-convergence", "cost-and-error", "stability-attacks", "energy", "error-laws"]
)
def test_all_that_a_study_shows_is_as_recorded(name, as_recorded):
    as_recorded(name, quick(name))


def test_every_study_has_its_record():
    assert {path.stem for path in FOLDER.iterdir()} == set(STUDIES)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("T | 73.47 | 1e-3", "T | 73.48 | 1e-3"),
        ("answer: after 600 transits", "answer: after 600 round trips"),
        ("ours: 4,412 V*", "ours: 4,413 V*"),
        ("ours: 3 · 10^{−6}", "ours: 3 · 10^{−7}"),
        ("at −2.68", "at 2.68"),
        ("expected: below 0.1; 3e-11", "expected: below 0.1; 6e-11"),
        ("expected: below 3 · 10^{−11}", "expected: below 6 · 10^{−11}"),
        ("y nan", "y 1"),
        ("order 4.01 ± 0.01", "order 4.04 ± 0.01"),
        ('number "order": 4.01 within 0.02', 'number "order": 4.11 within 0.02'),
        ("deep: delay | 0.02", "deep: delay | 0.04"),
        ("beside: LP | 1.004688 | 2e-6", "beside: LP | 1.004700 | 2e-6"),
    ],
)
def test_a_difference_is_told(old, new):
    assert differences(["first", old], ["first", new]) == [f"line 2: expected {old}\n  got {new}"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("T 73.47214", "T 73.47221"),
        ("size: 3e-12", "size: -8e-13"),
        ("9 · 10^{−13}", "1 · 10^{−12}"),
        ("nan", "nan"),
        ("order 4.01 ± 0.00", "order 4.02 ± 0.01"),
        ('number "order": 4.01 within 0.02', 'number "order": 4.05 within 0.02'),
        ("y, log, from (3e-16, 5.2e-7)", "y, log, from (7e-17, 5.6e-7)"),
        ("deep: delay | 0.0249", "deep: delay | 0.0351"),
        ("beside: NS | −0.1139800 | 2.5e-08", "beside: NS | −0.1139804 | 7.5e-07"),
        (
            "ours: 6.9e-6; largest relative difference, 6 sides; 6.910e-6",
            "ours: 6.9e-6; largest relative difference, 6 sides; 6.907e-6",
        ),
        ("worst of sbp:4, sbp:6, fem:4, dg:4, dg:7: `sbp:6`", "worst of sbp:4, sbp:6, fem:4, dg:4, dg:7: `fem:4`"),
    ],
)
def test_rounding_is_no_difference(old, new):
    assert differences([old], [new]) == []


def test_a_line_more_or_less_hides_no_other():
    assert differences(["a", "b 1", "c"], ["a", "c"]) == ["line 2: expected b 1\n  got nothing"]
    assert differences(["a", "c"], ["a", "b 1", "c"]) == ["line 2: expected nothing\n  got b 1"]


def plain(**changes):
    figure = canvas(7.4, 4.0)
    axes = figure.add_subplot()
    look = {"color": "#111111", "linestyle": (0, (5, 2)), "marker": "o", "linewidth": 1.1, "label": "exact"} | changes
    axes.semilogx([1.0, 10.0, 100.0], [2.0, np.nan, 4.0], **look)
    axes.annotate("here", (1.0, 2.0), (9, -12), textcoords="offset points")
    return figure


def wider(figure):
    figure.set_figwidth(8.0)


def farther(figure):
    figure.axes[0].texts[0].xyann = (9, -13)


def renamed(figure):
    figure.axes[0].set_xlabel("time")


def straight(figure):
    figure.axes[0].set_xscale("linear")


def with_bars(figure):
    figure.axes[0].bar([1.0], [2.0])


def with_points(figure):
    figure.axes[0].scatter([1.0], [2.0])


def without_numbers(figure):
    figure.axes[0].tick_params(labelleft=False)


@pytest.mark.parametrize("change", [wider, farther, renamed, straight, with_bars, with_points, without_numbers])
def test_a_changed_figure_is_seen(change):
    changed = plain()
    change(changed)
    assert differences(list(drawn(plain())), list(drawn(plain()))) == []
    assert differences(list(drawn(plain())), list(drawn(changed)))


@pytest.mark.parametrize(
    "change", [{"color": "red"}, {"linestyle": "-"}, {"marker": "s"}, {"linewidth": 1.2}, {"label": "other"}]
)
def test_a_line_that_looks_different_is_seen(change):
    assert differences(list(drawn(plain())), list(drawn(plain(**change))))

"""Stored figures: drawn again from their CSV, told in the numbers that are drawn, in colours that can be told from the page."""

import base64
import gzip
import io
import json
import re
from html import unescape

import numpy as np
import pytest
from fake_studies import draw
from matplotlib.colors import ListedColormap
from PIL import Image

from validation.report import store
from validation.report.build import make_report
from validation.report.figures import of_paper_in
from validation.report.store import Stored
from validation.study import Evidence, Figure, Outcome, StudyResult, Verdict
from validation.study.description import description_of, meetings, title_of
from validation.study.drawing import canvas, styled
from validation.study.drawn import MOST, curves_csv, drawn, plain_label, read_curves, redraw, staying, thin_out
from validation.study.render import render
from validation.study.vector import DARK_PAPER, PAPER, by_night, colors_of, contrast, corners, legible, rounded_path

X = np.linspace(0.0, 4.0, 9001)


def two_panels():
    """Curves that cross once, a branch in two parts that turns back, points with error bars, a map."""
    figure = canvas(height=3.0)
    left, right = figure.subplots(1, 2)
    left.plot(X, np.sin(3.0 * X), color="#0072b2", label="wave")
    left.plot(X, 0.5 * X - 0.7, color="#e69f00", linestyle="--", label=r"ramp $\Delta\mu$")
    left.step([0.0, 1.0, 4.0], [0.2, 0.1, 0.3], where="pre", label="count")
    left.axhline(0.0, color="#b5b5b0")
    left.set(xlabel="time", ylabel=r"stress $\mu$")
    left.legend()
    for part in (X[:200] - 2.0, X[200:300]):
        right.plot(np.sin(part), part, color="#111111", linestyle=(0, (1.5, 1.2)))
    right.errorbar([0.1, 0.2], [1.0, 2.0], [0.3, 0.4], fmt="o", capsize=2.0, label="runs", color="#d55e00")
    right.pcolormesh([0.0, 0.5, 1.0], [1.0, 2.0], [[7.0, 9.0]], rasterized=True)
    right.set(xlabel=r"$\log_{10} r$", ylabel="$T$", xlim=(-1.5, 1.5))
    figure.draw_without_rendering()
    return figure


@pytest.fixture
def panels():
    with styled():
        return drawn(two_panels())


def test_the_file_draws_the_figure_again(panels):
    """Twice: the curves of the figure that was drawn from the file, and those of the first one, number by number."""
    with styled():
        again = redraw(read_curves(curves_csv(panels), [panel.facts for panel in panels]))
        again.draw_without_rendering()
        found = drawn(again)
    for panel, other in zip(panels, found, strict=True):
        assert (panel.x_label, panel.y_label, panel.scales) == (other.x_label, other.y_label, other.scales)
        assert panel.limits == other.limits
        kinds = {one.name: one for one in other.curves}
        assert all("steps" not in one.look or kinds[one.name].look == one.look for one in panel.curves)
        for one in panel.curves:
            if one.look != "cells":
                np.testing.assert_allclose(kinds[one.name].x, one.x, rtol=1e-7, atol=1e-9)
                np.testing.assert_allclose(kinds[one.name].y, one.y, rtol=1e-7, atol=1e-9)
                for ours, theirs in zip(one.errors, kinds[one.name].errors, strict=True):
                    assert ours is None or np.allclose(ours, theirs)


def test_the_file_holds_what_was_drawn(panels):
    left, right = panels
    wave, ramp, count, zero = left.curves
    assert count.look == "solid steps-pre"
    assert (wave.name, ramp.name, wave.look, ramp.look) == ("wave", "ramp Δμ", "solid", "dashed")
    np.testing.assert_array_equal(ramp.y, 0.5 * X - 0.7)
    np.testing.assert_allclose([zero.x, zero.y], [(-0.2, 4.2), (0.0, 0.0)], atol=1e-12)
    (runs,) = (one for one in right.curves if one.name == "runs")
    np.testing.assert_allclose(runs.errors[1], [0.3, 0.4])
    branch = next(one for one in right.curves if one.look == "dotted")
    assert np.flatnonzero(np.isnan(branch.x)).tolist() == [200]  # between its two parts
    cells = next(one for one in right.curves if one.look == "cells")
    assert (cells.x.tolist(), cells.y.tolist(), cells.value.tolist()) == ([0.25, 0.75], [1.5, 1.5], [7.0, 9.0])
    assert "T,runs,points o,0.2,2,0.4," in curves_csv(panels).splitlines()


def test_thinning_keeps_every_extremum():
    x = np.arange(50_000.0)
    y = np.zeros(x.size)
    y[[123, 40_001]] = 5.0, -7.0
    chosen = staying(x, y)
    assert chosen.size <= MOST
    assert {0, 123, 40_001, x.size - 1} <= set(chosen.tolist())
    turning = staying(np.sin(x / 9e3), x)
    assert np.ptp(np.sin(x[turning] / 9e3)) == np.ptp(np.sin(x / 9e3))
    with styled():
        figure = two_panels()
        thin_out(figure)
        assert max(one.x.size for panel in drawn(figure) for one in panel.curves) <= MOST


def test_words_are_the_numbers_that_are_drawn(panels):
    title, words = title_of(panels), description_of(panels)
    assert title.startswith(
        "stress μ over time: 6 curves in 2 panels; largest 1.3 at x = 4 (ramp Δμ); least −1 at x = 1.571 (wave)"
    )
    wave, ramp, *_ = panels[0].curves
    places = meetings(wave, ramp)
    np.testing.assert_allclose(np.sin(3.0 * places), 0.5 * places - 0.7, atol=1e-6)
    assert f"wave and ramp Δμ cross {places.size} times, first at x = {places[0]:.4g}." in words
    assert "At x = 4 ramp Δμ is highest (1.3), wave lowest (−0.5366)." in words
    assert "log10 r" in words


def test_pictures_within_a_figure_follow_a_dark_page(tmp_path):
    """One of few colours has a second one in those of the key; the shades of one of many are turned by the page."""
    with styled():
        figure = canvas(height=2.0)
        few, many = figure.subplots(1, 2)
        few.pcolormesh([[0.0, 1.0], [1.0, 0.0]], cmap=ListedColormap(["#ffffff", "#c44e52"]), rasterized=True)
        few.fill([0.2, 0.4, 0.4], [0.2, 0.2, 0.4], color="#c44e52", label="a key: red")
        few.set_title("few: two")
        many.pcolormesh(np.arange(400.0).reshape(20, 20), rasterized=True)
        render(figure, tmp_path / "a", "a")
    svg = (tmp_path / "a.svg").read_text()
    assert ">few: two<" in svg
    assert re.findall(r'<image [^>]*class="(\w+)"', svg) == ["day", "night", "shades"]
    day, night = (colors_in(packed) for packed in re.findall(r"base64,([^\"]*)", svg)[:2])
    assert day >= {"#ffffff", "#c44e52"}
    assert night >= {DARK_PAPER, by_night("#c44e52")}
    assert "var(--cc44e52," in svg


def colors_in(packed):
    with Image.open(io.BytesIO(base64.b64decode(packed))) as image:
        return {f"#{bytes(color).hex()}" for _, color in image.convert("RGB").getcolors(9999)}


def test_svg_is_text_with_ids_of_its_own_and_the_same_twice(tmp_path):
    for name in ("a", "b"):
        with styled():
            render(two_panels(), tmp_path / name, "study-figure")
    first, second = ((tmp_path / name).with_suffix(".svg").read_text() for name in "ab")
    assert first == second
    assert all((tmp_path / f"a{end}").read_bytes() == (tmp_path / f"b{end}").read_bytes() for end in (".png", ".csv"))
    assert re.findall(r">(stress|time)\b", first)
    assert all(name.startswith("study-figure") for name in re.findall(r' id="([^"]*)"', first))
    assert set(re.findall(r"(?:href=\"#|url\(#)([^\")]*)", first)) <= set(re.findall(r' id="([^"]*)"', first))
    drawing = first.partition("</desc>")[2]
    assert "date" not in first
    assert not re.search(r"[ \"]-?\d+\.\d{3,}", re.sub(r'base64,[^"]*', "", drawing))


def test_a_rounded_path_is_the_path():
    path = "M 10.123 20.456 \nL 11 20.456 \nL 12.001 20.4561 \nL 30 40 \nL 12 20.456 \nz\n"
    assert rounded_path(path) == "M10.1 20.5l1.9 0 18 19.5-18-19.5z"
    assert corners([(0, 0), (500, 1), (1000, 0), (400, 0)]) == [(0, 0), (1000, 0), (400, 0)]


@pytest.mark.parametrize("color", ["#111111", "#0072b2", "#e69f00", "#56b4e9", "#cc4f8a", "#b9b9b9", "#009e73"])
def test_lines_are_clear_by_day_and_by_night(color):
    day = legible(color)
    assert contrast(day, PAPER) >= 3.0
    assert contrast(by_night(day), DARK_PAPER) >= 3.0
    assert contrast(by_night("#000000"), by_night(PAPER)) >= 7.0
    assert (contrast("#000000", "#ffffff"), contrast("#777777", "#777777")) == pytest.approx((21.0, 1.0))
    assert colors_of([f"var(--c{day[1:]},{day})"]) == (f"--c{day[1:]}:{day};", f"--c{day[1:]}:{by_night(day)};")


def test_labels_lose_their_markup():
    assert plain_label(r"$\log_{10} r$ of $r\,\omega_c$, slab.log10_r, $V/V^*$") == "log10 r of r ωc, slab.log10_r, V/V*"


def test_a_stored_figure_has_its_data_and_words(fake, tmp_path):
    module = fake.add("first")
    store.store_result(tmp_path, module, "key", StudyResult("", figures=(Figure("line", "A line.", draw),)), 1.0)
    (picture,) = store.stored_result(tmp_path, module, "key").pictures
    assert picture.title == "panel: 1 curve; largest 1 at x = 1 (curve); least 0 at x = 0 (curve)."


def test_the_papers_figures_stand_in_its_order_with_what_they_carry(tmp_path):
    """P1 is not P10; a figure takes verdicts of every study."""
    rows = [Verdict(claim, Evidence.PAPER, "73.5", "73.47", Outcome.PASS) for claim in ("P1 a", "P10 b", "Fig 5: c", "other")]
    one = Stored("one", "?", 1.0, True, StudyResult("", verdicts=tuple(rows[:2])), (picture_of(tmp_path, "Fig 7", "P10 "),))
    two = Stored(
        "two", "?", 1.0, True, StudyResult("", verdicts=tuple(rows[2:])), (picture_of(tmp_path, "Fig 5", "P1 ", "Fig 5"),)
    )
    found = [(one.picture.paper, [verdict.claim for verdict in one.verdicts]) for one in of_paper_in([one, two])]
    assert found == [("Fig 5", ["P1 a", "Fig 5: c"]), ("Fig 7", ["P10 b"])]


def picture_of(folder, paper, *carries):
    files = [folder / f"a{end}" for end in (".svg", ".png", ".csv")]
    return store.Picture("one", "a", "A.", False, False, paper, carries, False, "", "t", "d", [], *files)


def test_a_figure_that_opens_has_its_file_in_the_page(fake, tmp_path):
    """Packed, the same bytes; the script and its licence are there, and no address; without such a figure there is no script."""
    shown = StudyResult("", figures=(Figure("line", "A line.", draw, zoom=True),))
    fake.add("first", lambda budget: shown)
    html = make_report(tmp_path).read_text()
    packed, panels = re.search(r'id="first-line-curves" data-panels="(.*?)">(.*?)</script>', html).groups()[::-1]
    assert gzip.decompress(base64.b64decode(packed)) == (tmp_path / "data/first/line.csv").read_bytes()
    (facts,) = json.loads(unescape(panels))
    assert (facts["scales"], facts["colors"]) == (["linear", "linear"], ["#1f77b4"])
    assert 'data-packed="first-line-curves"' in html
    assert "Leon Sorokin, MIT License" in html
    assert "var uPlot=function" in html
    assert "http" not in html
    fake.add("first")
    assert "uPlot" not in make_report(tmp_path / "other").read_text()

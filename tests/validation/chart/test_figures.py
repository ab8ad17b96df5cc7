"""Charts: drawn again from their CSV files, told in the numbers that were computed."""

import base64
import gzip
import io
import json
import re
from html import unescape
from threading import Event, Thread

import matplotlib as mpl
import numpy as np
import pytest
from fake_studies import answered
from fake_studies import draw as drawing_of
from matplotlib.colors import to_rgb
from PIL import Image
from scipy.interpolate import CubicSpline

from validation.chart import (
    BLUE,
    DASHED,
    DOTTED,
    GUIDE,
    ORANGE,
    POINTS,
    Chart,
    Look,
    Panel,
    Scale,
    SecondScale,
    Trace,
    outline,
    with_gaps,
    with_limits,
)
from validation.chart.colors import DARK_PAPER, PAPER, by_night
from validation.chart.draw import draw, styled
from validation.chart.render import render
from validation.chart.svg import colors_of
from validation.chart.table import curves_csv, panel_facts, read_chart, trace_names
from validation.chart.thin import CELLS, MOST, staying, with_fewer
from validation.chart.words import described
from validation.report import Figure
from validation.report.build import make_report

X = np.linspace(0.0, 4.0, 1801)
PART = X[:200:10] - 2.0
CHART = Chart(
    [
        Panel(
            "",
            Scale("time", second=SecondScale("time / s", 2.0)),
            Scale(r"stress $\mu$"),
            [
                Trace("", *outline([1.0, 2.0], [-np.inf] * 2, [np.inf] * 2), Look("#efeee8", kind="area")),
                Trace("wave", X, np.sin(3.0 * X), Look(BLUE)),
                Trace(r"ramp $\Delta\mu$", X, 0.5 * X - 0.7, Look("#e69f00", DASHED)),
                Trace("count", [0.0, 1.0, 4.0], [0.2, 0.1, 0.3], Look(kind="steps-pre")),
                Trace("", [-np.inf, np.inf], [0.0, 0.0], GUIDE),
            ],
            legend="best",
        ),
        Panel(
            "",
            Scale(r"$\log_{10} r$", limits=(-1.5, 1.5)),
            Scale("$T$"),
            [
                Trace(
                    "branch",
                    *with_gaps([(np.sin(PART), PART), (np.sin(PART + 2.0), PART + 2.0)]),
                    Look(dashes=DOTTED, kind="smooth"),
                ),
                Trace("runs", [0.1, 0.2], [1.0, 2.0], POINTS.but(color=ORANGE, hollow=True), [0.3, np.nan], shift=(0.03, 0.0)),
                Trace("here", 1.0, 1.0, Look(kind="text")),
            ],
            grid=True,
        ),
        Panel(
            "shades",
            Scale("r"),
            Scale("V", "log"),
            [Trace("T", [0.0, 0.5, 1.0], [1.0, 2.0], Look(kind="cells"), value=[[7, 8, 9], [9, 6, np.nan]])],
        ),
        Panel(
            "a & b <",
            Scale("r"),
            Scale("V", "log", floor=1.5),
            [Trace("error", [0.0, 0.5, 1.0], [3.0, 0.0, 4.0], Look(marker="o"), y_error=[1.0, 1.0, 5.0])],
        ),
    ],
    height=5.0,
    columns=2,
    legend="outside upper left",
    title="all kinds",
)


def test_the_file_holds_what_was_computed():
    """Number by number: nothing is moved, nor held at a floor; a curve in parts has a gap; a guide ends at the edges."""
    rows = [line.split(",") for line in curves_csv(CHART).splitlines()]
    assert rows[0] == ["panel", "series", "look", "x", "y", "y_error", "value"]
    found = {}
    for _, name, look, *numbers in rows[1:]:
        found.setdefault((name, look), []).append([float(word or "nan") for word in numbers])
    for panel in CHART.panels:
        for own, trace in (pair for pair in zip(trace_names(panel), panel.traces, strict=True) if pair[1].name):
            (mine,) = (np.array(numbers) for (name, _), numbers in found.items() if name == own)
            for column, name in enumerate(("x", "y", "y_error", "value")):
                expected = trace.columns.get(name, np.full(len(mine), np.nan))
                np.testing.assert_allclose(mine[:, column], expected, rtol=1e-7, atol=1e-15, err_msg=trace.name)
    assert {look for _, look in found} == {
        "area", "solid", "dashed", "solid steps-pre", "solid guide", "dotted smooth", "points o", "text",
        "cells", "solid o",
    }  # fmt: skip
    branch = np.array(found["branch", "dotted smooth"])
    assert np.flatnonzero(np.isnan(branch[:, 0])).tolist() == [PART.size]
    assert [x for x, *_ in found["guide", "solid guide"]] == [-0.2, 4.2]
    assert np.isfinite(found["area", "area"])[:, :2].all()


def test_the_file_draws_the_chart_again():
    """Twice: the file of the chart that was read is the file; what is drawn of it are the same curves."""
    again = read_chart(curves_csv(CHART), panel_facts(CHART))
    assert curves_csv(again) == curves_csv(CHART)
    assert panel_facts(again) == panel_facts(CHART)
    for axes, other in zip(draw(CHART).axes, draw(again).axes, strict=True):
        assert (axes.get_xlim(), axes.get_ylim(), axes.get_yscale()) == (other.get_xlim(), other.get_ylim(), other.get_yscale())
        for line, same in zip(axes.get_lines(), other.get_lines(), strict=True):
            assert (line.get_color(), line.get_drawstyle()) == (same.get_color(), same.get_drawstyle())
            if other.get_title(loc="left") != "a & b <":  # its floor is not in the file
                np.testing.assert_allclose(line.get_xydata(), same.get_xydata(), rtol=1e-6, atol=1e-6)


def test_what_is_drawn():
    """Bars are moved aside, values below the floor lie on it, second scales show the same limits; a spline meets its points."""
    left, right, _, last, _ = draw(CHART).axes
    (second,) = left.child_axes
    left.figure.draw_without_rendering()
    assert second.get_xlim() == pytest.approx([2.0 * limit for limit in left.get_xlim()])
    (runs,) = right.containers
    assert runs.lines[0].get_xdata().tolist() == pytest.approx([0.13, 0.23])
    assert last.get_lines()[0].get_ydata().tolist() == [3.0, 1.5, 4.0]
    bar = last.containers[0].lines[2][0].get_segments()[2]
    assert bar[:, 1].tolist() == [4.0, 9.0]  # one that reaches zero has no lower end on a logarithmic scale
    x, y = right.get_lines()[0].get_data()
    assert x.size > 5 * PART.size
    np.testing.assert_allclose(x[np.isfinite(x)], np.sin(y[np.isfinite(y)]), atol=1e-5)
    assert [text.get_text() for text in left.get_legend().get_texts()] == ["wave", r"ramp $\Delta\mu$", "count"]


def test_small_numbers_of_a_second_scale_are_whole_where_they_stand():
    """A power of ten at its end would meet the words of the other second scale."""
    sides = [Scale(name, second=SecondScale(f"{name} / s", 1e-10)) for name in ("t", "T")]
    (axes,) = draw(Chart([Panel("", *sides, [Trace("", [1.0, 3.0], [1.0, 3.0])])])).axes
    axes.figure.draw_without_rendering()
    for marks in (axes.child_axes[0].xaxis, axes.child_axes[1].yaxis):
        assert marks.get_offset_text().get_text() == ""
        assert "2e−10" in [text.get_text() for text in marks.get_ticklabels()]


def test_a_long_label_stays_below_its_panel_and_meets_no_power_of_ten():
    """Of two panels side by side, and of numbers that matplotlib would write as 1, 2 and a 1e8 in the label."""
    label = "stiffness of the face's spring of the lower slab, of $a = b$ / (Pa/m)"
    panels = [Panel("", Scale(label), Scale(), [Trace("", [5e6, 3e8], [1.0, 2.0])])] * 2
    figure = draw(Chart(panels, columns=2))
    figure.draw_without_rendering()
    for axes in figure.axes:
        assert axes.xaxis.label.get_window_extent().width < axes.get_window_extent().width
        assert axes.get_xlabel().replace("\n", " ") == label
        assert axes.xaxis.get_offset_text().get_text() == ""
        assert r"$\mathdefault{2\times10^{8}}$" in [text.get_text() for text in axes.get_xticklabels()]


def test_thinning_keeps_every_extremum_and_changes_no_number():
    x = np.arange(50_000.0)
    y = np.zeros(x.size)
    y[[123, 40_001]] = 5.0, -7.0
    chosen = staying(x, y)
    assert chosen.size <= MOST
    assert {0, 123, 40_001, x.size - 1} <= set(chosen.tolist())
    turning = staying(np.sin(x / 9e3), x)
    assert np.ptp(np.sin(x[turning] / 9e3)) == np.ptp(np.sin(x / 9e3))
    cells = Trace("", np.arange(200.0), np.arange(100.0), Look(kind="cells"), value=np.arange(2e4).reshape(100, 200))
    curves = [Trace("", x, np.sin(x)), Trace("", np.sin(x / 9e3), x, y_error=x)]
    whole = Chart([Panel("", Scale("", limits=(-2.0, 2e4)), Scale(), curves), Panel("", Scale(), Scale(), [cells])])
    for panel, kept in zip(whole.panels, with_fewer(whole).panels, strict=True):
        for before, after in zip(panel.traces, kept.traces, strict=True):
            rows = {tuple(row) for row in np.column_stack(list(before.columns.values())).tolist()}
            found = [tuple(row) for row in np.column_stack(list(after.columns.values())).tolist() if not np.isnan(row[1])]
            assert len(found) <= max(MOST, CELLS**2)
            assert set(found) <= rows
    assert 3001 in staying(*with_gaps([(x[:3001], y[:3001]), (x, y)]))


def test_words_are_the_numbers_that_were_computed():
    title, words = described(CHART)
    assert title.startswith(
        "stress μ over time: 7 curves in 4 panels; largest 1.3 at x = 4 (ramp Δμ); least −1 at x = 1.571 (wave)"
    )
    apart = CubicSpline(X, np.sin(3.0 * X) - (0.5 * X - 0.7)).roots(extrapolate=False)
    assert f"wave and ramp Δμ cross {apart.size} times, first at x = {apart[0]:.4g}." in words
    assert "At x = 4 ramp Δμ is highest (1.3), wave lowest (−0.5366)." in words
    assert "shades: V over r; x from 0 to 1, y from 1 to 2, logarithmic in y. T (cells)" not in words
    assert "log10 r" in words


def test_panels_of_one_label_share_limits_and_say_it_once():
    """Within a column along x; `share` extends it to all panels, or to none."""
    pair = [Panel("", Scale("t"), Scale("y"), [Trace("", [0.0, end], [0.0, end])]) for end in (1.0, 3.0)]
    charts = (with_limits(Chart(pair, share=share)) for share in (("column", "row"), ("all", "all"), ("", "")))
    ends = [[(panel.x.ends[1], panel.y.ends[1]) for panel in chart.panels] for chart in charts]
    assert np.allclose(ends, [[(3.15, 1.05), (3.15, 3.15)], [(3.15, 3.15)] * 2, [(1.05, 1.05), (3.15, 3.15)]])
    assert [axes.get_xlabel() for axes in draw(Chart(pair)).axes] == ["", "t"]
    assert [axes.get_ylabel() for axes in draw(Chart(pair, columns=2)).axes] == ["y", ""]


def test_the_svg_has_ids_of_its_own_and_is_the_same_twice(tmp_path):
    for name in ("a", "b"):
        render(CHART, tmp_path / name, "study-figure")
    first, second = ((tmp_path / name).with_suffix(".svg").read_text() for name in "ab")
    assert first == second
    ids = set(re.findall(r' id="([^"]*)"', first))
    assert all(name.startswith("study-figure") for name in ids)
    assert set(re.findall(r"(?:href=\"#|url\(#)([^\")]*)", first)) <= ids
    assert re.findall(r">(time|a &amp; b &lt;)<", first) == ["time", "a &amp; b &lt;"]


def test_hatches_of_cells_are_in_the_svg(tmp_path):
    look = Look(kind="cells", colors={"no": "#ffffff", "two": "#c44e52"}, hatches={"two": "////"})
    traces = [Trace("", [0.0, 1.0], [0.0, 1.0], look, value=[[0, 1], [1, 0]])]
    render(Chart([Panel("", Scale(), Scale(), traces)], 2.0, legend="outside upper left"), tmp_path / "a", "a")
    svg = (tmp_path / "a.svg").read_text()
    hatches = re.findall(r"<pattern[^>]* id=\"([^\"]*)\"", svg)
    filled = re.findall(r"fill:url\(#([^)]*)\)", svg)
    assert filled
    assert set(filled) <= set(hatches)
    assert '<rect x="0" y="0" width="73" height="73" style="fill:var(--cc44e52,#c44e52)"' in svg


@pytest.mark.parametrize("color", ["#111111", BLUE, "#e69f00", "#56b4e9", "#b9b9b9"])
def test_lines_are_clear_by_day_and_by_night(color):
    """By the contrast ratio of WCAG 2.1, of the relative luminance of sRGB."""

    def luminance(color):
        linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in to_rgb(color)]
        return float(np.dot([0.2126, 0.7152, 0.0722], linear))

    def contrast(one, other):
        low, high = sorted([luminance(one), luminance(other)])
        return (high + 0.05) / (low + 0.05)

    day = Look(color).ink
    assert contrast(day, PAPER) >= 3.0
    assert contrast(by_night(day), DARK_PAPER) >= 3.0
    assert contrast(by_night("#000000"), by_night(PAPER)) >= 7.0
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert colors_of([f"var(--c{day[1:]},{day})"]) == (f"--c{day[1:]}:{day};", f"--c{day[1:]}:{by_night(day)};")


def test_pictures_within_a_chart_follow_a_dark_page(tmp_path):
    """One of few colours has a second one in those of the key; the shades of one of many are turned by the page."""
    few = Look(kind="cells", colors={"no": "#ffffff", "two": "#c44e52"})
    traces = Trace("", [0.0, 1.0], [0.0, 1.0], few, value=[[0, 1], [1, 0]]), CHART.panels[2].traces[0]
    render(Chart([Panel("", Scale(), Scale(), [trace]) for trace in traces], 2.0, 2), tmp_path / "a", "a")
    svg = (tmp_path / "a.svg").read_text()
    assert re.findall(r'class="(\w+)"', svg)[:2] == ["day", "night"]
    assert "shades" in svg
    day, night = (colors_in(packed) for packed in re.findall(r"base64,([^\"]*)", svg)[:2])
    assert day >= {"#ffffff", "#c44e52"}
    assert night >= {DARK_PAPER, by_night("#c44e52")}


def colors_in(packed):
    with Image.open(io.BytesIO(base64.b64decode(packed))) as image:
        return {f"#{bytes(color).hex()}" for _, color in image.convert("RGB").getcolors(9999)}


def test_a_figure_that_opens_has_its_file_in_the_page(fake, tmp_path):
    """Packed, the same bytes; the script and its licence are there, and no address; without such a figure there is no script."""
    shown = answered(figures=(Figure("line", "A line.", drawing_of, zoom=True),))
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


def test_threads_that_draw_leave_the_style_as_it_was():
    """Each would keep the style of the other as the one to return to."""
    before, inside, drawn = mpl.rcParams["font.size"], Event(), Event()

    def second():
        with styled(2.0):
            inside.set()
            drawn.wait()

    thread = Thread(target=second)
    with styled():
        thread.start()
        inside.wait(0.3)
    drawn.set()
    thread.join()
    assert mpl.rcParams["font.size"] == before


def test_a_title_that_is_wider_than_its_figure_stands_in_lines():
    """A column of a paper would show its first half only."""
    trace = Trace("delay", np.arange(3.0), np.arange(3.0), Look())
    title = "Regimes of two blocks of granite whose outer faces are held by grips\nand of one that is driven"
    chart = Chart([Panel("", Scale("V"), Scale("T"), [trace])], 2.5, width=3.35, title=title, letters=0.7, is_exact=True)
    figure = draw(chart)
    figure.canvas.draw()
    shown = figure._suptitle.get_window_extent()
    assert shown.x0 >= 0.0
    assert shown.x1 <= figure.bbox.x1

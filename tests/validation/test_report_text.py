"""Words and numerals as HTML."""

import math

import pytest

from validation.study import Column, Table, table
from validation.study.text import cell, markup, number, places, plain, power


@pytest.mark.parametrize(
    ("value", "spec", "html"),
    [
        (73.47214494, ".9g", "73.4721449"),
        (-0.0373, ".1%", "−3.7%"),
        (1.23e-9, ".2e", "1.23\u202f·\u202f10<sup>−9</sup>"),
        (-2e10, ".0e", "−2\u202f·\u202f10<sup>10</sup>"),
        (math.nan, ".3g", "–"),
        (-math.inf, ".3g", "−∞"),
    ],
)
def test_numbers(value, spec, html):
    assert number(value, spec) == html


def test_markup_escapes_first():
    assert markup("<b> v_{max} at 10^{-2}: *T*, `a*b` & 2 * 3 * 4") == (
        "&lt;b&gt; v<sub>max</sub> at 10<sup>−2</sup>: <em>T</em>, <code>a*b</code> &amp; 2 * 3 * 4"
    )


def test_cells():
    assert cell(None, ".3g") == "–"
    assert cell("x_{1}", ".3g") == "x<sub>1</sub>"
    assert cell(3, "") == "3"


def test_plain_is_markup():
    assert markup(plain(-1.2e-9, ".2g")) == "−1.2\u202f·\u202f10<sup>−9</sup>"
    assert plain(0.25) == "0.25"


def test_the_heading_of_a_table_is_one_line():
    rows = ([k, 0.5 * k] for k in range(2))
    columns = (
        Column("model"),
        Column("log_{10} r, exact", "ODE, (27)", ".11f"),
        Column("spread", "", ".1%"),
        Column("step", "at cfl 1"),
    )
    heading = "model | log_{10} r, exact [ODE, (27)] .11f | spread .1% | step [at cfl 1]"
    assert table("t", "Told.", heading, rows, [1]) == Table("t", "Told.", columns, ((0, 0.0), (1, 0.5)), (1,))


def test_powers_and_places_in_a_sentence():
    assert (power(1e-13), power(1e3), places([-2.69, -2.6])) == ("10^{−13}", "10^{3}", "−2.69, −2.6")

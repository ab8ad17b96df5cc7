"""Every column and row of a printed table has the figure that its heading names, of figures that all differ."""

import re
from unittest.mock import Mock

import pytest

import slipwave as sw
from validation.branches import SPECIAL_KINDS
from validation.branches.curve import Curve
from validation.branches.parameter import Over
from validation.branches.points import CurvePoint
from validation.results.bench import BenchResult
from validation.results.curve import CurveOptions, CurveResult

PAPER = sw.read("paper")


def table(lines, heading):
    """The rows below the line that begins with these words; cells are two blanks or more apart."""
    (end,) = [k for k, line in enumerate(lines) if line.split()[: len(heading[0].split())] == heading[0].split()]
    assert re.split(r"\s{2,}", lines[end].strip()) == heading
    cells = [re.split(r"\s{2,}", line.strip()) for line in lines[end + 1 : lines.index("", end)]]
    return [dict(zip(heading, row, strict=True)) for row in cells]


def test_a_curve_of_special_points():
    over, second = (Over(PAPER, name, -3.0, 200.0, lambda value: PAPER) for name in ("log10_r", "V"))
    values = (-2.12345678987, 101.512345678, 59.123456789123, 0.123456789123, 0.25, 900.0, 20.0, 3.4567e-9, 1, 0, -0.5, 0.75)
    found = CurveResult(Curve("NS", over, second, "delay", 1e-6, points=[CurvePoint(*values)] * 2), CurveOptions(), 0.25)
    lines = "\n".join(found.lines({})).splitlines()
    assert f"model delay: NS {SPECIAL_KINDS['NS']}, 2 points" in lines
    rows = table(lines, ["log10_r", "V", "period", "stress drop", "bracket", "multiplier"])
    told = {"log10_r": "-2.1234567899", "V": "101.51235", "period": "59.1234568", "stress drop": "0.1234568"}
    assert rows == [told | {"bracket": "3.5e-09", "multiplier": "-0.500000 +- 0.750000 i"}] * 2


def test_run_time_against_error():
    def row(model, setting, errors):
        error = dict(zip(("period", "stress_drop"), errors, strict=True))
        return {"model": model, "setting": setting, "wall_s": 0.512345, "error": error, "verdict": "periodic"}

    rows = [row("fd", {"cells": 64}, (1.23456e-3, 2.34567e-3)), row("delay", {"tolerance": 1e-7}, (3e-7, 4e-7))]
    apart = {
        "verdict": "torus",
        "difference": {"period": 0.02, "stress_drop": -0.3},
        "margin": {"period": 1e-3, "stress_drop": 0.1},
    }
    rows.append(row("block8", {}, (None, None)) | apart)  # type: ignore[arg-type]
    summary = {"models": rows, "until": 200.0, "reference": "delay", "conclusion": "a conclusion"}
    lines = "\n".join(BenchResult.lines(Mock(), summary)).splitlines()
    assert table(lines, ["model", "setting", "wall s", "error T", "error drop"]) == [
        {"model": "fd", "setting": "cells 64", "wall s": "0.512", "error T": "0.00123", "error drop": "0.00235"},
        {"model": "delay", "setting": "tolerance 1e-07", "wall s": "0.512", "error T": "3e-07", "error drop": "4e-07"},
        {"model": "block8", "setting": "-", "wall s": "0.512", "error T": "0.0200 +- 0.0010", "error drop": "-0.30 +- 0.10"},
    ]
    assert lines[-3] == "200 transits; relative errors of the second half's mean against delay (tight)"
    assert lines[-1] == "a conclusion"


def test_stability_in_si(printed):
    found = sw.stability("paper-si")
    si = found.summary["si"]
    rows = [re.split(r"\s{2,}", line.strip()) for line in printed("stability", "paper-si").splitlines()]
    told = {
        row[0]: [float(text.removeprefix("scene ")) for text in row[1:]]
        for row in rows
        if row[0].endswith(("[m]", "[Pa]", "[s]", "[Hz]"))
    }
    assert told == {
        "critical thickness [m]": pytest.approx([si["critical_thickness_m"], 0.03357797353158276], rel=1e-8),
        "critical normal stress [Pa]": pytest.approx([si["critical_normal_stress_Pa"], 1e3], rel=1e-8),
        "growth time of the leading root [s]": pytest.approx([si["growth_time_s"]], rel=1e-8),
        "frequency of the leading root [Hz]": pytest.approx([si["frequency_Hz"]], rel=1e-8),
    }
    root = complex(*found.summary["leading_roots"][0])
    assert (si["growth_time_s"], si["frequency_Hz"]) == pytest.approx(
        (0.9 / root.real, abs(root.imag) / (2.0 * 3.141592653589793 * 0.9)), rel=1e-12
    )

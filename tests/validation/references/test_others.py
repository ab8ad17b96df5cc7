"""The committed results of another program against the frozen table, which its authors never saw."""

import csv
import math

import pytest

from slipwave.sources import ROOT
from validation.references.others import sem2dpack

BENCHMARK = ROOT / "docs" / "benchmark"


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


FROZEN = {row["id"]: float(row["value"]) for row in rows(BENCHMARK / "benchmark.csv")}


@pytest.mark.parametrize(
    ("name", "within"), [*((f"smooth.psi.{t}", 1e-12) for t in (6, 8, 12, 20, 40, 100, 400)), ("orbit.period", 1e-10)]
)
def test_its_extrapolated_values_are_those_of_the_frozen_table(name, within):
    assert 0.0 < abs(sem2dpack()[name] / FROZEN[name] - 1.0) < within


@pytest.mark.parametrize(("scheme", "order"), [("newmark", 2.0), ("leapfrog", 1.0)])
def test_its_schemes_converge_at_the_orders_that_its_page_states(scheme, order):
    found = {
        int(row["steps_per_transit"]): float(row["value"])
        for row in rows(BENCHMARK / "others" / "sem2dpack.csv")
        if (row["scheme"], row["id"]) == (scheme, "smooth.psi.40")
    }
    errors = {steps: abs(value - FROZEN["smooth.psi.40"]) for steps, value in found.items()}
    coarse, fine = sorted(errors)[-2:]
    assert math.log2(errors[coarse] / errors[fine]) / math.log2(fine / coarse) == pytest.approx(order, abs=0.02)


def test_values_of_continuation_programs_have_all_their_digits():
    """Half of a unit of the last digit that is written; for log10 r that of the bar of the frozen table, if that is larger."""
    bars = {row["id"]: float(row["bar"]) for row in rows(BENCHMARK / "benchmark.csv")}
    for row in rows(BENCHMARK / "others" / "continuation.csv"):
        half = 0.5 * 10.0 ** -len(row["value"].partition(".")[2])
        assert abs(float(row["value"]) - FROZEN[row["id"]]) <= 1.2 * half + bars[row["id"]], row

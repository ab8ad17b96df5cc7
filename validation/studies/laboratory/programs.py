"""Velocity steps and a hold printed by other programs: what a fit of their numbers finds."""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import slipwave as sw
from validation.references.published import laboratory
from validation.report import WITNESS, Verdict, claim
from validation.studies.laboratory.measured import FrictionFit, plain_block

_BEFORE = 1.0  # s of steady sliding
_FAR = (1.5, 1.2, 3.0)  # times the printed values: where a fit begins
_TOLERANCE = 1e-9
_BAR = 1e-5  # relative error of a fitted value: printed digits in the tail of a step leave some 1e-6


class Printed(NamedTuple):
    """A `row` that a program printed, the largest residual of quasi-static friction fitted to it, and the fitted parameters over
    the true ones."""

    row: Mapping[str, Any]
    apart: float
    ratios: FrictionFit


def printed_rows() -> list[Mapping[str, Any]]:
    """The series that other programs print."""
    return list(laboratory()["programs"]["rows"])


def fitted_to(row: Mapping[str, Any]) -> Printed:
    """Fit a printed series from distant start values; friction is the shear stress over 1 MPa."""
    true = FrictionFit(row["a"], row["b"], row["Dc_um"])
    block = plain_block({**row, "sigma_MPa": 1.0}, FrictionFit(*(x * y for x, y in zip(_FAR, true, strict=True))), row["law"])
    begin = f"{_BEFORE} s"
    steps = [["0 s", "1 um/s"], [begin, "1 um/s"], [begin, f"{row['velocity']} um/s"]]
    samples = [(0.0, 0.6), *((_BEFORE + time, friction) for time, friction in zip(row["time_s"], row["friction"], strict=True))]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "printed.csv"
        file.write_text("time [s],friction\n" + "".join(f"{time!r},{friction!r}\n" for time, friction in samples))
        scene, free = sw.read(block, {"drive.velocity": steps, "start.size": 0.0}), ["a", "b", "memory_length"]
        found = sw.fit(scene, data=[str(file)], free=free, model="quasistatic", tol=_TOLERANCE).summary
    a, b, length = (one["value"] for one in found["parameters"].values())
    ratios = FrictionFit(a / true.a, b / true.b, 1e6 * length / true.length)
    return Printed(row, found["residual"]["largest"], ratios)


def on_programs(found: Sequence[Printed]) -> Iterator[Verdict]:
    """Verdicts on the agreement of the motion and of the parameters."""
    for one in found:
        name = f"{one.row['program']}, {one.row['law']} law, step to {one.row['velocity']:g} V*"
        title = "Fitted quasi-static friction is what rsfmodel and Marone's program print, within one unit of the last digit"
        yield claim(title, WITNESS, one.apart * 10.0 ** one.row["digits"], 1.0, f"{name}: {len(one.row['friction'])} values")
        worst = max(abs(ratio - 1.0) for ratio in one.ratios)
        title = "A fit of what these programs print gives back their a, b and L"
        yield claim(title, WITNESS, worst, _BAR, f"{name}: relative; begun 1.5, 1.2 and 3 times as large")

"""Velocity steps and a hold printed by other programs: the same motion by ours, and their parameters fitted to their numbers."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.fit.forward import OfReduction
from validation.fit.least_squares import Best, minimise
from validation.fit.parameters import Schedule, Variants, free_parameters
from validation.fit.problem import problem_of
from validation.fit.records import Experiment, travelled
from validation.references.published import laboratory
from validation.studies.laboratory.measured import FrictionFit, plain_block
from validation.study import WITNESS, Verdict, claim

_BEFORE = 1.0  # s of steady sliding
_FAR = FrictionFit(1.5, 1.2, 3.0)  # times the printed values: where a fit begins
_TOLERANCE = 1e-9
_BAR = 1e-5  # relative error of a fitted value: printed digits in the tail of a step leave some 1e-6


class Printed(NamedTuple):
    """A `row` that a program printed, the largest difference of our friction, and the fitted parameters over the true ones."""

    row: Mapping[str, Any]
    apart: float
    ratios: FrictionFit


def printed_rows() -> list[Mapping[str, Any]]:
    """The series that other programs print."""
    return list(laboratory()["programs"]["rows"])


def compared_with(row: Mapping[str, Any]) -> Printed:
    """Compare our quasi-static friction with a printed series, and fit the series from distant start values."""
    schedule, times = _drive(row)
    ours = OfReduction(Variants(_block(row), (), schedule), times, "quasistatic", _TOLERANCE).friction(np.empty(0))
    apart = float(np.abs(ours - row["friction"]).max())
    return Printed(row, apart, _fitted(row, schedule, times))


def _drive(row: Mapping[str, Any]) -> tuple[Schedule, Array]:
    """The load point, and the times of the samples since it began (s)."""
    times = _BEFORE + np.array(row["time_s"])
    after = 1e-6 * row["velocity"]
    return Schedule((0.0, _BEFORE, _BEFORE, float(times[-1])), (1e-6, 1e-6, after, after)), times


def _block(row: Mapping[str, Any], factors: Sequence[float] = (1.0, 1.0, 1.0)) -> Scene:
    """The spring of a series, with its parameters times `factors`; friction times 1 MPa."""
    a, b, length = (x * row[key] for x, key in zip(factors, ("a", "b", "Dc_um"), strict=True))
    return plain_block({**row, "sigma_MPa": 1.0}, FrictionFit(a, b, length), row["law"])


def _fitted(row: Mapping[str, Any], schedule: Schedule, times: Array) -> FrictionFit:
    """The fitted parameters over those of the series."""
    scene = _block(row, _FAR)
    free = free_parameters(scene, ["a", "b", "memory_length"])
    friction, weight = np.array(row["friction"]), 10.0 ** row["digits"]
    record = Experiment(row["program"], times, friction, travelled(schedule, times), schedule, (), weight)
    problem = problem_of(scene, free, [], [record], "quasistatic", _TOLERANCE)
    found = minimise(problem, problem.starts(), Best(next(problem.starts())), problem.noise)
    a, b, length = np.exp(found.inner)
    return FrictionFit(a / row["a"], b / row["b"], length / (1e-6 * row["Dc_um"]))


def on_programs(found: Sequence[Printed]) -> Iterator[Verdict]:
    """Verdicts on the agreement of the motion and of the parameters."""
    for one in found:
        name = f"{one.row['program']}, {one.row['law']} law, step to {one.row['velocity']:g} V*"
        title = "Quasi-static friction is what rsfmodel and Marone's program print, within one unit of the last digit"
        size, text = one.apart * 10.0 ** one.row["digits"], f"{name}: {len(one.row['friction'])} values"
        yield claim(title, WITNESS, size, 1.0, text)
        worst = max(abs(ratio - 1.0) for ratio in one.ratios)
        title = "A fit of what these programs print gives back their a, b and L"
        yield claim(title, WITNESS, worst, _BAR, f"{name}: relative; begun 1.5, 1.2 and 3 times as large")

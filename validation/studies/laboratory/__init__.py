"""The models against published laboratory experiments, and the effect of waves there."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from validation.chart import BLUE, ORANGE, POINTS, Chart, Look, Panel, Scale, Trace, outline, with_gaps
from validation.references import published
from validation.references.published import laboratory
from validation.report import WITNESS, Budget, Figure, Number, StudyAnswer, StudyResult, Verdict, claim, every, of_paper
from validation.studies.laboratory.measured import (
    FrictionFit,
    MeasuredCycle,
    Rise,
    cycle_in_run,
    cycle_without_tuning,
    cycles_of_samples,
    leeman_runs,
    printed_fits,
    rise_of,
    samples,
    steel_blocks,
)
from validation.studies.laboratory.programs import fitted_to, on_programs, printed_rows

NAME = "laboratory"
QUESTION = "Do the models meet experiments that nobody here made?"
SCENES: tuple[str, ...] = ()
FILES = (Path(published.__file__).with_name("laboratory.json"),)
SECONDS = (10.0, 28.0)

LAWS = ("ageing", "slip")
NAMES = ("period", "drop", "peak")
_PEAK = "peak slip rate / (mm/s)"
_SYMBOLS = {"period": ("T_s", "period / s"), "drop": ("drop", "drop of friction"), "peak": ("peak_mm_s", _PEAK)}
_SCATTER = {"period": 0.05, "drop": 0.05, "peak": 0.15}
"""Relative scatter of measured figures from event to event."""
_WITHIN = 5e-3  # of a printed period: three digits, of a program of unknown tolerance
_TWO_DIGITS = 0.05  # of a printed slip rate
_SAME = 0.05  # relative; the scatter of measured periods from event to event
_RISES = ((0.66, 0.005, 1.0), (1.0, 0.003, 1.0), (1.33, 0.005, 1.0), (0.66, 0.01, 10.0), (1.33, 0.005, 10.0), (1.33, 0.01, 10.0))
_SPREAD = 0.05  # of the rise time


class Band(NamedTuple):
    """Median and 95 % range of a figure over the samples that stick and slip; NaN where fewer than three do."""

    low: float
    median: float
    high: float


class Case(NamedTuple):
    """A run of the experiment and the samples of one law: the share of them that stick and slip, their bands, and how many
    meet period, drop and peak slip rate at once."""

    row: Mapping[str, Any]
    law: str
    slips: float
    bands: dict[str, Band]
    meets: int

    def holds(self, name: str) -> bool:
        """Whether the measured figure lies in its band."""
        return self.bands[name].low <= _measured_figure(self.row, name) <= self.bands[name].high


def run(budget: Budget) -> StudyResult:
    """Compute every run within the parameters' uncertainty, with and without waves, and compare it with the measurement."""
    count, events, with_keeping = budget.plan(quick=(6, 3, False), full=(24, len(_RISES), True))
    drawn = samples(count)
    pairs = [(row, law) for law in LAWS for row in leeman_runs()]
    cases = [_case(row, law, drawn) for row, law in budget.each(pairs, 0.6)]
    untuned = {(row["sigma_MPa"], k): cycle_without_tuning(row, printed_fits()[k][0]) for row in leeman_runs() for k in (1, 2)}
    budget.report(0.7)
    rises = [rise_of(*one) for one in _RISES[:events]]
    programs = [fitted_to(row) for row in printed_rows()]
    return StudyResult(
        answers=_answers(cases),
        figures=(
            Figure("leeman", _LEEMAN, lambda: _over_stress(cases)),
            Figure("togo", _TOGO, lambda: _over_drop(rises)),
        ),
        verdicts=(
            *_reproduced(untuned),
            *_against_measured(cases),
            *_on_waves(waves_in_blocks(with_keeping)),
            _on_rises(rises),
            *on_programs(programs),
        ),
        notes=(_NOTE,),
        numbers=_numbers(cases, rises, len(drawn)),
    )


def _answers(cases: Sequence[Case]) -> tuple[StudyAnswer, ...]:
    inside = {name: max(sum(case.holds(name) for case in cases if case.law == law) for law in LAWS) for name in NAMES}
    return (
        StudyAnswer(
            f"The printed a, b and L with their uncertainty hold the period in {inside['period']} of 7 runs, the drop in "
            f"{inside['drop']} and the peak slip rate in {inside['peak']}, but all three at once in {sum(_row_met(cases))} of 7.",
            ("Leeman et al. 2016: ",),
        ),
        StudyAnswer(
            "The delay of waves makes no measurable difference, where they go does; and the models’ friction is that of other "
            "programs.",
            (
                "Waves that leave",
                "Togo et al. 2015",
                "The plain spring and block",
                "Fitted quasi-static friction",
                "A fit of what",
            ),
        ),
    )


def _case(row: Mapping[str, Any], law: str, drawn: Sequence[tuple[FrictionFit, float]]) -> Case:
    found = [one for one in cycles_of_samples(row, law, drawn) if one is not None]
    nothing = Band(*[math.nan] * 3)
    bands = {
        name: Band(*np.quantile([getattr(one, name) for one in found], (0.025, 0.5, 0.975)).tolist())
        if len(found) > 2
        else nothing
        for name in NAMES
    }
    off = [{name: abs(getattr(one, name) / _measured_figure(row, name) - 1.0) for name in NAMES} for one in found]
    meets = sum(all(one[name] <= 2.0 * _SCATTER[name] for name in NAMES) for one in off)
    return Case(row, law, len(found) / len(drawn), bands, meets)


def _measured_figure(row: Mapping[str, Any], name: str) -> float:
    """The measured figure of a run."""
    return float(row[_SYMBOLS[name][0]])


def _row_met(cases: Sequence[Case]) -> list[bool]:
    """For each run, whether some sample of some law meets period, drop and peak slip rate at once."""
    return [any(case.meets for case in cases if case.row["run"] == row["run"]) for row in leeman_runs()]


def waves_in_blocks(with_keeping: bool) -> dict[str, MeasuredCycle]:
    """The run at 10 MPa with the third fit: by the plain `block`; by exact waves in blocks of 5 cm behind faces that `absorb`
    them and, if wanted, in blocks that `keep` them."""
    row, (fit, _) = leeman_runs()[2], printed_fits()[2]
    absorbing, seconds = steel_blocks(row, fit, dashpot=1.0), 4.0 * row["T_s"]
    block, absorbed = (cycle_in_run(absorbing, model, seconds, 0.0) for model in ("quasidynamic", "delay"))
    keeping = steel_blocks(row, fit, dashpot=0.0, mass=400.0)
    kept = cycle_in_run(keeping, "delay", seconds, 0.0, 1e-5) if with_keeping else None
    return {name: one for name, one in (("block", block), ("absorb", absorbed), ("keep", kept)) if one}


def _reproduced(untuned: Mapping[tuple[float, int], MeasuredCycle | None]) -> Iterator[Verdict]:
    """Verdicts: our plain block, by normal stress (MPa) and number of the fit, against another program's."""
    title = "The plain spring and block moves as in another program"
    printed = laboratory()["leeman-2016"]["plain_spring_block"]
    apart, slides = list[float](), list[bool]()
    for (stress, k), found in untuned.items():
        theirs = printed["T_s"][str(stress)][k - 1]
        if theirs is None:
            slides.append(found is None)
        else:
            apart.append(abs(found.period / theirs - 1.0) if found else math.nan)
    peaks = [
        abs(found.peak / theirs - 1.0) if (found := untuned[int(stress), k]) else math.nan
        for stress, pair in printed["peak_mm_s"].items()
        for k, theirs in zip((1, 2), pair, strict=True)
    ]
    yield claim(title, WITNESS, float(np.max(apart)), _WITHIN, f"{len(apart)} periods")
    yield claim(title, WITNESS, float(np.max(peaks)), _TWO_DIGITS, f"{len(peaks)} peak slip rates with two digits")
    yield every(title, WITNESS, sum(slides), len(slides), "steady sliding", what="runs")


def _of_others(title: str, expected: str, ours: str, holds: bool, remark: str = "") -> Verdict:
    """The verdict on a claim or measurement of another paper: one that does not hold is a finding, and none of the paper's."""
    return of_paper(title, expected, ours, holds, remark, evidence=WITNESS)


def _against_measured(cases: Sequence[Case]) -> Iterator[Verdict]:
    """Verdicts on onset, period, drop, peak slip rate."""
    of_law = {law: [case for case in cases if case.law == law] for law in LAWS}
    onset = {law: min(case.slips for case in own) for law, own in of_law.items()}
    yield _of_others(
        "Leeman et al. 2016: stick-slip in all seven runs",
        "half of the samples or more, in each run, by one of the laws",
        ", ".join(f"{law}: {share:.0%} or more" for law, share in onset.items()),
        max(onset.values()) >= 0.5,
        "with a, b, L as printed; k' with 5 %",
    ).with_margin(0.5 / max(onset.values()) if any(onset.values()) else math.inf, 1.0)
    for name, words in zip(NAMES, ("period", "drop of friction", "peak slip rate"), strict=True):
        inside = {law: sum(case.holds(name) for case in own) for law, own in of_law.items()}
        ratio = {
            law: np.median([one.bands[name].median / _measured_figure(one.row, name) for one in of_law[law]]) for law in LAWS
        }
        yield _of_others(
            "Leeman et al. 2016: what was measured lies within the uncertainty of a, b, L and k'",
            "7 of 7 runs by one of the laws",
            ", ".join(f"{law}: {inside[law]} of 7, computed over measured {ratio[law]:.2g}" for law in LAWS),
            max(inside.values()) == 7,
            words,
        ).with_margin(7 - max(inside.values()), 1.0)
    met = _row_met(cases)
    yield _of_others(
        "Leeman et al. 2016: one set of a, b, L and k' meets period, drop and peak slip rate at once",
        f"{len(met)} of {len(met)} runs",
        f"{sum(met)} of {len(met)} runs",
        all(met),
        f"within twice the scatter from event to event; {sum(case.meets for case in cases)} of all samples",
    ).with_margin(len(met) - sum(met), 1.0)


def _on_waves(waves: Mapping[str, MeasuredCycle]) -> Iterator[Verdict]:
    """Verdicts on the neglect of waves: no effect if they are absorbed; the whole damping if not."""
    apart = [abs(one / other - 1.0) for one, other in zip(waves["block"], waves["absorb"], strict=True)]
    text = ", ".join(f"{name} {100.0 * size:.2g} %" for name, size in zip(NAMES, apart, strict=True))
    title = "Waves that leave blocks of 5 cm differ from radiation damping by less than events scatter"
    yield claim(title, WITNESS, max(apart), _SAME, f"{text}: the blocks' own compliance, between friction and what absorbs")
    if kept := waves.get("keep"):
        measured = _measured_figure(leeman_runs()[2], "peak")
        yield _of_others(
            "Leeman et al. 2016: blocks that keep their waves slip as slowly as was measured",
            f"peak slip rate within a factor of 2 of {measured:.3g} mm/s",
            f"{kept.peak:.3g} mm/s",
            0.5 < kept.peak / measured < 2.0,
            "without a loss only inertia limits the slip rate: something takes the energy away",
        ).with_margin(abs(math.log2(kept.peak / measured)), 1.0)


def _on_rises(rises: Sequence[Rise]) -> Verdict:
    """Rise times over stress drops."""
    times, drops = [one.time for one in rises], [one.drop for one in rises]
    shown = f"{min(times):.3g} to {max(times):.3g} ms, drops of {min(drops):.2g} to {max(drops):.2g} MPa"
    title = "Togo et al. 2015: the rise time does not depend on the stress drop"
    return claim(title, WITNESS, max(times) / min(times) - 1.0, _SPREAD, "greatest over least, less 1", shown)


def _numbers(cases: Iterable[Case], rises: Iterable[Rise], count: int) -> dict[str, Number]:
    """Numbers for the baseline. The name of a median contains the number of samples: medians of different samples are not
    compared."""
    medians = {
        f"{case.law} {case.row['sigma_MPa']} MPa {name}, {count} samples": Number(case.bands[name].median, 1e-3)
        for case in cases
        for name in NAMES
        if math.isfinite(case.bands[name].median)
    }
    return medians | {f"rise time, drop {one.drop:.2g} MPa": Number(one.time, 1e-3) for one in rises}


def _over_stress(cases: Sequence[Case]) -> Chart:
    """Measured values with their scatter and the ranges of the laws, over normal stress."""
    panels, runs = [], leeman_runs()
    for name in NAMES:
        traces = []
        for law, color, aside in zip(LAWS, (BLUE, ORANGE), (-0.15, 0.15), strict=True):
            own = {float(case.row["sigma_MPa"]): case.bands[name] for case in cases if case.law == law}
            ranges = with_gaps(([stress] * 2, [band.low, band.high]) for stress, band in own.items())
            traces.append(Trace(f"{law} law, 95 %", *ranges, Look(color, width=2.5), shift=(aside, 0.0)))
            medians = [band.median for band in own.values()]
            traces.append(Trace(f"{law} law, median", [*own], medians, Look(color, "", "_", size=9.0), shift=(aside, 0.0)))
        values = np.array([_measured_figure(row, name) for row in runs])
        at, scatter = [row["sigma_MPa"] for row in runs], _SCATTER[name] * values
        traces.append(Trace("measured", at, values, POINTS.but(size=4.0), y_error=scatter))
        up = Scale(_SYMBOLS[name][1], "log", (0.01, 60.0)) if name == "peak" else Scale(_SYMBOLS[name][1], limits=(0.0, None))
        panels.append(Panel("", Scale("normal stress / MPa"), up, traces))
    return Chart(panels, 3.6, 3, 9.0, legend="outside upper left", legend_columns=5)


def _over_drop(rises: Sequence[Rise]) -> Chart:
    """Rise times over stress drops."""
    low, high = laboratory()["togo-2015"]["rise_time_ms"]
    drops, times = [one.drop for one in rises], [one.time for one in rises]
    traces = [
        Trace("", *outline((0.0, np.inf), (low, low), (high, high)), Look("#cccccc", kind="area")),
        Trace("measured", [0.01], [0.5 * (low + high)], Look(kind="text")),
        Trace("exact waves, machine of 153 MPa/m", drops, times, POINTS.but(color=BLUE)),
    ]
    across, up = Scale("stress drop / MPa", limits=(0.0, None)), Scale("rise time / ms", limits=(0.0, 25.0))
    return Chart([Panel("", across, up, traces, "lower right")], 2.8)


_LEEMAN = (
    "Leeman and others (2016), double direct shear of quartz powder. Points: measured (bars: scatter from event to event; drop: "
    "k' V times the time between events). Bars in colour: median and 95 % of spring and block with radiation damping, with the "
    "three fits of a, b and L that are printed for the largest displacement, within their standard deviations, and k' as printed "
    "with 5 % (our assumption). The ageing law is run with parameters that were fitted by the slip law, as printed."
)
_TOGO = (
    "Togo and others (2015): two slabs of gabbro, 20 cm each, on a machine of 153 MPa/m; exact waves, ageing law. Rise time: "
    "from 90 % to 10 % of the elastic stress drop, over the share of half a period that this takes in free swinging. The mass of "
    "the machine follows from the measured mean of 17.7 ms, so only its independence of the drop is tested."
)
_NOTE = (
    "Waves need 32 μs to and fro in the steel blocks, against events of 0.4 s. Absorbed, they are the radiation damping that the "
    "plain block has; kept, the slip rate is limited by inertia alone. The plain block’s damping, ρc/2 of steel, is therefore an "
    "assumption on the machine."
)

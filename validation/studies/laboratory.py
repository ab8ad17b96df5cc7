"""The models against published laboratory experiments, and the effect of waves there: a block under double direct shear, with and
without waves in the steel blocks, and a metre of gabbro; and what a fit finds of the velocity steps and the hold that other
programs print."""

import math
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

import slipwave as sw
from validation.chart import BLUE, ORANGE, POINTS, Chart, Look, Panel, Scale, Trace, outline, with_gaps
from validation.measure.cycle import history_of
from validation.references import published
from validation.references.published import laboratory
from validation.report import (
    WITNESS,
    Answers,
    Budget,
    Figure,
    Number,
    Outcome,
    StudyResult,
    Verdict,
    Verdicts,
    claim,
    every,
    holding,
)

NAME = "laboratory"
QUESTION = "Do the models meet experiments that nobody here made?"
SCENES: tuple[str, ...] = ()
FILES = (Path(published.__file__).with_name("laboratory.json"),)
SECONDS = (10.0, 28.0)

_LEEMAN_2016 = laboratory()["leeman-2016"]
_RUNS: list[Mapping[str, Any]] = _LEEMAN_2016["rows"]
_FITS = [np.transpose([fit[key] for key in ("a", "b", "Dc_um")]) for fit in _LEEMAN_2016["rate_and_state"]["fits"]]
"""The seven runs of Leeman et al. (2016); the printed fits: a, b and L (um), and their standard deviations."""

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


MeasuredCycle: TypeAlias = dict[str, float]
"""By NAMES: period (s), drop of friction, peak slip rate (mm/s)."""


class _Case(NamedTuple):
    """A run of the experiment and the samples of one law: the share of them that stick and slip; by figure the 95 % range of
    these with the median in its middle, NaN where fewer than three do; and how many meet period, drop and peak slip rate at
    once."""

    row: Mapping[str, Any]
    law: str
    slips: float
    bands: dict[str, np.ndarray]
    meets: int

    def holds(self, name: str) -> bool:
        """Whether the measured figure lies in its band."""
        low, _, high = self.bands[name]
        return bool(low <= _measured_figure(self.row, name) <= high)


def run(budget: Budget) -> StudyResult:
    """Compute every run within the parameters' uncertainty, with and without waves, and compare it with the measurement."""
    count, events, with_keeping = budget.plan(quick=(6, 3, False), full=(24, len(_RISES), True))
    # parameters within the printed uncertainty, with a factor of k': the three fits in turn, a, b and L normal and independent of
    # each other (no correlation is printed)
    numbers = zip(np.random.default_rng(20160331).standard_normal((count, 4)), cycle(_FITS))
    drawn = [(mean + spread * row[:3], math.exp(_STIFFNESS_SPREAD * row[3])) for row, (mean, spread) in numbers]
    pairs = [(row, law) for law in LAWS for row in _RUNS]
    cases = [_case(row, law, drawn) for row, law in budget.each(pairs, 0.6)]
    untuned = {(row["sigma_MPa"], k): _cycle_without_tuning(row, _FITS[k][0]) for row in _RUNS for k in (1, 2)}
    budget.report(0.7)
    rises = [_rise_of(*rise) for rise in _RISES[:events]]
    programs = [(row, *_fitted_to(row)) for row in laboratory()["programs"]["rows"]]
    return StudyResult(
        answers=_answers(cases),
        figures=(
            Figure("leeman", _LEEMAN, lambda: _over_stress(cases)),
            Figure("togo", _TOGO, lambda: _over_drop(rises)),
        ),
        verdicts=(
            *_reproduced(untuned),
            *_against_measured(cases),
            *_on_waves(_waves_in_blocks(with_keeping)),
            _on_rises(rises),
            *(verdict for program in programs for verdict in _program_verdicts(*program)),
        ),
        notes=(_NOTE,),
        numbers=_numbers(cases, rises, len(drawn)),
    )


def _answers(cases: Sequence[_Case]) -> Answers:
    inside = {name: max(sum(case.holds(name) for case in cases if case.law == law) for law in LAWS) for name in NAMES}
    return {
        (
            f"The printed a, b and L with their uncertainty hold the period in {inside['period']} of 7 runs, the drop in "
            f"{inside['drop']} and the peak slip rate in {inside['peak']}, but all three at once in {sum(_row_met(cases))} of 7."
        ): ("Leeman et al. 2016: ",),
        (
            "The delay of waves makes no measurable difference, where they go does; and the models’ friction is that of other "
            "programs."
        ): (
            "Waves that leave",
            "Togo et al. 2015",
            "The plain spring and block",
            "Fitted quasi-static friction",
            "A fit of what",
        ),
    }


def _case(row: Mapping[str, Any], law: str, drawn: Sequence[tuple[np.ndarray, float]]) -> _Case:
    cycles = [cycle for cycle in _cycles_of_samples(row, law, drawn) if cycle is not None]
    figures = {name: [cycle[name] for cycle in cycles] for name in NAMES}
    bands = {
        name: np.quantile(values if len(cycles) > 2 else [math.nan], (0.025, 0.5, 0.975)) for name, values in figures.items()
    }
    off = [{name: abs(cycle[name] / _measured_figure(row, name) - 1.0) for name in NAMES} for cycle in cycles]
    meets = sum(all(errors[name] <= 2.0 * _SCATTER[name] for name in NAMES) for errors in off)
    return _Case(row, law, len(cycles) / len(drawn), bands, meets)


def _measured_figure(row: Mapping[str, Any], name: str) -> float:
    """The measured figure of a run."""
    return float(row[_SYMBOLS[name][0]])


def _row_met(cases: Sequence[_Case]) -> list[bool]:
    """For each run, whether some sample of some law meets period, drop and peak slip rate at once."""
    return [any(case.meets for case in cases if case.row["run"] == row["run"]) for row in _RUNS]


def _waves_in_blocks(with_keeping: bool) -> dict[str, MeasuredCycle]:
    """The run at 10 MPa with the third fit: by the plain `block`; by exact waves in blocks of 5 cm behind faces that `absorb`
    them and, if wanted, in blocks that `keep` them."""
    row, (fit, _) = _RUNS[2], _FITS[2]
    absorbing, seconds = _steel_blocks(row, fit, dashpot=1.0), 4.0 * row["T_s"]
    block, absorbed = (_cycle_in_run(absorbing, model, seconds, 0.0) for model in ("quasidynamic", "delay"))
    keeping = _steel_blocks(row, fit, dashpot=0.0, mass=400.0)
    kept = _cycle_in_run(keeping, "delay", seconds, 0.0, 1e-5) if with_keeping else None
    return {name: cycle for name, cycle in (("block", block), ("absorb", absorbed), ("keep", kept)) if cycle}


def _reproduced(untuned: Mapping[tuple[float, int], MeasuredCycle | None]) -> Verdicts:
    """Verdicts: our plain block, by normal stress (MPa) and number of the fit, against another program's."""
    title = "The plain spring and block moves as in another program"
    printed = _LEEMAN_2016["plain_spring_block"]
    apart, slides = list[float](), list[bool]()
    for (stress, k), motion in untuned.items():
        theirs = printed["T_s"][str(stress)][k - 1]
        if theirs is None:
            slides.append(motion is None)
        else:
            apart.append(abs(motion["period"] / theirs - 1.0) if motion else math.nan)
    peaks = [
        abs(motion["peak"] / theirs - 1.0) if (motion := untuned[int(stress), k]) else math.nan
        for stress, pair in printed["peak_mm_s"].items()
        for k, theirs in zip((1, 2), pair, strict=True)
    ]
    yield claim(title, WITNESS, np.max(apart), _WITHIN, f"{len(apart)} periods")
    yield claim(title, WITNESS, np.max(peaks), _TWO_DIGITS, f"{len(peaks)} peak slip rates with two digits")
    yield every(title, WITNESS, sum(slides), len(slides), "steady sliding", what="runs")


def _of_others(title: str, expected: str, ours: str, holds: bool, remark: str = "") -> Verdict:
    """The verdict on a claim or measurement of another paper: one that does not hold is a finding, and none of the paper's."""
    return holding(title, WITNESS, expected, ours, holds, remark, otherwise=Outcome.FINDING)


def _against_measured(cases: Sequence[_Case]) -> Verdicts:
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
        ratio = {law: np.median([case.bands[name][1] / _measured_figure(case.row, name) for case in of_law[law]]) for law in LAWS}
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


def _on_waves(waves: Mapping[str, MeasuredCycle]) -> Verdicts:
    """Verdicts on the neglect of waves: no effect if they are absorbed; the whole damping if not."""
    apart = {name: abs(waves["block"][name] / waves["absorb"][name] - 1.0) for name in NAMES}
    text = ", ".join(f"{name} {100.0 * size:.2g} %" for name, size in apart.items())
    title = "Waves that leave blocks of 5 cm differ from radiation damping by less than events scatter"
    yield claim(
        title, WITNESS, max(apart.values()), _SAME, f"{text}: the blocks' own compliance, between friction and what absorbs"
    )
    if kept := waves.get("keep"):
        measured = _measured_figure(_RUNS[2], "peak")
        yield _of_others(
            "Leeman et al. 2016: blocks that keep their waves slip as slowly as was measured",
            f"peak slip rate within a factor of 2 of {measured:.3g} mm/s",
            f"{kept['peak']:.3g} mm/s",
            0.5 < kept["peak"] / measured < 2.0,
            "without a loss only inertia limits the slip rate: something takes the energy away",
        ).with_margin(abs(math.log2(kept["peak"] / measured)), 1.0)


def _on_rises(rises: Sequence[tuple[float, float]]) -> Verdict:
    """Rise times over stress drops."""
    drops, times = zip(*rises, strict=True)
    shown = f"{min(times):.3g} to {max(times):.3g} ms, drops of {min(drops):.2g} to {max(drops):.2g} MPa"
    title = "Togo et al. 2015: the rise time does not depend on the stress drop"
    return claim(title, WITNESS, max(times) / min(times) - 1.0, _SPREAD, "greatest over least, less 1", shown)


def _numbers(cases: Iterable[_Case], rises: Iterable[tuple[float, float]], count: int) -> dict[str, Number]:
    """Numbers for the baseline. The name of a median contains the number of samples: medians of different samples are not
    compared."""
    medians = {
        f"{case.law} {case.row['sigma_MPa']} MPa {name}, {count} samples": Number(case.bands[name][1], 1e-3)
        for case in cases
        for name in NAMES
        if math.isfinite(case.bands[name][1])
    }
    return medians | {f"rise time, drop {drop:.2g} MPa": Number(time, 1e-3) for drop, time in rises}


def _over_stress(cases: Sequence[_Case]) -> Chart:
    """Measured values with their scatter and the ranges of the laws, over normal stress."""
    panels = []
    for name in NAMES:
        traces = []
        for law, color, aside in zip(LAWS, (BLUE, ORANGE), (-0.15, 0.15), strict=True):
            own = {float(case.row["sigma_MPa"]): case.bands[name] for case in cases if case.law == law}
            ranges = with_gaps(([stress] * 2, band[[0, 2]]) for stress, band in own.items())
            traces.append(Trace(f"{law} law, 95 %", *ranges, Look(color, width=2.5), shift=(aside, 0.0)))
            medians = [band[1] for band in own.values()]
            traces.append(Trace(f"{law} law, median", [*own], medians, Look(color, "", "_", size=9.0), shift=(aside, 0.0)))
        values = np.array([_measured_figure(row, name) for row in _RUNS])
        at, scatter = [row["sigma_MPa"] for row in _RUNS], _SCATTER[name] * values
        traces.append(Trace("measured", at, values, POINTS.but(size=4.0), y_error=scatter))
        up = Scale(_SYMBOLS[name][1], "log", (0.01, 60.0)) if name == "peak" else Scale(_SYMBOLS[name][1], limits=(0.0, None))
        panels.append(Panel("", Scale("normal stress / MPa"), up, traces))
    return Chart(panels, 3.6, 3, 9.0, legend="outside upper left", legend_columns=5)


def _over_drop(rises: Sequence[tuple[float, float]]) -> Chart:
    """Rise times over stress drops."""
    low, high = laboratory()["togo-2015"]["rise_time_ms"]
    drops, times = zip(*rises, strict=True)
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


_DENSITY, _SHEAR_MODULUS, _THICKNESS = 7850.0, 79e9, 0.05  # of the steel forcing blocks
_STIFFNESS_SPREAD = 0.05  # of k', for which no uncertainty is printed: our assumption
_TOLERANCE = 1e-6
_CYCLES = 12.0
_START = 2.0


def _plain_block(row: Mapping[str, Any], fit: np.ndarray, law: str, factor: float = 1.0) -> sw.Scene:
    """Spring, `factor` times k', and radiation damping, rho c/2 of steel: alike slabs whose elasticity is the spring, for a model
    without waves and inertia."""
    stiffness = factor * row["k_per_um"] * row["sigma_MPa"] * 1e12  # Pa/m
    slab = {"density": _DENSITY, "shear_modulus": _SHEAR_MODULUS, "thickness": _SHEAR_MODULUS / (2.0 * stiffness)}
    return _scene(row, fit, law, slab)


def _steel_blocks(row: Mapping[str, Any], fit: np.ndarray, dashpot: float, mass: float = 0.0) -> sw.Scene:
    """Two blocks of steel, each behind a spring with a dashpot (of `dashpot` times rho c) and a mass (kg/m2)."""
    stiffness = row["k_per_um"] * row["sigma_MPa"] * 1e12
    spring = 1.0 / (1.0 / (2.0 * stiffness) - _THICKNESS / _SHEAR_MODULUS)
    impedance = dashpot * math.sqrt(_DENSITY * _SHEAR_MODULUS)
    face = {"kind": "machine", "stiffness": spring, "impedance": impedance, "mass": mass}
    slab = {"density": _DENSITY, "shear_modulus": _SHEAR_MODULUS, "thickness": _THICKNESS, "face": face}
    return _scene(row, fit, "ageing", slab)


def _scene(row: Mapping[str, Any], fit: np.ndarray, law: str, slab: Mapping[str, Any]) -> sw.Scene:
    """A run between alike slabs; `fit`: a, b and L (um)."""
    a, b, length = fit.tolist()
    interface = {"law": law, "a_star": 0.6, "a": a, "b": b, "memory_length": length * 1e-6}
    interface |= {"normal_stress": row["sigma_MPa"] * 1e6, "reference_velocity": 1e-6}
    drive, start = {"velocity": 10.0}, {"size": _START}
    return sw.read_scene({"name": "laboratory", "interface": interface, "slab": slab, "drive": drive, "start": start})


def _cycle_in_run(
    scene: sw.Scene, model: str, seconds: float, after: float = 0.5, tolerance: float = _TOLERANCE
) -> MeasuredCycle | None:
    """The last complete cycle, beginning `after` this share, of a run of `seconds`; None if there is none, or if the slip rate
    stays below twice V: steady sliding, now or later."""
    assert scene.units
    transit = scene.units.size("transit", scene.transit)
    until = seconds / transit
    events = sw.run(scene, model, until=until, tol=tolerance).records.watch.events(after * until)
    if events.time.size == 0 or events.v_max[-1] <= 2.0 * scene.velocity:
        return None
    peak = 1e3 * events.v_max[-1] * scene.units.reference_velocity
    return {"period": events.period[-1] * transit, "drop": events.stress_drop[-1], "peak": peak}


def _cycles_of_samples(row: Mapping[str, Any], law: str, drawn: Iterable[tuple[np.ndarray, float]]) -> list[MeasuredCycle | None]:
    """A cycle of the plain block for each of the samples; None where it slides steadily."""
    return [
        _cycle_in_run(_plain_block(row, fit, law, factor), "quasidynamic", _CYCLES * row["T_s"])
        if fit[1] > fit[0] > 0.0
        else None
        for fit, factor in drawn
    ]


def _cycle_without_tuning(row: Mapping[str, Any], fit: np.ndarray) -> MeasuredCycle | None:
    """The cycle of the plain block with a printed fit, ageing law."""
    return _cycle_in_run(_plain_block(row, fit, "ageing"), "quasidynamic", 2.0 * _CYCLES * row["T_s"], after=0.7)


def _rise_of(normal_stress: float, weakening: float, velocity: float) -> tuple[float, float]:
    """Drop (MPa) and rise time (ms) of the last slip event of a metre of gabbro on the machine of Togo et al. (2015), exact
    waves. `normal_stress` in MPa, b - a, V in mm/s."""
    togo = laboratory()["togo-2015"]
    stiffness, mass = 153e6, float(togo["mass_kg_per_m2"])
    slab = {"density": 2980.0, "shear_modulus": 3.9e10, "thickness": 0.2}
    face = {"kind": "machine", "stiffness": stiffness, "impedance": 0.0, "mass": mass}
    interface = {"law": "ageing", "a_star": 0.7, "a": 0.01, "b": 0.01 + weakening}
    interface |= {"normal_stress": normal_stress * 1e6, "memory_length": 1e-6, "reference_velocity": 1e-6}
    tables = {"interface": interface, "upper": slab | {"face": face}, "lower": slab, "drive": {"velocity": 1e3 * velocity}}
    scene = sw.read_scene({"name": "gabbro", "start": {"size": _START}, **tables})
    assert scene.units
    transit = scene.units.size("transit", scene.transit)
    until = 120.0 * weakening * normal_stress * 1e6 / stiffness / (1e-3 * velocity) / transit  # some periods
    run = sw.run(scene, "delay", until=until, tol=1e-6, window=(0.4 * until, until))
    history, date = history_of(run), run.done.events.time[-1]
    near = np.abs(transit * (history["time"] - date)) <= 0.1  # s
    drop = run.done.events.elastic_stress_drop[-1] * normal_stress
    return (drop, 1e3 * transit * _rise_time(history["time"][near], history["elastic_stress"][near]))


def _rise_time(time: np.ndarray, elastic: np.ndarray) -> float:
    """The time in which the elastic stress falls from 90 % to 10 % of its drop, over 0.590, the share of this time in half a
    period of free vibration."""
    top = int(np.argmax(elastic))
    bottom = top + int(np.argmin(elastic[top:]))
    share = (elastic[top:bottom] - elastic[bottom]) / (elastic[top] - elastic[bottom])
    begin, end = (top + int(np.flatnonzero(share > level)[-1]) for level in (0.9, 0.1))
    return float(time[end] - time[begin]) / ((math.acos(-0.8) - math.acos(0.8)) / math.pi)


_BEFORE = 1.0  # s of steady sliding
_FAR = np.array([1.5, 1.2, 3.0])  # times the printed values: where a fit begins
_OF_FIT = 1e-9
_BAR = 1e-5  # relative error of a fitted value: printed digits in the tail of a step leave some 1e-6


def _fitted_to(row: Mapping[str, Any]) -> tuple[float, np.ndarray]:
    """The largest residual of quasi-static friction fitted to a printed series from distant start values, and the fitted
    parameters over the true ones; friction is the shear stress over 1 MPa."""
    true = np.array([row["a"], row["b"], row["Dc_um"]])
    block = _plain_block({**row, "sigma_MPa": 1.0}, _FAR * true, row["law"])
    begin = f"{_BEFORE} s"
    steps = [["0 s", "1 um/s"], [begin, "1 um/s"], [begin, f"{row['velocity']} um/s"]]
    samples = [(0.0, 0.6), *((_BEFORE + time, friction) for time, friction in zip(row["time_s"], row["friction"], strict=True))]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "printed.csv"
        file.write_text("time [s],friction\n" + "".join(f"{time!r},{friction!r}\n" for time, friction in samples))
        scene, free = sw.read(block, {"drive.velocity": steps, "start.size": 0.0}), ["a", "b", "memory_length"]
        summary = sw.fit(scene, data=[str(file)], free=free, model="quasistatic", tol=_OF_FIT).summary
    a, b, length = (parameter["value"] for parameter in summary["parameters"].values())
    return summary["residual"]["largest"], np.array([a, b, 1e6 * length]) / true


def _program_verdicts(row: Mapping[str, Any], apart: float, ratios: np.ndarray) -> Verdicts:
    """Verdicts on the agreement of the motion and of the parameters."""
    name = f"{row['program']}, {row['law']} law, step to {row['velocity']:g} V*"
    title = "Fitted quasi-static friction is what rsfmodel and Marone's program print, within one unit of the last digit"
    yield claim(title, WITNESS, apart * 10.0 ** row["digits"], 1.0, f"{name}: {len(row['friction'])} values")
    worst = np.abs(ratios - 1.0).max()
    title = "A fit of what these programs print gives back their a, b and L"
    yield claim(title, WITNESS, worst, _BAR, f"{name}: relative; begun 1.5, 1.2 and 3 times as large")

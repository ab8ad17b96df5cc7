"""The tables, figures and captions of the study."""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from validation.references.published import laboratory
from validation.studies.laboratory.measured import MeasuredCycle, Rise, leeman_runs
from validation.study import Cell, Table, table
from validation.study.drawing import Drawing, canvas, subplots

LAWS = ("ageing", "slip")
NAMES = ("period", "drop", "peak")
_SHOWN = {"period": "period / s", "drop": "drop of friction", "peak": "peak slip rate / (mm/s)"}
SCATTER = {"period": 0.05, "drop": 0.05, "peak": 0.15}
"""Relative scatter of measured figures from event to event."""
_COLORS = {"ageing": "#0072b2", "slip": "#d55e00"}


class Band(NamedTuple):
    """Median and 95 % range of a figure over the samples that stick and slip; NaN where fewer than three do."""

    low: float
    median: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a measured value lies in the range."""
        return self.low <= value <= self.high


class Case(NamedTuple):
    """A run of the experiment and the samples of one law: the share of them that stick and slip, their bands, and how many
    meet period, drop and peak slip rate at once."""

    row: Mapping[str, Any]
    law: str
    slips: float
    bands: dict[str, Band]
    meets: int


class Variant(NamedTuple):
    """A run of the experiment under a law or a damping called `name`: its cycle, or None where it slides steadily."""

    row: Mapping[str, Any]
    name: str
    cycle: MeasuredCycle | None


def measured_figure(row: Mapping[str, Any], name: str) -> float:
    """The measured figure of a run."""
    return float(row[{"period": "T_s", "drop": "drop", "peak": "peak_mm_s"}[name]])


def table_of_cases(cases: Sequence[Case]) -> Table:
    """Measured figures, and those of the samples."""
    titles = (("T", " [s]"), ("drop", ""), ("peak", " [mm/s]"))
    figures = (f"{title} measured{unit} .3g | median{unit} .3g | from{unit} .3g | to{unit} .3g" for title, unit in titles)
    found: list[list[Cell]] = []
    for case in cases:
        ranges = (_with_band(measured_figure(case.row, name), case.bands[name]) for name in NAMES)
        found.append([float(case.row["sigma_MPa"]), case.law, 100.0 * case.slips, *chain.from_iterable(ranges)])
    return table("leeman", _CASES, " | ".join(["σ [MPa] .0f | law | slips [%] .0f", *figures]), found)


def _with_band(measured: float, band: Band) -> list[float]:
    return [measured, band.median, band.low, band.high]


def table_of_waves(waves: Sequence[tuple[str, MeasuredCycle | None]]) -> Table:
    """A row for each model."""
    cells = ((name, *(one or (None, None, None))) for name, one in waves)
    return table("waves", _WAVES, "model | T [s] .5g | drop .4g | peak slip rate [mm/s] .4g", cells)


def table_of_variants(varied: Sequence[Variant]) -> Table:
    """Cycles with other laws and dampings, and the measured ones."""
    found: list[list[Cell]] = [[float(row["sigma_MPa"]), name, *(one or (None, None, None))] for row, name, one in varied]
    for row in {id(one.row): one.row for one in varied}.values():
        found.append([float(row["sigma_MPa"]), "measured", *(measured_figure(row, name) for name in NAMES)])
    return table("cutoff", _VARIED, "σ [MPa] .0f | law | T [s] .4g | drop .3g | peak slip rate [mm/s] .3g", found)


def table_of_rises(rises: Sequence[Rise]) -> Table:
    """A row for each event."""
    return table("togo", _RISES_TABLE, "σ [MPa] .2f | b − a .3f | V [mm/s] .1f | drop [MPa] .3f | rise time [ms] .2f", rises)


def draw_cases(cases: Sequence[Case]) -> Drawing:
    """Measured values with their scatter and the ranges of the laws."""
    figure = canvas(9.0, 3.6)
    for axes, name in zip(figure.subplots(1, 3), NAMES, strict=True):
        for law, aside in zip(LAWS, (-0.15, 0.15), strict=True):
            own = [case for case in cases if case.law == law]
            stress = [case.row["sigma_MPa"] + aside for case in own]
            low, median, high = (np.array(side) for side in zip(*(case.bands[name] for case in own), strict=True))
            ends, label = [median - low, high - median], f"{law} law, median and 95 %"
            axes.errorbar(stress, median, ends, fmt="_", color=_COLORS[law], linewidth=2.5, alpha=0.7, label=label)
        values = np.array([measured_figure(row, name) for row in leeman_runs()])
        axes.errorbar(
            [row["sigma_MPa"] for row in leeman_runs()],
            values,
            SCATTER[name] * values,
            fmt="o",
            color="#111111",
            markersize=4,
            label="measured",
        )
        axes.set(xlabel="normal stress / MPa", ylabel=_SHOWN[name], ylim=(0, None))
    axes.set(yscale="log", ylim=(0.01, 60))
    figure.axes[0].legend(fontsize="small", loc="lower right")
    return figure


def draw_rises(rises: Sequence[Rise]) -> Drawing:
    """Rise times over stress drops."""
    figure, axes = subplots(2.8, x="stress drop / MPa", y="rise time / ms")
    low, high = laboratory()["togo-2015"]["rise_time_ms"]
    axes.axhspan(low, high, color="#cccccc", linewidth=0.0, label="measured")
    drops = [one.drop for one in rises]
    axes.plot(drops, [one.time for one in rises], "o", color="#0072b2", markersize=4, label="exact waves, machine of 153 MPa/m")
    axes.set(ylim=(0, 25), xlim=(0, None))
    axes.legend(fontsize="small", loc="lower right")
    return figure


_SAMPLED = (
    "a, b and L from the three fits that are printed for the largest displacement, within their standard deviations, "
    "independent of each other because no correlation is printed; k' as printed with 5 % (our assumption)"
)
LEEMAN = (
    "Leeman and others (2016), double direct shear of quartz powder. Points: measured (bars: scatter from event to event; drop: "
    f"k' V times the time between events). Bars in colour: spring and block with radiation damping; {_SAMPLED}."
)
_CASES = f"The same in numbers: share of samples that stick and slip, and of those the median and the 95 % range. {_SAMPLED}."
_WAVES = (
    "The run at 10 MPa with the third fit, ageing law. One transit of 5 cm of steel and back lasts 32 μs, the event 0.4 s. A "
    "dashpot of the impedance of steel at the outer face absorbs the waves; without it they stay, and nothing takes energy away "
    "but friction."
)
_VARIED = (
    "The third fit, ageing law, with the state effect cut off above V_{c}: b ln(1 + θV_{c}/L), and with the damping of Gualandi "
    "and others (2023), 20 to 35 times that of a plain block. Empty: slides steadily. Both lower the peak slip rate, and with it "
    "drop and period."
)
_RISES_TABLE = (
    "Two slabs of gabbro, 20 cm each, on a machine of 153 MPa/m and the mass per area that follows from the measured mean of "
    "17.7 ms; exact waves, ageing law, a 0.01, L 1 μm. Rise time: from 90 % to 10 % of the elastic stress drop, over the share "
    "of half a "
    "period that this takes in free swinging."
)
TOGO = (
    "Togo and others (2015): rise time over drop. The mass follows from the measured rise time, so only its independence is "
    "tested."
)

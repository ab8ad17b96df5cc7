"""The period of stick-slip over the delay r, the paper's Fig 8: orbits, stable or not, and means where none is stable."""

from collections.abc import Mapping
from typing import NamedTuple

from validation.chart import ORANGE, Chart, Look, Panel, Scale, Trace
from validation.chart.looks import model_line, model_look
from validation.measure.cycle import Estimate
from validation.measure.over_r import FAR, Branch, branch_of
from validation.measure.regimes import Regime
from validation.references.published import reference
from validation.report import Number, Verdicts, minus, stated
from validation.report.branch_drawing import orbit_traces
from validation.report.known import as_known, numbered_period, order_of_periods

WAVES, BLOCKS = ("kelvin-voigt", "delay"), ("block8", "block12")
"""Models with reverberations, whose orbits lose stability; blocks, whose orbits are all stable."""
_PRINTED = -2.68  # log10 r whose periods `one-cycle` compares


class _Periods(NamedTuple):
    """A model at one r (transits): periods of its `orbits` on the branch, stable or not; the period of its run's orbit, or its
    mean over so many `cycles`; and as a number that of the first orbit that is known."""

    orbits: list[float]
    seen: Estimate
    cycles: int
    number: Number | None

    @property
    def every(self) -> list[float]:
        """All periods, the seen one with two of its errors."""
        return self.orbits + [self.seen.value + share * self.seen.error for share in (-2.0, 2.0)]


ByModel = Mapping[str, Mapping[float, _Periods]]
"""model -> log10 r -> its periods."""


def branches_of(ode: float, longest: float) -> dict[str, Branch]:
    """The branches of the paper's ODE, up to this log10 r, and of the exact system, up to the `longest` period (transits)."""
    return {"kelvin-voigt": branch_of("kelvin-voigt", ode, FAR), "delay": branch_of("delay", -2.3, longest)}


def _periods_at(model: str, log10_r: float, branches: Mapping[str, Branch], regime: Regime) -> _Periods:
    """The periods of a model of Fig 8, from its branch, if it has one, and from its `regime` there."""
    orbits, seen = branches[model].orbits_at(log10_r) if model in branches else [], regime.figures["T"]
    alone = None if regime.cycles else stated(seen.value, seen.error)
    return _Periods(
        [closed.cycle.period for closed in orbits], seen, regime.cycles, numbered_period(orbits[0]) if orbits else alone
    )


def periods_of(branches: Mapping[str, Branch], regimes: Mapping[str, Mapping[float, Regime]]) -> ByModel:
    """The periods of all models of Fig 8 at every r of the table."""
    return {
        model: {log10_r: _periods_at(model, log10_r, branches, regime) for log10_r, regime in regimes[model].items()}
        for model in (*WAVES, *BLOCKS)
    }


def period_verdicts(periods: ByModel) -> Verdicts:
    """P7 over the whole range of r, and the periods of other programs at all r but the one of `one-cycle`."""
    listed = {log10_r: {model: by_r[log10_r].every for model, by_r in periods.items()} for log10_r in periods["delay"]}
    yield order_of_periods(listed, "all orbits known at an r, stable or not, and means of runs with two standard errors")
    for model, by_r in periods.items():
        for log10_r, place_periods in by_r.items():
            if log10_r != _PRINTED and place_periods.number:
                yield from as_known(
                    "Periods over r are those of other programs", model, log10_r, {"period": place_periods.number.value}
                )


def period_numbers(periods: ByModel, places: tuple[float, ...]) -> dict[str, Number]:
    """Periods of orbits at these r."""
    stored = ((model, x, periods[model][x].number) for model in (*WAVES, "block12") for x in places)
    return {f"{model} T at {x}": number for model, x, number in stored if number}


def period_answer(periods: ByModel) -> str:
    """How the period depends on r."""
    first = min(periods["delay"])
    apart = max(periods["block12"][first].every) / min(periods["kelvin-voigt"][first].every) - 1.0
    return (
        f"The period grows with r, fastest near the onset, where models agree within {100 * apart:.0f} % at log_{{10}} r = "
        f"{minus(f'{first:g}')}; further on that of the paper’s ODE hardly grows, that of blocks too much, and the exact one "
        "lies between them."
    )


CAPTION = (
    "Period of stick-slip over r. Orbits of the delay system and of the ODE by continuation from the Hopf point, stable ones "
    "solid, unstable ones dotted; circles: means of runs with two standard errors, where no orbit is stable; crosses: as printed."
)
_TICKS = {float(tick): str(tick) for tick in (50, 60, 70, 80, 90, 100, 120, 140)}
_LOWEST, _HIGHEST = 47.0, 145.0


def over_r(branches: Mapping[str, Branch], periods: ByModel) -> Chart:
    """Branches, blocks, means and the paper's values."""
    traces = [trace for branch in branches.values() for trace in orbit_traces(branch, "period")]
    traces += [model_line(model, [*periods[model]], [drawn.seen.value for drawn in periods[model].values()]) for model in BLOCKS]
    for model in WAVES:
        shown = {x: drawn.seen for x, drawn in periods[model].items() if drawn.cycles}
        look, bars = (
            model_look(model, dashes="", marker="o", size=4.0, hollow=True),
            [2.0 * estimate.error for estimate in shown.values()],
        )
        traces.append(Trace(f"{model}, means", [*shown], [estimate.value for estimate in shown.values()], look, y_error=bars))
    paper = reference()["paper"]
    printed = [_PRINTED, _PRINTED], [paper["T_ode"], paper["T_dde"]]
    traces.append(Trace("the paper’s values", *printed, Look(ORANGE, "", "x", size=7.0)))
    scales = Scale(r"$\log_{10} r$"), Scale("$T$ (transits)", "log", (_LOWEST, _HIGHEST), _TICKS)
    return Chart([Panel("", *scales, traces, grid=True)], 4.4, legend="outside upper left", legend_columns=3)

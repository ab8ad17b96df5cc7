"""The paper's claims that runs and closed forms decide, and its scene; those about whole branches are judged in `bifurcation`."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

import slipwave as sw
from validation.chart import ORANGE, Chart, Look, Panel, Scale, Trace
from validation.chart.looks import model_line
from validation.measure import memo
from validation.measure.cycle import Events, Orbit, history_of, one_cycle, ripple_period
from validation.references.onset import FAST_PERIOD_KELVIN_VOIGT, onset_of
from validation.references.published import half_digit, reference
from validation.report import (
    ASYMPTOTIC,
    EXACT,
    PAPER,
    Answers,
    Budget,
    Figure,
    Number,
    Omission,
    Outcome,
    StudyResult,
    Table,
    Verdict,
    Verdicts,
    at_least,
    claim,
    holding,
    in_range,
    minus,
    stated,
    table,
)
from validation.report.known import as_known, error_of, order_of_periods, range_of_r, rounding
from validation.report.names import by_claim

NAME = "claims"
QUESTION = "Which of the paper’s claims hold?"
SCENES = ("paper", "paper-si", "rock", "paper-2.3")
SECONDS = (8.0, 16.0)

MODELS = ("delay", "kelvin-voigt", "block8", "block12")
WAVES = MODELS[:2]
DEEP = -2.3
LONGEST = 12
"""Most cycles of a periodic orbit in `recurrence`."""
SHOWN = (1000.0, 1420.0)
"""Transits of a long run, after its transient, that are drawn."""
RESTLESS = 1e-6
"""Relative difference of cycles above which an orbit is not compared."""

_OPERATIONS = 4  # two roundings, twice in each of ε and r
_EPSILON_WITHIN = 5e-3 * 2.8e-5  # half a per cent
_TABLE_1 = {"density": 800.0, "shear_modulus": 1e6, "epsilon": 2.8e-5}
_VERY_SMALL, _ORDER_OF_TEN_PER_CENT = 1e-2, (0.1 / math.sqrt(10.0), 0.1 * math.sqrt(10.0))
_RIPPLES = 3e-4  # maxima between samples
_CLOSES = 2e-6  # sixteen samples a piece
_SHARE = 0.1  # power of the drop and of T ~ drop/(eps V)
_CONSTANT = 0.05  # spread of drops that is called nearly constant
_CONTRAST = {"period": 1.5, "stress_drop": 1.5, "v_max": 5.0}
"""Least ratios of the ODE's spread to the delay system's, which vary by chance."""
_IRREGULAR = 0.3  # of `recurrence`
_AFTER, _SLOW, _SAMPLES = 20.0, 12, 64  # transits from an event on, ripples, samples of each
_RATE = 768  # samples per transit of what is recorded
_RIPPLE = {"delay": 1.0, "kelvin-voigt": FAST_PERIOD_KELVIN_VOIGT}
_SINE = 0.05  # share of the power that may be in other than the sine

Orbits: TypeAlias = dict[float, dict[str, Orbit]]
"""log10 r, where all models have settled -> their orbits."""


History: TypeAlias = dict[str, np.ndarray]
"""The interface over a stretch of a run, by the names of `OneCycle`."""

_SOME, _ALL = (-2.695, -2.69, -2.685, -2.68, -2.67, -2.665, -2.66), tuple(round(-2.695 + 0.0025 * n, 4) for n in range(15))
"""log10 r from just beyond the onset to where the delay system's orbit loses stability (-2.6575)."""


def run(budget: Budget) -> StudyResult:
    """Settle orbits along the stable branch, run deep inside it, evaluate the closed forms."""
    along, until = budget.plan(quick=(_SOME, 6000.0), full=(_ALL, 16000.0))
    settled = {log10_r: _settled_at(log10_r) for log10_r in budget.each(along, end=0.6)}
    orbits = {log10_r: models for log10_r, models in settled.items() if models}
    runs = {model: _run_deep(model, until) for model in WAVES}
    events, motions = {model: own for model, (own, _) in runs.items()}, {model: own for model, (_, own) in runs.items()}
    ripples = {model: _measure_ripples(model) for model in WAVES}
    scenes = [sw.read(name) for name in SCENES[:3]]
    of_orbits = (*_orbit_claims(orbits), *_ripple_claims(ripples), *_stable_branch_claims(orbits))
    of_cycles = (*_load_claims(orbits, events["delay"], ripples), *_irregular_claims(events, motions))
    verdicts = (*_onset_claims(), *of_orbits, *of_cycles, *_scene_claims(*scenes[:2]))
    onset = _onset_at(100.0)
    numbers = {"r_c delay": onset["delay"], "r_c kelvin-voigt": onset["kelvin-voigt"], "omega_c": onset["omega_c"]}
    return StudyResult(
        answers=_answers(verdicts),
        figures=(
            Figure("irregular", _CAPTION, lambda: _irregular(motions), paper="Fig 9", carries=("P13 ",), zoom=True),
            Figure("planes", _PLANES, lambda: _slip_planes(motions), paper="Fig 9", carries=("P13 ",)),
        ),
        tables=(_groups(scenes),),
        verdicts=verdicts,
        notes=(_NUMBERED,),
        numbers={name: Number(value, 1e-12) for name, value in numbers.items()}
        | {
            f"{model} T at {r}": stated(models[model].period.value, models[model].period.error)
            for r, models in orbits.items()
            for model in WAVES
        },
        omissions=_OMISSIONS,
    )


def _answers(verdicts: tuple[Verdict, ...]) -> Answers:
    """The first counts the verdicts that it cites as the page does: the cases of one claim are one."""
    cited = (*(f"P{n} " for n in (*range(1, 8), 11, 12, 13)), "Periods are those of other programs")
    judged = [verdict for verdict in by_claim(NAME, verdicts) if verdict.claim.startswith(cited)]
    held, findings = (sum(verdict.outcome is kind for verdict in judged) for kind in (Outcome.PASS, Outcome.FINDING))
    paper = sw.read("paper")
    return {
        (
            f"On onset, periods, ripples and irregular cycles {held} of {len(judged)} checks hold and {findings} qualify a claim."
        ): cited,
        (
            "Two numbers govern the slabs, the impedance ratio ε and the round trip r, beside the drive V and friction: the "
            f"paper’s scene lies {100 * (paper.transit / _onset_at(100.0)['delay'] - 1.0):.1f} % beyond the onset of stick-slip."
        ): (
            "SI input and (ε, r) input",
            "Table 1’s paper material",
        ),
    }


_GROUPS = (
    "a, direct effect",
    "b, evolution effect",
    "V, drive [V*]",
    "ε = ρc V*/σ, slab impedance over frictional one",
    "r = (h/c)/(L/V*), wave round trip over state relaxation",
    "r_{∗}, quasi-static onset (22)",
    "r_{c}, exact onset (39)",
    "r_{c}, onset of the paper’s ODE (27)",
    "ω_{c}, frequency at onset [V*/L] (20)",
    "r/r_{c}, how far beyond onset",
)


def _groups(scenes: list[sw.Scene]) -> Table:
    columns = []
    for s in scenes:
        onset = onset_of(s.law, s.upper.epsilon, s.velocity)
        onsets = [onset[name] for name in ("quasistatic", "delay", "kelvin-voigt", "omega_c")]
        columns.append([s.law.a, s.law.b, s.velocity, s.upper.epsilon, s.transit, *onsets, s.transit / onset["delay"]])
    rows = zip(_GROUPS, *columns, strict=True)
    caption = (
        "The scenes in dimensionless groups. L: slip over which friction’s state renews itself; V*: reference rate; σ: normal "
        "stress; ρ, c: density and shear-wave speed of the slabs; h: thickness of both together."
    )
    return table("groups", caption, " | ".join(["group", *(f"{s.name} .6g" for s in scenes)]), rows)


def _irregular(motions: dict[str, History]) -> Chart:
    """Stress over time, one panel per model."""
    across, up = Scale("time (transits)", limits=SHOWN), Scale(r"$\mu$")
    lines = [model_line(model, own["time"], own["stress"], dashes="-", width=0.7) for model, own in motions.items()]
    return Chart([Panel(line.name, across, up, [line]) for line in lines], 3.6, share=("all", "all"))


def _slip_planes(motions: dict[str, History]) -> Chart:
    law: Any = sw.read("paper-2.3").law
    panels = []
    for model, own in motions.items():
        line = model_line(model, own["slip_rate"], own["stress"], dashes="-", width=0.5)
        rate = np.geomspace(own["slip_rate"].min(), own["slip_rate"].max(), 50)
        steady = Trace("steady sliding", rate, law.a_star + (law.a - law.b) * np.log(rate), Look(ORANGE, "--"))
        panels.append(Panel(line.name, Scale("$v/V^*$", "log"), Scale(r"$\mu$"), [line, steady]))
    return Chart(panels, 3.4, len(panels), share=("all", "all"))


_NUMBERED = (
    "P1, P2 ... number the claims of the paper in their order there. The *friction clock* counts time in L/V*, the *transit "
    "clock* t~ = t/r in round trips of a wave through one slab. Periods are in transits unless stated otherwise; stress is in "
    "units of σ, rates are in units of V*."
)
_PLANES = "The same cycles in the plane of stress and slip rate (the paper’s Fig 9); dashed: steady sliding."
_CAPTION = (
    "Stress at log_{10} r = −2.3 over some cycles (the paper’s Fig 9): the stress drops of the delay system vary little, but "
    "its ripples are no longer sinusoidal and change shape from cycle to cycle; the paper’s ODE is irregular. μ in units of σ, "
    "time in transits."
)
_BRANCHES = "Judged by the study `bifurcation`, on branches."
_OMISSIONS = (
    *(Omission(f"{name}, on orbits stable or not.", _BRANCHES, (f"{name} ",)) for name in ("P8", "P9", "P10", "P14")),
    Omission(
        "P7 and P11 beyond log_{10} r = −2.66.",
        "The delay system’s orbit loses stability there; runs then show a torus, not the orbit.",
        ("Special points are where", "Beyond the first torus point a direct run does not settle"),
    ),
)


def _scene_claims(paper: sw.Scene, same: sw.Scene) -> Verdicts:
    """The scene in SI is that in epsilon and r; Table 1."""
    gap = max(abs(same.upper.epsilon / paper.upper.epsilon - 1), abs(same.transit / paper.transit - 1))
    yield claim("SI input and (ε, r) input give the same scene", EXACT, gap, rounding(_OPERATIONS))
    printed = math.sqrt(_TABLE_1["density"] * _TABLE_1["shear_modulus"]) * 1e-6 / 1e3
    title = "Table 1’s paper material has the ε that the paper computes with"
    remark = "ρ = 800 kg/m³ as printed gives 1 % more; the scenes here use ε = 2.8 · 10^{-5}, that is ρ = 784 kg/m³"
    within, near = 1e5 * _EPSILON_WITHIN, 1e5 * _TABLE_1["epsilon"]
    yield claim(title, PAPER, 1e5 * printed, within, remark, near=near, unit="· 10^{−5}")


def _settled_at(log10_r: float) -> dict[str, Orbit]:
    """Every model's orbit from the scene's own nudge; empty if one of them does not settle."""
    settled = {model: memo.settled(model, sw.read("paper", {"slab.log10_r": log10_r})) for model in MODELS}
    if any(motion.unrest > RESTLESS for motion in settled.values()):
        return {}
    return {model: motion.orbit for model, motion in settled.items()}


def _run_deep(model: str, until: float) -> tuple[Events, History]:
    """A run of `model` at log10 r = -2.3 to `until` (transits): its cycles after the transient, and a stretch of it."""
    run = sw.run("paper-2.3", model, until=until, tol=1e-9, window=SHOWN, rate=_RATE)
    return run.records.watch.events(SHOWN[0]), history_of(run)


def _measure_ripples(model: str) -> dict[str, float]:
    """Of one cycle of the model's orbit at log10 r = -2.68, in transits: the period of its ripples; its own period and the parts
    of that: the elastic drop over epsilon V, the time in which the elastic stress falls (v > V), and the slip while it rises,
    over V; for y' = eps (V - v), so that y rises by eps (V t_rise - s_rise)."""
    scene = sw.read("paper")
    settled = memo.settled(model, scene, 1e-10, 1e-9)
    cycle, orbit = one_cycle(settled, per_piece=16), settled.orbit
    since = np.mod(cycle.time - cycle.time[np.argmin(cycle.elastic_stress)], orbit.period.value)
    order = np.argsort(since)
    rises = order[: int(np.argmax(cycle.elastic_stress[order])) + 1]
    slip = np.trapezoid(cycle.slip_rate[rises], since[rises]) / scene.velocity
    falling = orbit.period.value - np.ptp(since[rises])
    drop = orbit.elastic_stress_drop.value / _load_rate()
    return {"ripple": ripple_period(cycle), "period": orbit.period.value, "drop": drop, "falling": falling, "slipped": slip}


def _onset_at(velocity: float) -> dict[str, float]:
    """Closed forms of the paper's material at drive `velocity` (V*)."""
    scene = sw.read("paper")
    return onset_of(scene.law, scene.upper.epsilon, velocity)


def _spread_of(values: np.ndarray) -> float:
    """Standard deviation over mean."""
    return float(np.std(values) / np.mean(values))


def _recurrence(values: np.ndarray) -> float:
    """Measure of how far a sequence is from periodic: root mean square of x_(n + k) - x_n over sqrt(2) times the standard
    deviation, the least over k up to 12. 0 for every orbit of up to 12 cycles, about 1 for a sequence without memory."""
    if np.std(values) < RESTLESS * np.max(np.abs(values)):
        return 0.0
    steps = [np.sqrt(np.mean((values[k:] - values[:-k]) ** 2)) for k in range(1, LONGEST + 1)]
    return float(min(steps) / (np.std(values) * 2.0**0.5))


def _onset_claims() -> Verdicts:
    """P1 and P2, by closed forms; `onset` compares these with roots."""
    onsets = [math.log10(_onset_at(100.0)[model]) for model in WAVES]
    paper = reference()["paper"]["log10_r_c"]
    title = "P1 Delay system and ODE share ω_{c}; both r_{c} are close to 10^{-2.6996} at V = 100"
    both = minus(", ".join(f"{value:.7f}" for value in onsets))
    away, digit = max(abs(value - paper) for value in onsets), 2.0 * half_digit(paper)
    yield holding(title, PAPER, minus(f"{paper} ± {digit:.4f}"), both, away < digit, "log_{10} r_{c}").with_margin(away, digit)
    # P2, which the paper's Fig 2 shows: the largest error up to V = 10^3, and that at V = 10^4
    slow, fast = (abs(onset["kelvin-voigt"] / onset["delay"] - 1.0) for onset in map(_onset_at, (1e3, 1e4)))
    small = "read as: below a tenth of the error that is claimed for V = 10^{4}"
    yield claim("P2 the error of (27) is very small for V < 10^{3}", PAPER, slow, _VERY_SMALL, small)
    large = "read as: nearer to 10 % than to 1 % or 100 %, on a logarithmic scale"
    yield in_range("P2 it grows to the order of 10 % at V = 10^{4}", PAPER, _ORDER_OF_TEN_PER_CENT, [fast], large, ".1%")


def _as_printed(title: str, printed: float, ours: float) -> Verdict:
    """Verdict on a number of the paper: half of its last digit is allowed."""
    off, half = abs(ours - printed), half_digit(printed)
    return holding(title, PAPER, f"{printed:g} ± {half:g}", f"{ours:.5f}", off <= half).with_margin(off, half)


def _orbit_claims(orbits: Orbits) -> Verdicts:
    """P3 and P4, and the digits known from other programs."""
    paper, here = reference()["paper"], orbits[-2.68]
    yield _as_printed("P3 Period of the ODE at r = 10^{-2.68}", paper["T_ode"], here["kelvin-voigt"].period.value)
    yield _as_printed("P4 Period of the delay system at r = 10^{-2.68}", paper["T_dde"], here["delay"].period.value)
    for model, orbit in here.items():
        yield from as_known(
            "Periods are those of other programs", model, -2.68, {"period": orbit.period.value}, error_of(orbit.period)
        )


def _ripple_claims(ripples: dict[str, dict[str, float]]) -> Verdicts:
    """P5."""
    ode, delay = ripples["kelvin-voigt"]["ripple"], ripples["delay"]["ripple"]
    title = "P5 Period of the fast ripples: π/√6 transits in the ODE, exactly one in the delay system"
    off = max(abs(ode / FAST_PERIOD_KELVIN_VOIGT - 1.0), abs(delay - 1.0))
    measured = f"relative; measured on the orbits: {ode:.5f} for {FAST_PERIOD_KELVIN_VOIGT:.5f}, and {delay:.5f}"
    yield claim(title, EXACT, off, _RIPPLES, measured)
    yield replace(_as_printed(title, reference()["paper"]["ripples_ode"], ode), remark="the ODE’s by (43), in transits")
    slip = "frequency of the ODE’s: the text’s “about 28 % too high” is a mistake; the period is 28 % too long, the frequency low"
    yield claim(title, PAPER, 100.0 * (delay / ode - 1.0), 0.5, slip, near=28.0, unit="%")


def _stable_branch_claims(orbits: Orbits) -> Verdicts:
    """P6, P7 and P11 on orbits on which runs settle."""
    figures = {r: {model: orbit.values() for model, orbit in by_model.items()} for r, by_model in orbits.items()}
    where, here = range_of_r(list(orbits)), figures[-2.68]
    off = {model: {name: abs(figures[name] / here["delay"][name] - 1.0) for name in figures} for model, figures in here.items()}
    symbols = {"period": "T", "elastic_stress_drop": "Δy", "stress_drop": "Δμ"}
    closer = {symbol: off["block8"][name] < off["block12"][name] for name, symbol in symbols.items()}
    text = ", ".join(f"{symbol} {'yes' if yes else 'no'}" for symbol, yes in closer.items())
    yield holding(
        "P6 The ρh/8 block lies closer to the exact orbit than ρh/12",
        PAPER,
        "perhaps",
        text,
        all(closer.values()),
        "at r = 10^{-2.68}",
    )
    yield order_of_periods(
        {r: {model: [own["period"]] for model, own in by_model.items()} for r, by_model in figures.items()},
        "where runs of all four models settle: from just beyond the onset to where the exact orbit loses stability. The paper "
        "claims it for the whole primary branch",
    )
    gaps = {
        symbol: [1.0 - by_model["kelvin-voigt"][name] / by_model["delay"][name] for by_model in figures.values()]
        for name, symbol in (("stress_drop", "Δμ"), ("elastic_stress_drop", "Δy"))
    }
    exceed = all(min(gap) > 0.0 for gap in gaps.values())
    grows = {symbol: all(later > sooner for sooner, later in pairwise(gap)) for symbol, gap in gaps.items()}
    growth = [f"{symbol} {'grows' if yes else 'does not grow steadily'}" for symbol, yes in grows.items()]
    listed = "; ".join(f"{symbol} {', '.join(f'{100 * value:.1f}' for value in gap)} %" for symbol, gap in gaps.items())
    yield holding(
        f"P11 Stress drops of the delay system exceed the ODE’s, by a relative gap that grows with r, {where}",
        PAPER,
        "larger, gap grows",
        "; ".join(["larger" if exceed else "not larger", *growth]),
        exceed and all(grows.values()),
        f"relative gaps along r: {listed}",
    )


def _load_claims(orbits: Orbits, events: Events, ripples: dict[str, dict[str, float]]) -> Verdicts:
    """P12: the identity, whether periods are proportional to drops, and whether they are nearly equal deep inside, where the
    delay system has these `events`."""
    off = max(abs((part["drop"] + part["falling"] + part["slipped"]) / part["period"] - 1.0) for part in ripples.values())
    text = "relative, both systems at r = 10^{{-2.68}}; delay system: "
    text += "{period:.2f} = {drop:.2f} + {falling:.2f} + {slipped:.2f} transits"
    title = "P12 The period is Δy/(εV) + (time in which y falls) + (slip while y rises)/V"
    yield claim(title, EXACT, off, _CLOSES, text.format(**ripples["delay"]))
    exact = [by_model["delay"] for by_model in orbits.values()]
    periods, drops = (np.array([getattr(orbit, name).value for orbit in exact]) for name in ("period", "elastic_stress_drop"))
    power, shares = np.polyfit(np.log(drops), np.log(periods), 1)[0], drops / _load_rate() / periods
    yield claim(
        "P12 The period is proportional to the elastic drop: T ~ Δy/((ε/r) V) along the branch",
        PAPER,
        power,
        _SHARE,
        f"power of Δy; delay system; Δy/(εV) is {100 * shares[0]:.0f} % of T at the smallest r and "
        f"{100 * shares[-1]:.0f} % at the largest, "
        f"{range_of_r(list(orbits))}",
        near=1.0,
    )
    period = float(np.mean(events.period))
    share = float(np.mean(events.elastic_stress_drop)) / _load_rate() / period
    most = 1.0 - 1.0 / period  # an event lasts until its wave is back, which is one transit
    yield holding(
        "P12 T ~ Δy/((ε/r) V) to within a tenth, deep inside the stick-slip domain",
        ASYMPTOTIC,
        f"Δy/(εVT) from {1.0 - _SHARE:.2f} to {most:.3f}",
        f"{share:.3f}",
        1.0 - _SHARE < share < most,
        f"delay system, means over {events.period.size} cycles at log_{{10}} r = −{-DEEP:g}; an event takes at least one transit",
        otherwise=Outcome.FINDING,
    ).with_margin(abs(share - 0.5 * (1.0 - _SHARE + most)), 0.5 * (most - 1.0 + _SHARE))


def _load_rate() -> float:
    """epsilon V, the rate of loading at v = 0 on the transit clock."""
    scene = sw.read("paper")
    return float(scene.upper.epsilon * scene.velocity)


def _overtones(dates: np.ndarray, motion: History, ripple: float) -> np.ndarray:
    """In the slow phase of each recorded cycle, the share of the ripples' power that is not a sine of period `ripple` (transits):
    of the stress over `_SLOW` such periods, without its cubic trend."""
    shares = []
    for date in dates[(dates > motion["time"][0]) & (dates + _AFTER + _SLOW * ripple < motion["time"][-1])]:
        time = date + _AFTER + ripple * np.arange(_SLOW * _SAMPLES) / _SAMPLES
        stress = np.interp(time, motion["time"], motion["stress"])
        turn = 2.0 * np.pi * (time - date) / ripple
        basis = np.column_stack([np.vander((time - time.mean()) / np.ptp(time), 4), np.sin(turn), np.cos(turn)])
        weights = np.linalg.lstsq(basis, stress, rcond=None)[0]
        rest, sine = np.mean((stress - basis @ weights) ** 2), 0.5 * (weights[4:] @ weights[4:])
        shares.append(rest / (rest + sine))
    return np.array(shares)


def _irregular_claims(events: dict[str, Events], motions: dict[str, History]) -> Verdicts:
    """P13: the ODE's cycles neither repeat nor keep their size; the delay system's vary little in comparison."""
    ode, delay = events["kelvin-voigt"], events["delay"]
    recurrences = [_recurrence(values) for values in (ode.period, ode.stress_drop, np.log(ode.v_max))]
    ratios = {name: _spread_of(getattr(ode, name)) / _spread_of(getattr(delay, name)) for name in _CONTRAST}
    yield at_least(
        "P13 At r = 10^{-2.3} the ODE is irregular",
        PAPER,
        min(recurrences),
        _IRREGULAR,
        f"least distance of {ode.period.size} cycles from repeating after up to {LONGEST} cycles, in T, Δμ and "
        "ln v_{max}: 0 for a periodic orbit, 1 for a sequence without memory",
    )
    title = "P13 At r = 10^{-2.3} the delay system’s stress drops are nearly constant"
    over = f"standard deviation over mean, {delay.period.size} cycles"
    yield claim(title, PAPER, _spread_of(delay.stress_drop), _CONSTANT, over)
    yield holding(
        "P13 At r = 10^{-2.3} the ODE’s drops, periods and events vary more than the delay system’s",
        PAPER,
        ", ".join(f"{times:g}" for times in _CONTRAST.values()) + " times or more",
        ", ".join(f"{value:.1f}" for value in ratios.values()) + " times",
        all(ratios[name] > times for name, times in _CONTRAST.items()),
        "spreads (standard deviation over mean) of T, Δμ and v_{max}; largest v_{max} "
        f"{ode.v_max.max():.0e} against {delay.v_max.max():.0e} V*",
    ).with_margin(max(times / ratios[name] for name, times in _CONTRAST.items()), 1.0)
    rest = {model: _overtones(events[model].time, motions[model], period) for model, period in _RIPPLE.items()}
    most, least = max(rest["kelvin-voigt"], default=math.inf), min(rest["delay"], default=0.0)
    yield holding(
        "P13 At r = 10^{-2.3} the ODE’s ripples remain sinusoidal, the delay system’s have new structures",
        PAPER,
        f"below and above {100 * _SINE:g} %",
        f"{100 * most:.1f} % at most and {100 * least:.1f} % at least",
        most < _SINE < least,
        f"share of the ripples’ power outside the sine of their period, in the slow phases of {rest['kelvin-voigt'].size} and "
        f"{rest['delay'].size} cycles",
    ).with_margin(max(most / _SINE, _SINE / least if least else math.inf), 1.0)

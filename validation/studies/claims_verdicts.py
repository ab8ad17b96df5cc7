"""Verdicts on the paper's claims P1 to P7 and P11 to P13."""

import math

import numpy as np

import scene
from reduced.stability import critical_round_trip
from validation.closed_forms import FAST_PERIOD_KELVIN_VOIGT
from validation.reference import reference
from validation.report.text import plain
from validation.studies.claims_runs import DEEP, LOG10_R, Branch, Deep, onset_at, spread
from validation.study import Evidence, Outcome, Verdict, judge


def all_verdicts(branch: Branch, deep: dict[str, Deep], ripples: dict[str, float]) -> tuple[Verdict, ...]:
    """Every claim that these runs and the closed forms can settle, in the paper's order."""
    return (*_onset(), *_periods(branch), *_ripples(ripples), *_branch_claims(branch), _load(branch, deep), *_irregular(deep))


def _onset() -> tuple[Verdict, ...]:
    onset = onset_at(100.0)
    ours = {"delay": math.log10(onset.r_delay), "kelvin-voigt": math.log10(onset.r_kelvin_voigt)}
    paper = reference()["paper"]["log10_r_c"]
    known = {model: reference()["hopf"][model]["log10_r"] for model in ours}
    off = max(abs(ours[model] - known[model]) for model in ours)
    slow, fast = (abs(onset_at(v).r_kelvin_voigt / onset_at(v).r_delay - 1.0) for v in (1e3, 1e4))
    roots = [critical_round_trip(scene.read("paper"), model) for model in ours]
    gap = max(abs(roots[0][0] / onset.r_delay - 1), abs(roots[1][0] / onset.r_kelvin_voigt - 1))
    gap = max(gap, *(abs(omega / onset.omega_c - 1) for _, omega in roots))
    claim = "P1 Delay system and ODE share ω_{c}; both r_{c} are close to 10^{-2.6996} at V = 100"
    both = f"10^{{{ours['delay']:.7f}}}, 10^{{{ours['kelvin-voigt']:.7f}}}"
    return (
        Verdict(claim, Evidence.PAPER, f"10^{{{paper}}}", both, judge(all(abs(x - paper) < 1e-4 for x in ours.values()))),
        Verdict(
            claim,
            Evidence.EXACT,
            "(20), (27), (39)",
            f"off by {plain(gap, '.0e')}",
            judge(gap < 1e-10),
            "roots found from each model’s impedance alone, against the closed forms",
        ),
        Verdict(
            claim, Evidence.WITNESS, "log_{10} r_{c} of AUTO and DDE-BIFTOOL", f"off by {plain(off, '.0e')}", judge(off < 1e-9)
        ),
        Verdict(
            "P2 Error of (27) against (39): tiny below V = 10^{3}, of the order of 10 % at 10^{4}",
            Evidence.PAPER,
            "tiny; about 10 %",
            f"{100 * slow:.2f} %; {100 * fast:.1f} %",
            judge(slow < 0.01 and 0.05 < fast < 0.15),
        ),
    )


def _periods(branch: Branch) -> tuple[Verdict, ...]:
    paper = reference()["paper"]
    verdicts = []
    for claim, model, known, half in (("P3", "kelvin-voigt", paper["T_ode"], 0.005), ("P4", "delay", paper["T_dde"], 0.05)):
        ours = branch[model][-2.68].period.value
        title = f"{claim} Period of the {'ODE' if model != 'delay' else 'delay system'} at r = 10^{{-2.68}}"
        verdicts.append(Verdict(title, Evidence.PAPER, f"{known:g}", f"{ours:.5f}", judge(abs(ours - known) <= half)))
    return tuple(verdicts)


def _ripples(ripples: dict[str, float]) -> tuple[Verdict, ...]:
    ode, delay = ripples["kelvin-voigt"], ripples["delay"]
    claim = "P5 Period of the fast ripples: π/√6 transits in the ODE, exactly one in the delay system"
    close = abs(ode / FAST_PERIOD_KELVIN_VOIGT - 1.0) < 1e-3 and abs(delay - 1.0) < 1e-3
    slip = "the text’s “frequency about 28 % too high” is a slip: the period is 28 % too long, the frequency 22 % too low"
    return (
        Verdict(
            claim,
            Evidence.EXACT,
            f"{FAST_PERIOD_KELVIN_VOIGT:.4f}; 1",
            f"{ode:.4f}; {delay:.4f}",
            judge(close),
            "measured on the orbits",
        ),
        Verdict(
            claim,
            Evidence.PAPER,
            "28 % too high",
            f"{100 * (delay / ode - 1):.0f} % in frequency",
            judge(ode < delay, Outcome.FINDING),
            slip,
        ),
    )


def _error(branch: Branch, model: str, name: str, log10_r: float = -2.68) -> float:
    return abs(branch[model][log10_r].values()[name] / branch["delay"][log10_r].values()[name] - 1.0)


def _branch_claims(branch: Branch) -> tuple[Verdict, ...]:
    closer = {
        name: _error(branch, "block8", name) < _error(branch, "block12", name)
        for name in ("period", "elastic_stress_drop", "stress_drop")
    }
    periods = [[branch[model][r].period.value for model in ("kelvin-voigt", "delay", "block8", "block12")] for r in LOG10_R]
    gaps = {name: [_error(branch, "kelvin-voigt", name, r) for r in LOG10_R] for name in ("stress_drop", "elastic_stress_drop")}
    exceed = all(branch["delay"][r].values()[n] > branch["kelvin-voigt"][r].values()[n] for n in gaps for r in LOG10_R)
    where = f"log_{{10}} r = {LOG10_R[0]} to {LOG10_R[-1]}".replace("-", "−")
    grows = all(np.all(np.diff(gap) > 0) for gap in gaps.values())
    told = [", ".join(f"{100 * value:.1f}" for value in gap) for gap in gaps.values()]
    words = ", ".join(
        f"{'T' if n == 'period' else 'Δy' if n[0] == 'e' else 'Δμ'} {'yes' if yes else 'no'}" for n, yes in closer.items()
    )
    return (
        Verdict(
            "P6 The ρh/8 block lies closer to the exact orbit than ρh/12",
            Evidence.PAPER,
            "perhaps",
            words,
            judge(all(closer.values()), Outcome.FINDING),
            "at r = 10^{-2.68}",
        ),
        Verdict(
            "P7 T_{ODE} < T_{delay} < T_{block} along the primary orbit",
            Evidence.PAPER,
            "at every r",
            where,
            judge(all(t[0] < t[1] < min(t[2:]) for t in periods), Outcome.FINDING),
            "on the part of the branch where all four orbits are stable",
        ),
        Verdict(
            "P11 Stress drops of the delay system exceed the ODE’s, by a relative gap that grows with r",
            Evidence.PAPER,
            "larger, gap grows",
            f"{'larger' if exceed else 'not larger'}; Δμ {told[0]} %; Δy {told[1]} %",
            judge(exceed and grows, Outcome.FINDING),
            f"gaps at {where}: larger throughout, but the gap does not grow steadily"
            if exceed and not grows
            else f"gaps at {where}",
        ),
    )


def _load(branch: Branch, deep: dict[str, Deep]) -> Verdict:
    epsilon, velocity = scene.read("paper").upper.epsilon, scene.read("paper").velocity
    orbits = [branch["delay"][r] for r in LOG10_R]
    ratios = [orbit.elastic_stress_drop.value / (epsilon * velocity) / orbit.period.value for orbit in orbits]
    events = deep["delay"].events
    ratios.append(float(np.mean(events.elastic_stress_drop) / (epsilon * velocity) / np.mean(events.period)))
    rising = all(np.diff(ratios) > 0) and ratios[-1] < 1.05
    return Verdict(
        "P12 The period is the time it takes to load the elastic drop: T ~ Δy/((ε/r) V)",
        Evidence.ASYMPTOTIC,
        "ratio to T → 1 as r grows",
        ", ".join(f"{ratio:.2f}" for ratio in ratios),
        judge(rising, Outcome.FINDING),
        f"delay system, log_{{10}} r = {', '.join(str(r) for r in (*LOG10_R, DEEP))}".replace("-", "−"),
    )


def _irregular(deep: dict[str, Deep]) -> tuple[Verdict, ...]:
    scatter = {model: spread(one.events.stress_drop) for model, one in deep.items()}
    return (
        Verdict(
            "P13 At r = 10^{-2.3} the ODE is irregular with large events, the delay system’s drops are nearly constant",
            Evidence.PAPER,
            "irregular; nearly constant",
            f"Δμ varies by {100 * scatter['kelvin-voigt']:.0f} %; {100 * scatter['delay']:.0f} %",
            judge(scatter["kelvin-voigt"] > 0.06 and scatter["delay"] < 0.05, Outcome.FINDING),
            "standard deviation over mean of the cycles’ stress drops",
        ),
    )

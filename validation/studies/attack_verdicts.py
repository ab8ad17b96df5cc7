"""What the study of attacks makes of its measurements."""

import math
from typing import NamedTuple

from validation.report.text import plain
from validation.studies.attack_runs import ATTACKS, CELLS, Advice, Outcome
from validation.study import Evidence, Verdict, judge

SHARP = 0.1
"""How far a step limit may lie from the declared one."""

_RIGHT, _LATE = 1e-2, 5e-2
_CALM, _GROWN = 20.0, 100.0
_ROUNDING = 1e-4
_REACH = {"sbp:2": 2.785, "fem:1": 2.785, "fd": math.inf}
_REACH_OF_ORDER_8 = 6.394


class Found(NamedTuple):
    """Everything that was measured, by family; attacks and media by name first."""

    decades: tuple[int, ...]
    limits: dict[str, list[float]]
    reach: dict[str, float]
    media: dict[str, dict[str, tuple[float, float]]]
    stopped: dict[str, bool]
    late: bool
    attacks: dict[str, dict[str, Outcome]]
    advice: dict[str, Advice]
    transits: float
    noise: dict[str, float]


def answer(found: Found) -> str:
    """One sentence with the figures that matter."""
    stiff = [value for some in found.limits.values() for value, decade in zip(some, found.decades, strict=True) if decade > 0]
    outcomes = [outcome for some in found.attacks.values() for outcome in some.values()]
    silent = sum(outcome.silently_wrong(_RIGHT, _LATE) for outcome in outcomes)
    told = sum(outcome.reported for outcome in outcomes)
    return (
        f"The step limit lies at {min(stiff):.2f} to {max(stiff):.2f} of the declared one however stiff friction is; of "
        f"{len(outcomes)} attacks {len(outcomes) - told - silent} end right, {told} with a message, {silent} silently wrong; "
        f"noise in a locked slab never gains energy (at most {max(found.noise.values()):.6g} of it is left)."
    )


def limit_verdict(found: Found) -> Verdict:
    """Whether the limit stays where stiffness moves."""
    every = [(value, decade) for some in found.limits.values() for value, decade in zip(some, found.decades, strict=True)]
    returning = [value for value, decade in every if decade != 0]
    return Verdict(
        "The step limit does not move with the stiffness of friction",
        Evidence.EXACT,
        "1, ± 10 %",
        f"{min(returning):.2f} to {max(returning):.2f}",
        judge(all(abs(value - 1.0) <= SHARP for value in returning) and min(value for value, _ in every) >= 1.0 - SHARP),
        f"largest stable step over the declared one, {len(found.limits)} families, a/v from 10^{{{found.decades[0]}}} to "
        f"10^{{8}} times Z; where friction swallows the waves (a/v = Z) up to {max(value for value, _ in every):.2f}",
    )


def medium_verdict(media: dict[str, dict[str, tuple[float, float]]]) -> Verdict:
    """Whether the limit parts calm from growth in every medium."""
    below = max(pair[0] for some in media.values() for pair in some.values())
    above = min(pair[1] for some in media.values() for pair in some.values())
    return Verdict(
        "Noise stays at 0.99 of the limit and grows at 1.05, whatever slabs and faces",
        Evidence.EXACT,
        f"below {_CALM:g}, above {_GROWN:g}",
        f"at most {below:.1f}, " + (f"at least {plain(above, '.0e')}" if math.isfinite(above) else "all beyond any number"),
        judge(below < _CALM and above > _GROWN),
        f"{len(media)} media by {len(CELLS)} families, over the noise put in",
    )


def state_verdict(reach: dict[str, float]) -> Verdict:
    """Whether the state's limit is where theory puts it."""
    ratios = {model: value / _REACH.get(model, _REACH_OF_ORDER_8) for model, value in reach.items() if math.isfinite(value)}
    return Verdict(
        "A fast state limits the step by itself, at the real reach of the time stepping",
        Evidence.EXACT,
        "1, ± 2 %",
        f"{min(ratios.values()):.3f} to {max(ratios.values()):.3f}",
        judge(all(abs(ratio - 1.0) <= 0.02 for ratio in ratios.values()) and math.isinf(reach["fd"])),
        "Δt r V over 2.785 (Runge-Kutta of order 4) or 6.394 (order 8); the leapfrog takes ψ implicitly and has no such limit",
    )


def stop_verdict(stopped: dict[str, bool]) -> Verdict:
    """Whether steps too long are told."""
    silent = [model for model, one in stopped.items() if not one]
    return Verdict(
        "A step past the limit ends the run with a message",
        Evidence.EXACT,
        f"{len(stopped)} of {len(stopped)}",
        f"{len(stopped) - len(silent)} of {len(stopped)}",
        judge(not silent),
        f"steps 1.25 times the limit, paper’s scene{'; silent: ' + ', '.join(silent) if silent else ''}",
    )


def attack_verdict(name: str, some: dict[str, Outcome], beyond: bool) -> Verdict:
    """Whether an attack ended right or with a message in every family."""
    silent = [model for model, outcome in some.items() if outcome.silently_wrong(_RIGHT, _LATE)]
    errors = [outcome.error for outcome in some.values() if not outcome.reported]
    late = max((outcome.late for outcome in some.values() if not outcome.reported), default=0.0)
    ours = f"ψ to {plain(max(errors), '.0e')}" + (f", late {plain(late, '.0e')}" if beyond else "") if errors else "messages"
    return Verdict(
        "Extreme scenes end right or with a message, never wrong in silence",
        Evidence.WITNESS,
        f"ψ to {plain(_RIGHT, '.0e')}" + (f", late {plain(_LATE, '.0e')}" if beyond else "") + ", or a message",
        ours,
        judge(not silent),
        f"{ATTACKS[name].title}, against the delay system" + (f"; silent: {', '.join(silent)}" if silent else ""),
    )


def advice_verdict(advice: dict[str, Advice]) -> Verdict:
    """Whether more cells cured the runs that asked for them."""
    worst = max(one.error for one in advice.values())
    return Verdict(
        "A run that asks for more cells is right once it has them",
        Evidence.WITNESS,
        f"ψ to {plain(_RIGHT, '.0e')}",
        f"ψ to {plain(worst, '.0e')}",
        judge(worst <= _RIGHT),
        f"V = 10^{{5}} V*, 400 transits; {sum(one.stopped > 0 for one in advice.values())} of {len(advice)} families asked",
    )


def noise_verdict(noise: dict[str, float], transits: float) -> Verdict:
    """Whether noise gained energy."""
    worst = max(noise, key=noise.__getitem__)
    return Verdict(
        "Noise at the grid scale gains no energy in a locked slab",
        Evidence.EXACT,
        "at most 1",
        f"{noise[worst]:.6g}",
        judge(all(math.isfinite(ratio) and ratio <= 1.0 + _ROUNDING for ratio in noise.values())),
        f"energy after {transits:,.0f} transits over that in the first ten, {len(noise)} families; most is left by `{worst}`",
    )

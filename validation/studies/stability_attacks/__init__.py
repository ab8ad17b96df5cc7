"""Attacks on the full wave: steps past the limit, stiff friction, extreme scenes, noise at the grid scale."""

import math
from collections.abc import Mapping

from validation.compute.models import grid_of
from validation.measure.grids import limits
from validation.measure.grids.limits import AROUND, BEYOND, MEDIA, SOFT_AND_STIFF, STEPS
from validation.measure.grids.noise import locked_noise, noise_left
from validation.studies.stability_attacks import runs
from validation.studies.stability_attacks.runs import ADVISED, ATTACKS, CELLS, MOMENTS, AttackOutcome, Cure
from validation.study import Budget, Cell, Number, StudyResult, Table, table
from validation.study.grid_verdicts import SHARP, Media, limit_verdict, medium_verdict, state_verdict, stop_verdict
from validation.study.text import places, plain
from validation.study.verdict import EXACT, WITNESS, Verdict, claim, every, holding

NAME = "stability-attacks"
QUESTION = "Can extreme inputs make the full-wave solvers fail without a message?"
SCENES = ("paper", "unlike")
SECONDS = (8.0, 32.0)

_QUICK_DECADES, _FULL_DECADES = (-4, 0, 2, 4, 8), (-4, -2, *range(9))
_QUICK_MEDIA = ("alike slabs", "impedances 1 : 1000", "layers 1 : 100", "Kelvin-Voigt, 0.02 transits")
_ADVISED = ("sbp:4", "fem:4", "dg:3")

_CURED = {"sbp:2": 5e-3, "fem:1": 5e-3, "fd": 1e-5}  # error of psi on the grid that was asked for: 3e-4, 3e-4, 8e-7 and at most
_CURED_OTHERS = 2e-6  # 8e-8 was measured
Outcomes = Mapping[str, Mapping[str, AttackOutcome]]
"""Attack -> model -> outcome."""


def run(budget: Budget) -> StudyResult:
    """Step limits over eight decades of stiffness and over media, extreme scenes, and noise in a locked slab."""
    decades, few = (_QUICK_DECADES if budget.quick else _FULL_DECADES), (_QUICK_MEDIA if budget.quick else MEDIA)
    transits, late = 1e3 if budget.quick else 2e4, not budget.quick
    steps = {model: {decade: limits.limit_at(model, decade) for decade in decades} for model in budget.each(CELLS, 0.2)}
    media = {medium: {model: limits.around_the_limit(model, medium) for model in CELLS} for medium in few}
    reach = {model: limits.state_reach(model) for model in budget.each(CELLS, 0.4, 0.2)}
    stopped = {model: limits.stops_beyond(model, BEYOND) for model in budget.each(CELLS, 0.6, 0.4)}
    attacks = {name: runs.attack(name, late) for name in budget.each(ATTACKS, 0.8, 0.6)}
    advice = {model: runs.advised(model) for model in (_ADVISED if budget.quick else CELLS)}
    noise = {model: locked_noise(model, transits) for model in budget.each(CELLS, 1.0, 0.8)}
    return StudyResult(
        answer=answer(steps, attacks, noise),
        tables=(
            _limit_table(steps, reach),
            _medium_table(media),
            _attack_table(attacks, late),
            *_message_table(attacks),
            _advice_table(advice),
            _noise_table(noise, transits),
        ),
        verdicts=(
            limit_verdict(steps),
            medium_verdict(media),
            state_verdict(reach),
            stop_verdict(stopped),
            *(attack_verdict(name, outcomes, late) for name, outcomes in attacks.items()),
            advice_verdict(advice),
            noise_verdict(noise, transits),
        ),
        notes=(
            "Users cannot pass the limit: cfl beyond 1 is refused before a run begins. The runs of the first two tables "
            "set their steps inside the solvers.",
        ),
        numbers={f"limit of {model}": Number(shares[decades[-1]], SHARP) for model, shares in steps.items()},
    )


def answer(shares_of: Mapping[str, Mapping[int, float]], attacks: Outcomes, noise: Mapping[str, float]) -> str:
    """One sentence with the figures that matter."""
    stiff = [value for shares in shares_of.values() for decade, value in shares.items() if decade > 0]
    outcomes = [(name, outcome) for name, by_family in attacks.items() for outcome in by_family.values()]
    silent = sum(outcome.silently_wrong(*ATTACKS[name].right) for name, outcome in outcomes)
    stopped = sum(bool(outcome.message) for _, outcome in outcomes)
    return (
        f"The step limit lies at {min(stiff):.2f} to {max(stiff):.2f} of the declared one however stiff friction is; of "
        f"{len(outcomes)} attacks {len(outcomes) - stopped - silent} end right, {stopped} with a message, {silent} silently "
        f"wrong; at most {max(noise.values()):.6g} of the energy of noise in a locked slab is left."
    )


def attack_verdict(name: str, by_family: Mapping[str, AttackOutcome], beyond: bool) -> Verdict:
    """Whether an attack ended right or with a message in every family."""
    right = ATTACKS[name].right
    silent = [model for model, outcome in by_family.items() if outcome.silently_wrong(*right)]
    through = [outcome for outcome in by_family.values() if not outcome.message]

    def words(early: float, late: float) -> str:
        """Text of the errors of psi, and of the late motion if the run continues."""
        return f"ψ to {plain(early, '.0e')}" + (f", late {plain(late, '.0e')}" if beyond else "")

    title, expected = "Extreme scenes end right or with a message, never silently wrong", f"{words(*right)}, or a message"
    remark = f"{ATTACKS[name].title}, against the delay system" + (f"; silent: {', '.join(silent)}" if silent else "")
    if not through:
        return every(title, WITNESS, len(by_family), len(by_family), remark, "end with a message")
    worst = max(one.error for one in through), max(one.late for one in through)
    share = max(found / allowed for found, allowed in zip(worst, right, strict=False))
    return holding(title, WITNESS, expected, words(*worst), not silent, remark).with_margin(share, 1.0)


def advice_verdict(advice: Mapping[str, Cure]) -> Verdict:
    """Whether more cells cured the runs that asked for them."""
    allowed = {model: _CURED.get(model, _CURED_OTHERS) for model in advice}
    worst = max(advice, key=lambda model: advice[model].error / allowed[model])
    asked = f"{sum(one.stopped > 0 for one in advice.values())} of {len(advice)} families asked"
    remark = f"ψ, V = 10^{{5}} V*, {ADVISED:g} transits; {asked}; shown: `{worst}`, the closest to its limit"
    title = "A run that asks for more cells is right once it has them"
    return claim(title, WITNESS, advice[worst].error, allowed[worst], remark)


def noise_verdict(noise: Mapping[str, float], transits: float) -> Verdict:
    """Whether noise gained energy."""
    others = {model: ratio for model, ratio in noise.items() if not grid_of(model)[0].conserves}
    worst, known = max(others, key=others.__getitem__), noise_left(transits)
    off = max((abs(noise[model] - known.value) / known.error for model in noise.keys() - others.keys()), default=math.inf)
    return holding(
        "Noise at the grid scale gains no energy in a locked slab, and the leapfrog loses none",
        EXACT,
        f"{known.value:.10g}, what friction leaves; less than 1",
        f"{noise['fd']:.10g}; {others[worst]:.3g}",
        off < 1.0 and others[worst] < 1.0,
        f"energy after {transits:,.0f} transits over that in the first ten: `fd`; largest of {len(others)} others: `{worst}`",
    ).with_margin(max(off, others[worst]), 1.0)


def _limit_table(shares_of: Mapping[str, Mapping[int, float]], reach: Mapping[str, float]) -> Table:
    longest = {model: value if math.isfinite(value) else "none" for model, value in reach.items()}
    rows = (
        (model, limits.CELLS[model], limits.step_per_cell(model), *shares.values(), longest[model])
        for model, shares in shares_of.items()
    )
    stiffness = [f"10^{{{decade}}} .2f" for decade in next(iter(shares_of.values()))]
    heading = " | ".join(["family | cells [a slab] .0f | c Δt / cell [at cfl 1] .4f", *stiffness, "Δt r V [state] .2f"])
    caption = (
        "Largest stable step over the declared one (cfl 1), by bisection to 1 per cent, against a/v in units of Z, the impedance "
        f"of the interface. With a stable step, noise at the grid scale does not grow a hundredfold in {STEPS} steps. Friction "
        "is F = a ln v and sliding is steady, so that all growth comes from the scheme; at 10^{0} the interface absorbs waves, "
        "which allows discontinuous elements longer steps. The last column is a limit that does not depend on waves or "
        "stiffness: ψ relaxes r V times in a transit, and all but the leapfrog step it explicitly; shown is the longest stable "
        "step times that rate, to 1 per cent. Solvers respect it in steady sliding and end with a message where an event exceeds "
        "it."
    )
    return table("limits", caption, heading, rows)


def _medium_table(media: Media) -> Table:
    rows = (
        (medium, *(f"{_size(below)}, {_size(above)}" for below, above in (by_family[model] for model in CELLS)))
        for medium, by_family in media.items()
    )
    (below, few), (above, many) = AROUND
    soft, stiff = (f"10^{{{decade:g}}} Z" for decade in SOFT_AND_STIFF)
    caption = (
        f"Largest field, over the size of the noise put in, after {few} steps at {below:g} of the limit, then after {many} steps "
        f"at {above:g} of it; the larger of soft (a/v = {soft}) and stiff ({stiff}) friction. ∞: beyond the range of numbers."
    )
    return table("media", caption, " | ".join(["medium", *CELLS]), rows)


def _size(value: float) -> str:
    return "∞" if value > 1e300 else plain(value, ".0e" if value > 1e4 or value < 0.01 else ".1g")


def _attack_table(attacks: Outcomes, late: bool) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (
            ATTACKS[name].title + (f", cells × {ATTACKS[name].finer}" if ATTACKS[name].finer > 1 else ""),
            ATTACKS[name].late if late else MOMENTS[-1],
            *(by_family[model].wording for model in CELLS),
        )
        for name, by_family in attacks.items()
    ]
    ending = (
        "; after the semicolon, at the end of the run, the error of ψ or, if that is less, the largest relative error of mean "
        "period, stress drop and v_{max} of the cycles in the second half"
        if late
        else ""
    )
    cells = ", ".join(f"{model} {size}" for model, size in CELLS.items())
    caption = (
        f"Largest difference of ψ from the delay system’s at {places(MOMENTS)} transits of the upper slab{ending}. Smooth start "
        "of the paper’s scene unless stated otherwise. *message*: the run was refused or ended with the words in a table below. "
        f"Cells of the faster slab: {cells}."
    )
    return table("attacks", caption, " | ".join(["attack", "until [t] .0f", *CELLS]), rows)


def _message_table(attacks: Outcomes) -> tuple[Table, ...]:
    rows = [
        (ATTACKS[name].title, model, outcome.message)
        for name, by_family in attacks.items()
        for model, outcome in by_family.items()
        if outcome.message
    ]
    return (table("messages", "What the runs that stopped said.", "attack | family | message", rows),) if rows else ()


def _advice_table(advice: Mapping[str, Cure]) -> Table:
    rows = (
        (model, advised.stopped or "–", advised.message or "–", advised.cells, plain(advised.error, ".0e"))
        for model, advised in advice.items()
    )
    heading = "family | stops at [cells] | message | goes through at [cells] .0f | largest error of ψ"
    caption = (
        f"V = 10^{{5}} V* for {ADVISED:g} transits: ψ relaxes 200 times in a transit and more in events, so that the steps of "
        "coarse grids are too long. Cells are doubled as long as the run ends with a message; then ψ is compared with the delay "
        "system’s."
    )
    return table("advice", caption, heading, rows)


def _noise_table(noise: Mapping[str, float], transits: float) -> Table:
    caption = (
        "A slab locked by friction (V = 10^{-6} V*, where waves of 1 V* change the slip rate by some 10^{-9} V*), every node "
        f"given a random velocity of about 1 V*, marched at the full step: energy in the family’s own norm after {transits:,.0f} "
        "transits over its mean in the first ten. Leapfrog conserves it; the others dissipate what their grids cannot resolve. "
        "The test suite’s slow part goes on to 10^{6} transits."
    )
    rows = ((model, limits.CELLS[model], ratio) for model, ratio in noise.items())
    return table("noise", caption, "family | cells [a slab] .0f | energy left .6g", rows)

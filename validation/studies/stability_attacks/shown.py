"""The tables of the study of attacks."""

import math

from validation.studies.stability_attacks.limits import AROUND, SOFT_AND_STIFF, STEPS, step_per_cell
from validation.studies.stability_attacks.limits import CELLS as COARSE
from validation.studies.stability_attacks.runs import ADVISED, ATTACKS, CELLS, MOMENTS, Advice, AttackOutcome
from validation.study import Cell, Table, table
from validation.study.text import places, plain


def limit_table(decades: tuple[int, ...], limits: dict[str, list[float]], reach: dict[str, float]) -> Table:
    """Step limits against stiffness, and the state's own limit."""
    rows = (
        (model, COARSE[model], step_per_cell(model), *shares, reach[model] if math.isfinite(reach[model]) else "none")
        for model, shares in limits.items()
    )
    stiffness = [f"10^{{{decade}}} .2f" for decade in decades]
    heading = " | ".join(["family | cells [a slab] .0f | c Δt / cell [at cfl 1] .4f", *stiffness, "Δt r V [state] .2f"])
    caption = (
        "Largest stable step over the declared one (cfl 1), by bisection to 1 per cent, against a/v in units of Z, the impedance "
        "of the interface. With a stable step, noise at the grid scale does not grow a hundredfold in "
        f"{STEPS} steps. Friction is "
        "F = a ln v and sliding is steady, so that all growth comes from the scheme; at 10^{0} the interface absorbs waves, "
        "which allows discontinuous elements longer steps. The last column is a limit that does not depend on waves or "
        "stiffness: ψ relaxes r V times in a transit, and all but the leapfrog step it explicitly; shown is the longest stable "
        "step times that rate, to 1 per cent. Solvers respect it in steady sliding and end with a message where an event exceeds "
        "it."
    )
    return table("limits", caption, heading, rows)


def medium_table(found: dict[str, dict[str, tuple[float, float]]]) -> Table:
    """Noise just below and just above the limit."""
    rows = (
        (medium, *(f"{_size(below)}, {_size(above)}" for below, above in (by_family[model] for model in CELLS)))
        for medium, by_family in found.items()
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


def attack_table(found: dict[str, dict[str, AttackOutcome]], late: bool) -> Table:
    """Outcome of every attack by every family."""
    rows: list[tuple[Cell, ...]] = [
        (
            ATTACKS[name].title + (f", cells × {ATTACKS[name].finer}" if ATTACKS[name].finer > 1 else ""),
            ATTACKS[name].late if late else MOMENTS[-1],
            *(by_family[model].wording for model in CELLS),
        )
        for name, by_family in found.items()
    ]
    ending = (
        "; after the semicolon, at the end of the run, the error of ψ or, if that is less, the largest relative error of mean "
        "period, stress drop and v_{max} of the cycles in the second half"
        if late
        else ""
    )
    cells = ", ".join(f"{model} {size}" for model, size in CELLS.items())
    caption = (
        f"Largest difference of ψ from the delay system’s at {places(MOMENTS)} transits of the upper slab"
        f"{ending}. Smooth start of the paper’s scene unless stated otherwise. *message*: the run was refused or ended with the "
        "words in a table below. Cells of the faster slab: "
        f"{cells}."
    )
    return table("attacks", caption, " | ".join(["attack", "until [t] .0f", *CELLS]), rows)


def message_table(found: dict[str, dict[str, AttackOutcome]]) -> tuple[Table, ...]:
    """What the attacks that ended with a message said; no table if none did."""
    rows = [
        (ATTACKS[name].title, model, outcome.message)
        for name, by_family in found.items()
        for model, outcome in by_family.items()
        if outcome.message
    ]
    return (table("messages", "What the runs that stopped said.", "attack | family | message", rows),) if rows else ()


def advice_table(advice: dict[str, Advice]) -> Table:
    """Runs that asked for more cells, and their outcome with more cells."""
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


def noise_table(noise: dict[str, float], transits: float) -> Table:
    """Energy left in a locked slab."""
    caption = (
        "A slab locked by friction (V = 10^{-6} V*, where waves of 1 V* change the slip rate by some 10^{-9} V*), every node "
        f"given a random velocity of about 1 V*, marched at the full step: energy in the family’s own norm after {transits:,.0f} "
        "transits over its mean in the first ten. Leapfrog conserves it; the others dissipate what their grids cannot resolve. "
        "The test suite’s slow part goes on to 10^{6} transits."
    )
    rows = ((model, COARSE[model], ratio) for model, ratio in noise.items())
    return table("noise", caption, "family | cells [a slab] .0f | energy left .6g", rows)

"""What it takes to upset the full wave: steps past the limit, stiff friction, extreme scenes, noise at the grid scale."""

import math

from validation.report.text import plain
from validation.studies.attack_runs import (
    ATTACKS,
    CELLS,
    Outcome,
    attack,
    limit_at,
    locked_noise,
    step_per_cell,
    stops_beyond,
)
from validation.study import Budget, Cell, Column, Evidence, Number, StudyResult, Table, Verdict, judge

NAME = "stability-attacks"
QUESTION = "Can the full wave be upset, and does it say so?"
SCENES = ("paper", "unlike")
SECONDS = (8.0, 40.0)

_SHARP = 0.1
_RIGHT = 1e-2
_QUICK, _FULL = (0, 2, 4, 6, 8), tuple(range(9))


def run(budget: Budget) -> StudyResult:
    """Step limits over eight decades of stiffness, extreme scenes, and noise in a locked slab."""
    decades = _QUICK if budget.quick else _FULL
    transits = 1e3 if budget.quick else 1e5
    limits: dict[str, list[float]] = {}
    for count, model in enumerate(CELLS):
        limits[model] = [limit_at(model, decade) for decade in decades]
        budget.report(0.4 * (count + 1) / len(CELLS))
    stopped = {model: stops_beyond(model, 1.25) for model in CELLS}
    found = {name: attack(name) for name in ATTACKS}
    budget.report(0.6)
    noise = {model: locked_noise(model, transits) for model in CELLS}
    return StudyResult(
        answer=_answer(limits, found, noise),
        tables=(_limit_table(decades, limits), _attack_table(found), *_refusals(found), _noise_table(noise, transits)),
        verdicts=(
            *(_limit_verdict(model, some) for model, some in limits.items()),
            _stop_verdict(stopped),
            *(_attack_verdict(name, some) for name, some in found.items()),
            *(_noise_verdict(model, ratio, transits) for model, ratio in noise.items()),
        ),
        notes=(
            "Users cannot pass the limit: cfl beyond 1 is refused before a run begins. The first table sets its steps "
            "inside the solvers.",
        ),
        numbers={f"limit of {model}": Number(max(some), _SHARP) for model, some in limits.items()},
    )


def _answer(limits: dict[str, list[float]], found: dict[str, dict[str, Outcome]], noise: dict[str, float]) -> str:
    every = [value for some in limits.values() for value in some]
    outcomes = [outcome for some in found.values() for outcome in some.values()]
    silent = sum(outcome.silently_wrong(_RIGHT) for outcome in outcomes)
    told = sum(outcome.reported for outcome in outcomes)
    return (
        f"The step limit lies at {min(every):.2f} to {max(every):.2f} of the declared one whatever the friction’s stiffness; of "
        f"{len(outcomes)} attacks {len(outcomes) - told - silent} end right, {told} with a message, {silent} silently wrong; "
        f"noise in a locked slab never gains energy (at most {max(noise.values()):.3g} of it is left)."
    )


def _limit_verdict(model: str, some: list[float]) -> Verdict:
    moved = max(some) / min(some) - 1.0
    return Verdict(
        "The step limit does not move with the stiffness of friction",
        Evidence.EXACT,
        "1, ± 10 %",
        f"{min(some):.2f} to {max(some):.2f}",
        judge(moved <= _SHARP and abs(some[0] - 1.0) <= _SHARP),
        f"`{model}`: largest stable step over the declared one, a/(ZV) scaled from 1 to 10^{{8}}",
    )


def _stop_verdict(stopped: dict[str, bool]) -> Verdict:
    silent = [model for model, one in stopped.items() if not one]
    return Verdict(
        "A step past the limit ends the run with a message",
        Evidence.EXACT,
        f"{len(stopped)} of {len(stopped)}",
        f"{len(stopped) - len(silent)} of {len(stopped)}",
        judge(not silent),
        f"steps 1.25 times the limit{': silent: ' + ', '.join(silent) if silent else ''}",
    )


def _attack_verdict(name: str, some: dict[str, Outcome]) -> Verdict:
    silent = [model for model, outcome in some.items() if outcome.silently_wrong(_RIGHT)]
    errors = [outcome.error for outcome in some.values() if not outcome.reported]
    return Verdict(
        "Extreme scenes end right or with a message, never wrong in silence",
        Evidence.WITNESS,
        f"ψ to {plain(_RIGHT, '.0e')}, or a message",
        f"ψ to {plain(max(errors), '.0e')}" if errors else "messages",
        judge(not silent),
        f"{ATTACKS[name].title}, against the delay system" + (f"; silent: {', '.join(silent)}" if silent else ""),
    )


def _noise_verdict(model: str, ratio: float, transits: float) -> Verdict:
    return Verdict(
        "Noise at the grid scale gains no energy in a locked slab",
        Evidence.EXACT,
        "at most 1",
        f"{ratio:.6g}",
        judge(math.isfinite(ratio) and ratio <= 1.0 + 1e-3),
        f"`{model}`: energy after {transits:,.0f} transits over the energy in the first ten",
    )


def _limit_table(decades: tuple[int, ...], limits: dict[str, list[float]]) -> Table:
    rows: list[tuple[Cell, ...]] = [(model, CELLS[model].coarse, step_per_cell(model), *some) for model, some in limits.items()]
    columns = (
        Column("family"),
        Column("cells", "a slab", ".0f"),
        Column("c Δt / cell", "at cfl 1", ".4f"),
        *(Column(f"10^{{{decade}}}", "", ".2f") for decade in decades),
    )
    caption = (
        "Largest stable step over the declared limit (cfl 1), by bisection to 5 per cent on runs of 120 transits, against the "
        "stiffness a/(ZV) of friction beside the wave’s impedance, in units of its value at V = 100 V* (25): the paper’s scene "
        "with V lowered to 10^{−6} V*. A step counts as unstable when the run ends with a message."
    )
    return Table("limits", caption, columns, tuple(rows))


def _attack_table(found: dict[str, dict[str, Outcome]]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (ATTACKS[name].title, *(some[model].wording if model in some else None for model in CELLS))
        for name, some in found.items()
    ]
    columns = (Column("attack"), *(Column(model) for model in CELLS))
    cells = ", ".join(f"{model} {size.fine}" for model, size in CELLS.items())
    caption = (
        "Largest difference of ψ from the delay system’s at 6, 8, 12, 20 and 40 transits of the upper slab; smooth start of the "
        "paper’s scene unless told otherwise. *n failures*: interface solves that were counted as failed; *message*: the run was "
        f"refused or ended with the words in the next table. Cells of the faster slab: {cells}."
    )
    return Table("attacks", caption, columns, tuple(rows))


def _refusals(found: dict[str, dict[str, Outcome]]) -> tuple[Table, ...]:
    rows: list[tuple[Cell, ...]] = [
        (ATTACKS[name].title, model, outcome.message)
        for name, some in found.items()
        for model, outcome in some.items()
        if outcome.message
    ]
    if not rows:
        return ()
    return (
        Table(
            "messages", "What the runs that stopped said.", (Column("attack"), Column("family"), Column("message")), tuple(rows)
        ),
    )


def _noise_table(noise: dict[str, float], transits: float) -> Table:
    columns = (Column("family"), Column("cells", "a slab", ".0f"), Column("energy left", "", ".6g"))
    caption = (
        "A slab locked by friction (V = 10^{−6} V*, where waves of 1 V* change the slip rate by some 10^{−9} V*), every node "
        f"given a random velocity of about 1 V*: mean square of velocity and stress after {transits:,.0f} transits over "
        "its mean in the first ten. Leapfrog conserves it; the others dissipate what their grids cannot resolve."
    )
    return Table("noise", caption, columns, tuple((model, CELLS[model].coarse, ratio) for model, ratio in noise.items()))

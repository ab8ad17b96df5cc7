"""Tables of one cycle: every model's figures and their errors against the delay system, and beside reference values."""

from validation.references.published import reference_orbit
from validation.studies.one_cycle.runs import LOG10_R, QUANTITIES, CycleRun, error
from validation.study import Cell, Table, table


def _row(runs: dict[str, CycleRun], model: str, quantities: tuple[str, ...]) -> list[Cell]:
    cells: list[Cell] = [model]
    for quantity in quantities:
        off = None if model == "delay" else error(runs[model], runs["delay"], quantity)
        cells += [runs[model].orbit.values()[quantity], off]
    return cells


def drops(runs: dict[str, CycleRun]) -> Table:
    """Period and drops."""
    names = ("period", "stress_drop", "elastic_stress_drop")
    off = "error [relative] .1e"
    heading = f"model | T [transits] .9g | {off} | Δμ [σ] .7f | {off} | Δy [σ] .7f | {off}"
    caption = (
        "The settled orbit at log_{10} r = −2.68, V = 100. T: time from one slip event to the next on the transit clock; Δμ: "
        "largest minus smallest stress; Δy: the same for the elastic stress, y′ = ε (V − v). Errors are relative, against the "
        "delay system."
    )
    return table("drops", caption, heading, (_row(runs, model, names) for model in runs), (0,))


def rates(runs: dict[str, CycleRun]) -> Table:
    """Extreme slip rates, and how the run went."""
    names = ("v_max", "v_min")
    heading = (
        "model | v_{max} [V*] .8g | error [relative] .1e | v_{min} [V*] .7g | error [relative] .1e | "
        "cycles run .0f | unrest .0e | failed solves .0f"
    )
    rows = (
        (*_row(runs, model, names), own.settled.cycles, own.settled.unrest, own.settled.solver.failures)
        for model, own in runs.items()
    )
    caption = (
        "Largest and smallest slip rate v over the cycle, from the dense polynomials. *Unrest* is the largest relative spread "
        "of any of the five quantities over the last four cycles when the run was stopped: what is left of the transient."
    )
    return table("rates", caption, heading, rows, (0,))


def beside_reference(runs: dict[str, CycleRun]) -> Table:
    """Ours beside values of other programs."""
    rows = []
    for model, own in runs.items():
        for quantity, known in reference_orbit(model, LOG10_R).items():
            ours = own.orbit.values()[quantity]
            rows.append((model, QUANTITIES[quantity], known, ours, ours / known - 1.0))
    caption = "Comparison with values of other programs (first note below); T in transits."
    return table("reference", caption, "model | quantity | reference .10g | ours .10g | difference [relative] .0e", rows)

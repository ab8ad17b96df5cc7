"""Tables of the cycles behind grips and bare coefficients."""

from validation.studies.partial_reflection.runs import RESTLESS, UNTIL, Pair, Point
from validation.study import Table, table
from validation.study.text import plain


def wave_table(pairs: list[Pair]) -> Table:
    """Delay system and full wave, grip by grip."""
    rows = []
    for pair in pairs:
        off = (ours / theirs - 1.0 for ours, theirs in zip(pair.wave, pair.exact, strict=True))
        rows.append((pair.stiffness, pair.impedance, *pair.exact, *off))
    differences = [f"difference in {name} [relative] .0e" for name in ("T", "Δμ", "v_{max}")]
    columns = "K [ε a transit] .0f | Z_{g}/ε .3g | T [transits] .9g | Δμ [σ] .7f | v_{max} [V*] .7g"
    caption = (
        f"Slabs in grips of stiffness K and impedance Z_{{g}}, log_{{10}} r = −2.6: last complete cycle before {UNTIL:.0f} "
        "transits by the delay system, and how far discontinuous Galerkin is from it in the same cycle."
    )
    return table("grips", caption, " | ".join([columns, *differences]), rows)


def bare_table(leaks: tuple[float, ...], bare: list[Point], held: list[Point], ends: list[str]) -> Table:
    """Bare coefficients beside grips of the same reflection."""
    rows = ((q, end, *point, 2.0 / q - 1.0, *grip) for q, end, point, grip in zip(leaks, ends, bare, held, strict=True))
    figures = "T [transits] .6g | Δμ [σ] .5f | v_{max} [V*] .0f"
    heading = f"1 − R .0e | bare: ends as | {figures} | grip: Z_{{g}}/ε .5g | {figures}"
    caption = (
        "Left: faces with a bare coefficient R, right: grips that reflect the same share of a fast wave, stiffness 10 ε a "
        f"transit; log_{{10}} r = −2.66, delay system. A dash: no cycle that repeats to {plain(RESTLESS, '.0e')}."
    )
    return table("bare", caption, heading, rows)

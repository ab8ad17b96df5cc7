"""Tables of the cycles behind grips and bare coefficients."""

from validation.studies.partial_reflection.runs import RESTLESS, UNTIL, Pair, Point
from validation.study import Cell, Column, Table
from validation.study.text import plain


def wave_table(pairs: list[Pair]) -> Table:
    """Delay system and full wave, grip by grip."""
    rows: list[tuple[Cell, ...]] = []
    for pair in pairs:
        off = (ours / theirs - 1.0 for ours, theirs in zip(pair.wave, pair.exact, strict=True))
        rows.append((pair.stiffness, pair.impedance, *pair.exact, *off))
    figures = (Column("T", "transits", ".9g"), Column("Δμ", "σ", ".7f"), Column("v_{max}", "V*", ".7g"))
    columns = (Column("K", "ε a transit", ".0f"), Column("Z_{g}/ε", "", ".3g"), *figures)
    differences = tuple(Column(f"difference in {name}", "relative", ".0e") for name in ("T", "Δμ", "v_{max}"))
    caption = (
        f"Slabs in grips of stiffness K and impedance Z_{{g}}, log_{{10}} r = −2.6: last complete cycle before {UNTIL:.0f} "
        "transits by the delay system, and how far discontinuous Galerkin is from it in the same cycle."
    )
    return Table("grips", caption, (*columns, *differences), tuple(rows))


def bare_table(leaks: tuple[float, ...], bare: list[Point], held: list[Point], ends: list[str]) -> Table:
    """Bare coefficients beside grips of the same reflection."""
    rows = tuple((q, end, *one, 2.0 / q - 1.0, *grip) for q, end, one, grip in zip(leaks, ends, bare, held, strict=True))
    figures = (Column("T", "transits", ".6g"), Column("Δμ", "σ", ".5f"), Column("v_{max}", "V*", ".0f"))
    columns = (Column("1 − R", "", ".0e"), Column("bare: ends as"), *figures, Column("grip: Z_{g}/ε", "", ".5g"), *figures)
    caption = (
        "Left: faces with a bare coefficient R, right: grips that reflect the same share of a fast wave, stiffness 10 ε a "
        f"transit; log_{{10}} r = −2.66, delay system. A dash: no cycle that repeats to {plain(RESTLESS, '.0e')}."
    )
    return Table("bare", caption, columns, rows)

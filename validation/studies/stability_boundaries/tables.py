"""Tables of the study of stability boundaries."""

import math

import numpy as np

from reduced.stability import Stability
from validation.studies.stability_boundaries.measured import Curves
from validation.study import Cell, Column, Table
from validation.study.text import plain


def velocity_table(curves: Curves) -> Table:
    """Critical r at five velocities."""
    shown = [int(np.argmin(np.abs(np.log(curves.velocity / v)))) for v in (1.0, 10.0, 100.0, 1e3, 1e4)]
    rows = tuple(
        (float(curves.velocity[i]), float(curves.delay[i]), float(curves.kelvin_voigt[i]), float(curves.error[i])) for i in shown
    )
    columns = (
        Column("V", "V*", ".4g"),
        Column("r_{c}, delay (39)", "L/V*", ".12g"),
        Column("r_{c}, Kelvin–Voigt (27)", "L/V*", ".12g"),
        Column("relative error", "", ".3e"),
    )
    return Table("critical-r", "Critical round trip over the drive V, the paper’s Fig 2.", columns, rows)


def model_table(onsets: dict[str, tuple[float, float]]) -> Table:
    """Critical r and frequency of every model at the paper's V and epsilon."""
    exact = onsets["delay"][0]
    rows: list[tuple[Cell, ...]] = [
        (f"`{model}`", math.log10(r), r / exact - 1.0 if model != "delay" else None, omega, r * omega)
        for model, (r, omega) in onsets.items()
    ]
    columns = (
        Column("model"),
        Column("log_{10} r_{c}", "", ".11f"),
        Column("error of r_{c}", "relative", ".3e"),
        Column("ω at onset", "V*/L", ".8f"),
        Column("r_{c} ω", "per transit", ".8f"),
    )
    return Table("models", "Onset of stick-slip in every model, V = 100, ε = 2.8 · 10^{-5}.", columns, tuple(rows))


def scene_table(found: dict[str, Stability]) -> Table:
    """Exact stability of one scene per row."""
    rows: list[tuple[Cell, ...]] = []
    for name, one in found.items():
        lead = one.leading_roots[0]
        root = f"{plain(lead.real, '.5g')} ± {plain(abs(lead.imag), '.6g')} i" if lead.imag else plain(lead.real, ".5g")
        state = "stable" if one.stable else f"unstable ({one.unstable_roots})"
        rows.append((f"`{name}`", state, one.omega_c, one.log10_r_c, one.epsilon_c, root, one.essential_abscissa))
    columns = (
        Column("scene"),
        Column("steady sliding"),
        Column("ω_{c}", "V*/L", ".6f"),
        Column("log_{10} r_{c}", "", ".8f"),
        Column("ε_{c}", "", ".6e"),
        Column("leading root", "V*/L"),
        Column("fast roots", "Re, V*/L", ".5g"),
    )
    caption = (
        "Exact stability of other arrangements. In brackets: number of growing roots, certified by the argument principle. "
        "r_{c}: the upper slab’s round trip, both scaled together. Fast roots: where the real parts of the infinitely many "
        "fast roots pile up."
    )
    return Table("scenes", caption, columns, tuple(rows))

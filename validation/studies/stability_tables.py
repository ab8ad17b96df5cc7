"""Tables of the study of stability boundaries."""

import numpy as np

from reduced.stability import Stability, critical_round_trip
from scene.scene import Scene
from validation.report.text import plain
from validation.studies.stability_measured import Curves, Law
from validation.study import Cell, Column, Table

_LAW_TEXT = {
    "quasistatic": "θ²/12",
    "quasidynamic": "θ G_{φ}/(2ω_{c})",
    "block8": "−θ²/24",
    "block12": "θ^{4}/720",
    "kelvin-voigt": "−θ^{4}/480",
}


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


def law_table(laws: dict[str, Law], paper: Scene) -> Table:
    """Error law of every reduction beside its measured error."""
    r, omega = critical_round_trip(paper)
    rows: list[tuple[Cell, ...]] = [
        (f"`{model}`", _LAW_TEXT.get(model, "θ^{4} Σ_{k>N} 2/(2πk)^{4}"), law.measured[0], law.predicted[0], *_ratios(law))
        for model, law in laws.items()
    ]
    caption = (
        "How wrong a reduction is about the onset, known in advance: relative error of its critical r, measured and by the "
        f"leading term in θ = r ω_{{c}} = {r * omega:.4f} (radians per transit, at the paper’s ε), and the ratio of the two "
        "there and at a quarter of ε."
    )
    columns = (
        Column("model"),
        Column("law"),
        Column("measured", "", ".4e"),
        Column("law’s value", "", ".4e"),
        Column("ratio", "at ε", ".6f"),
        Column("ratio", "at ε/4", ".6f"),
    )
    return Table("error-laws", caption, columns, tuple(rows))


def _ratios(law: Law) -> tuple[float, float]:
    return law.measured[0] / law.predicted[0], law.measured[1] / law.predicted[1]


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

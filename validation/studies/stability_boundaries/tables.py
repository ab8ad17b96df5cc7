"""Tables of the study of stability boundaries."""

import math

import numpy as np

from reduced.stability import Stability
from validation.studies.stability_boundaries.measured import Curves
from validation.study import Table, table
from validation.study.text import plain


def velocity_table(curves: Curves) -> Table:
    """Critical r at five velocities."""
    shown = [int(np.argmin(np.abs(np.log(curves.velocity / v)))) for v in (1.0, 10.0, 100.0, 1e3, 1e4)]
    rows = ((float(column[i]) for column in (curves.velocity, curves.delay, curves.kelvin_voigt, curves.error)) for i in shown)
    heading = "V [V*] .4g | r_{c}, delay (39) [L/V*] .12g | r_{c}, Kelvin–Voigt (27) [L/V*] .12g | relative error .3e"
    return table("critical-r", "Critical round trip over the drive V, the paper’s Fig 2.", heading, rows)


def model_table(onsets: dict[str, tuple[float, float]]) -> Table:
    """Critical r and frequency of every model at the paper's V and epsilon."""
    exact = onsets["delay"][0]
    rows = (
        (f"`{model}`", math.log10(r), r / exact - 1.0 if model != "delay" else None, omega, r * omega)
        for model, (r, omega) in onsets.items()
    )
    heading = "model | log_{10} r_{c} .11f | error of r_{c} [relative] .3e | ω at onset [V*/L] .8f | r_{c} ω [per transit] .8f"
    return table("models", "Onset of stick-slip in every model, V = 100, ε = 2.8 · 10^{-5}.", heading, rows)


def scene_table(found: dict[str, Stability]) -> Table:
    """Exact stability of one scene per row."""
    rows = []
    for name, stability in found.items():
        lead = stability.leading_roots[0]
        root = f"{plain(lead.real, '.5g')} ± {plain(abs(lead.imag), '.6g')} i" if lead.imag else plain(lead.real, ".5g")
        state = "stable" if stability.stable else f"unstable ({stability.unstable_roots})"
        rows.append(
            (f"`{name}`", state, stability.omega_c, stability.log10_r_c, stability.epsilon_c, root, stability.essential_abscissa)
        )
    heading = (
        "scene | steady sliding | ω_{c} [V*/L] .6f | log_{10} r_{c} .8f | ε_{c} .6e | leading root [V*/L] | "
        "fast roots [Re, V*/L] .5g"
    )
    caption = (
        "Exact stability of other arrangements. In brackets: number of growing roots, certified by the argument principle. "
        "r_{c}: the upper slab’s round trip, both scaled together. Fast roots: where the real parts of the infinitely many "
        "fast roots accumulate."
    )
    return table("scenes", caption, heading, rows)

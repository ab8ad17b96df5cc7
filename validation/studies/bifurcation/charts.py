"""The paper's Figs 6 and 7: branches of orbits over r, and the ODE's doubled orbits."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

from validation.chart import DOTTED, ORANGE, Chart, Look, Panel, Scale, Trace
from validation.chart.looks import NAMES, model_line, model_look
from validation.measure.over_r import COMPARED, Branch
from validation.report.branch_drawing import branch_keys, branch_traces
from validation.studies.bifurcation.doubling import ODE, Bubble, Doubled, between_doublings

_LABELS = {"period": "$T$ (transits)", "stress_drop": r"$\Delta\mu$", "elastic_stress_drop": r"$\Delta y$"}
_OVER_R = r"$\log_{10} r$"
_NEAR = (-2.706, -2.62)
_BESIDE = 0.01  # of log10 r, around the pairs of period doublings
_LEGEND: dict[str, Any] = {"legend": "outside upper left"}


def diagram(branches: Sequence[Branch], waves: Sequence[Any]) -> Chart:
    """The paper's Fig 6: period and drops over log10 r, from the onset to log10 r = -2.62 and to the end."""
    panels, look = [], Look(ORANGE, "", "o", size=7.0, hollow=True)
    for name in COMPARED:
        traces = [trace for branch in branches for trace in branch_traces(branch, name)]
        orbits = Trace("full wave", [one.log10_r for one in waves], [one.wave[name] for one in waves], look)
        panels.append(Panel("", Scale(_OVER_R, limits=_NEAR), Scale(_LABELS[name]), [*traces, orbits], grid=True))
        panels.append(Panel("", Scale(_OVER_R), Scale(_LABELS[name]), traces, grid=True))
    keys = [*(model_line(branch.model, [], [], dashes="-") for branch in branches), *branch_keys(NAMES), orbits]
    return Chart(panels, 8.2, 2, widths=(1.25, 1.0), keys=keys, legend_columns=4, **_LEGEND)


def orbits_in_planes(found: Doubled, ode: Branch, bubbles: Iterable[Bubble]) -> Chart:
    """The paper's Fig 7: both orbits in two planes; below, T and half the doubled period over r."""
    double = model_look(ODE, color=ORANGE, dashes="-", width=0.9)
    looks = (
        ("doubled orbit, stable", found.double, double),
        ("T = 79.09, unstable", found.single, model_look(ODE, dashes=DOTTED)),
    )
    rows: tuple[list[Trace], ...] = ([], [], [])
    for name, orbit, look in looks:
        pieces, ten = orbit.closed.cycle.pieces, math.log(10.0)
        time = (pieces.time[:, None] + pieces.length[:, None] * orbit.closed.flow.nodes) / orbit.closed.cycle.period
        turn, rate, stress, state = [values.ravel() for values in (time, pieces.z / ten, pieces.mu, pieces.psi / ten)]
        for traces, (x, y) in zip(rows, ((turn, rate), (rate, stress), (rate, state)), strict=True):
            traces.append(Trace(name, x, y, look))
    pairs = between_doublings(ode)
    halves = [Trace("half of doubled T", [r for r, _ in one.points], [half for _, half in one.points], double) for one in bubbles]
    log_v, limits = r"$\log_{10} v$", (pairs[0][0].value - _BESIDE, pairs[-1][-1].value + _BESIDE)
    periods = [one.period for pair in pairs for one in pair]
    over_r = Scale("$T$, half of the doubled $T$", limits=(min(periods) - 0.2, max(periods) + 0.2))
    panels = (
        Panel("", Scale("time over the period of each orbit"), Scale(log_v), rows[0], grid=True),
        Panel("", Scale(log_v), Scale(r"$\mu$"), rows[1], grid=True),
        Panel("", Scale(log_v), Scale(r"$\log_{10}\phi$"), rows[2], grid=True),
        Panel("", Scale(_OVER_R, limits=limits), over_r, [*branch_traces(ode, "period"), *halves], grid=True),
    )
    keys = [*rows[0], *branch_keys(("PD",))]
    layout, heights = ((0, 0), (1, 2), (3, 3)), (0.8, 1.2, 1.0)
    return Chart(panels, 8.4, layout=layout, heights=heights, share=("", ""), keys=keys, legend_columns=2, **_LEGEND)


CAPTION = (
    "Period T, stress drop Δμ and elastic stress drop Δy of the periodic orbits over r, the paper’s Fig 6, near the onset (left) "
    "and as far as the branches were followed (right). Stable orbits are thick and solid, unstable ones thin and dotted. "
    "Circles: orbits of the full wave."
)
PLANES = (
    "The ODE’s orbits at log_{10} r = −2.590007, the paper’s Fig 7: the unstable one of T = 79.09 transits (dotted) and the "
    "stable one of twice the period. Above: slip rate over time, each over its own period; middle: two planes; below: periods of "
    "the simple orbits over r and half the periods of the doubled ones."
)

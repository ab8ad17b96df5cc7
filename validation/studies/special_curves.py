"""The Hopf point, the first fold, the first torus point and the first period doubling, in two parameters."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from reduced.parameters import with_parameter
from validation.compute.branch import FollowedBranch
from validation.compute.curve import Curve
from validation.compute.followed import ends_of
from validation.compute.parameter import over_range
from validation.compute.points import CurvePoint, StopAt
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference
from validation.study import EXACT, PAPER, WITNESS, Budget, Figure, StudyResult, Table, Verdict, claim, in_range, stated, table
from validation.study.drawing import WIDTH, Drawing, canvas, style_of
from validation.study.known import JUST_BELOW
from validation.study.over_r import scene_at
from validation.study.text import plain
from validation.study.verdict import ROUNDING

NAME = "special-curves"
QUESTION = "How do the points where orbits are born and change their stability depend on ε and V?"
SCENES = ("paper",)
SECONDS = (5.0, 40.0)

_TOLERANCE = 1e-6
_RANGE = (-2.73, -2.3)
_KINDS = {"LP": ("first fold", "-"), "NS": ("first torus point", "--"), "PD": ("first period doubling", ":")}
_PLAN: dict[bool, tuple[tuple[str, str, tuple[float, float]], ...]] = {
    True: (("delay", "LP", (2.3, 1.7)),),
    False: (
        ("delay", "LP", (2.3, 1.7)),
        ("kelvin-voigt", "LP", (2.3, 1.7)),
        ("delay", "NS", (2.06, 1.97)),
        ("kelvin-voigt", "PD", (2.02, 1.97)),
    ),
}
"""Quick report -> model, kind and the values of log10 V towards which its curve is followed."""

_MOST = {True: 12, False: 24}

Key = tuple[str, str]


def run(budget: Budget) -> StudyResult:
    """Follow the curves from V = 100 in both directions; recompute the end of one as an orbit at V = 100."""
    plan, found = _PLAN[budget.quick], dict[Key, list[CurvePoint]]()
    for model, kind, ends in budget.each(plan, end=len(plan) / (len(plan) + 1)):
        up, down = (_curve(model, kind, end, _MOST[budget.quick]) for end in ends)
        found[model, kind] = [*reversed(down[1:]), *up]
    end = found["delay", "LP"][-1]
    return StudyResult(
        answer=_answer(found),
        figures=(Figure("curves", _CAPTION, lambda: _diagram(found)),),
        tables=(_table(found),),
        verdicts=tuple(curve_verdicts(found, _fold_at(end))),
        notes=() if budget.quick else (_TURNS,),
        numbers={
            f"{model} {kind} at V = 100": stated(start.first, start.bracket)
            for (model, kind), points in found.items()
            for start in [_start(points)]
        },
    )


def _curve(model: str, kind: str, end: float, most: int) -> list[CurvePoint]:
    first = over_range(f"log10_r={_RANGE[0]}:{_RANGE[1]}", scene_at(-2.68))
    curve = Curve(kind, first, over_range(f"log10_V=2:{end}", scene_at(-2.68)), model, _TOLERANCE)
    for _ in ends_of(curve, StopAt(points=most)):
        pass
    return curve.points


def _start(points: list[CurvePoint]) -> CurvePoint:
    return min(points, key=lambda point: abs(point.second - 2.0))


def _fold_at(point: CurvePoint) -> float:
    """log10 r of the first fold at V = 100 and at the epsilon that has the product epsilon V of `point`."""
    scene = scene_at(-2.68)
    raised = with_parameter(scene, "epsilon", scene.upper.epsilon * 10.0 ** (point.second - 2.0))
    shift = point.second - 2.0
    over = over_range(f"log10_r={_RANGE[0] + shift}:{_RANGE[1] + shift}", raised)
    branch = FollowedBranch(over, "delay", _TOLERANCE)
    return float(branch.first_special(branch.begin(), "LP")[0].point.parameter)


def _below(model: str, point: CurvePoint) -> float:
    """Relative distance in r below the Hopf point."""
    scene = scene_at(-2.68)
    onset = onset_of(scene.law, scene.upper.epsilon, 10.0**point.second)
    critical = onset.r_delay if model == "delay" else onset.r_kelvin_voigt
    return float(1.0 - 10.0**point.first / critical)


def curve_verdicts(found: dict[Key, list[CurvePoint]], again: float) -> Iterator[Verdict]:
    """`again`: the end of the delay system's fold curve as log10 r of a fold at V = 100 (`_fold_at`)."""
    end, known = found["delay", "LP"][-1], reference()["special"]["delay"]["first fold"]["log10_r"]
    title = "Only the products εV and rV matter: the fold at V is that at V = 100 with ε and r larger by V/100"
    remark = f"log_{{10}} r of the end of the delay system’s fold curve, V = {10.0**end.second:.1f}, against a branch of its own"
    yield claim(title, EXACT, end.first + end.second - 2.0, ROUNDING, remark, near=again)
    here = _start(found["delay", "LP"]).first
    title = "The fold curve passes the known fold"
    yield claim(title, WITNESS, here, 2.0 * half_digit(known), "log_{10} r at V = 100, lifted shooting", near=known)
    folds = [(model, point) for (model, kind), points in found.items() if kind == "LP" for point in points]
    depths, speeds = [_below(*fold) for fold in folds], sorted(10.0**point.second for _, point in folds)
    low, high = speeds[0], speeds[-1]
    yield in_range(
        "P8 The Hopf point is very mildly subcritical, at other V (and so at other ε) too",
        PAPER,
        (0.0, JUST_BELOW),
        depths,
        f"of r_{{c}}, how far below lie {len(depths)} folds at V from {low:.0f} to {high:.0f}; at fixed V that is ε from "
        f"{plain(2.8e-7 * low, '.2g')} to {plain(2.8e-7 * high, '.2g')}",
        ".2%",
    )


def _answer(found: dict[Key, list[CurvePoint]]) -> str:
    depths = [_below("delay", point) for point in found["delay", "LP"]]
    return (
        "Through the products εV and rV alone. The first fold stays near the Hopf point, "
        f"{100 * min(depths):.2f} to {100 * max(depths):.2f} % below it in r in the exact system."
    )


def _table(found: dict[Key, list[CurvePoint]]) -> Table:
    rows = [
        # the imaginary part of a real multiplier is rounding
        (
            f"{_KINDS[kind][0]}, {model}",
            10.0**p.second,
            p.first,
            p.period,
            p.multiplier[0],
            p.multiplier[1] if kind == "NS" else None,
        )
        for (model, kind), points in found.items()
        for p in points[:: max(1, len(points) // 8)]
    ]
    heading = "point | V [V*] .6g | log_{10} r .10f | T [transits] .7f | Re .6f | Im .6f"
    return table("curves", "Points of the curves at ε = 2.8 · 10^{−5}, with the multiplier that passes.", heading, rows)


def _diagram(found: dict[Key, list[CurvePoint]]) -> Drawing:
    """Folds relative to the Hopf point; their period; and, where there are any, torus points and period doublings over V."""
    figure, far = canvas(WIDTH, 4.2), {key: points for key, points in found.items() if key[1] != "LP"}
    near, period, *others = np.atleast_1d(figure.subplots(1, 3 if far else 2)).tolist()
    for (model, kind), points in found.items():
        label, dashes = _KINDS[kind]
        look = {"color": style_of(model).color, "linestyle": dashes, "label": f"{label}, {style_of(model).label}"}
        velocity = [10.0**point.second for point in points]
        if kind == "LP":
            near.plot(velocity, [-100.0 * _below(model, point) for point in points], **look)
            period.plot(velocity, [point.period for point in points], **look)
        else:
            others[0].plot(velocity, [point.first for point in points], **look)
    grey: Any = {"color": "#777777", "linewidth": 0.9, "label": "Hopf point (39)"}
    near.axhline(0.0, **grey)
    low, high = period.dataLim.intervalx
    scene, grid = scene_at(-2.68), np.linspace(low, high, 40)
    closed = [onset_of(scene.law, scene.upper.epsilon, float(velocity)) for velocity in grid]
    period.plot(grid, [2.0 * math.pi / (one.omega_c * one.r_delay) for one in closed], **grey)
    near.set(ylabel="$r/r_c - 1$ (%)")
    period.set(ylabel="$T$ (transits)")
    for axes in others:
        axes.set(ylabel=r"$\log_{10} r$")
    for axes in (near, period, *others):
        axes.set_xlabel("$V/V^*$")
        axes.grid(True)
    lines = [line for axes in (near, *others) for line in axes.get_lines()]
    figure.legend(handles=lines, loc="outside upper left", ncols=2)
    return figure


_CAPTION = (
    "Special points over V at ε = 2.8 · 10^{−5}; by the products εV and rV these are their curves over ε too. Folds: r relative "
    "to the Hopf point of each system, and the period, with T = 2π/(ω_{c} r_{c}) of the Hopf point in grey. In a full report "
    "also the first torus point of the delay system and the first period doubling of the ODE."
)
_TURNS = (
    "The curves of the first torus point and of the first period doubling turn back in V just below 100 and lead towards the "
    "second point of their pair: at smaller V the unstable window between both is gone. The paper’s V lies near such turns."
)

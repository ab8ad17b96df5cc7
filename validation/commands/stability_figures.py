"""Charts of the stability of steady sliding: leading roots, the pair's impedance and what its faces reflect over frequency."""

import math
from typing import Any

import numpy as np

from reduced.impedance import impedance
from reduced.stability import Stability
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.chart import BLUE, DASHED, GREY, GUIDE, ORANGE, POINTS, Chart, Look, Panel, Scale, Second, Trace
from validation.commands.faces import watched

_POINTS, _CYCLES, _BELOW = 1000, 1.4, 30.0
"""Points of a curve; its end, in cycles per transit, and its beginning, below the frequency at which faces are judged."""


def stability_chart(scene: Scene, found: Stability, one_port: str) -> Chart:
    """Leading roots in the complex plane: those right of the dashed line grow. Below |Z(i omega)| of the pair over its Z for fast
    waves, under the analysed model and exact, and |R| of faces that are not rigid. Grey lines mark the leading root's frequency
    and the rates below which a grip is its spring."""
    roots = np.asarray(found.leading_roots, dtype=complex)
    shown = Trace("roots", roots.real, roots.imag, POINTS.but(hollow=True))
    edge = Trace("", [0.0, 0.0], [-np.inf, np.inf], GUIDE.but(color=GREY, dashes="--"))
    sides = Scale("growth rate Re s / (V*/L)"), Scale("frequency Im s / (V*/L)")
    omega = watched(scene, complex(roots[0]) if roots.size else 0j)
    along, marks = _frequencies(scene, omega), [_mark(omega, "leading root", ":")] if omega > 0.0 else []
    panels = [Panel("", *sides, [shown, edge]), _impedance(scene, one_port, found.model, marks, along)]
    curves, springs = list[Trace](), list[Trace]()
    for name, slab in ((name, slab) for name, slab in scene.named_slabs if not slab.termination.is_rigid):
        look, rate = Look(ORANGE, DASHED) if curves else Look(BLUE), slab.termination.spring_rate
        curves.append(Trace(f"{name} face", along, np.abs(slab.reflection(1j * along)), look))
        springs += [_mark(rate, "below, it is its spring", DASHED)] if 0.0 < rate < math.inf else []
    if curves:
        panels.append(
            Panel("", _scale(scene, along), Scale("reflected by the face, |R|"), [*curves, *marks, *springs], legend="best")
        )
    title = f"{scene.name}, {found.model}: steady sliding"
    return Chart(panels, 3.0 * len(panels), title=title, share=("", ""))


def _frequencies(scene: Scene, omega: float) -> Array:
    """Angular frequencies (V*/L) from below `omega` and the rates of faces to above these and the slabs' own first waves."""
    rates = [slab.termination.spring_rate for _, slab in scene.named_slabs]
    known = [rate for rate in (omega, *rates, 1.0 / scene.transit) if 0.0 < rate < math.inf]
    last = max(2.0 * math.pi * _CYCLES / scene.transit, 3.0 * max(known))
    return np.unique([*np.geomspace(min(known) / _BELOW, last, _POINTS), *np.linspace(last / _POINTS, last, _POINTS)])


def _mark(rate: float, name: str, dashes: Any) -> Trace:
    return Trace(name, [rate] * 2, [-np.inf, np.inf], GUIDE.but(color=GREY, width=1.0, dashes=dashes))


def _scale(scene: Scene, along: Array) -> Scale:
    size, unit = (1.0 / scene.units.time, "Hz") if scene.units else (scene.transit, "cycles per transit")
    second = Second(f"frequency / {unit}" if scene.units else unit, size / (2.0 * math.pi))
    return Scale("angular frequency omega / (V*/L)", "log", (float(along[0]), float(along[-1])), second=second)


def _impedance(scene: Scene, one_port: str, model: str, marks: list[Trace], along: Array) -> Panel:
    names = {one_port: model} if one_port == "delay" else {"delay": "exact", one_port: model}
    looks = [Look(GREY), Look(BLUE, DASHED)][-len(names) :] if len(names) > 1 else [Look(BLUE)]
    curves = [
        Trace(label, along, np.abs(impedance(scene, 1j * along, name)) / scene.impedance, look)
        for (name, label), look in zip(names.items(), looks, strict=True)
    ]
    limits = float(max(1e-2, min(np.nanmin(one.columns["y"]) for one in curves))), None
    scale = Scale("|impedance of the pair| / Z", "log", limits)
    return Panel("", _scale(scene, along), scale, [*curves, *marks], legend="best")

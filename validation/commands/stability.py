"""`slipwave stability`: Stability of steady sliding from the slabs' impedance alone, for any scene and model."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from reduced.families import DELAY, REDUCTIONS
from reduced.impedance import impedance
from reduced.stability import Stability, analyse, friction_slopes
from reduced.stability.analyse import PhysicalStability, stability_in_si
from reduced.stability.crossing import FIRST_OCTAVE, LAST_OCTAVE
from slipwave.files import FIGURES
from slipwave.friction.law import ALWAYS_STABLE
from slipwave.input.assemble import SceneSource
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.scene import doubts
from validation.chart import BLUE, DASHED, GREY, GUIDE, ORANGE, POINTS, Chart, Look, Panel, Scale, SecondScale, Trace
from validation.commands.options import SceneOptions, command, option
from validation.commands.reasons import on_stability
from validation.commands.result import Output, Result, aligned, rounded
from validation.commands.wording import face_figures, header, watched
from validation.data.datasets import Dataset, new_dataset
from validation.models.by_name import family_of, one_port_of
from validation.models.provenance import provenance

_CRITICAL = {
    "omega_c": "critical frequency, in V*/L",
    "log10_r_c": "log10 of the critical round trip",
    "epsilon_c": "critical epsilon",
}

_PHYSICAL = {"critical_thickness": "m", "critical_normal_stress": "Pa", "growth_time": "s", "decay_time": "s", "frequency": "Hz"}

_OWN_FACES = (
    "log10_r_c and epsilon_c hold for faces that keep their ratios to the slabs; --set and the critical thickness leave a face "
    "in units of its own as it is"
)

_POINTS, _CYCLES, _BELOW = 1000, 1.4, 30.0
"""Points of a curve; its end, in cycles per transit, and its beginning, below the frequency at which faces are judged."""


class _StabilityOptions(SceneOptions):
    """Options of `slipwave.stability`."""

    EXAMPLES: ClassVar = ("slipwave stability paper", "slipwave stability grip --model fitted:4 --json")

    model: str = option(
        f"{DELAY.name} (exact; so are auto and the full-wave models), "
        f"{', '.join(family.pattern for family in REDUCTIONS)}, or taylor (the truncation that cannot be used)",
        "delay",
        positional=True,
    )


class StabilityResult(Result):
    """The `analysis` of steady sliding of the `scene`."""

    OUTPUTS: ClassVar = (
        Output("--plot", FIGURES, "save_plot", "draw roots, and impedance and faces over frequency: .png, .pdf or .svg"),
    )

    scene: Scene
    analysis: Stability

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`; frequencies and roots in 1/(L/V*)."""
        analysis = self.analysis
        result: dict[str, Any] = {
            "scene": self.scene.name,
            "model": analysis.model,
            **{name: getattr(analysis, name) for name in (*_CRITICAL, "velocity", "stable", "unstable_roots")},
            "leading_roots": [[root.real, root.imag] for root in analysis.leading_roots],
            "essential_abscissa": analysis.essential_abscissa,
            "faces": face_figures(self.scene, watched(self.scene, self._root)),
            "notes": [*doubts(self.scene), *self.notes],
        }
        if self.physical:
            result["si"] = {f"{name}_{unit}": getattr(self.physical, name) for name, unit in _PHYSICAL.items()}
        return result

    @property
    def _root(self) -> complex:
        return self.analysis.leading_roots[0] if self.analysis.leading_roots else 0j

    @property
    def leading_roots(self) -> "np.ndarray[Any, np.dtype[np.complex128]]":
        """The leading roots, in 1/(L/V*), the fastest growing one first."""
        return np.asarray(self.analysis.leading_roots, dtype=complex)

    @property
    def reason(self) -> str:
        """Text: whether steady sliding is stable, and what would change that."""
        return on_stability(self.scene, self.analysis)

    @cached_property
    def physical(self) -> PhysicalStability | None:
        """The stability in SI, None for a scene without units."""
        return stability_in_si(self.scene, self.analysis)

    @cached_property
    def dataset(self) -> Dataset:
        """The leading roots by `root`, and the critical values."""
        roots = self.leading_roots
        values: dict[str, Any] = {}
        for part, numbers in (("real", roots.real), ("imaginary", roots.imag)):
            notes = {"long_name": f"{part} part of the root, in 1/(L/V*)", "units": "1"}
            values[f"root_{part}"] = ("root", numbers, notes)
        for name, meaning in _CRITICAL.items():
            value = self.summary[name]
            values[name] = ((), np.nan if value is None else value, {"long_name": meaning, "units": "1"})
        return new_dataset(values, attrs=provenance("stability", self.scene, self.analysis.model, {}))

    def chart(self) -> Chart:
        """Leading roots in the complex plane: those right of the dashed line grow. Below |Z(i omega)| of the pair over its Z for
        fast waves, under the analysed model and exact, and |R| of faces that are not rigid. Grey lines mark the leading root's
        frequency and the rates below which a grip is its spring."""
        scene, analysis, roots = self.scene, self.analysis, self.leading_roots
        shown = Trace("roots", roots.real, roots.imag, POINTS.but(hollow=True))
        edge = Trace("", [0.0, 0.0], [-np.inf, np.inf], GUIDE.but(color=GREY, dashes="--"))
        sides = Scale("growth rate Re s / (V*/L)"), Scale("frequency Im s / (V*/L)")
        omega = watched(scene, self._root)
        # frequencies (V*/L) from below the root's and the rates of faces to above these and the slabs' own first waves
        rates = [slab.termination.spring_rate for _, slab in scene.named_slabs]
        known = [rate for rate in (omega, *rates, 1.0 / scene.transit) if 0.0 < rate < math.inf]
        last = max(2.0 * math.pi * _CYCLES / scene.transit, 3.0 * max(known))
        along = np.unique([*np.geomspace(min(known) / _BELOW, last, _POINTS), *np.linspace(last / _POINTS, last, _POINTS)])
        marks = [_mark(omega, "leading root", ":")] if omega > 0.0 else []
        panels = [Panel("", *sides, [shown, edge]), _impedance(scene, one_port_of(analysis.model), analysis.model, marks, along)]
        curves, springs = list[Trace](), list[Trace]()
        for name, slab in ((name, slab) for name, slab in scene.named_slabs if not slab.termination.is_rigid):
            look, rate = Look(ORANGE, DASHED) if curves else Look(BLUE), slab.termination.spring_rate
            curves.append(Trace(f"{name} face", along, np.abs(slab.reflection(1j * along)), look))
            springs += [_mark(rate, "below, it is its spring", DASHED)] if 0.0 < rate < math.inf else []
        if curves:
            panels.append(
                Panel("", _scale(scene, along), Scale("reflected by the face, |R|"), [*curves, *marks, *springs], legend="best")
            )
        title = f"{scene.name}, {analysis.model}: steady sliding"
        return Chart(panels, 3.0 * len(panels), title=title, share=("", ""))

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The scene, the verdict with its reason, critical values and leading roots."""
        scene, analysis = self.scene, self.analysis
        yield from header(scene, root=self._root)
        verdict = "stable" if analysis.stable else f"unstable: {analysis.unstable_roots} growing roots (certified count)"
        verdict = "neutral" if analysis.stable is None else verdict
        yield f"model {analysis.model}: steady sliding is {verdict} at V = {analysis.velocity:g}"
        yield self.reason
        yield from (f"note: {note}" for note in self.notes)
        yield ""
        rows = [
            ["critical frequency omega_c [V*/L]", rounded(analysis.omega_c, 12), ""],
            ["critical round trip log10 r_c", rounded(analysis.log10_r_c, 12), f"scene {rounded(math.log10(scene.transit), 10)}"],
            ["critical epsilon", rounded(analysis.epsilon_c, 12), f"scene {rounded(scene.upper.epsilon, 10)}"],
            ["limit of the fast roots, Re s [V*/L]", rounded(analysis.essential_abscissa, 10), ""],
        ]
        yield from aligned(["", "critical", "here"], [*rows, *self._rows_in_si()])
        yield ""
        roots = [
            [f"{rounded(root.real, 8)} {root.imag:+.8g} i", rounded(abs(root.imag) * scene.transit / (2.0 * math.pi), 6)]
            for root in analysis.leading_roots
            if root.imag >= 0.0
        ]
        yield from aligned(["leading roots s [V*/L], conjugates left out", "cycles per transit"], roots)

    def _rows_in_si(self) -> list[list[str]]:
        """Rows of the table for a scene with units."""
        scene, physical = self.scene, self.physical
        if physical is None or scene.units is None:
            return []
        word, time = ("growth", physical.growth_time) if self.analysis.stable is False else ("decay", physical.decay_time)
        slabs = "thickness" if scene.alike else "upper thickness, both scaled together"
        stress, critical = scene.units.normal_stress, physical.critical_normal_stress
        return [
            [f"critical {slabs} [m]", rounded(physical.critical_thickness, 9), f"scene {rounded(physical.thickness, 9)}"],
            ["critical normal stress [Pa]", rounded(critical, 9), f"scene {rounded(stress, 9)}"],
            [f"{word} time of the leading root [s]", "", rounded(time, 9)],
            ["frequency of the leading root [Hz]", "", rounded(physical.frequency, 9)],
        ]

    @property
    def notes(self) -> list[str]:
        """Notes on the numbers: the V of a ramp, the reason for no verdict on a neutral root, values not found and values that do
        not exist."""
        notes, analysis = [], self.analysis
        if not self.scene.drive.is_constant:
            notes.append(
                f"the drive changes: this is steady sliding at V = {analysis.velocity:g}, the one at t = 0; set "
                "drive.velocity for others"
            )
        if analysis.stable is None:
            notes.append(
                f"neutral within rounding: the leading root's real part {analysis.rate:.2g} cannot be told from 0; no other root "
                "grows"
            )
        if analysis.endless:
            notes.append(
                f"infinitely many roots accumulate at Re s = {analysis.essential_abscissa:.6g} V*/L, right of all that are "
                "listed: no finite list holds those that decay most slowly"
            )
        if not math.isnan(analysis.log10_r_c) and _has_own_faces(self.scene):
            notes.append(_OWN_FACES)
        absent = self._absent() if family_of(analysis.model) else []  # no family: a truncation that no scene is computed with
        return [*notes, *analysis.missing, *(self.physical.missing if self.physical else ()), *absent]

    def _absent(self) -> Iterator[str]:
        """Reasons for critical values that do not exist, if not stated elsewhere."""
        analysis = self.analysis
        if not friction_slopes(self.scene.law, self.scene.velocity).weakening:
            yield f"no critical values: {ALWAYS_STABLE}"
            return
        missing = " ".join([*analysis.missing, *(self.physical.missing if self.physical else ())])
        reach = f"between {2.0**FIRST_OCTAVE:.2g} and {2.0**LAST_OCTAVE:g} times"
        if math.isnan(analysis.log10_r_c) and "the critical r " not in missing:
            yield f"no critical r: steady sliding loses its stability at no r {reach} the present one"
        if math.isnan(analysis.epsilon_c) and "the critical epsilon" not in missing:
            yield "no critical epsilon: there is none above which steady sliding is stable and just below which it is not"
        if self.physical and math.isnan(self.physical.critical_thickness) and "the critical thickness" not in missing:
            yield f"no critical thickness: steady sliding loses its stability at none {reach} the present one"


@command
def stability(source: SceneSource, options: _StabilityOptions) -> StabilityResult:
    """Stability of steady sliding from the slabs' impedance alone, for any scene and model. Raises SceneError for wrong input."""
    scene, model = options.scene_of(source), options.model
    analysis = replace(analyse(scene, one_port_of(model)), model=DELAY.name if model == "auto" else model)
    return StabilityResult(scene, analysis)


def _has_own_faces(scene: Scene) -> bool:
    """Whether an outer face that is not rigid is given in units of its own, not relative to its slab."""
    return any(slab.face.own for _, slab in scene.named_slabs)


def _mark(rate: float, name: str, dashes: Any) -> Trace:
    return Trace(name, [rate] * 2, [-np.inf, np.inf], GUIDE.but(color=GREY, width=1.0, dashes=dashes))


def _scale(scene: Scene, along: Array) -> Scale:
    size, unit = (1.0 / scene.units.time, "Hz") if scene.units else (scene.transit, "cycles per transit")
    second = SecondScale(f"frequency / {unit}" if scene.units else unit, size / (2.0 * math.pi))
    return Scale("angular frequency omega / (V*/L)", "log", (float(along[0]), float(along[-1])), second=second)


def _impedance(scene: Scene, one_port: str, model: str, marks: list[Trace], along: Array) -> Panel:
    names = {one_port: model} if one_port == "delay" else {"delay": "exact", one_port: model}
    looks = [Look(GREY), Look(BLUE, DASHED)][-len(names) :] if len(names) > 1 else [Look(BLUE)]
    curves = [
        Trace(label, along, np.abs(impedance(scene, 1j * along, name)) / scene.impedance, look)
        for (name, label), look in zip(names.items(), looks, strict=True)
    ]
    limits = float(max(1e-2, min(np.nanmin(curve.columns["y"]) for curve in curves))), None
    scale = Scale("|impedance of the pair| / Z", "log", limits)
    return Panel("", _scale(scene, along), scale, [*curves, *marks], legend="best")

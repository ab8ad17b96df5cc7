"""`slipwave.stability`: stability of steady sliding, its critical values, and the growth of small disturbances."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from reduced.families import DELAY, REDUCTIONS
from reduced.stability import Stability, analyse, friction_slopes
from reduced.stability.analyse import PhysicalStability, stability_in_si
from reduced.stability.crossing import FIRST_OCTAVE, LAST_OCTAVE
from slipwave.files import FIGURES
from slipwave.input import SceneSource
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.chart import Chart
from validation.commands.command import command
from validation.commands.faces import face_figures, watched
from validation.commands.options import SceneOptions, option
from validation.commands.reasons import on_stability
from validation.commands.result import Output, Result, aligned, rounded
from validation.commands.stability_figures import stability_chart
from validation.commands.wording import header
from validation.data.datasets import Dataset, new_dataset
from validation.models.by_name import one_port_of
from validation.models.provenance import provenance

_CRITICAL = {
    "omega_c": "critical frequency, in V*/L",
    "log10_r_c": "log10 of the critical round trip",
    "epsilon_c": "critical epsilon",
}

_PHYSICAL = {"critical_thickness": "m", "critical_normal_stress": "Pa", "growth_time": "s", "decay_time": "s", "frequency": "Hz"}


@dataclass(frozen=True, kw_only=True)
class StabilityOptions(SceneOptions):
    """Options of `slipwave.stability`."""

    EXAMPLES: ClassVar = ("slipwave stability paper", "slipwave stability grip --model fitted:4 --json")

    model: str = option(
        f"{DELAY.name} (exact; so are auto and the full-wave models), "
        f"{', '.join(family.pattern for family in REDUCTIONS)}, or taylor (the truncation that cannot be used)",
        "delay",
        positional=True,
    )


@dataclass(frozen=True, repr=False, eq=False)
class StabilityResult(Result):
    """The stability `found` of steady sliding of the `scene`."""

    OUTPUTS: ClassVar = (
        Output("--plot", FIGURES, "save_plot", "draw roots, and impedance and faces over frequency: .png, .pdf or .svg"),
    )

    scene: Scene
    found: Stability

    @property
    def facts(self) -> dict[str, Any]:
        """As `Result`; frequencies and roots in 1/(L/V*)."""
        found = self.found
        result: dict[str, Any] = {
            "scene": self.scene.name,
            "model": found.model,
            **{name: getattr(found, name) for name in (*_CRITICAL, "velocity", "stable", "unstable_roots")},
            "leading_roots": [[root.real, root.imag] for root in found.leading_roots],
            "essential_abscissa": found.essential_abscissa,
            "faces": face_figures(self.scene, watched(self.scene, self._root)),
            "notes": [*doubts(self.scene), *self.notes],
        }
        if self.physical:
            result["si"] = {f"{name}_{unit}": getattr(self.physical, name) for name, unit in _PHYSICAL.items()}
        return result

    @property
    def _root(self) -> complex:
        return self.found.leading_roots[0] if self.found.leading_roots else 0j

    @property
    def leading_roots(self) -> "np.ndarray[Any, np.dtype[np.complex128]]":
        """The leading roots, in 1/(L/V*), the fastest growing one first."""
        return np.asarray(self.found.leading_roots, dtype=complex)

    @property
    def reason(self) -> str:
        """Text: whether steady sliding is stable, and what would change that."""
        return on_stability(self.scene, self.found)

    @cached_property
    def physical(self) -> PhysicalStability | None:
        """The stability in SI, None for a scene without units."""
        return stability_in_si(self.scene, self.found)

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
        return new_dataset(values, attrs=provenance("stability", self.scene, self.found.model, {}))

    def chart(self) -> Chart:
        """The leading roots, the pair's impedance and |R| of its faces over frequency."""
        return stability_chart(self.scene, self.found, one_port_of(self.found.model))

    def lines(self, summary: Mapping[str, Any]) -> Iterator[str]:
        """The scene, the verdict with its reason, critical values and leading roots."""
        scene, found = self.scene, self.found
        yield from header(scene, root=self._root)
        verdict = "stable" if found.stable else f"unstable: {found.unstable_roots} growing roots (certified count)"
        verdict = "neutral" if found.stable is None else verdict
        yield f"model {found.model}: steady sliding is {verdict} at V = {found.velocity:g}"
        yield self.reason
        yield from (f"note: {note}" for note in self.notes)
        yield ""
        rows = [
            ["critical frequency omega_c [V*/L]", rounded(found.omega_c, 12), ""],
            ["critical round trip log10 r_c", rounded(found.log10_r_c, 12), f"scene {rounded(math.log10(scene.transit), 10)}"],
            ["critical epsilon", rounded(found.epsilon_c, 12), f"scene {rounded(scene.upper.epsilon, 10)}"],
            ["limit of the fast roots, Re s [V*/L]", rounded(found.essential_abscissa, 10), ""],
        ]
        yield from aligned(["", "critical", "here"], [*rows, *self._rows_in_si()])
        yield ""
        roots = [
            [f"{rounded(root.real, 8)} {root.imag:+.8g} i", rounded(abs(root.imag) * scene.transit / (2.0 * math.pi), 6)]
            for root in found.leading_roots
            if root.imag >= 0.0
        ]
        yield from aligned(["leading roots s [V*/L], conjugates left out", "cycles per transit"], roots)

    def _rows_in_si(self) -> list[list[str]]:
        """Rows of the table for a scene with units."""
        scene, found = self.scene, self.physical
        if found is None or scene.units is None:
            return []
        word, time = ("growth", found.growth_time) if self.found.stable is False else ("decay", found.decay_time)
        slabs = "thickness" if scene.alike else "upper thickness, both scaled together"
        stress, critical = scene.units.normal_stress, found.critical_normal_stress
        return [
            [f"critical {slabs} [m]", rounded(found.critical_thickness, 9), f"scene {rounded(found.thickness, 9)}"],
            ["critical normal stress [Pa]", rounded(critical, 9), f"scene {rounded(stress, 9)}"],
            [f"{word} time of the leading root [s]", "", rounded(time, 9)],
            ["frequency of the leading root [Hz]", "", rounded(found.frequency, 9)],
        ]

    @property
    def notes(self) -> list[str]:
        """Notes on the numbers: the V of a ramp, the reason for no verdict on a neutral root, values not found and values that do
        not exist."""
        notes, found = [], self.found
        if not self.scene.drive.is_constant:
            notes.append(
                f"the drive changes: this is steady sliding at V = {found.velocity:g}, the one at t = 0; set drive.velocity for "
                "others"
            )
        if found.stable is None:
            notes.append(
                f"neutral within rounding: the leading root's real part {found.rate:.2g} cannot be told from 0; no other root "
                "grows"
            )
        if found.endless:
            notes.append(
                f"infinitely many roots accumulate at Re s = {found.essential_abscissa:.6g} V*/L, right of all that are listed: "
                "no finite list holds those that decay most slowly"
            )
        absent = [] if found.model == "taylor" else self._absent()
        return [*notes, *found.missing, *(self.physical.missing if self.physical else ()), *absent]

    def _absent(self) -> Iterator[str]:
        """Reasons for critical values that do not exist, if not stated elsewhere."""
        found = self.found
        if not friction_slopes(self.scene.law, self.scene.velocity).weakening:
            yield "no critical values: friction does not weaken with the slip rate, so that steady sliding is always stable"
            return
        missing = " ".join([*found.missing, *(self.physical.missing if self.physical else ())])
        reach = f"between {2.0**FIRST_OCTAVE:.2g} and {2.0**LAST_OCTAVE:g} times"
        if math.isnan(found.log10_r_c) and "the critical r " not in missing:
            yield f"no critical r: steady sliding loses its stability at no r {reach} the present one"
        if math.isnan(found.epsilon_c) and "the critical epsilon" not in missing:
            yield "no critical epsilon: there is none above which steady sliding is stable and just below which it is not"
        if self.physical and math.isnan(self.physical.critical_thickness) and "the critical thickness" not in missing:
            yield f"no critical thickness: steady sliding loses its stability at none {reach} the present one"


@command
def stability(source: SceneSource, options: StabilityOptions) -> StabilityResult:
    """Stability of steady sliding from the slabs' impedance alone, for any scene and model. Raises SceneError for wrong input."""
    scene, model = options.scene_of(source), options.model
    found = replace(analyse(scene, one_port_of(model)), model=DELAY.name if model == "auto" else model)
    return StabilityResult(scene, found)

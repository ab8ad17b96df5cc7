"""`slipwave.stability`: is steady sliding stable, where does it lose stability, and how do small disturbances grow?"""

from dataclasses import dataclass, replace
from typing import Any

from reduced.families import DELAY
from reduced.stability import Stability, analyse
from slipwave.input import SceneSource
from slipwave.scene import Scene
from slipwave.scene.doubts import doubts
from validation.door.result import Result, finite, scene_of
from validation.registry.families import one_port_of


@dataclass(frozen=True, repr=False, eq=False)
class StabilityResult(Result):
    """What was `found` on steady sliding of the `scene`."""

    scene: Scene
    found: Stability

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave stability` (users rely on its keys); frequencies and roots in 1/(L/V*), None where there is no
        value."""
        found = self.found
        result = {
            "scene": self.scene.name,
            "model": found.model,
            "omega_c": found.omega_c,
            "log10_r_c": found.log10_r_c,
            "epsilon_c": found.epsilon_c,
            "velocity": found.velocity,
            "stable": found.stable,
            "unstable_roots": found.unstable_roots,
            "leading_roots": [[root.real, root.imag] for root in found.leading_roots],
            "essential_abscissa": found.essential_abscissa,
            "notes": [*doubts(self.scene), *self.notes],
        }
        return dict(finite(result))

    @property
    def notes(self) -> list[str]:
        """Remarks on the numbers: which V was taken on a ramp, why there is no verdict on a neutral root."""
        notes, found = [], self.found
        if not self.scene.drive.is_constant:
            notes.append(
                f"the drive changes: this is steady sliding at V = {found.velocity:g}, the one at t = 0; set drive.velocity for "
                "others"
            )
        if found.stable is None:
            notes.append(
                f"neutral within rounding: the leading root's real part {found.leading_roots[0].real:.2g} cannot be "
                "distinguished from 0; no other root grows"
            )
        return notes


def stability(source: SceneSource, model: str = "delay", **changes: Any) -> StabilityResult:
    """Stability of steady sliding from the slabs' impedance alone, for any scene and model; `changes` are those of
    `slipwave.read_scene`. Raises SceneError for wrong input."""
    scene = scene_of(source, changes)
    found = replace(analyse(scene, one_port_of(model)), model=DELAY.name if model == "auto" else model)
    return StabilityResult(scene, found)

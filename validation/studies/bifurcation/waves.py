"""The full wave's own periodic orbits, by Newton's method on the exactly marched grid, beside the delay system's branch."""

from typing import NamedTuple

from reduced.orbit import periodic_orbit
from reduced.orbit.approach import approach
from reduced.orbit.figures import figures_of
from validation.registry.orbits import moving
from validation.study.over_r import Branch, scene_at

WAVE, CELLS = "dg:7", 8
_TOLERANCE = 1e-8

COMPARED = ("period", "stress_drop", "elastic_stress_drop")


class WaveOrbit(NamedTuple):
    """Figures of the full wave's orbit at one r, and of the nearest orbit of the delay system's branch there, by period."""

    log10_r: float
    wave: dict[str, float]
    delay: dict[str, float]

    @property
    def apart(self) -> float:
        """Largest relative difference of period and drops."""
        return max(abs(self.wave[name] / self.delay[name] - 1.0) for name in COMPARED)


def wave_orbit(branch: Branch, log10_r: float) -> WaveOrbit:
    """The orbit that the full wave reaches from the scene's own start; `branch` is the delay system's."""
    model = moving(WAVE, scene_at(log10_r), _TOLERANCE, CELLS)
    wave = figures_of(periodic_orbit(*approach(model.solver, model.freeze)[:3], _TOLERANCE).closed)
    others = [figures_of(orbit) for orbit in branch.orbits_at(log10_r)]
    return WaveOrbit(log10_r, wave, min(others, key=lambda one: abs(one["period"] - wave["period"])))

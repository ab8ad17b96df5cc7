"""The periodic orbit of a scene, by a run that comes near it and Newton's method from there."""

import time
from dataclasses import dataclass

from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.approach import MOST_TRANSITS, approach
from slipwave.errors import SceneError
from slipwave.scene import Scene
from slipwave.step.flow import Flow
from validation.registry.flows import Moving
from validation.run.progress import progress

LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-11, 1e-2
_MESHES = 6.0


@dataclass(frozen=True)
class OrbitFound:
    """The orbit `found` to `tolerance` from a run of `transits` that had `settled` or not; run time in seconds."""

    found: PeriodicOrbit
    tolerance: float
    transits: float
    settled: bool
    wall_s: float

    @property
    def flow(self) -> Flow:
        """The model on the mesh of the orbit."""
        return self.found.closed.flow

    @property
    def scene(self) -> Scene:
        """Whose orbit."""
        return self.flow.scene

    @property
    def notes(self) -> list[str]:
        """Remarks on the numbers: what they do not say by themselves."""
        notes = [self.found.multipliers.reason] if self.found.multipliers.reason else []
        if not self.found.settled:
            notes.append(f"the requested error of {self.tolerance:g} was not reached on the finest mesh: see error_estimate")
        if not self.settled:
            notes.append(f"found from a run of {self.transits:.0f} transits that had not settled: its cycles still changed")
        return notes


def require_tolerance(tolerance: float) -> None:
    """Raises SceneError if no orbit can be computed to `tolerance`."""
    if not LEAST_TOLERANCE <= tolerance <= LARGEST_TOLERANCE:
        raise SceneError(f"tol = {tolerance:g}: must lie in [{LEAST_TOLERANCE:g}, {LARGEST_TOLERANCE:g}] for an orbit")


def find_orbit(model: Moving, tolerance: float) -> OrbitFound:
    """The orbit that the scene's own start leads to, or comes near to. Raises NumericsError if there is none."""
    began, solver = time.perf_counter(), model.solver
    label = f"{solver.scene.name}, {solver.model}"
    with progress(f"{label}, on the way to an orbit", MOST_TRANSITS) as report:
        guess = approach(solver, model.freeze, progress=report)
    with progress(f"{label}, orbit", _MESHES) as report:
        done = iter(range(int(_MESHES) + 1))
        found = periodic_orbit(*guess[:3], tolerance, lambda _: report(float(next(done))))
    return OrbitFound(found, tolerance, solver.time, guess.settled, time.perf_counter() - began)

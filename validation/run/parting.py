"""How fast motions close to that of a run part from it: its largest Lyapunov exponent, by a second march beside it."""

import math

from slipwave.errors import SceneError
from slipwave.observe import Solver
from slipwave.observe.foresight import DAY
from slipwave.observe.lyapunov import INTERVALS, TRANSIENT, Exponent, largest_exponent
from slipwave.scene import Scene
from validation.run.outlook import outlook
from validation.run.progress import progress
from validation.run.simulate import Run


def require_constant(scene: Scene) -> None:
    """Raises SceneError if the drive changes: then motions part because they are driven."""
    if not scene.drive.is_constant or scene.velocity == 0.0:
        raise SceneError(f"scene {scene.name!r}: a Lyapunov exponent needs a constant drive.velocity")


def exponent_of(done: Run, twin: Solver, model: str, most_seconds: float = DAY) -> Exponent:
    """The exponent of the motion from the end of a run on; `twin` is another solver of its scene, and `model` one with the
    one-port of the model that ran.

    Raises as `largest_exponent`."""
    solver = done.solver
    period = float(done.events.period[-1]) if done.events.period.size else outlook(solver.scene, model).period
    cycle = period if math.isfinite(period) else 1.0
    with progress(f"{solver.scene.name}, {solver.model}, beside a second motion", float(TRANSIENT + INTERVALS)) as report:
        return largest_exponent(solver, twin, cycle, report, most_seconds=most_seconds)

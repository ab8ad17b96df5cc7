"""How fast motions close to that of a run part from it: its largest Lyapunov exponent, by a second march beside it."""

import math

from slipwave.errors import NumericsError, SceneError
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from slipwave.solve import Solver
from slipwave.solve.foresight import DAY
from slipwave.solve.lyapunov import INTERVALS, TRANSIENT, Exponent, largest_exponent
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

    Raises NumericsError for a run whose cycles do not represent its motion: a disturbance of steady sliding fades or grows as
    `slipwave stability` says, and a transient has no exponent; else as `largest_exponent`."""
    solver = done.solver
    if done.verdict is not None and not done.verdict.repeats:
        advice = "run longer" if done.verdict.kind in ("too short", "settling") else "slipwave stability gives its rate"
        raise NumericsError(
            f"{solver.model}: a Lyapunov exponent is measured of runs with the verdict {', '.join(REPEATING[:-1])} or "
            f"{REPEATING[-1]}; this one is {done.verdict.kind}: {advice} (scene {solver.scene.name!r})"
        )
    period = float(done.events.period[-1]) if done.events.period.size else outlook(solver.scene, model).period
    cycle = period if math.isfinite(period) else 1.0
    with progress(f"{solver.scene.name}, {solver.model}, beside a second motion", float(TRANSIENT + INTERVALS)) as report:
        return largest_exponent(solver, twin, cycle, report, most_seconds=most_seconds)

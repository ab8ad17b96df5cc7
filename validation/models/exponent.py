"""The largest Lyapunov exponent of the motion at the end of a run, from a second, perturbed run."""

import math

from slipwave.errors import NumericsError, SceneError
from slipwave.observe.verdict import REPEATING
from slipwave.scene import Scene
from slipwave.solve import has_fields
from slipwave.solve.lyapunov import INTERVALS, TRANSIENT, Exponent, largest_exponent
from validation.models.build import prepare
from validation.models.by_name import Options, one_port_of
from validation.models.outlook import outlook
from validation.models.progress import progress
from validation.models.run import Run


def require_constant(scene: Scene) -> None:
    """Raises SceneError if the drive changes: a Lyapunov exponent needs a constant drive."""
    if not scene.drive.is_constant or scene.velocity == 0.0:
        raise SceneError(f"scene {scene.name!r}: a Lyapunov exponent needs a constant drive.velocity")


def exponent_of(done: Run, numerical: Options, most_seconds: float) -> Exponent:
    """The exponent of the motion from the end of a run on; the second solver has the same `numerical` options, but a grid chosen
    for a tolerance is not chosen again.

    Raises NumericsError for a run whose cycles do not represent its motion: a disturbance of steady sliding fades or grows as
    `slipwave stability` says, and a transient has no exponent; else as `largest_exponent`."""
    solver, scene = done.solver, done.solver.scene
    if done.verdict is not None and not done.verdict.repeats:
        advice = "run longer" if done.verdict.kind in ("too short", "settling") else "slipwave stability gives its rate"
        raise NumericsError(
            f"{solver.model}: a Lyapunov exponent is measured of runs with the verdict {', '.join(REPEATING[:-1])} or "
            f"{REPEATING[-1]}; this one is {done.verdict.kind}: {advice} (scene {scene.name!r})"
        )
    if has_fields(solver):
        numerical = numerical | Options(cells=solver.cells, tolerance=solver.settings.get("resolution"))
    twin = prepare(solver.model, scene, True, **numerical).solver
    period = float(done.events.period[-1]) if done.events.period.size else outlook(scene, one_port_of(solver.model)).period
    cycle = period if math.isfinite(period) else 1.0
    with progress(f"{scene.name}, {solver.model}, and a perturbed run", float(TRANSIENT + INTERVALS)) as report:
        return largest_exponent(solver, twin, cycle, report, most_seconds=most_seconds)

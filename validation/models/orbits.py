"""The periodic orbit of a scene, by a run that comes near it and Newton's method."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import cast

from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.approach import MOST_TRANSITS, FlowingSolver, Guess, guesses
from reduced.orbit.closing import Closed, close
from reduced.orbit.periodic import repeats_sooner
from slipwave.errors import NumericsError, SceneError
from slipwave.family import Family
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.scene import Scene
from slipwave.scene.drive import StartKind
from slipwave.solve import FieldSolver
from slipwave.step.flow import Flow
from validation.models.by_name import DELAY, GRIDS, families, family_of, honouring, make, requested, resolve
from validation.models.outlook import expected_period
from validation.models.progress import News, progress

LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-11, 1e-2
_RUN = 1e-6  # tolerance of a run that only has to come near an orbit
_MESHES = 6.0
_CYCLES = 25.0  # expected in a run before it is given up
_LONGEST_EXPECTED = 3e4  # transits; steel on PMMA, with periods of 22,444, takes 20 s
_CHANGING = "its cycles still changed; --others and --near-period look for other orbits"
_OTHER = 0.05  # relative difference of the periods on two grids from which they are of different orbits
_SAME = 1e-6  # relative difference of two periods on one mesh that count as one orbit's


@dataclass(frozen=True)
class SceneOrbit:
    """The `periodic` orbit of a scene, computed to `tolerance`; `source`, its origin if not a settled run; the periods and
    stability, in words, of `others` found with it; `searched`, a text on how far others were searched for; `grid`, one on the
    error of a full wave's grid."""

    periodic: PeriodicOrbit
    tolerance: float
    source: str = ""
    others: tuple[str, ...] = ()
    searched: str = ""
    grid: str = ""

    @property
    def flow(self) -> Flow:
        """The flow on the mesh of the orbit."""
        return self.periodic.closed.flow

    @property
    def scene(self) -> Scene:
        """The scene of the orbit."""
        return self.flow.scene

    @property
    def notes(self) -> list[str]:
        """Notes on the limits of the numbers."""
        coarse = f"the requested error of {self.tolerance:g} was not reached on the finest mesh: see error_estimate"
        periods = ", ".join(self.others)
        others = f"other orbits of this scene have the periods {periods}: --near-period finds one of them"
        settled, reason = self.periodic.settled, self.periodic.multipliers.reason
        notes = [reason, "" if settled else coarse, self.grid, self.source, others if self.others else "", self.searched]
        return [note for note in notes if note]


def has_flow(family: Family) -> bool:
    """Whether the motion of its members over a period is a differentiable map; not that of the leapfrog, whose steps cannot be
    fractions of a period."""
    return family not in GRIDS or "time" in family.options


def flowing(model: str, scene: Scene) -> tuple[str, str]:
    """As `resolve`, among the models that have a flow. Raises SceneError for any other, and if the drive changes."""
    if not scene.drive.is_constant:
        raise SceneError(f"scene {scene.name!r}: a periodic orbit needs a constant drive.velocity")
    model, why = resolve(model, scene, [family for family in families() if has_flow(family)])
    family = family_of(model)
    if family is not None and not has_flow(family):
        able = ", ".join(other.pattern for other in honouring(scene) if has_flow(other))
        raise SceneError(
            f"model = {model!r}: its steps cannot be fractions of a period, so it gives no orbits; models that do: {able}"
        )
    return model, why


def moving(model: str, scene: Scene, cells: int | None = None) -> FlowingSolver:
    """The solver of `model` for a run to an orbit. Full waves march exactly; a start on the orbit is replaced by the nudge.

    Raises SceneError if the drive changes, as `prepare` does, and for a model without flow.
    """
    model, _ = flowing(model, scene)
    if scene.start.kind is StartKind.ORBIT:
        scene = replace(scene, start=replace(scene.start, kind=StartKind.NUDGE))
    asked = requested(model, scene, cells=cells, time="exact" if family_of(model) in GRIDS else None)
    known, scene, *_ = asked
    if known is DELAY:
        from reduced.delay.network import DelayNetwork

        return DelayNetwork(scene, tolerance=_RUN)
    return cast(FlowingSolver, make(*asked).solver)


def find_orbit(model: str, scene: Scene, tolerance: float, cells: int | None = None) -> SceneOrbit:
    """The orbit of `model` that the scene's own start leads to, or comes near to. Raises NumericsError if there is none."""
    solver, failed, news = moving(model, scene, cells), None, News()
    for guess in _guesses(solver, tolerance):
        try:
            source = "" if guess.settled else f"found from a run of {solver.time:.0f} transits that had not settled: {_CHANGING}"
            return SceneOrbit(refined_orbit(solver.scene, guess, tolerance), tolerance, source)
        except NumericsError as reason:
            failed = failed or reason
            news("no orbit of scene %r at t = %.0f of its run; looking on", scene.name, solver.time)
    assert failed is not None
    raise failed


def with_error_of_grid(done: SceneOrbit, cells: int | None = None) -> SceneOrbit:
    """`done`, an orbit on the grid of `cells`, with the error of that grid added to those of its figures: `GRID_MARGIN` times
    their change on another grid, if a run leads to the orbit there too. `done` itself without a grid."""
    model, scene, orbit = done.flow.model, done.scene, done.periodic.orbit
    if family_of(model) not in GRIDS:
        return done
    from fullwave.adapt import GRID_MARGIN, on_another_grid

    solver = cast(FieldSolver, moving(model, scene, cells))
    other = on_another_grid(solver, lambda number: cast(FieldSolver, moving(model, scene, number)))
    grid = f"that of the grid of {solver.cells} cells"
    unknown = replace(done, grid=f"errors leave out {grid}: no run on another one leads to this orbit")
    if other is None:
        return unknown
    try:
        theirs = find_orbit(model, scene, done.tolerance, other.cells).periodic.orbit.values()
    except (NumericsError, SceneError):
        return unknown
    if abs(theirs["period"] / orbit.period.value - 1.0) > _OTHER:
        return unknown
    by_grid = {name: GRID_MARGIN * abs(value - theirs[name]) for name, value in orbit.values().items()}
    figures = {name: Estimate(value, getattr(orbit, name).error + by_grid[name]) for name, value in orbit.values().items()}
    share = f"{by_grid['period'] / orbit.period.value:.2g} of the period"
    note = f"errors include {grid}, estimated from one of {other.cells}: {share}"
    return replace(done, periodic=replace(done.periodic, orbit=Orbit(**figures)), grid=note)


def orbits_near(solver: FlowingSolver, tolerance: float, period: float) -> list[Closed]:
    """The orbits near the closest returns of the scene's motion after about `period` (transits), on the mesh of `solver`. Raises
    NumericsError if there are none."""
    orbits: list[Closed] = []
    failed = NumericsError(f"{solver.model}: the run does not come back to its state after about {period:g} transits")
    for guess in _guesses(solver, tolerance, period):
        try:
            orbit = close(*guess[:3])
        except NumericsError as reason:
            failed = reason
            continue
        known = any(abs(orbit.cycle.period / other.cycle.period - 1.0) < _SAME for other in orbits)
        if not known and not repeats_sooner(orbit, guess.cycles):
            orbits.append(orbit)
    if not orbits:
        raise failed
    return orbits


def _guesses(solver: FlowingSolver, tolerance: float, near: float | None = None) -> Iterator[Guess]:
    """`guesses` with progress."""
    most = most_transits(solver.scene)
    with progress(f"{solver.scene.name}, {solver.model}, on the way to an orbit", most) as report:
        yield from guesses(solver, tolerance, most, report, near)


def most_transits(scene: Scene) -> float:
    """Longest run (transits) that searches for an orbit: many expected cycles, unless a cycle is so long that the derivative of
    its motion would take minutes."""
    expected = expected_period(scene)
    return max(MOST_TRANSITS, _CYCLES * expected) if expected <= _LONGEST_EXPECTED else MOST_TRANSITS


def refined_orbit(scene: Scene, guess: Guess, tolerance: float) -> PeriodicOrbit:
    """The orbit at a guess, to the `tolerance`, with progress. Raises NumericsError if there is none."""
    with progress(f"{scene.name}, {guess.flow.model}, orbit", _MESHES) as report:
        done = iter(range(int(_MESHES) + 1))
        return periodic_orbit(*guess[:3], tolerance, lambda _: report(float(next(done))))

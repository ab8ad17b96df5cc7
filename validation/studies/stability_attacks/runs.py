"""The runs of the study: each returns its outcome and catches errors of the numerics."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import slipwave
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver, RunStatistics, summarise
from slipwave.scene import Scene
from slipwave.solve import Solver, follow
from validation.compute.build import build
from validation.compute.models import explicit_time
from validation.measure.grids.limits import ATTACKED
from validation.study.text import plain

CELLS = {model: cells.fine for model, cells in ATTACKED.items()}
"""Cells of the faster slab for runs that are compared with the delay system."""


class Attack(NamedTuple):
    """An extreme scene: its title, the scene and its changes, the errors of psi up to t = 40 and of the late motion that count as
    `right` (the coarsest family's are a tenth to a half of them), the refinement of its grids over CELLS, and the time (transits)
    of the late motion."""

    title: str
    scene: str
    changes: tuple[str, ...]
    right: tuple[float, float]
    finer: int = 1
    late: float = 400.0


_IMPEDANCES = {-9: (2e-6, 2e-7), -4: (3e-6, 1e-11), -2: (6e-6, 1e-12), 2: (7e-6, 3e-9)}
_DRIVES = {-6: (2e-6, 1e-9), -2: (2e-6, 1e-10), 3: (1e-2, 4e-3), 4: (2e-3, 3e-2), 5: (2e-8, 2e-5), 6: (3e-9, 1e-8)}
_GRIDS = {4: (2, 400.0), 5: (4, 200.0), 6: (1, 200.0)}
"""Power of ten -> right errors, of epsilon and of V; refinement of the grids of some V, and their late time."""

_PI = ("upper.r=2e-3", f"lower.r={2e-3 * math.pi:.17g}")
ATTACKS = {
    **{f"epsilon {n}": Attack(f"ε = 10^{{{n}}}", "paper", (f"slab.epsilon=1e{n}",), _IMPEDANCES[n]) for n in _IMPEDANCES},
    **{
        f"V {n}": Attack(f"V = 10^{{{n}}} V*", "paper", (f"drive.velocity=1e{n}",), right, *_GRIDS.get(n, (1, 400.0)))
        for n, right in _DRIVES.items()
    },
    "impedance": Attack("impedances 1 : 1000", "unlike", ("upper.epsilon=2.8e-5", "lower.epsilon=2.8e-2"), (6e-6, 1e-6)),
    "round trip": Attack("round trips 1 : 50", "unlike", ("upper.r=2e-4", "lower.r=1e-2"), (2e-6, 2e-7), late=200.0),
    "pi": Attack("round trips 1 : π", "unlike", _PI, (3e-5, 1e-4)),
    "jump": Attack("jump of 5 in ψ at t = 0", "paper", ("start.kind=jump", "start.size=5"), (1e-4, 5e-2)),
    "jump back": Attack("jump of −5 in ψ at t = 0", "paper", ("start.kind=jump", "start.size=-5"), (1e-2, 5e-2)),
}
"""The most extreme scenes that still make sense."""

MOMENTS = (6.0, 8.0, 12.0, 20.0, 40.0)
"""Transits at which psi is compared."""

ADVISED = 400.0
"""Transits of a run with the cells that messages ask for."""

_FEWEST_CYCLES = 2
_FINEST = 16  # times the usual cells, at most


@dataclass(frozen=True)
class AttackOutcome:
    """Largest error of psi up to t = 40; `late` as `_late_error` gives it; the message of a run that stopped (empty if none did).
    Only a run that stops need not be right: counted failed solves do not suffice."""

    error: float
    late: float = 0.0
    message: str = ""

    def silently_wrong(self, allowed: float, late: float = math.inf) -> bool:
        """Whether the run ended with an error of psi above `allowed`, or of the late motion above `late`."""
        return not self.message and not (self.error <= allowed and self.late <= late)

    @property
    def wording(self) -> str:
        """Text of the outcome in the table."""
        if self.message:
            return "message"
        return plain(self.error, ".0e") + (f"; {plain(self.late, '.0e')}" if self.late else "")


class _Trajectory(NamedTuple):
    psis: list[float]
    late: float
    statistics: RunStatistics


def attack(name: str, late: bool = False) -> dict[str, AttackOutcome]:
    """The outcome of attack `name` for every family, in 40 transits or until its late time."""
    scene, finer = _scene(name), ATTACKS[name].finer
    until = ATTACKS[name].late if late else MOMENTS[-1]
    exact = _trajectory(build("delay", scene, tolerance=1e-10), until)
    return {model: _outcome(model, finer * cells, scene, exact, until) for model, cells in CELLS.items()}


def _scene(name: str) -> Scene:
    return slipwave.read(ATTACKS[name].scene, list(ATTACKS[name].changes))


def _trajectory(solver: Solver, until: float) -> _Trajectory:
    watch = EventObserver(solver.scene, solver.nodes)
    psis = [follow(solver, moment, [watch]).psi for moment in MOMENTS]
    late = follow(solver, until, [watch]).psi if until > MOMENTS[-1] else psis[-1]
    return _Trajectory(psis, late, summarise(watch.events(0.5 * until)))


def _outcome(model: str, cells: int, scene: Scene, exact: _Trajectory, until: float) -> AttackOutcome:
    try:
        ours = _trajectory(build(model, scene, cells=cells, time=explicit_time(model)), until)
    except (SceneError, NumericsError) as error:
        return AttackOutcome(math.nan, message=str(error))
    off = max(abs(psi - theirs) for psi, theirs in zip(ours.psis, exact.psis, strict=True))
    return AttackOutcome(off, _late_error(ours, exact) if until > MOMENTS[-1] else 0.0)


def _late_error(ours: _Trajectory, exact: _Trajectory) -> float:
    """Error of psi at the end or, if that is less, the largest relative error of the mean period, stress drop and v_max of the
    second half's cycles: an orbit may be right while its phase has drifted."""
    of_state = abs(ours.late - exact.late)
    mine, theirs = ours.statistics, exact.statistics
    if min(mine.cycles, theirs.cycles) < _FEWEST_CYCLES:
        return of_state
    pairs = ((mine.period.mean, theirs.period.mean), (mine.stress_drop.mean, theirs.stress_drop.mean), (mine.v_max, theirs.v_max))
    return min(of_state, max(abs(value / true - 1.0) for value, true in pairs))


class Cure(NamedTuple):
    """Cells at which a run stopped with `message` (0 if it never did), cells at which it ended, its error of psi."""

    stopped: int
    message: str
    cells: int
    error: float


def advised(model: str) -> Cure:
    """Run V = 1e5 with `model`'s usual cells, doubled as long as the run stops with a message."""
    scene = _scene("V 5")
    exact = _trajectory(build("delay", scene, tolerance=1e-10), ADVISED)
    stopped, message, cells = 0, "", CELLS[model]
    while cells <= _FINEST * CELLS[model]:
        outcome = _outcome(model, cells, scene, exact, ADVISED)
        if not outcome.message:
            return Cure(stopped, message, cells, max(outcome.error, abs(outcome.late)))
        stopped, message = cells, outcome.message
        cells *= 2
    return Cure(stopped, message, cells, math.inf)

"""The runs behind the study of attacks: each returns what came out, and lets no error of the numerics escape."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

import scene
from scene.errors import NumericsError, SceneError
from scene.observe import Solver, follow
from scene.scene import Scene
from validation.models import build
from validation.report.text import plain


class Size(NamedTuple):
    """Cells of a slab for runs that try the step and for runs that are held against the delay system."""

    coarse: int
    fine: int


CELLS = {
    "fd": Size(12, 64),
    "sbp:2": Size(12, 64),
    "sbp:4": Size(12, 32),
    "sbp:6": Size(16, 32),
    "fem:4": Size(2, 8),
    "dg:4": Size(2, 8),
    "dg:7": Size(2, 4),
}
"""The families under attack, and their grids."""


class Attack(NamedTuple):
    """What it is called, the scene and what is changed in it."""

    title: str
    scene: str
    changes: tuple[str, ...]


_PI = ("upper.r=2e-3", f"lower.r={2e-3 * math.pi:.17g}")
ATTACKS = {
    **{f"epsilon {power}": Attack(f"ε = 10^{{{power}}}", "paper", (f"slab.epsilon=1e{power}",)) for power in (-9, -4, -2, 2)},
    **{f"V {power}": Attack(f"V = 10^{{{power}}} V*", "paper", (f"drive.velocity=1e{power}",)) for power in (-6, -2, 3, 6)},
    "impedance": Attack("impedances 1 : 1000", "unlike", ("upper.epsilon=2.8e-5", "lower.epsilon=2.8e-2")),
    "round trip": Attack("round trips 1 : 50", "unlike", ("upper.r=2e-4", "lower.r=1e-2")),
    "pi": Attack("round trips 1 : π", "unlike", _PI),
    "jump": Attack("jump of 5 in ψ at t = 0", "paper", ("start.kind=jump", "start.size=5")),
    "jump back": Attack("jump of −5 in ψ at t = 0", "paper", ("start.kind=jump", "start.size=-5")),
}
"""Scenes at the ends of what makes sense."""

_MOMENTS = (6.0, 8.0, 12.0, 20.0, 40.0)
_FASTEST = 100.0
_TRIAL = 120.0
_SHARPNESS = 1.05


@dataclass(frozen=True)
class Outcome:
    """Largest error of psi, failed interface solves, and the message of a run that stopped (empty if none did)."""

    error: float
    failures: int
    message: str = ""

    @property
    def reported(self) -> bool:
        """The run stopped with a message or counted failures."""
        return bool(self.message) or self.failures > 0

    def silently_wrong(self, allowed: float) -> bool:
        """Nothing was said and psi is off by more than `allowed`."""
        return not self.reported and not self.error <= allowed

    @property
    def wording(self) -> str:
        """As the table shows it."""
        if self.message:
            return "message"
        return plain(self.error, ".0e") + (f", {self.failures} failures" if self.failures else "")


def attack(name: str) -> dict[str, Outcome]:
    """What every family makes of attack `name`."""
    what = scene.read(ATTACKS[name].scene, list(ATTACKS[name].changes))
    exact = _psis(build("delay", what, tolerance=1e-10))
    return {model: _outcome(model, size.fine, what, exact) for model, size in CELLS.items()}


def _psis(solver: Solver) -> list[float]:
    return [follow(solver, moment).psi for moment in _MOMENTS]


def _outcome(model: str, cells: int, what: Scene, exact: list[float]) -> Outcome:
    try:
        solver = build(model, what, cells=cells)
        psis = _psis(solver)
    except (SceneError, NumericsError) as error:
        return Outcome(math.nan, 0, str(error))
    off = max(abs(ours - theirs) for ours, theirs in zip(psis, exact, strict=True))
    return Outcome(off, solver.failures)


def with_step(model: str, what: Scene, cells: int, share: float) -> Solver:
    """The solver at `share` of its declared step limit, which may lie beyond 1; users are refused that."""
    if model == "fd":
        from fullwave.finite_difference import Leapfrog

        leapfrog = Leapfrog(what, cells)
        leapfrog._set_up(what, cells, share)
        return leapfrog
    solver = cast(Any, build(model, what, cells=cells, cfl=1.0))
    solver.step *= share
    return cast(Solver, solver)


def step_per_cell(model: str) -> float:
    """c dt over the length of a cell at cfl 1."""
    cells = CELLS[model].coarse
    return float(cast(Any, with_step(model, _at(0), cells, 1.0)).step * 2.0 * cells)


def stops_beyond(model: str, share: float) -> bool:
    """Whether a run at `share` of the declared step limit ends with a message."""
    return not _stable(model, _at(4), share)


def limit_at(model: str, decade: float) -> float:
    """Largest stable share of the declared step with friction 10^decade times stiffer, to 5 per cent (geometric bisection)."""
    what = _at(decade)
    low, high = 0.7, 1.6
    if not _stable(model, what, low):
        return 0.0
    if _stable(model, what, high):
        return high
    while high / low > _SHARPNESS:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if _stable(model, what, middle) else (low, middle)
    return math.sqrt(low * high)


def _at(decade: float) -> Scene:
    return scene.read("paper", [f"drive.velocity={_FASTEST / 10.0**decade!r}"])


def _stable(model: str, what: Scene, share: float) -> bool:
    try:
        follow(with_step(model, what, CELLS[model].coarse, share), _TRIAL)
    except NumericsError:
        return False
    return True


def locked_noise(model: str, transits: float) -> float:
    """Energy left of noise in a locked slab after `transits`, over its mean in the first ten; infinite if the run broke down."""
    what = scene.read("paper", ["drive.velocity=1e-6", "start.size=0"])
    solver = cast(Any, build(model, what, cells=CELLS[model].coarse))
    draw = np.random.default_rng(1).standard_normal
    if model == "fd":
        state = solver.state()
        state["upper.velocity"][1:-1] += draw(state["upper.velocity"].size - 2)
        solver.restore(state)
    else:
        solver.impose(0, lambda depth: draw(depth.size), lambda depth: np.full(depth.size, what.steady_stress))
    try:
        first = np.mean([_energy(solver, what, moment) for moment in 2.0 * np.arange(1.0, 6.0)])
        last = np.mean([_energy(solver, what, moment) for moment in transits + 2.0 * np.arange(1.0, 6.0)])
    except NumericsError:
        return math.inf
    return float(last / first)


def _energy(solver: Any, what: Scene, moment: float) -> float:
    """Mean square of velocity and of stress over impedance at the nodes (V*^2)."""
    follow(solver, moment)
    shot = solver.snapshot().upper
    moving, loaded = shot.velocity - 0.5 * what.velocity, (shot.stress - what.steady_stress) / what.upper.epsilon
    return float(np.mean(moving**2) + np.mean(loaded**2))

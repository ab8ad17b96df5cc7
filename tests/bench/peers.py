"""The reductions beside general integrators at equal error: scipy's LSODA and Radau, numbalsoda's LSODA and DOP853, which need
`make bench` (requirements-bench.lock) and are left out elsewhere.

The peers integrate the reductions' equations as one would write them without this package, compiled by numba: psi, z = ln v, the
spring stress y where there is a mass, and tau_k, q_k of each mode; ageing law, transit clock, V constant between knots. With
stiffness k, damping D, mass m, and residue R_k, frequency omega_k and drive g_k V of the modes,

    psi' = r (e^-psi - v),   tau_k' = -R_k (v - g_k V) - omega_k^2 q_k,   q_k' = tau_k,   y' = k (V - v),
    m v z' = y + sum tau - mu,   or without mass   (a + D v) z' = k (V - v) + sum tau' - b psi'.

An error is the largest one of ln v and psi at 20 times, against this package's own solution at a tolerance of 1e-12.
"""

import math
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import carray, cfunc, njit, types
from scipy.integrate import solve_ivp

import slipwave as sw
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import follow
from tests.granite import GRANITE, SAMPLE
from validation.models.build import build
from validation.models.timing import Work, in_turn, quartiles

os.environ["GFORTRAN_UNBUFFERED_PRECONNECTED"] = "y"  # read when a library of Fortran is loaded; for `_silenced`
try:
    import numbalsoda
except ImportError:
    numbalsoda = None

_SHORTEST = 0.02  # s of work that are timed at once
_LONGEST = 1.0  # s, from which no smaller tolerance is tried
_LEAST = 1e-11  # error at which marches are compared that err less: rounding, and the error of the reference
_MOST_STEPS = 1_000_000


@njit(error_model="numpy")
def _rates(t, u, du, p):  # type: ignore[no-untyped-def]
    """Time derivatives `du` of the state `u` with the numbers `p` (`Problem.numbers`)."""
    velocity, r, a_star, a, b, spring, damping, mass = p[:8]
    count = int(p[8])
    psi, z = u[0], u[1]
    v, first = math.exp(z), 3 if mass > 0.0 else 2
    du[0] = r * (math.exp(-psi) - v)
    stress, change = 0.0, 0.0
    for k in range(count):
        residue, omega2, driven = p[9 + 3 * k : 12 + 3 * k]
        tau, q = u[first + 2 * k], u[first + 2 * k + 1]
        du[first + 2 * k] = -residue * (v - driven * velocity) - omega2 * q
        du[first + 2 * k + 1] = tau
        stress, change = stress + tau, change + du[first + 2 * k]
    if mass > 0.0:
        du[1] = (u[2] + stress - a_star - a * z - b * psi) / (mass * v)
        du[2] = spring * (velocity - v)
    else:
        du[1] = (spring * (velocity - v) + change - b * du[0]) / (a + damping * v)


@cfunc(types.void(types.double, *[types.CPointer(types.double)] * 3))
def _pointed(t, u, du, p):  # type: ignore[no-untyped-def]
    """`_rates` behind pointers, as numbalsoda calls it."""
    numbers = carray(p, (9 + 3 * int(p[8]),))
    size = (3 if numbers[7] > 0.0 else 2) + 2 * int(numbers[8])
    _rates(t, carray(u, (size,)), carray(du, (size,)), numbers)


class Problem(NamedTuple):
    """A `scene` by a `model` until its end: what its peers need to know."""

    scene: Scene
    model: str

    @property
    def until(self) -> float:
        assert self.scene.until is not None
        return self.scene.until

    @property
    def times(self) -> Array:
        """The 20 times (transits) of comparison, none of them a knot."""
        return self.until * (np.arange(20) + 0.5) / 20.0

    @property
    def modes(self) -> tuple[float, list[tuple[float, float, float]]]:
        """Mass, and residue, omega^2 and drive of each mode, relative to epsilon (MODEL.md section 4)."""
        kind, _, number = self.model.partition(":")
        match kind:
            case "modal":
                omega2 = [(2.0 * math.pi * k) ** 2 for k in range(1, int(number) + 1)]
                return 1.0 / 12.0 - sum(2.0 / one for one in omega2), [(2.0, one, (-1.0) ** k) for k, one in enumerate(omega2, 1)]
            case "kelvin-voigt":
                return 0.0, [(2.0, 24.0, 1.0)]
        return {"block8": 1.0 / 8.0, "block12": 1.0 / 12.0}.get(kind, 0.0), []

    def numbers(self, velocity: float) -> Array:
        """What `_rates` needs, at a velocity of the drive; stress in units of the normal stress, time in transits."""
        scene, law, (mass, modes) = self.scene, self.scene.law, self.modes
        damping = scene.impedance if self.model == "quasidynamic" else 0.0
        found = [velocity, scene.transit, law.a_star, law.a, law.b]
        found += [scene.stiffness, damping, mass * scene.upper.epsilon, len(modes)]
        return np.array([*found, *(x for mode in modes for x in (mode[0] * scene.upper.epsilon, *mode[1:]))])

    def solved(self, integrate: Callable[[Array, Array, Array], Array]) -> Array:
        """ln v and psi at the `times`: `integrate` takes the numbers, a state and times, the first of which is that of the state,
        and returns the states there; NaN if it fails."""
        scene, (mass, modes) = self.scene, self.modes
        drive, numbers = scene.drive, self.numbers(scene.velocity)
        ln_v, psi = math.log(scene.velocity), scene.steady_psi + scene.start.jump_size
        rest = [
            x for residue, omega2, g in modes for x in (0.0, -residue * scene.upper.epsilon * (1.0 - g) * scene.velocity / omega2)
        ]
        state = np.array([psi, ln_v, *([scene.steady_stress] if mass else []), *rest])
        if not mass:
            state[1] = _slid(numbers, ln_v, -numbers[4] * scene.start.jump_size)
        ends, found, now = [*dict.fromkeys(one for one in drive.times if 0.0 < one < self.until), self.until], [], 0.0
        for end in ends:
            inside = self.times[(self.times > now) & (self.times < end)]
            states = integrate(numbers, state, np.array([now, *inside, end]))
            if not np.isfinite(states).all():
                return np.full((self.times.size, 2), math.nan)
            found.append(states[1:-1, 1::-1])
            state, now, before = states[-1].copy(), end, numbers[0]
            numbers = self.numbers(drive.at(end))
            if not mass:
                state[1] = _slid(numbers, state[1], numbers[6] * (numbers[0] - before))
        return np.concatenate(found)

    def marched(self, tolerance: float) -> Work[Any]:
        return lambda: partial(follow, build(self.model, self.scene, tolerance=tolerance), self.until)

    def ours(self, tolerance: float) -> tuple[Array, int]:
        solver = build(self.model, self.scene, tolerance=tolerance)
        history = HistoryObserver(self.scene.law, solver.nodes)
        follow(solver, self.until, [history])
        return history.at(self.times)[1:3].T, history.pieces().time.size


def _slid(numbers: Array, ln_v: float, change: float) -> float:
    """ln v after a jump by `change` of what friction and damping bear, a z + D e^z."""
    a, damping = numbers[3], numbers[6]
    wanted, z = a * ln_v + damping * math.exp(ln_v) + change, ln_v
    for _ in range(50):
        z -= (a * z + damping * math.exp(z) - wanted) / (a + damping * math.exp(z))
    return float(z)


def _by_scipy(method: str, tolerance: float, numbers: Array, state: Array, times: Array) -> Array:
    def rates(t: float, u: Array) -> Array:
        du = np.empty_like(u)
        _rates(t, u, du, numbers)
        return du

    with warnings.catch_warnings(action="ignore"):
        found = solve_ivp(rates, (times[0], times[-1]), state, method=method, t_eval=times, rtol=tolerance, atol=tolerance)
    return found.y.T if found.success else np.full((times.size, state.size), math.nan)


def _by_numbalsoda(name: str, tolerance: float, numbers: Array, state: Array, times: Array) -> Array:
    solve = getattr(numbalsoda, name)
    found, good = solve(_pointed.address, state, times, data=numbers, rtol=tolerance, atol=tolerance, mxstep=_MOST_STEPS)
    return found if good else np.full((times.size, state.size), math.nan)


PEERS: dict[str, tuple[Any, tuple[float, ...]]] = {
    "scipy LSODA": (partial(_by_scipy, "LSODA"), tuple(10.0**-k for k in range(4, 13, 2))),
    "scipy Radau": (partial(_by_scipy, "Radau"), tuple(10.0**-k for k in range(4, 11, 2))),
}
"""The integrators by name, and the tolerances that are tried."""
if numbalsoda:
    PEERS["numbalsoda LSODA"] = partial(_by_numbalsoda, "lsoda"), tuple(10.0**-k for k in range(4, 14))
    PEERS["numbalsoda DOP853"] = partial(_by_numbalsoda, "dop853"), tuple(10.0**-k for k in range(4, 14))


def rows_of(problem: Problem, rounds: int, tolerances: Sequence[float] = (1e-9, 1e-6)) -> Iterator[list[str]]:
    """A row for each of our tolerances: error, steps, time (ms), and each peer's time at that error with the ratio of ours to
    it; all marches in turn, medians over rounds."""
    reference, _ = problem.ours(1e-12)
    ours = {one: problem.ours(one) for one in tolerances}
    errors = {one: max(float(np.abs(found - reference).max()), _LEAST) for one, (found, _) in ours.items()}
    tried = {name: dict(_tried(problem, *peer, reference, min(errors.values()))) for name, peer in PEERS.items()}
    near = {(name, one) for name, found in tried.items() for error in errors.values() for one in around(found, error)}
    calls: dict[Any, Work[Any]] = {one: problem.marched(one) for one in tolerances}
    calls |= {one: partial(partial, problem.solved, partial(PEERS[one[0]][0], one[1])) for one in near}
    works = {name: _repeated(call) for name, call in calls.items()}
    taken = in_turn({name: work for name, (work, _) in works.items()}, rounds)
    ms = {name: 1e3 * quartiles(each[name] for each in taken)[1] / count for name, (_, count) in works.items()}
    for one, error in errors.items():
        cells = []
        for name, found in tried.items():
            time_at, reached = at_error(error, [(found[k], ms[name, k]) for k in around(found, error)])
            least = f" at {reached:.0e}" if reached > error else ""
            cells.append("-" if math.isnan(time_at) else f"{time_at:.3g} ({ms[one] / time_at:.2g}){least}")
        what = f"{problem.scene.name}, {problem.until:.4g}", problem.model
        yield [*what, f"{one:.0e}", f"{error:.0e}", str(ours[one][1]), f"{ms[one]:.3g}", *cells]


def _tried(problem: Problem, integrate: Any, tolerances: Sequence[float], reference: Array, least: float) -> Iterator[Any]:
    """(tolerance, error) of a peer, until its error is below `least`, or a march takes long."""
    for tolerance in tolerances:
        began = time.process_time()
        error = float(np.abs(problem.solved(partial(integrate, tolerance)) - reference).max())
        if math.isfinite(error):
            yield tolerance, error
        if error < least or time.process_time() - began > _LONGEST:
            return


def around(found: Mapping[float, float], error: float) -> list[float]:
    """The coarsest tolerance that reaches the `error`, and the next coarser one; that with the smallest error if none does."""
    good = max((one for one in found if found[one] <= error), default=None)
    if good is None:
        return sorted(found, key=lambda one: found[one])[:1]
    return [good, *sorted(one for one in found if one > good)[:1]]


def at_error(error: float, known: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Time at an `error` (NaN of a peer that fails) by its logarithm between two (error, time), and the error that is reached."""
    if len(known) < 2:
        return (known[0][1], max(known[0][0], error)) if known else (math.nan, error)
    (fine, slow), (coarse, fast) = known
    return slow * (fast / slow) ** (math.log(error / fine) / math.log(coarse / fine)), error


def _repeated(prepare: Work[Any]) -> tuple[Work[Any], int]:
    """The work of so many calls that they last long enough to be timed, and their number."""
    once, began = prepare(), time.process_time()
    once()
    count = max(1, math.ceil(_SHORTEST / max(time.process_time() - began, 1e-5)))

    def work() -> Callable[[], Any]:
        calls = [prepare() for _ in range(count)]
        return lambda: [call() for call in calls]

    return work, count


_STEPS = [["0 s", "10 um/s"], ["20 s", "10 um/s"], ["20 s", "0 um/s"], ["120 s", "0 um/s"], ["120 s", "10 um/s"]]
HELD = SAMPLE | {
    "name": "1 mm sample, hold",
    "slab": SAMPLE["slab"] | {"face": SAMPLE["slab"]["face"] | {"stiffness": "40 GPa/m", "mass": "100 kg/m2"}},
    "drive": {"velocity": _STEPS},
    "start": {"size": 0.0},
    "run": {"until": "220 s"},
}
"""The sample in a stiffer and heavier machine, held for 100 s."""
_JUMP = {"kind": "jump", "size": 0.05}
LABORATORY: dict[str, Any] = {"lab-1mm": SAMPLE, "lab-1mm-hold": HELD, "velocity-steps": "velocity-steps", "hold": "hold"}


def problems() -> list[Problem]:
    """The laboratory's scenes by the models without waves, and the paper's by every reduction. They start with a jump, for no
    integrator sees a nudge that it steps over."""
    found = [Problem(sw.read(scene), "quasidynamic") for scene in LABORATORY.values()]
    found += [Problem(sw.read(name), model) for name in ("velocity-steps", "hold") for model in ("quasistatic", "block8")]
    granite = sw.read(GRANITE | {"name": "granite, 10 m", "start": _JUMP, "run": {"until": "3600 s"}})
    found += [Problem(granite, model) for model in ("quasidynamic", "block8")]
    paper = [sw.read("paper", {"start.kind": "jump", "start.size": 0.05, "run.until": until}) for until in (600.0, 6000.0)]
    models = ("quasidynamic", "block8", "block12", "kelvin-voigt", "modal:4")
    return found + [Problem(scene, model) for model in models for scene in paper]


def table_of_peers(rounds: int, wanted: Sequence[Problem] | None = None) -> list[list[str]]:
    with _silenced():
        return [row for problem in (problems() if wanted is None else wanted) for row in rows_of(problem, rounds)]


PEER_HEADS = ["scene, transits", "model", "tolerance", "error", "steps", "ms", *PEERS]


@contextmanager
def _silenced() -> Iterator[None]:
    """No output: compiled peers print whenever an equation becomes stiff or an error test fails."""
    sys.stdout.flush()
    kept = {number: os.dup(number) for number in (1, 2)}
    with open(os.devnull, "w") as nowhere:
        try:
            for number in kept:
                os.dup2(nowhere.fileno(), number)
            yield
        finally:
            for number, copy in kept.items():
                os.dup2(copy, number)
                os.close(copy)

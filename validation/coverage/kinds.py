"""Kinds of stated errors, each with a truth to hold them against: random scenes beyond the loss of stability."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

import slipwave
from fullwave.adapt import difference_of, probe
from reduced.orbit.closing import Closed, close
from reduced.orbit.figures import figures_of
from reduced.parameters import scaled
from reduced.stability.critical import critical_round_trip
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import Solver, follow
from slipwave.solve.lyapunov import largest_exponent
from validation.measure.correlated import mean_of
from validation.measure.cycle import watch
from validation.measure.order_fit import richardson
from validation.measure.settle import NoCycle, settle
from validation.registry.build import build, build_full_wave, judged_grid, prepare
from validation.registry.families import one_port_of
from validation.registry.orbits import find_orbit
from validation.study import SELF, WITNESS, Evidence

_FINER = 3.0
_BEYOND = (1.01, 1.25)  # times the round trip at which steady sliding loses its stability
_FAR_BEYOND = (1.15, 2.5)  # the same, where many motions never repeat
_DEFAULT, _LOOSEST, _TIGHTEST = 1e-8, 1e-4, 1e-10  # tolerances of orbits; four in ten have the default
_WITNESS, _WITNESS_CELLS = "dg:9", 8
_EXACT = 1e-11
_SETTLED = 0.1  # of the tolerance: how closely cycles repeat
_GRIDS = {
    "fd": 1e-3,
    "sbp:2": 1e-3,
    "sbp:4": 1e-4,
    "sbp:6": 1e-5,
    "fem:4": 1e-6,
    "dg": 1e-6,
}  # tolerances asked for, and near them
_TRANSIENT = 1500.0  # transits
_LEAST_SPREAD, _FEWEST = 1e-3, 6  # change of the periods, relative, and number of them, in motions that never repeat
_PARTS, _CYCLES = 24, (16.0, 240.0)  # of a long run: parts, each with a mean of its own, and the range of cycles in one
_EXPONENTS = 12  # of a long run

Part = Callable[[np.random.Generator], dict[str, Any]]
SLABS: dict[str, Part] = {
    "alike": lambda random: {},
    "unlike": lambda random: {},
    "layered": lambda random: {
        "layers": [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": random.uniform(0.5, 2.0)}]
    },
    "grip": lambda random: {
        "face": {"kind": "grip", "stiffness": 10.0 ** random.uniform(0.5, 1.5), "impedance": 10.0 ** random.uniform(-0.5, 0.7)}
    },
    "machine": lambda random: {
        "face": {"kind": "machine", "stiffness": 10.0 ** random.uniform(0.5, 1.5)}
        | {"impedance": random.uniform(0.1, 2.0), "mass": random.uniform(0.1, 2.0)}
    },
    "viscous": lambda random: {"viscosity": {"kind": "kelvin-voigt", "time": 10.0 ** random.uniform(-6.0, -4.7)}},
}
"""Slabs: what a random one has beside impedance and round trip."""


class Held(NamedTuple):
    """A `figure` with its stated error `bar` and its true `error`, relative to the figure."""

    figure: str
    bar: float
    error: float


def random_scene(kind: str, model: str, random: np.random.Generator, beyond: tuple[float, float] = _BEYOND) -> Scene:
    """A scene of one of the SLABS of slabs, a little beyond where steady sliding of `model` loses its stability."""
    a, transit = 0.0349 * 10.0 ** random.uniform(-0.1, 0.1), 0.002
    slab = {"epsilon": 2.8e-5 * 10.0 ** random.uniform(-0.3, 0.3), "r": transit} | SLABS[kind](random)
    ratio = random.choice([0.5, 0.75, 1.5, 2.0, 3.0]) if random.random() < 0.7 else random.uniform(0.5, 2.0)
    other = slab | {"epsilon": slab["epsilon"] * 10.0 ** random.uniform(-0.4, 0.4), "r": transit * float(ratio)}
    scene = slipwave.read(
        {
            "name": kind,
            "interface": {"law": "ageing", "a_star": 0.369, "a": a, "b": a * random.uniform(1.2, 1.6)},
            "drive": {"velocity": 10.0 ** random.uniform(1.5, 2.8)},
            **({"upper": slab, "lower": other} if kind == "unlike" else {"slab": slab}),
        }
    )
    critical, _ = critical_round_trip(scene, one_port_of(model))
    return scaled(scene, round_trip=random.uniform(*beyond) * critical / scene.transit)


def of_orbit(model: str, scene: Scene, random: np.random.Generator) -> list[Held]:
    """Figures of an orbit to a random tolerance, beside those of a much finer mesh."""
    tolerance = _DEFAULT if random.random() < 0.4 else 10.0 ** random.uniform(math.log10(_TIGHTEST), math.log10(_LOOSEST))
    found = find_orbit(model, scene, tolerance).found
    truth = _by_finer_mesh(found.closed)
    stated = {name: getattr(found.orbit, name).error for name in truth}
    return [Held(name, stated[name] / true, abs(found.orbit.values()[name] / true - 1.0)) for name, true in truth.items()]


def _by_finer_mesh(closed: Closed) -> dict[str, float]:
    flow, start = closed.flow.remeshed(closed.cycle, _FINER)
    return figures_of(close(flow, start, closed.cycle.period, 0.0))


def _any_orbit(random: np.random.Generator) -> list[Held]:
    kind = str(random.choice(list(SLABS)))
    able = {"alike": ["delay", "kelvin-voigt", "block8", "modal:2"], "unlike": ["delay", "modal:1"], "viscous": ["sbp:6"]}
    model = str(random.choice(able.get(kind, ["delay"])))
    return of_orbit(model, random_scene(kind, model, random), random)


def _grid_scene(model: str, random: np.random.Generator) -> tuple[str, Scene]:
    """A scene for a grid and the model that knows its truth."""
    kind = str(random.choice(["alike", "unlike", "layered", "grip", "viscous"]))
    viscous = kind == "viscous"
    return _WITNESS if viscous else "delay", random_scene(kind, model if viscous else "auto", random)


def _exact(model: str, scene: Scene) -> Solver:
    return build_full_wave(model, scene, cells=_WITNESS_CELLS) if model == _WITNESS else build(model, scene, tolerance=_EXACT)


def _chosen_grid(random: np.random.Generator) -> list[Held]:
    """Periods and drops of the probe's cycles on a grid chosen by a tolerance."""
    model = str(random.choice(list(_GRIDS)))
    known, scene = _grid_scene(model, random)
    built = prepare(model, scene, tolerance=_GRIDS[model] * 10.0 ** random.uniform(-0.5, 0.5))
    assert built.choice is not None
    return [Held("cycles", built.choice.error_estimate, difference_of(probe(_exact(known, scene)), probe(built.solver)))]


def _default_grid(random: np.random.Generator) -> list[Held]:
    """The same on a default grid; a warning that has no number, because a coarser grid finds other cycles, states no error."""
    model = str(random.choice([*_GRIDS, "dg:7"]))
    known, scene = _grid_scene(model, random)
    solver = prepare(model, scene).solver
    choice = judged_grid(solver, solver.state())
    assert choice is not None
    if not math.isfinite(choice.error_estimate):
        return []
    return [Held("cycles", choice.error_estimate, difference_of(probe(_exact(known, scene)), probe(solver)))]


def _steps(random: np.random.Generator) -> list[Held]:
    """The cycle on which a run of a model without a grid in space settles, beside the orbit. Its tolerance is the error that
    a run states of a cycle; to this comes how much its cycles still differ."""
    kind = str(random.choice(["alike", "unlike", "layered", "grip"]))
    model = str(random.choice(["delay", "kelvin-voigt", "block8", "modal:2"] if kind == "alike" else ["delay"]))
    scene, tolerance = random_scene(kind, model, random), 10.0 ** random.uniform(-9.0, -4.0)
    settled = settle(build(model, scene, tolerance=tolerance), _SETTLED * tolerance)
    if settled.unrest > tolerance:
        raise NumericsError("the motion does not settle")
    truth = find_orbit(model, scene, _EXACT).found.orbit.values()
    found = {name: getattr(settled.orbit, name) for name in ("period", "stress_drop")}
    return [Held(name, tolerance + one.error / one.value, abs(one.value / truth[name] - 1.0)) for name, one in found.items()]


def _extrapolated(random: np.random.Generator) -> list[Held]:
    """State and slip rate after a while, from three grids of order 2."""
    model, kind = str(random.choice(["fd", "sbp:2"])), str(random.choice(["alike", "unlike", "layered"]))
    scene = replace(random_scene(kind, "auto", random), until=float(random.integers(30, 90)))
    cells, cfl = int(random.integers(24, 64)), 0.5 if model == "fd" else None
    coarse, middle, fine = (_final(build_full_wave(model, scene, cells=n * cells, cfl=cfl)) for n in (1, 2, 4))
    truth = _final(build("delay", scene, tolerance=_EXACT))
    found = {name: (richardson(coarse[k], middle[k], fine[k], 2.0), truth[k]) for k, name in enumerate(("ln v", "psi"))}
    return [Held(name, one.error, abs(one.value - known)) for name, (one, known) in found.items()]


def _final(solver: Solver) -> tuple[float, float]:
    assert solver.scene.until is not None
    final = follow(solver, solver.scene.until)
    return final.ln_v, final.psi


def _irregular(random: np.random.Generator) -> tuple[Solver, float]:
    """A solver past its transient, in a motion that never repeats, and its mean period. Raises NumericsError in one that does."""
    model = str(random.choice(["delay", "kelvin-voigt", "modal:2"]))
    solver = build(model, random_scene("alike", model, random, _FAR_BEYOND), tolerance=1e-7)
    found = watch(solver, 2.0 * _TRANSIENT).events(_TRANSIENT).period
    repeats = [np.ptp(found[lag:] - found[:-lag]) < _LEAST_SPREAD * found.mean() for lag in range(1, found.size // 2)]
    if found.size < _FEWEST or any(repeats):
        raise NumericsError("the motion repeats")
    return solver, float(found.mean())


def _means(random: np.random.Generator) -> list[Held]:
    """Means over the parts of a long run, each beside that of all others."""
    solver, period = _irregular(random)
    cycles, begin = round(math.exp(random.uniform(*np.log(_CYCLES)))), solver.time
    events = watch(solver, begin + (_PARTS * cycles + 8) * period).events(begin)
    return [held for name in ("period", "stress_drop") for held in _parts(name, getattr(events, name)[: _PARTS * cycles])]


def _parts(name: str, values: Array) -> Iterator[Held]:
    """Of a sequence, each part beside the rest."""
    parts = np.array_split(values, _PARTS)
    means = [mean_of(part) for part in parts]
    truths = _of_others(np.array([mean.value for mean in means]))
    for mean, (truth, own) in zip(means, truths, strict=True):
        yield Held(name, 2.0 * mean.error / truth, own / truth)


def _of_others(values: Array) -> list[tuple[float, float]]:
    """Of each of n values the mean of all others, and how far it lies from that, times sqrt(1 - 1/n): as if that were exact."""
    others = (values.sum() - values) / (values.size - 1.0)
    return list(zip(others.tolist(), (np.abs(values - others) * math.sqrt(1.0 - 1.0 / values.size)).tolist(), strict=True))


def _exponents(random: np.random.Generator) -> list[Held]:
    """Largest Lyapunov exponents of the parts of a long run, each beside the mean of all others; times the period."""
    solver, period = _irregular(random)
    twin = build(solver.model, solver.scene, tolerance=1e-7)
    found = [largest_exponent(solver, twin, period) for _ in range(_EXPONENTS)]
    truths = _of_others(np.array([one.rate for one in found]))
    return [Held("exponent", one.margin * period, off * period) for one, (_, off) in zip(found, truths, strict=True)]


class Kind(NamedTuple):
    """A kind of stated error: whose `bar`, the `truth` it is held against, the `evidence` that this is, how one computation is
    `measure`d, how many are `recorded`, and how many of them a report `repeated`ly makes. An irregular motion is not `exact`ly
    repeated on another machine."""

    bar: str
    truth: str
    evidence: Evidence
    measure: Callable[[np.random.Generator], list[Held]]
    recorded: int
    repeated: int
    exact: bool = True


_KNOWN = f"delay system; with viscosity `{_WITNESS}`"
KINDS = {
    "orbits": Kind("`slipwave orbit`: error of each figure", "a mesh three times finer", SELF, _any_orbit, 110, 6),
    "tolerances": Kind("`--tol` of models without a grid", "the orbit, by Newton’s method", SELF, _steps, 250, 4),
    "chosen grids": Kind("`--tol` of full waves: estimated error", _KNOWN, WITNESS, _chosen_grid, 50, 2),
    "default grids": Kind("default grids of full waves: estimated error", _KNOWN, WITNESS, _default_grid, 110, 4),
    "extrapolation": Kind("Richardson’s limit of three grids", "delay system", WITNESS, _extrapolated, 104, 4),
    "means": Kind("means of motions that never repeat: margin", "the rest of a run 24 times as long", SELF, _means, 12, 1, False),
    "exponents": Kind("largest Lyapunov exponents: margin", "the rest of a run 12 times as long", SELF, _exponents, 17, 1, False),
}
"""Kinds by name."""


def computation(kind: str, number: int) -> list[Held]:
    """Computation `number` of a kind: the same whenever it is repeated. Empty where there is nothing to be held: no orbit, or a
    motion of another sort."""
    try:
        return KINDS[kind].measure(np.random.default_rng([crc32(kind.encode()), number]))
    except (NumericsError, SceneError, NoCycle):
        return []

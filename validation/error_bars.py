"""How often stated errors hold the truth: orbits and grids chosen by a tolerance, of random scenes beyond the loss of stability.

python -m validation.error_bars orbit unlike delay 100        # `slipwave orbit`, by a much finer mesh
python -m validation.error_bars witness alike delay 20        # the same, by the orbit of discontinuous elements of degree 9
python -m validation.error_bars run unlike fd 40 1e-3         # `slipwave run --tol 1e-3`, by the delay system or fine elements

A line for each kind of figure: the share of orbits whose error bar holds the truth, with its 95 % interval (Wilson), and how many
times larger than the error a bar is in the median.
"""

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import groupby, islice
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binomtest

import slipwave
from fullwave.adapt import difference_of, probe
from reduced.orbit.closing import Closed, close
from reduced.orbit.figures import figures_of
from reduced.parameters import scaled
from reduced.stability.critical import critical_round_trip
from slipwave.errors import NumericsError, SceneError
from slipwave.scene import Scene
from validation.output import print_table
from validation.registry.build import build, build_full_wave, prepare
from validation.registry.families import one_port_of
from validation.registry.orbits import find_orbit

_FINER = 3.0
_BEYOND = (1.01, 1.25)  # times the round trip at which steady sliding loses its stability
_DEFAULT, _LOOSEST, _TIGHTEST = 1e-8, 1e-4, 1e-10  # tolerances of orbits; four in ten have the default
_WITNESS, _WITNESS_CELLS = "dg:9", 8
_EXACT = 1e-11
_CHANCE = 1e-15  # rounding error of what is taken for the truth, relative

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


def random_scene(kind: str, model: str, random: np.random.Generator) -> Scene:
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
    return scaled(scene, round_trip=random.uniform(*_BEYOND) * critical / scene.transit)


def of_orbits(kind: str, model: str, random: np.random.Generator, witness: bool = False) -> Iterator[list[Held]]:
    """Figures of random orbits, without end; an empty list where there is none."""

    def measure() -> list[Held]:
        """Of one orbit."""
        tolerance = _DEFAULT if random.random() < 0.4 else 10.0 ** random.uniform(math.log10(_TIGHTEST), math.log10(_LOOSEST))
        found = find_orbit(model, random_scene(kind, model, random), tolerance).found
        truth = _by_witness(found.closed.flow.scene) if witness else _by_finer_mesh(found.closed)
        stated = {name: getattr(found.orbit, name).error for name in truth}
        return [Held(name, stated[name] / true, abs(found.orbit.values()[name] / true - 1.0)) for name, true in truth.items()]

    return _repeated(measure)


def _repeated(measure: Callable[[], list[Held]]) -> Iterator[list[Held]]:
    while True:
        try:
            yield measure()
        except (NumericsError, SceneError):
            yield []


def _by_finer_mesh(closed: Closed) -> dict[str, float]:
    flow, start = closed.flow.remeshed(closed.cycle, _FINER)
    return figures_of(close(flow, start, closed.cycle.period, 0.0))


def _by_witness(scene: Scene) -> dict[str, float]:
    """Of another discretisation, whose own error must be below what it is to judge."""
    return find_orbit(_WITNESS, scene, _EXACT, _WITNESS_CELLS).found.orbit.values()


def of_runs(kind: str, model: str, random: np.random.Generator, tolerance: float) -> Iterator[list[Held]]:
    """Periods and drops of the probe's cycles on grids chosen by tolerances near one, without end; an empty list where none is
    found."""
    viscous = kind == "viscous"

    def measure() -> list[Held]:
        """Of one run."""
        asked = tolerance * 10.0 ** random.uniform(-0.5, 0.5)
        scene = random_scene(kind, model if viscous else "auto", random)
        built = prepare(model, scene, tolerance=asked)
        exact = build_full_wave(_WITNESS, scene, cells=_WITNESS_CELLS) if viscous else build("delay", scene, tolerance=_EXACT)
        assert built.choice is not None
        return [Held(built.choice.quantity, built.choice.error_estimate, difference_of(probe(exact), probe(built.solver)))]

    return _repeated(measure)


def rows(cases: Iterable[list[Held]]) -> Iterator[list[str]]:
    """A row for each kind of figure: number, share held with its interval, and the median of bar over error."""
    found = sorted((held for case in cases for held in case), key=lambda held: held.figure)
    for figure, members in groupby(found, key=lambda held: held.figure):
        group = list(members)
        holds = sum(held.error <= held.bar for held in group)
        low, high = binomtest(holds, len(group)).proportion_ci(method="wilson")
        median = float(np.median([held.bar / max(held.error, _CHANCE) for held in group]))
        yield [figure, str(len(group)), f"{holds / len(group):.3f}", f"{low:.3f} .. {high:.3f}", f"{median:.1f}"]


def print_error_bars(words: list[str]) -> None:
    """Print the table that the words ask for: what, kind, model, count, and the tolerance of runs."""
    what, kind, model, count, *rest = words
    random = np.random.default_rng(sum(map(ord, kind + model)))
    cases = of_runs(kind, model, random, float(rest[0])) if what == "run" else of_orbits(kind, model, random, what == "witness")
    print_table([f"{kind}, {model}", "number", "held", "95 % interval", "bar / error"], list(rows(islice(cases, int(count)))))


if __name__ == "__main__":
    print_error_bars(sys.argv[1:])

"""Stated errors, true errors, and how often the former contain the latter; random scenes beyond the loss of stability."""

from collections.abc import Callable, Iterable
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binomtest

import slipwave
from reduced.parameters import scaled
from reduced.stability.critical import critical_round_trip
from slipwave.scene import Scene
from validation.models.by_name import one_port_of

_CHANCE = 1e-15  # rounding error of what is taken for the truth, relative


class Held(NamedTuple):
    """A `figure` with its stated error `bar` and its true `error`, relative to the figure."""

    figure: str
    bar: float
    error: float


class Coverage(NamedTuple):
    """Coverage of a kind of `figure`: the number of bars (`many`), the `share` that contain the truth with its 95 % interval
    (Wilson), and `width`, the median ratio of bar to error."""

    figure: str
    many: int
    share: float
    low: float
    high: float
    width: float


def coverage_of(computations: Iterable[list[Held]]) -> list[Coverage]:
    found = sorted((held for one in computations for held in one), key=lambda held: held.figure)
    return [_covered(figure, list(members)) for figure, members in groupby(found, key=lambda held: held.figure)]


def _covered(figure: str, group: list[Held]) -> Coverage:
    holds = sum(held.error <= held.bar for held in group)
    low, high = binomtest(holds, len(group)).proportion_ci(method="wilson")
    width = float(np.median([held.bar / max(held.error, _CHANCE) for held in group]))
    return Coverage(figure, len(group), holds / len(group), float(low), float(high), width)


_CLOSE = (1.01, 1.25)  # times the round trip at which steady sliding loses its stability

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
"""Kind of slabs -> keys of a random slab other than impedance and round trip."""


def random_scene(kind: str, model: str, random: np.random.Generator, beyond: tuple[float, float] = _CLOSE) -> Scene:
    """A scene with a kind of SLABS, a little beyond the loss of stability of steady sliding of `model`."""
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

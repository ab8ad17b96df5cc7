"""Random scenes beyond the loss of stability."""

from collections.abc import Callable
from typing import Any

import numpy as np

import slipwave
from reduced.parameters import scaled
from reduced.stability.critical import critical_round_trip
from slipwave.scene import Scene
from validation.compute.models import one_port_of

_BEYOND = (1.01, 1.25)  # times the round trip at which steady sliding loses its stability

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


def random_scene(kind: str, model: str, random: np.random.Generator, beyond: tuple[float, float] = _BEYOND) -> Scene:
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

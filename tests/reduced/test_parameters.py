"""Parameters by name: each takes the value, and all others keep theirs."""

from dataclasses import replace
from typing import NamedTuple

import pytest

import slipwave
from reduced.parameters import PARAMETERS, with_parameter
from slipwave.errors import SceneError

MACHINE = {"kind": "machine", "stiffness": 1.5, "impedance": 0.5, "mass": 0.3}
SCENES = {
    "machine": slipwave.read("unlike", [f"upper.face.{key}={value}" for key, value in MACHINE.items()]),
    "reflection": slipwave.read("reflection"),
}
OF_EVERY_SCENE = {
    "r": lambda scene: scene.upper.round_trip,
    "epsilon": lambda scene: scene.upper.epsilon,
    "V": lambda scene: scene.velocity,
    "a": lambda scene: scene.law.a,
    "b": lambda scene: scene.law.b,
    "ratio_r": lambda scene: scene.lower.round_trip / scene.upper.round_trip,
    "ratio_epsilon": lambda scene: scene.lower.epsilon / scene.upper.epsilon,
}
OF_A_FACE = {
    "machine": {
        "grip_impedance": lambda scene: scene.upper.face.impedance,
        "grip_stiffness": lambda scene: scene.upper.face.stiffness,
        "machine_mass": lambda scene: scene.upper.face.mass,
    },
    "reflection": {"reflection": lambda scene: scene.upper.face.coefficient},
}
CASES = [
    (kind, name)
    for kind, face in OF_A_FACE.items()
    for name in PARAMETERS
    if name.removeprefix("log10_") in face | OF_EVERY_SCENE
]


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_it_takes_the_value_and_all_others_keep_theirs(kind, name):
    scene, plain = SCENES[kind], name.removeprefix("log10_")
    changed = with_parameter(scene, name, -0.5) if name != plain else with_parameter(scene, name, 0.125)
    for other, read in (OF_EVERY_SCENE | OF_A_FACE[kind]).items():
        wanted = (0.125 if name == plain else 10.0**-0.5) if other == plain else read(scene)
        assert read(changed) == pytest.approx(wanted, rel=1e-14), other


def test_a_name_that_is_no_parameter_is_refused():
    with pytest.raises(SceneError, match="did you mean 'log10_r'"):
        with_parameter(SCENES["machine"], "log_r", -3.0)


def test_a_law_of_the_users_without_the_parameter_is_told_its_own():
    """Before, a traceback."""
    scene = replace(SCENES["machine"], law=NamedTuple("Bare", [("strength", float)])(0.4))
    with pytest.raises(SceneError, match=r"interface.a = 0.03: the law of scene .* has none; must be one of interface.strength"):
        with_parameter(scene, "a", 0.03)

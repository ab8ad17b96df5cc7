"""A law from outside: the documented example runs, a wrong function is refused by name."""

import math
import runpy
from pathlib import Path
from typing import NamedTuple

import pytest

from slipwave.errors import SceneError
from slipwave.friction.ageing import Ageing
from slipwave.friction.ageing import respond_ageing as respond
from slipwave.friction.check import check_law
from slipwave.friction.law import LAWS, Registered, register
from slipwave.friction.law import steady_psi as steady_state

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = ("v", "v_z", "F", "F_z", "F_psi", "G", "G_z", "G_psi")


class Unpriced(NamedTuple):
    a: float
    b: float
    c: float
    d: float


def law_with(respond_=respond, steady=steady_state, parameters=Ageing, rate_of=None):
    return Registered(parameters, respond_, steady, rate_of or (lambda law, z: math.exp(z)), lambda law, v: math.log(v))


@pytest.mark.parametrize("name", LAWS)
def test_every_law_of_the_house_passes_the_check(name):
    own = {"cutoff_velocity": 1e3, "saturation_velocity": 1e-3}
    fields = LAWS[name].parameters._fields
    check_law(name, LAWS[name], (0.6, 0.01, 0.015, *(own[field] for field in fields[3:] if field in own)))


@pytest.mark.parametrize("wrong", ["v_z", "F_z", "F_psi", "G_z", "G_psi"])
@pytest.mark.parametrize("fault", [lambda x: -x, lambda x: 1.001 * x, lambda x: x + 1e-3, lambda x: math.nan, lambda x: 0.0])
def test_a_wrong_derivative_is_refused_by_name(wrong, fault):
    place = ANSWERS.index(wrong)

    def spoilt(law, z, psi):
        answer = list(respond(law, z, psi))
        answer[place] = fault(answer[place])
        return tuple(answer)

    with pytest.raises(SceneError, match=rf"'mine': {wrong} "):
        register("mine", Ageing, spoilt, steady_state)
    assert "mine" not in LAWS


@pytest.mark.parametrize(
    ("law", "told"),
    [
        (law_with(steady=lambda law, v: 0.1 - math.log(v)), "state rate G"),
        (law_with(rate_of=lambda law, z: math.exp(2 * z)), "rate_of"),
        (law_with(lambda law, z, psi: respond(law, z, psi)[:7]), "respond must return"),
        (law_with(lambda law, z, psi: (2 * respond(law, z, psi)[0], *respond(law, z, psi)[1:])), "v of respond"),
        (law_with(lambda law, z, psi: 1 / 0), "ZeroDivisionError"),
        (law_with(parameters=Unpriced), "defaults"),
        (LAWS["ageing"]._replace(rate_of=lambda law, z: z * z, unknown_of=lambda law, v: v**0.5), "v''"),
    ],
)
def test_other_faults_are_refused_with_their_reason(law, told):
    with pytest.raises(SceneError, match=told):
        check_law("mine", law)


def test_the_documented_example_is_the_one_that_runs():
    page, program = ((ROOT / name).read_text() for name in ("docs/extending.md", "examples/own_law.py"))
    assert page.split("```python\n")[1].split("```")[0] == program


def test_a_tiny_cutoff_is_the_ageing_law():
    example = runpy.run_path(str(ROOT / "examples" / "own_law.py"), run_name="example")
    mine = example["Cutoff"](cutoff=0.0)
    for z, psi in ((0.0, 0.0), (3.0, -4.0), (-2.0, 5.0)):
        assert example["respond"](mine, z, psi) == pytest.approx(respond(Ageing(0.369, 0.0349, 0.0489), z, psi), rel=1e-14)

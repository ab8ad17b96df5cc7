"""Answers on steady sliding: MODEL.md's impedance by hand, and count, roots and critical values of random scenes."""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import slipwave
from reduced.parameters import scaled, thickened
from reduced.stability import analyse, characteristic, unstable_count
from reduced.stability.analyse import stability_in_si
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.ageing import Ageing, AgeingRegularised
from slipwave.friction.slip import Slip, SlipRegularised
from slipwave.scene import Scene
from slipwave.scene.drive import steady_drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, MachineFace, ReflectingFace, Slab, StandardLinearViscosity
from tests.one_port_by_hand import friction_impedance, pair_impedance
from validation.models.by_name import one_port_of

MODELS = ["delay"] * 6 + ["quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:2", "fitted:3"]
KINDS = ["plain", "plain", "unlike", "irrational", "layers", "grip", "machine", "reflection", "kelvin-voigt", "zener", "si"]


def scene_of(number):
    """(scene, model, kind) of this number: from deep inside the stable to far beyond the onset, a fifth of them close to it."""
    rng = np.random.default_rng([2026, number])

    def among(low, high):
        """A number from `low` to `high`, its logarithm uniform."""
        return float(10.0 ** rng.uniform(math.log10(low), math.log10(high)))

    kind, model = str(rng.choice(KINDS)), str(rng.choice(MODELS))
    a = among(0.003, 0.05)
    gap = a * among(0.05, 1.0) * (-1.0 if rng.random() < 0.08 else 1.0)
    velocity = among(1e-3, 1e4) if rng.random() < 0.85 else among(1e4, 1e7)
    if kind == "si":
        return _in_si(among, a, gap, rng), model, kind
    law = rng.choice(np.array([Ageing, AgeingRegularised, Slip, SlipRegularised], dtype=object))(0.5, a, a + gap)
    r = among(1e-4, 3.0 if rng.random() < 0.7 else 100.0) / velocity
    epsilon = abs(gap) * r * (among(0.1, 10.0) if rng.random() < 0.8 else 1.0 + among(1e-6, 1e-2))
    upper = lower = Slab(epsilon, r)
    if kind in ("unlike", "irrational"):
        ratio = rng.integers(1, 7) / rng.integers(1, 7) if kind == "unlike" else among(0.2, 5.0)
        lower = Slab(epsilon * among(0.1, 10.0), r * float(ratio))
    elif kind == "layers":
        parts = rng.dirichlet(np.ones(rng.integers(2, 5)))
        lower = upper = replace(upper, layers=tuple(Layer(float(part), among(0.1, 10.0)) for part in parts))
    elif kind == "reflection":
        lower = upper = replace(upper, face=ReflectingFace(float(rng.uniform(-0.9, 0.999))))
    elif kind in ("grip", "machine"):
        face = GripFace(among(0.01, 100.0), among(0.01, 100.0))
        held = replace(upper, face=face if kind == "grip" else MachineFace(face.stiffness, face.impedance, among(0.01, 10.0)))
        upper, lower = held, held if rng.random() < 0.5 else lower
    elif kind == "kelvin-voigt":
        lower = upper = replace(upper, viscosity=KelvinVoigtViscosity(r * among(1e-3, 1.0)))
    elif kind == "zener":
        lower = upper = replace(upper, viscosity=StandardLinearViscosity(r * among(0.1, 100.0), among(0.05, 2.0)))
    return Scene(f"{kind}-{number}", law, upper, lower, steady_drive(velocity)), model, kind


def _in_si(among, a, gap, rng):
    slab = {"density": among(1e3, 8e3), "shear_modulus": among(1e9, 1e11), "thickness": among(1e-3, 30.0)}
    if rng.random() < 0.5:
        face = {"stiffness": among(1e9, 1e12), "impedance": among(1e3, 1e7), "mass": among(1.0, 1e4)}
        slab["face"] = {"kind": "machine"} | face
    law = {"law": "ageing", "a_star": 0.6, "a": a, "b": a + gap, "reference_velocity": 1e-6}
    law |= {"normal_stress": among(1e5, 1e8), "memory_length": among(1e-7, 1e-4)}
    tables = {"interface": law, "slab": slab, "drive": {"velocity": among(1e-9, 1.0) * 1e6}}
    return slipwave.read(tables)


def disagreements(scene, model):
    """What contradicts what. Raises what the analysis raises."""
    port = one_port_of(model)
    found = analyse(scene, port)
    problem, wrong = characteristic(scene, port), list(found.missing)
    growing = [root for root in found.leading_roots if root.real > 0.0]
    certain = 1e-9 * problem.slopes.reach
    if found.stable is True and any(root.real > certain for root in growing):
        wrong.append(f"stable, yet a root {growing[0]:.6g} grows")
    if found.stable is False and len(growing) < min(found.unstable_roots, len(found.leading_roots) - 1):
        wrong.append(f"{found.unstable_roots} roots grow, {len(growing)} were found")
    for root in found.leading_roots:
        if not abs(complex(problem.imbalance(root))) < (1e-6 if root.real * scene.transit > -100.0 else 1e-3):
            wrong.append(f"{root:.6g} is no root: {abs(complex(problem.imbalance(root))):.1e}")
    return wrong + [text for name, below, above in _sides(scene, found, port) if (text := _beside(name, below, above, port))]


def _sides(scene, found, model):
    """(name, scene that ought to be stable, scene that ought to be unstable) of every critical value."""
    near = 1e-3
    if math.isfinite(found.log10_r_c):
        r = 10.0**found.log10_r_c / scene.transit
        yield "log10_r_c", scaled(scene, round_trip=r * (1.0 - near)), scaled(scene, round_trip=r * (1.0 + near))
    if math.isfinite(found.epsilon_c):
        factor = found.epsilon_c / scene.upper.epsilon
        yield "epsilon_c", scaled(scene, epsilon=factor * (1.0 + near)), scaled(scene, epsilon=factor * (1.0 - near))
    physical = stability_in_si(scene, found)
    if physical is not None and math.isfinite(physical.critical_thickness):
        factor = physical.critical_thickness / physical.thickness
        yield "thickness", thickened(scene, factor * (1.0 - near)), thickened(scene, factor * (1.0 + near))


def _beside(name, below, above, model):
    counts = [unstable_count(characteristic(one, model)) for one in (below, above)]
    return "" if counts[0] == 0 and counts[1] > 0 else f"{name}: {counts[0]} and {counts[1]} grow on its sides"


def told(numbers):
    """What contradicts what in the scenes of these numbers, with its number; a model that cannot do a scene is replaced."""
    for number in numbers:
        scene, model, kind = scene_of(number)
        try:
            characteristic(scene, model)
        except SceneError:
            model = "delay"
        with suppress(NumericsError):
            yield from (f"{number} {kind} {model}: {text}" for text in disagreements(scene, model))


PLAIN = ["paper", "paper-2.3", "paper-si", "rock", "slip-law", "unlike", "unlike-irrational"]
SCENES = [*PLAIN, "grip", "layered", "machine", "reflection", "viscous"]


def smallest(scene, omega):
    """|H + Z|/|H| at the frequencies `omega`."""
    values = [
        (friction_impedance(scene, 1j * w) + pair_impedance(scene, 1j * w)) / friction_impedance(scene, 1j * w) for w in omega
    ]
    return np.abs(values)


@pytest.mark.parametrize("name", SCENES)
def test_critical_values_of_the_gallery_are_the_first_zeros_of_the_impedance_by_hand(name):
    """H + Z vanishes at i omega of the critical r and epsilon, and at no smaller r and no larger epsilon."""
    scene = slipwave.read(name)
    found = slipwave.stability(name).summary
    fine = scene.velocity * np.sqrt((scene.law.b - scene.law.a) / scene.law.a) * np.linspace(0.5, 1.05, 441)
    if found["log10_r_c"] is not None:
        at = scaled(scene, round_trip=10.0 ** found["log10_r_c"] / scene.transit)
        assert smallest(at, [found["omega_c"]])[0] < 1e-9
        for share in (0.5, 0.8, 0.95, 0.99):
            assert smallest(scaled(at, round_trip=share), fine).min() > 0.3 * (1.0 - share)
    else:
        assert name == "reflection"
    at = scaled(scene, epsilon=found["epsilon_c"] / scene.upper.epsilon)
    low = np.geomspace(1e-9, 1.0, 2001) * fine[-1]
    closest = low[np.argmin(smallest(at, low))]
    within = (0.99 * closest, 1.01 * closest)
    assert minimize_scalar(lambda w: smallest(at, [w])[0], bounds=within, method="bounded", options={"xatol": 1e-12}).fun < 1e-7
    for share in (1.01, 1.1, 2.0, 10.0, 1e3):
        assert smallest(scaled(at, epsilon=share), np.concatenate([fine, low])).min() > 0.3 * (1.0 - 1.0 / share)


@pytest.mark.parametrize("numbers", [range(6), pytest.param(range(300, 324), marks=pytest.mark.slow)], ids=str)
def test_answers_on_random_scenes_agree(numbers):
    assert list(told(numbers)) == []

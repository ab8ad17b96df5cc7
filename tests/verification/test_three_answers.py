"""Run, count of roots and orbit asked of random scenes near their onset: none contradicts another.

Plain slabs, unlike ones whose round trips are not commensurate, nearly alike ones, in which waves ring long, faces that leak,
slabs so thick that a transit lasts as long as friction's own oscillation, and scenes in SI.

    steady, decaying    no root of steady sliding grows
    growing             a root grows, or there is an orbit, to which it grows
    periodic, torus,    a root grows, or there is an orbit beside stable sliding. Of cycles with one event that repeat, the orbit
    irregular           is found, has the period, and is not unstable; beside cycles that wander, it is not stable
    torus               neighbours part no faster than within the margin of the largest Lyapunov exponent
"""

import math
import signal
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

import numpy as np
import pytest

import slipwave
from reduced.stability import analyse, characteristic, unstable_count
from slipwave.errors import NumericsError, SceneError
from slipwave.solve.lyapunov import largest_exponent
from validation.models.build import build
from validation.models.by_name import one_port_of
from validation.models.outlook import UntilSettled
from validation.models.run import Run, reconsidered, simulate

KINDS = ("plain", "unlike", "nearly alike", "leaking", "thick", "SI")
MODELS = ("delay", "delay", "delay", "modal:2", "kelvin-voigt")
_SAME = 1e-3
_MOST = 3.0  # s, by a count of the work of a run


class Answers(NamedTuple):
    """The run, how many roots grow, the JSON of the orbit if there is one; whether neighbours of a torus part."""

    run: Run
    roots: int
    orbit: dict[str, Any] | None
    parts: bool


def scene_of(number):
    """The scene of this number and its model: within 5 % of the thickness at the onset, or from half of it to twice as thick."""
    rng = np.random.default_rng([37, number])
    onset = math.nan
    while not math.isfinite(onset):
        given, model = _drawn(rng, KINDS[number % len(KINDS)])
        scene = slipwave.read_scene(given)
        with suppress(SceneError, NumericsError):
            onset = analyse(scene, one_port_of(model)).log10_r_c
    beyond = rng.uniform(-0.02, 0.02) if rng.random() < 0.4 else rng.uniform(-0.3, 0.3)
    scale = 10.0 ** (onset + beyond) / scene.transit
    for slab in (given[key] for key in ("slab", "upper", "lower") if key in given):
        slab["thickness" if scene.units else "r"] *= scale
    return slipwave.read_scene(given), model


def _drawn(rng, kind):
    def among(low, high):
        return float(10.0 ** rng.uniform(math.log10(low), math.log10(high)))

    a, gap, velocity = among(0.01, 0.05), among(0.1, 1.0), among(1.0, 1000.0)
    omega = velocity * math.sqrt(gap)
    turned = among(0.5, 2.5) if kind == "thick" else among(0.05, 0.6)  # radians of that oscillation in a transit
    slab = {"epsilon": 2.0 * a * gap / omega * math.tan(0.5 * turned), "r": turned / omega}
    law = {"law": "slip" if rng.random() < 0.15 else "ageing", "a_star": 0.4, "a": a, "b": a + a * gap}
    name = {"name": kind, "interface": law, "drive": {"velocity": velocity}, "start": {"size": among(0.02, 2.0)}}
    model = str(rng.choice(MODELS)) if kind == "plain" else "delay"
    if kind == "SI":
        density, modulus = among(800.0, 3000.0), among(1e6, 5e10)
        law |= {"normal_stress": math.sqrt(density * modulus) * 1e-6 / slab["epsilon"], "memory_length": among(1e-6, 1e-4)}
        law["reference_velocity"] = 1e-6
        return name | {"slab": {"density": density, "shear_modulus": modulus, "thickness": 1.0}}, model
    if kind in ("unlike", "nearly alike"):
        trips = among(0.4, 2.5) if kind == "unlike" else among(0.85, 1.2)
        other = {"epsilon": slab["epsilon"] * among(0.3, 3.0), "r": slab["r"] * trips}
        return name | {"upper": slab, "lower": other}, model
    if kind == "leaking":
        face = [
            {"kind": "grip", "stiffness": among(0.1, 10.0), "impedance": among(0.1, 10.0)},
            {"kind": "machine", "stiffness": among(0.1, 10.0), "impedance": among(0.01, 1.0), "mass": among(0.1, 3.0)},
            {"kind": "reflection", "coefficient": 1.0 - among(1e-5, 1e-3)},
        ][rng.integers(3)]
        slab["face"] = face
    return name | {"slab": slab}, model


def answers(scene, model):
    """What run, count of roots and `orbit` say of a scene. Raises NumericsError where the run or the count fails."""
    length, solver = UntilSettled(scene, one_port_of(model), most_seconds=_MOST), build(model, scene)
    run = reconsidered(simulate(solver, length), one_port_of(model))
    roots = unstable_count(characteristic(scene, one_port_of(model)))
    parts = run.kind == "torus" and parting(solver, build(model, scene), float(run.events.period.mean()))
    try:
        return Answers(run, roots, slipwave.orbit(scene, model).summary, parts)
    except NumericsError:
        return Answers(run, roots, None, parts)


def parting(solver, twin, cycle):
    with suppress(NumericsError):  # the steps of the two marches part
        exponent = largest_exponent(solver, twin, cycle, intervals=24)
        return exponent.rate > max(1.5 * exponent.margin, 1e-3 / cycle)
    return False


def contradiction(given):
    """Where the answers contradict each other, in words; empty if they do not."""
    run, roots, orbit, parts = given
    kind, periods = run.kind, run.events.period
    if kind in ("steady", "decaying") and roots:
        return f"{kind}, while {roots} roots grow"
    if kind == "growing" and not (roots or orbit):
        return "growing, while no root grows and there is no orbit"
    if not run.verdict.repeats:
        return ""
    if not (roots or orbit):
        return f"{kind}, while no root grows and there is no orbit"
    if kind == "periodic" and not orbit and run.verdict.multiplicity == 1:
        return f"cycles of {periods[-1]:.6g} that repeat, while no orbit was found"
    if kind == "periodic" and orbit:
        period = float(periods[-run.verdict.multiplicity :].sum())
        same = abs(orbit["period"] / period - 1.0) < _SAME
        if run.verdict.multiplicity == 1 and not same:
            return f"cycles of {period:.6g} that repeat, while the orbit has {orbit['period']:.6g}"
        if same and orbit["stable"] is False:
            return f"cycles of {period:.6g} that repeat, while the orbit is unstable"
    if parts:
        return "torus, while neighbours part"
    if kind in ("torus", "irregular") and orbit and orbit["stable"]:
        return f"{kind}, while the orbit of {orbit['period']:.6g} is stable (mean period {periods.mean():.6g})"
    return ""


@contextmanager
def within(seconds):
    """TimeoutError after so many seconds of the processor."""

    def give_up(*_):
        raise TimeoutError

    signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


@pytest.mark.parametrize("number", [0, 3, 4, 5, 10, 13, 15, 17, 19, 26, 28, 32, 56])
def test_run_roots_and_orbit_do_not_contradict_each_other(number):
    assert contradiction(answers(*scene_of(number))) == ""


@pytest.mark.slow
def test_they_do_not_on_more_random_scenes():
    """Of those that are answered within 20 s each."""
    for number in range(120):
        with suppress(NumericsError, SceneError, TimeoutError), within(20.0):
            assert contradiction(answers(*scene_of(number))) == "", number

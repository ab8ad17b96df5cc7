"""Nothing grows: noise at the grid scale against the step limit, and in a locked slab for a million transits."""

import dataclasses

import numpy as np
import pytest
from exact_waves import LOCKED, fields, impose, rate_scene, squared

import slipwave
from fullwave.finite_difference import Leapfrog
from validation.measure.limits import CELLS, MEDIA, around_the_limit, growth
from validation.models.build import build
from validation.models.by_name import explicit_time


def explicit_step(model, scene):
    return build(model, scene, cells=CELLS[model], time=explicit_time(model)).step


@pytest.mark.parametrize("medium", MEDIA)
@pytest.mark.parametrize("model", CELLS)
def test_noise_grows_beyond_the_limit_and_nowhere_below(model, medium):
    below, above = around_the_limit(model, medium)
    assert below < 20.0
    assert above > 100.0


@pytest.mark.parametrize("stiffness", [1e4, 1e8])
@pytest.mark.parametrize("model", [model for model in CELLS if model != "fd"])
def test_limit_is_blind_to_a_stiff_state(model, stiffness):
    """a and b of the ageing law scaled: the same step, stable at 0.99 of it, not at 1.04."""
    plain = slipwave.read("paper", ["start.size=0"])
    stiff = dataclasses.replace(plain, law=plain.law._replace(a=stiffness * plain.law.a, b=stiffness * plain.law.b))
    assert explicit_step(model, stiff) == explicit_step(model, plain)
    assert growth(model, stiff, 0.99) < 20.0
    assert growth(model, stiff, 1.04) > 100.0


NOISY = {"sbp:2": 6, "sbp:4": 12, "sbp:6": 16, "fem:1": 6, "fem:4": 2, "dg:3": 2, "dg:4": 2, "dg:7": 2}

LONG = [pytest.param(model, 10, 1e5, marks=pytest.mark.slow) for model in ("sbp:6", "fem:4", "dg:7")]


@pytest.mark.parametrize(("model", "looks", "apart"), [*((model, 12, 40.0) for model in NOISY), *LONG])
def test_noise_in_a_locked_slab_never_gains_energy(model, looks, apart):
    """An absolutely still interface and rigid faces, at the full step; energy in the scheme's own norm (slow: 1e6 transits)."""
    solver = build(model, rate_scene(LOCKED), cells=NOISY[model], cfl=1.0)
    draw = np.random.default_rng(5).standard_normal
    impose(solver, lambda x: draw(x.size), lambda x: draw(x.size))
    energies = []
    for look in range(looks + 1):
        while solver.time < look * apart:
            solver.advance(look * apart)
        _, w, s, norm = fields(solver)
        energies.append(squared(norm, w, s))
    assert (np.diff(energies) <= 1e-9 * energies[0]).all()
    assert energies[-1] < energies[0]
    assert solver.energy().radiated == 0.0


@pytest.mark.parametrize("transits", [500, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_noise_in_the_leapfrogs_locked_slab_comes_back_unchanged(transits):
    """At cfl 1 waves travel without error, so that every transit repeats the one before; rounding alone may add up."""
    solver = Leapfrog(rate_scene(LOCKED), cells=12, cfl=1.0)
    solver.advance(1.0)
    state = solver.state()
    state["upper.velocity"][1:-1] += np.random.default_rng(5).standard_normal(11)
    solver.restore(state)
    begin, before = solver.time, state["upper.velocity"].copy()
    while solver.time < begin + transits:
        solver.advance(begin + transits)
    assert (solver.time - begin) % 1.0 == pytest.approx(0.0, abs=1e-9)
    drift = np.abs(solver.state()["upper.velocity"] - before).max()
    assert drift < 1e-13 * transits

"""The compiled right-hand side against the plain matrix: every family, every scene."""

import numpy as np
import pytest
from leapfrog_scenes import SCENES
from march_scenes import FAMILIES, PAIRS

from fullwave.lines.matrix import motion_matrix
from fullwave.lines.motion import rates_of
from fullwave.lines.system import ELASTIC, FRICTION, GRIP, PSI, SCALARS, Viscous
from slipwave.compiled import njit
from slipwave.friction import respond, unknown_of


@njit
def compiled_rates(system, time, state, rates, z):
    return rates_of(system, time, state, rates, 0, z)


COMPARED = [
    ("dg:5", "alike"),
    ("dg:5", "unlike"),
    ("dg:5", "everything"),
    ("fem:4", "layers"),
    ("fem:2 consistent", "alike"),
    ("sbp:6", "grip"),
    ("sbp:6", "machine"),
    ("dg:5", "hung-machine"),
]


@pytest.mark.parametrize(("family", "name"), COMPARED)
def test_compiled_motion_is_the_plain_matrix_plus_friction(family, name):
    scene = SCENES[name]
    solver = FAMILIES[family](scene)
    system, size = solver.system, solver.grid.size
    state = solver.state()["state"]
    generator = np.random.default_rng(1)
    used = np.concatenate([slots for block in solver.grid.blocks for slots in (block.velocity, block.stress)])
    state[used] = generator.standard_normal(used.size)
    state[size + GRIP : size + GRIP + system.interface.sides] = generator.standard_normal(system.interface.sides)
    if isinstance(system.medium, Viscous):
        relaxing = np.flatnonzero(system.medium.rate > 0.0)
        state[size + SCALARS + relaxing] = generator.standard_normal(relaxing.size)
    if system.interface.heavy:
        state[system.interface.heavy] = generator.standard_normal()
    rates = np.zeros(state.size)
    z, mu, _, iterations = compiled_rates(system, 0.0, state, rates, unknown_of(scene.law, scene.velocity))
    assert iterations > 0

    kept = np.r_[0:size, size + SCALARS : state.size]
    plain = motion_matrix(system, locked=False) @ state
    # free: mu stays at its steady value; friction's change of it slows each slab's end by (mu - mu_ss)/(eps f), felt through
    # whatever the end's velocity feeds, so the difference is this multiple of one column of the locked-to-free change
    answer = respond(scene.law, z, state[size + PSI])
    assert mu == pytest.approx(answer[2], rel=1e-13)
    first = 2 * system.interface.joints
    ends = slice(first, first + system.interface.sides)
    change = mu - scene.steady_stress
    push = -change / (system.traces.impedance * system.traces.stiffened)[ends]
    for k, jump in zip(range(first, ends.stop), push, strict=True):
        if system.traces.stiffened[k] == 1.0 and "consistent" not in family:
            extra = np.zeros(state.size)
            extra[system.traces.velocity[k]] = system.traces.lift[k] * jump
            strain = -system.traces.lift[k] * jump
            extra[system.traces.stress[k]] = strain
            if isinstance(system.medium, Viscous):
                extra[size + SCALARS + system.traces.stress[k]] = system.medium.fraction[system.traces.stress[k]] * strain
            plain = plain + extra
            continue
        near = np.concatenate([block.velocity for block in solver.grid.blocks if block.section.slab == k - first][:1])
        stress = np.concatenate([block.stress for block in solver.grid.blocks if block.section.slab == k - first][:1])
        kept = np.setdiff1d(kept, np.r_[near, stress])  # spread over the first block by M^-1 or by viscosity: not compared
    np.testing.assert_allclose(rates[kept], plain[kept], rtol=1e-9, atol=1e-9 * np.abs(plain).max())
    grips = slice(size + GRIP, size + GRIP + system.interface.sides)
    np.testing.assert_allclose(rates[grips], plain[grips], rtol=1e-10, atol=1e-12)
    assert rates[size + PSI] == pytest.approx(scene.transit * answer[5], rel=1e-12)
    assert rates[size + ELASTIC] == pytest.approx(scene.stiffness * (scene.velocity - answer[0]), rel=1e-12)
    assert rates[size + FRICTION] == pytest.approx(scene.transit * mu * answer[0], rel=1e-12)


@pytest.mark.parametrize(("family", "name"), PAIRS)
def test_no_scene_lets_the_frictionless_motion_grow(family, name):
    """Spectrum of the plain matrix: nothing to the right of the imaginary axis, locked or free."""
    system = FAMILIES[family](SCENES[name]).system
    for locked in (True, False):
        spectrum = np.linalg.eigvals(motion_matrix(system, locked))
        assert spectrum.real.max() < 1e-9 * np.abs(spectrum).max()

"""Exact waves in a single slab: pulses at every kind of outer face and layer, damped standing waves, no growth in long runs."""

import cmath
import dataclasses
import math

import numpy as np
import pytest
from leapfrog_scenes import PAPER, SLAB

from fullwave.leapfrog.grid import slab_grid
from fullwave.leapfrog.media import accelerate, load, strain
from fullwave.leapfrog.viscous import steady_side
from slipwave.compiled import njit
from slipwave.scene.slab import KelvinVoigtViscosity, Layer, ReflectingFace, StandardLinearViscosity


@njit
def march_locked(medium, face, steps):
    """The interface held at rest, the drive still."""
    for _ in range(steps):
        strain(medium)
        load(medium, face, 0.0, 0.0)
        accelerate(medium, face, 0.0, 0.0, 0.0)


def at_rest(slab, cells, cfl=1.0):
    grid = slab_grid(slab, slab.round_trip, cfl * 0.5 / cells, cfl, cells)
    side = steady_side(PAPER, slab, grid)
    side.medium.velocity[:] = 0.0
    return side, grid


def send_pulse(side, grid, centre, width=0.03):
    """A pulse on its way outwards: w(depth - t), sigma = -eps w; velocities half a step early of the first `strain`."""

    def shape(s):
        return np.exp(-(((s - centre) / width) ** 2))

    middle = 0.5 * (grid.depth[1:] + grid.depth[:-1])
    side.medium.velocity[:] = shape(grid.depth + 0.5 * grid.step)
    side.medium.stress[:] = -grid.impedance * shape(middle + grid.step)
    return shape


@pytest.mark.parametrize("reflection", [1.0, 0.5, 0.0, -1.0])
def test_pulse_at_the_outer_face(reflection):
    """It comes back as -R times itself; at cfl 1 without any error but rounding. R = 0 swallows it."""
    slab = dataclasses.replace(SLAB, face=ReflectingFace(reflection))
    side, grid = at_rest(slab, 200)
    shape = send_pulse(side, grid, 0.25)
    march_locked(side.medium, side.face, 200)
    expected = -reflection * shape(grid.depth + 0.5 * grid.step - grid.step)
    assert np.abs(side.medium.velocity[:-1] - expected[:-1]).max() < 2e-3 * (abs(reflection) < 1) + 1e-12


def test_echo_of_a_layer():
    """Reflected (1 - k)/(1 + k), transmitted 2/(1 + k) at an impedance jump by k, to second order."""
    ratio = 3.0
    slab = dataclasses.replace(SLAB, layers=(Layer(0.5, 1.0), Layer(0.5, ratio)))
    errors = []
    for cells in (200, 400):
        side, grid = at_rest(slab, cells)
        send_pulse(side, grid, 0.125, 0.02)
        march_locked(side.medium, side.face, cells // 2)
        near, far = grid.depth < 0.25, grid.depth > 0.25
        reflected = side.medium.velocity[near][np.abs(side.medium.velocity[near]).argmax()]
        transmitted = side.medium.velocity[far].max()
        errors.append(max(abs(reflected - (1 - ratio) / (1 + ratio)), abs(transmitted - 2 / (1 + ratio))))
    assert errors[1] < 2e-3
    assert errors[1] < 0.4 * errors[0]


def roots_of(slab):
    """Decay and frequency of the fundamental standing wave: s^2 = -k^2 G(s), by fixed point from the elastic root."""
    k = 2 * math.pi
    s = 1j * k
    viscosity = slab.viscosity
    for _ in range(200):
        time = viscosity.time / SLAB.round_trip
        if isinstance(viscosity, KelvinVoigtViscosity):
            modulus = 1 + s * time
        else:
            modulus = (1 + viscosity.ratio * s * time / (1 + s * time)) / (1 + viscosity.ratio)
        s = 1j * k * cmath.sqrt(modulus)
    return s


@pytest.mark.parametrize(
    "viscosity",
    [KelvinVoigtViscosity(0.01 * SLAB.round_trip), StandardLinearViscosity(0.3 * SLAB.round_trip, 0.5)],
    ids=["kelvin-voigt", "standard-linear"],
)
def test_damped_standing_wave(viscosity):
    """Decay per transit and frequency against the complex dispersion relation, to second order."""
    slab = dataclasses.replace(SLAB, viscosity=viscosity)
    root = roots_of(slab)
    errors = []
    for cells in (24, 48, 96):
        side, grid = at_rest(slab, cells)
        side.medium.velocity[:] = np.sin(2 * math.pi * grid.depth)
        middle = cells // 2
        trace = []
        for _ in range(8 * cells):
            march_locked(side.medium, side.face, 1)
            trace.append(side.medium.velocity[middle])
        trace = np.array(trace)
        # a damped oscillation and one relaxation: u[n+3] = p u[n+2] + q u[n+1] + o u[n]
        past = np.column_stack([trace[2:-1], trace[1:-2], trace[:-3]])
        factors = np.roots([1.0, *-np.linalg.lstsq(past, trace[3:], rcond=None)[0]])
        oscillation = factors[factors.imag.argmax()]
        errors.append(abs(cmath.log(oscillation) / grid.step - root))
    assert errors[-1] < 2e-3 * abs(root)
    assert errors[0] / errors[1] > 3.5
    assert errors[1] / errors[2] > 3.5

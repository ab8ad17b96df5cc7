"""The longest stable step of a scheme, computed from its spectrum.

In a homogeneous elastic slab the characteristics s + w and s - w travel independently, so a slab unfolds into one line along
which u_t = -u_x. Its discrete spectrum is computed without inflow, and with the outflow returning at all phases. The spectrum
times the step must lie where the Runge-Kutta method does not amplify. The friction solve does not reduce the limit, because it
does not amplify waves. The matrices are not normal; a measurement shows that the spectrum is still sufficient: noise on the whole
grid does not grow at 0.99 of the limit, and grows beyond the limit (tests/verification/test_noise.py).

Step limits that depend on the scene and not only on the scheme: outer faces, viscosity, the frictional state.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from fullwave.lines.blocks import Builder, Section, assemble
from fullwave.lines.matrix import motion_matrix
from fullwave.lines.runge_kutta import RungeKutta, method_of, stability_polynomial
from fullwave.lines.system import System
from slipwave.friction import respond, steady_state, unknown_of
from slipwave.observe.pieces import Array
from slipwave.scene import Scene

Complex = NDArray[np.complex128]
MARGIN = 0.99
"""Share of the computed limit that is used if the line is shortened for the computation."""

_GROWTH = 1e-11  # largest amplification in one step that counts as rounding
_KEPT_OFF = 1e-6  # relative distance kept from the limit; without it that rounding would be real growth in 1e6 transits
_PHASES, _PHASES_BY_NODE = 24, 800
"""Least number of phases, and how many there are times the nodes of a line: with 24 the limit of elements of degree 1 is 2e-4
too long, since the worst phase lies between two; with 400 it is right to 1e-6."""
_BISECTIONS = 40

_SAMPLE_NODES = 28  # per section of the sample whose spectrum is computed


def line_spectrum(derivative: Array, lift: Array) -> Complex:
    """Eigenvalues of u_t = -D u + lift (inflow - u_0) with inflow = phase * u_end, for phases on the unit circle and for 0.
    `derivative` D (n, n) and `lift` (n,) belong to a line of length 1."""
    base = -derivative.astype(complex)
    base[:, 0] -= lift
    spectra = [np.linalg.eigvals(base)]
    for angle in np.linspace(0.0, np.pi, max(_PHASES, _PHASES_BY_NODE // len(lift))):
        ring = base.copy()
        ring[:, -1] += lift * np.exp(1j * angle)
        spectra.append(np.linalg.eigvals(ring))
    return np.concatenate(spectra)


def longest_step(spectrum: Complex, method: RungeKutta) -> float:
    """Largest step below which no eigenvalue is amplified; step and eigenvalues on the same clock."""
    amplification = Polynomial(stability_polynomial(method))

    def _stable(step: float) -> bool:
        """Whether no eigenvalue is amplified by this step."""
        return bool(np.abs(amplification(step * spectrum)).max() <= 1.0 + _GROWTH)

    radius = float(np.abs(spectrum).max())
    steps = np.linspace(0.0, 20.0 / radius, 401)[1:]
    first_bad = next((k for k, step in enumerate(steps) if not _stable(step)), len(steps) - 1)
    low, high = (steps[first_bad - 1] if first_bad else 0.0), steps[first_bad]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _stable(middle) else (low, middle)
    return float(low) * (1.0 - _KEPT_OFF)


@cache
def _real_reach(order: int) -> float:
    return longest_step(np.array([-1.0 + 0.0j]), method_of(order))


def longest_decay_step(rate: float, method: RungeKutta) -> float:
    """Largest stable step for u' = -rate u."""
    return _real_reach(method.order) / rate if rate > 0.0 else np.inf


def relaxation_limit(system: System, method: RungeKutta) -> float:
    """Longest step (transits) for stable relaxation of the springs at massless faces and, in steady sliding, of the state."""
    law, forcing = system.interface.law, system.forcing
    psi = steady_state(law, forcing.velocity)
    ageing = forcing.transit * abs(respond(law, unknown_of(law, forcing.velocity), psi)[7])
    massless = system.tops.mass == 0.0
    return longest_decay_step(max(ageing, float((massless * system.tops.spring * system.tops.yielding).max())), method)


def spectral_limit(scene: Scene, build: Builder, sections: Sequence[Section], method: RungeKutta) -> float:
    """Longest stable step (transits) of `scene` with the cells of `sections`. The spectra are computed for shortened slabs (a few
    cells per section), with the interface locked (v = 0) and free (constant stress). `MARGIN` covers the shortening, which
    changed the limit by 0.3 per cent (measured)."""
    short = []
    for section in sections:
        nodes = sum(block.depth.size for block in build([section]).blocks)
        cells = min(section.cells, max(section.fewest, -(-_SAMPLE_NODES * section.cells // nodes)))
        short.append(section._replace(length=section.length * cells / section.cells, cells=cells))
    system = assemble(scene, build(short))
    spectra = [np.linalg.eigvals(motion_matrix(system, locked)).astype(complex) for locked in (True, False)]
    return MARGIN * longest_step(np.concatenate(spectra), method)

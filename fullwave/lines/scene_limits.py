"""Step limits that depend on the scene and not only on the scheme: outer faces, viscosity, the frictional state."""

from collections.abc import Sequence

import numpy as np

from fullwave.lines.blocks import Builder, Section, assemble
from fullwave.lines.matrix import motion_matrix
from fullwave.lines.runge_kutta import RungeKutta
from fullwave.lines.scheme_limit import MARGIN, longest_decay_step, longest_step
from fullwave.lines.system import System
from slipwave.friction import respond, steady_state, unknown_of
from slipwave.scene import Scene

_SAMPLE_NODES = 28  # per section of the sample whose spectrum is computed


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
    system = assemble(scene, build([_cut_short(section, build) for section in sections]))
    spectra = [np.linalg.eigvals(motion_matrix(system, locked)).astype(complex) for locked in (True, False)]
    return MARGIN * longest_step(np.concatenate(spectra), method)


def _cut_short(section: Section, build: Builder) -> Section:
    """The same section with fewer cells of the same length, so that it has about `_SAMPLE_NODES` nodes."""
    whole = build([section])
    nodes = sum(block.depth.size for block in whole.blocks)
    cells = min(section.cells, max(section.fewest, -(-_SAMPLE_NODES * section.cells // nodes)))
    return section._replace(length=section.length * cells / section.cells, cells=cells)

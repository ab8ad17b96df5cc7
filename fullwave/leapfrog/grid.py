"""The leapfrog's grid: each layer of each slab has its own whole number of cells, so that no travel time is rounded.

The step is common: cfl times the cell of the slab with the shorter round trip. A layer has as many cells as keep its own Courant
number at or just below cfl. Boundaries between layers are nodes, which carry half a cell of either side.
"""

from dataclasses import dataclass

import numpy as np

from fullwave.options import CellsRefused
from slipwave.observe.pieces import Array
from slipwave.scene.slab import Slab

MOST_CELLS = 10_000_000


@dataclass(frozen=True)
class LeapfrogGrid:
    """Cells of a slab from the interface outwards: `width` (n,) as travel time in transits, `impedance` (n,); the step; and the
    `burden` on the last node, which is the mass on the slab's outer face (stress/V* times a transit)."""

    width: Array
    impedance: Array
    step: float
    burden: float = 0.0

    @staticmethod
    def of(slab: Slab, transit: float, step: float, cfl: float, cells: int) -> "LeapfrogGrid":
        """Grid of `slab`; a transit is `transit` L/V*. Raises SceneError naming cells if a layer is thinner than a cell."""
        widths, impedances = [], []
        for number, layer in enumerate(slab.layers):
            travel = 0.5 * slab.round_trip / transit * layer.fraction
            count = int(np.floor(cfl * travel / step * (1.0 + 1e-9)))
            if count < 1:
                wanted = int(np.ceil(cells * step / (cfl * travel)))
                raise CellsRefused(f"cells = {cells}: layer {number + 1} is thinner than a cell; use at least {wanted}")
            if count > MOST_CELLS:
                raise CellsRefused(f"cells = {cells}: the slower slab would need {count} cells; at most {MOST_CELLS} are allowed")
            widths.append(np.full(count, travel / count))
            impedances.append(np.full(count, slab.epsilon * layer.impedance))
        burden = slab.termination.in_transits(transit).mass
        return LeapfrogGrid(np.concatenate(widths), np.concatenate(impedances), step, burden)

    @property
    def depth(self) -> Array:
        """Travel time of the nodes from the interface, transits, shape (n + 1,)."""
        return np.concatenate(([0.0], np.cumsum(self.width)))

    @property
    def mass(self) -> Array:
        """Mass per node times c: half of each neighbouring cell's eps dx, and the burden; shape (n + 1,)."""
        half = 0.5 * self.impedance * self.width
        return np.concatenate((half, [self.burden])) + np.concatenate(([0.0], half))

    @property
    def inertia(self) -> Array:
        """Grid impedance 2 mass/dt of the nodes (eps dx/dt at an end), shape (n + 1,)."""
        return 2.0 * self.mass / self.step

    @property
    def stiffness(self) -> Array:
        """eps dt/dx, shape (n,)."""
        return self.impedance * self.step / self.width

    @property
    def is_uniform(self) -> bool:
        """Whether it has one width and one impedance, and no burden."""
        return self.burden == 0.0 and bool(np.all(self.width == self.width[0]) and np.all(self.impedance == self.impedance[0]))

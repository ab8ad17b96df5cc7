"""A model with its numerical options, as the tables of `make bench` name it."""

import math
from typing import NamedTuple

from slipwave.scene import Scene
from slipwave.solve import Solver
from validation.models.build import build
from validation.models.by_name import Options
from validation.models.timing import March


class Setting(NamedTuple):
    """`None` leaves an option to the model."""

    model: str
    tolerance: float | None = None
    cells: int | None = None
    time: str | None = None

    @property
    def options(self) -> Options:
        """The numerical options."""
        return Options(tolerance=self.tolerance, cells=self.cells, time=self.time)

    @property
    def words(self) -> str:
        """The model and its options."""
        words = [f"{self.cells} cells"] if self.cells else []
        words += [f"{self.time} in time"] if self.time else []
        words += [f"tolerance 1e{math.log10(self.tolerance):.2g}"] if self.tolerance else []
        return ", ".join([self.model, *words])

    def solver(self, scene: Scene) -> Solver:
        """The solver at the start of `scene`."""
        return build(self.model, scene, **self.options)

    def march(self, scene: Scene, transits: float, begin: float = 0.0) -> March:
        """The work of a march."""
        return March(self.model, scene, transits, begin, self.options)

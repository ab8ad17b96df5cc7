"""Processor time of models on one scene, all timed in turn in one process."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slipwave.scene import Scene
from validation.models.by_name import Options
from validation.models.timing import in_turn, marching


def march_times(
    models: Sequence[tuple[str, Mapping[str, Any]]], scene: Scene, transits: float, rounds: int, begin: float = 0.0
) -> np.ndarray:
    """Seconds (rounds, models) of march and event detection over so many `transits` from `begin` on, of each model with its
    options of `slipwave.run`. The first round loads code."""
    works = {}
    for number, (model, settings) in enumerate(models):
        options = Options(
            tolerance=settings.get("tol"), cells=settings.get("cells"), cfl=settings.get("cfl"), time=settings.get("time")
        )
        works[number] = marching(model, scene, transits, begin, **options)
    return np.array([[*seconds.values()] for seconds in in_turn(works, rounds)])

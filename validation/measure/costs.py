"""Processor time of models on one scene, all timed in turn in one process."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slipwave.scene import Scene
from validation.models.timing import March, Setting, in_turn


def march_times(
    models: Sequence[tuple[str, Mapping[str, Any]]], scene: Scene, transits: float, rounds: int, begin: float = 0.0
) -> np.ndarray:
    """Seconds (rounds, models) of march and event detection over so many `transits` from `begin` on, of each model with its
    options of `slipwave.run`. The first round loads code."""
    settings = [Setting(model, *map(options.get, ("tol", "cells", "cfl", "time"))) for model, options in models]
    works = {number: March(setting, scene, transits, begin) for number, setting in enumerate(settings)}
    return np.array([[*seconds.values()] for seconds in in_turn(works, rounds)])

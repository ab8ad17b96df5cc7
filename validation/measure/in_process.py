"""Sweeps in this process, without keeping a folder: studies are computed side by side in processes of their own."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import slipwave
from validation.commands.sweep import SweepResult as SweepResult


def swept_here(scene: slipwave.Scene, vary: Mapping[str, Any], models: tuple[str, ...], **options: Any) -> SweepResult:
    """The sweep of verdicts with these `models`, all points; `options` of `slipwave.sweep`."""
    with ThreadPoolExecutor(1) as here:
        found = slipwave.sweep(scene, vary=vary, models=",".join(models), workers=1, executor=here, **options)
        _ = found.dataset  # read before its folder is removed
    found.close()
    return found


def model_regimes(model: str, swept: SweepResult) -> Any:
    """The regimes of one of its models at the points of a sweep, as `MapResult.regimes`."""
    return slipwave.map(swept, plain=True).regimes(model)

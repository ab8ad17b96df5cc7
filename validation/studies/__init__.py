"""The studies of the report, in the order in which they are shown. Adding one means adding its file and its line here."""

from importlib import import_module
from typing import cast

from slipwave.errors import SceneError
from validation.study import Study

STUDIES = {
    "which-model": "which_model",
    "beyond-one-scene": "beyond_one_scene",
    "scene-facts": "scene_facts",
    "one-cycle": "one_cycle",
    "leapfrog-convergence": "leapfrog_convergence",
    "grid-convergence": "grid_convergence",
    "manufactured": "manufactured",
    "cost-and-error": "cost_and_error",
    "stability-boundaries": "stability_boundaries",
    "slip-event": "slip_event",
    "stability-attacks": "stability_attacks",
    "energy": "energy",
    "unlike-slabs": "unlike_slabs",
    "partial-reflection": "partial_reflection",
    "error-laws": "error_laws",
    "bifurcation": "bifurcation",
    "snaking": "snaking",
    "period-against-delay": "period_against_delay",
    "special-curves": "special_curves",
    "period-doubling": "period_doubling",
    "regime-map": "regime_map",
    "asymmetry-map": "asymmetry_map",
    "bias": "bias",
    "laboratory": "laboratory",
    "claims": "claims",
    "coverage": "coverage",
    "planted-faults": "planted_faults",
    "slow-verification": "slow_verification",
}
"""Name of each study and the module of this package that holds it."""


def study_called(name: str) -> Study:
    """The module of the study called `name`; imported only now, so that listing studies costs nothing."""
    return cast(Study, import_module(f"{__name__}.{STUDIES[name]}"))


def choose(only: list[str] | None) -> list[str]:
    """Names in the report's order; raises SceneError for a name that is not registered."""
    for name in only or ():
        if name not in STUDIES:
            raise SceneError(f"--only {name!r}: no such study; choose from {', '.join(STUDIES)}")
    return [name for name in STUDIES if not only or name in only]

"""The studies of the report, in display order. To add one, add its file to `validation.studies` and its line here."""

from importlib import import_module
from typing import cast

from slipwave.errors import SceneError
from validation.report import Study

STUDIES = {
    "which-model": "which",
    "one-cycle": "which",
    "regime-map": "which",
    "asymmetry": "which",
    "laboratory": "which",
    "cost-and-error": "cost",
    "orders": "exact",
    "energy": "exact",
    "onset": "begin",
    "bifurcation": "begin",
    "snaking": "begin",
    "reflection": "begin",
    "claims": "paper",
    "stability-attacks": "trust",
    "checks": "trust",
}
"""Name of a study, whose module has underscores for hyphens -> the question that it answers (`validation.report.questions`)."""


def study_called(name: str) -> Study:
    """The module of the study called `name`; imported when called, so that listing studies costs nothing."""
    return cast(Study, import_module(f"validation.studies.{name.replace('-', '_')}"))


def choose(only: list[str] | None) -> list[str]:
    """Names in the report's order; raises SceneError for a name that is not registered."""
    for name in only or ():
        if name not in STUDIES:
            raise SceneError(f"--only {name!r}: no such study; choose from {', '.join(STUDIES)}")
    return [name for name in STUDIES if not only or name in only]

"""The studies of the report, in display order. To add one, add its file to `validation.studies` and its line here."""

import traceback
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from slipwave.errors import SceneError
from slipwave.input.assemble import gallery_names
from slipwave.input.wording import shorten
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
    """The module of the study called `name`; imported when called, so that listing studies costs nothing. Raises SceneError if it
    cannot be imported, or does not offer what a study does."""
    try:
        study: Any = import_module(f"validation.studies.{name.replace('-', '_')}")
    except Exception as error:
        raise SceneError(f"study {name!r}: cannot be imported: {placed(error)}") from error
    _require_facts(study, name)
    module: Study = study
    return module


def placed(error: BaseException) -> str:
    """An error in one line, with the place where it was raised; a SyntaxError names its own."""
    where = traceback.extract_tb(error.__traceback__)[-1]
    place = "" if isinstance(error, SyntaxError) else f" ({Path(where.filename).name}, line {where.lineno}, in {where.name})"
    return f"{type(error).__name__}: {error}{place}"


def _require_facts(study: Any, name: str) -> None:
    """Raises SceneError, which names the fact, if the facts of the `study` called `name` are not those of a study."""
    facts: dict[str, tuple[str, Callable[[Any], bool]]] = {
        "NAME": (repr(name), lambda given: given == name),
        "QUESTION": ("a text", lambda given: isinstance(given, str)),
        "SCENES": ("a tuple of names of the gallery", lambda given: isinstance(given, tuple) and {*given} <= {*gallery_names()}),
        "SECONDS": ("(quick, full), two numbers", lambda given: isinstance(given, tuple) and len(given) == 2),
        "run": ("a function", callable),
    }
    for fact, (must, holds) in facts.items():
        given = getattr(study, fact, None)
        if not holds(given):
            raise SceneError(f"study {name!r}: {fact} = {shorten(given)}: must be {must}")


def choose(only: list[str] | None) -> list[str]:
    """Names in the report's order; raises SceneError for a name that is not registered."""
    for name in only or ():
        if name not in STUDIES:
            raise SceneError(f"--only {name!r}: no such study; choose from {', '.join(STUDIES)}")
    return [name for name in STUDIES if not only or name in only]

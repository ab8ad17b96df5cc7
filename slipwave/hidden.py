"""Finds files of the user that hide one of our packages. `slipwave` imports these by name and on demand only."""

import sys
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("validation", "reduced", "fullwave")


def hidden_package() -> str:
    """One line that names the user's file that Python would import instead of one of our packages; empty if there is none."""
    ours = Path(__file__).resolve().parents[1]
    for package in PACKAGES:
        loaded = sys.modules.get(package)
        file = getattr(loaded, "__file__", None) if loaded else getattr(find_spec(package), "origin", None)
        if file and Path(file).resolve() != ours / package / "__init__.py":
            return f"{file} hides slipwave's own package {package!r}: rename that file"
    return ""

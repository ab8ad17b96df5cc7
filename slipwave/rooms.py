"""The packages that stand on this one. They are imported by name and on demand only: no file here depends on them."""

import sys
from importlib.util import find_spec
from pathlib import Path

ROOMS = ("validation", "reduced", "fullwave")


def hidden() -> str:
    """One line that names a file of the user's own that Python finds in place of one of our packages; empty if there is none."""
    ours = Path(__file__).resolve().parents[1]
    for room in ROOMS:
        found = getattr(sys.modules[room], "__file__", None) if room in sys.modules else getattr(find_spec(room), "origin", None)
        if found and Path(found).resolve() != ours / room / "__init__.py":
            return f"{found} hides slipwave's own package {room!r}: rename that file"
    return ""

"""What is simulated: friction laws, slabs, drive, start and observers. Imports no solver and none of the other packages.

It is also the door of the house: `run`, `stability`, `orbit`, `branch`, `curve`, `compare`, `bench`, `scenes`, `models` and
`show` are those of `validation.door`, imported when one of them is first used. `import slipwave` itself stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from slipwave.errors import NumericsError, SceneError
from slipwave.input import read, read_scene

if TYPE_CHECKING:
    from validation.door.bench import bench
    from validation.door.branch import branch
    from validation.door.compare import compare
    from validation.door.curve import curve
    from validation.door.listing import models, scenes, show
    from validation.door.orbit import orbit
    from validation.results.run import run
    from validation.results.stability import stability

    __version__: str

_FILES = dict.fromkeys(("models", "scenes", "show"), "door.listing") | {name: f"results.{name}" for name in ("run", "stability")}
_FILES |= {name: f"door.{name}" for name in ("bench", "branch", "compare", "curve", "orbit")}
"""Where in `validation` each command is declared."""

__all__ = [
    "NumericsError",
    "SceneError",
    "bench",
    "branch",
    "compare",
    "curve",
    "models",
    "orbit",
    "read",
    "read_scene",
    "run",
    "scenes",
    "show",
    "stability",
]


def __getattr__(name: str) -> Any:
    """The function `name` of the door. What it needs is imported here, on its first use."""
    if name == "__version__":
        return import_module("importlib.metadata").version("slipwave")
    if name not in _FILES:
        raise AttributeError(f"module 'slipwave' has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"validation.{_FILES[name]}"), name)
    return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

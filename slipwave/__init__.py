"""What is simulated: friction laws, slabs, drive, start and observers. Imports no solver and none of the other packages.

The commands as functions: `run`, `stability`, `orbit`, `branch`, `curve`, `compare`, `bench`, `fit`, `scenes`, `models` and
`show` are imported when one of them is first used (their types are in `__init__.pyi`). `import slipwave` stays light.
"""

from importlib import import_module
from typing import Any

from slipwave.errors import NumericsError, SceneError

_PLACES = {
    "bench": "commands.bench",
    "branch": "commands.branch",
    "compare": "commands.compare",
    "curve": "commands.curve",
    "fit": "commands.fit",
    "map": "commands.map",
    "models": "commands.listing",
    "orbit": "commands.orbit",
    "run": "commands.run",
    "scenes": "commands.listing",
    "show": "commands.listing",
    "stability": "commands.stability",
    "sweep": "commands.sweep",
    "verify": "verification.command",
}
"""The module of `validation` in which each function is written."""

_OWN = {"Scene": "slipwave.scene", "read": "slipwave.input.assemble", "read_scene": "slipwave.input.assemble"}
"""The modules of what is here, imported when it is used: numba and pydantic take longer than `slipwave --help`."""

__all__ = ["NumericsError", "SceneError", *_OWN, *_PLACES]


def __getattr__(name: str) -> Any:
    """The function `name` of a command; raises ImportError naming the user's file that hides one of our packages."""
    if name == "__version__":
        return import_module("importlib.metadata").version("slipwave")
    if name in _OWN:
        return getattr(import_module(_OWN[name]), name)
    if name not in _PLACES:
        raise AttributeError(f"module 'slipwave' has no attribute {name!r}")
    line = import_module("slipwave.hidden").hidden_package()
    if line:
        raise ImportError(line)
    function = globals()[name] = getattr(import_module(f"validation.{_PLACES[name]}"), name)
    return function


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

"""What is simulated: friction laws, slabs, drive, start and observers. Imports no solver and none of the other packages.

The commands as functions: `run`, `orbit`, `branch`, `curve`, `stability`, `compare`, `bench`, `fit`, `sweep`, `map`, `verify`,
`scenes`, `models` and `show`; and `read`, `read_scene`, `Scene`, `SceneError`, `NumericsError`. Each is imported when it is first
used, so that `import slipwave` stays light: numba and pydantic take longer than `slipwave --help`.
"""

from importlib import import_module

with open(f"{__file__}i", encoding="utf-8") as _stub:  # pathlib takes longer to import than all of this
    _PLACES = {words[-1]: words[1] for words in map(str.split, _stub) if words[:1] == ["from"]}
"""The module in which each name is written, as the stub says it to type checkers: from MODULE import NAME as NAME."""

__all__ = list(_PLACES)


def __getattr__(name: str) -> object:
    """What has this `name`; for a command, raises ImportError naming the user's file that hides one of our packages."""
    if name == "__version__":
        return import_module("importlib.metadata").version("slipwave")
    if name not in _PLACES:
        raise AttributeError(f"module 'slipwave' has no attribute {name!r}")
    if not _PLACES[name].startswith("slipwave."):
        line = import_module("slipwave.hidden").hidden_package()
        if line:
            raise ImportError(line)
    attribute = globals()[name] = getattr(import_module(_PLACES[name]), name)
    return attribute


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

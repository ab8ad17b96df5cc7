"""The tables of a summary: nested dictionaries and lists, as they are in the JSON."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from slipwave.scene import Scene

if TYPE_CHECKING:
    from reduced.orbit.closing import Closed


class Facts(dict[str, Any]):
    """A table of a summary, whose keys are attributes too."""

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(f"no {name!r} here, only {', '.join(self)}")
        return as_facts(self[name])


class PointOfBranch(Facts):
    """A point of a branch: a table of its JSON that is also a source of the `scene` there, for `slipwave.orbit` and others.
    `model` and `tolerance` are those of the branch, `closed` is the orbit of a special point that was computed just now."""

    scene: Scene
    model: str
    closed: "Closed | None"
    tolerance: float

    def __init__(self, facts: Mapping[str, Any], scene: Scene, model: str, closed: "Closed | None", tolerance: float) -> None:
        super().__init__(facts)
        self.scene, self.model, self.closed, self.tolerance = scene, model, closed, tolerance


def as_facts(value: Any) -> Any:
    """A part of a summary with its tables as `Facts`."""
    if isinstance(value, list):
        return [as_facts(item) for item in value]
    return Facts(value) if isinstance(value, dict) and not isinstance(value, Facts) else value


def finite(value: Any) -> Any:
    """`value` with None in place of NaN and infinity, which JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def leaves(facts: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every single value among `facts` with its dotted key."""
    for key, value in facts.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{above}{key}.")
        elif not isinstance(value, list):
            yield f"{above}{key}", value

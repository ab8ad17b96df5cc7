"""`slipwave.curve`: a special point of branches of orbits followed in two parameters."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from slipwave.errors import NumericsError, SceneError
from slipwave.input import SceneSource
from slipwave.scene.doubts import doubts
from validation.branches.curve import Curve, CurvePoint, require_curve, trace
from validation.branches.curve_drawing import figure_of
from validation.branches.parameter import over_range
from validation.door.provenance import SCHEMA, provenance
from validation.door.result import Dataset, Result, announced, deliver, finite, scene_of, table_of
from validation.registry.flows import flowing
from validation.registry.orbits import require_tolerance
from validation.run.progress import progress
from validation.study.drawing import Drawing, styled


@dataclass(frozen=True, repr=False, eq=False)
class CurveResult(Result):
    """The curve that was `found`, the options of the call, and run time in seconds; `failed` says why it ended early, or is
    empty."""

    found: Curve
    options: Mapping[str, Any]
    wall_s: float
    failed: str = ""

    @property
    def summary(self) -> dict[str, Any]:
        """The JSON of `slipwave curve`; `failed` is there only if the numerics failed or the user stopped it."""
        found = self.found
        result = {
            "schema": SCHEMA,
            "scene": found.over.base.name,
            "model": found.model,
            "clock": "transit",
            "type": found.kind,
            "parameters": [found.over.name, found.second.name],
            "points": [_at(found, point) for point in found.points],
            "wall_s": self.wall_s,
            "notes": [*doubts(found.over.base), *found.notes],
        }
        return dict(finite(result | ({"failed": self.failed} if self.failed else {})))

    @cached_property
    def dataset(self) -> Dataset:
        """The points by `point`."""
        rows = [_at(self.found, point) for point in self.found.points]
        rows = [row | dict(zip(("multiplier_re", "multiplier_im"), row.pop("multiplier"), strict=True)) for row in rows]
        facts = provenance("curve", self.found.over.base, self.found.model, self.options)
        return table_of(rows, "point").assign_attrs(facts)

    def plot(self) -> Drawing:
        """The plane of both parameters, and the period."""
        with styled():
            return figure_of(self.found)


def curve(
    source: SceneSource,
    of: str,
    over: str,
    along: str,
    model: str = "auto",
    *,
    tol: float = 1e-6,
    most_points: int = 100,
    settings: Iterable[str] = (),
    **changes: Any,
) -> CurveResult:
    """Follow the first special point of the kind `of` (HB, LP, PD, NS) on the branch of orbits in two parameters; `changes` are
    those of `slipwave.read_scene`.

    `over` is the branch's parameter with its range, as "log10_r=-2.72:-2.30"; `along` the second one, as "V=100:200": the curve
    begins on the branch at its first value and is followed in this direction until it leaves one of the ranges, or for
    `most_points`. It may turn back in both parameters. `tol` is the requested relative error of the figures.

    Raises SceneError for wrong input; NumericsError where there is no such point or the curve cannot be followed, with the part
    before as its `result`.
    """
    require_tolerance(tol)
    if most_points < 1:
        raise SceneError(f"--most-points = {most_points}: must be at least 1")
    scene = scene_of(source, settings, changes)
    parameters = over_range(over, scene), over_range(along, scene, "--and")
    require_curve(of, *parameters)
    name = announced(*flowing(model, scene))
    options = {"of": of, "over": over, "and": along, "tol": tol, "most_points": most_points}
    found, failed, stopped, began = Curve(of, *parameters, name, tol), "", False, time.perf_counter()
    try:
        with progress(f"{scene.name}, {name}, points of the curve", most_points) as report:
            for count in trace(found, most_points):
                report(count)
    except NumericsError as error:
        failed = str(error)
    except KeyboardInterrupt:
        failed, stopped = f"interrupted after {len(found.points)} points", True
    return deliver(CurveResult(found, options, time.perf_counter() - began, failed), failed, stopped)


def _at(found: Curve, point: CurvePoint) -> dict[str, Any]:
    """A point with the values of both parameters under their own names."""
    facts = point._asdict()
    return {found.over.name: facts.pop("first"), found.second.name: facts.pop("second")} | facts

"""The stored fits over the points of the atlas, and the rule derived from them."""

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from slipwave.extras import require
from slipwave.observe.pieces import Array
from validation.fit.synthetic import stepped_scene
from validation.studies.bias.measured import MACHINES, MODELS, RECORD, STEPPED, SWINGS, AtlasPoint, atlas_points

if TYPE_CHECKING:
    from xarray import Dataset
else:
    Dataset = Any

ALLOWED = 0.01
_CLOSE = ("a", "b", "L")  # what the rule holds for


@dataclass(frozen=True)
class Atlas:
    """The fits of the record `data`."""

    data: Dataset

    @classmethod
    def read(cls) -> "Atlas":
        """Read the atlas of the checkout."""
        require("files", "the record of fits")
        import xarray

        return cls(xarray.load_dataset(RECORD))

    @cached_property
    def points(self) -> list[AtlasPoint]:
        """The points in the order of the record."""
        return atlas_points()

    @cached_property
    def _manifest(self) -> dict[str, Any]:
        return dict(json.loads(self.data.attrs["manifest"]))

    @property
    def digest(self) -> str:
        """Sixteen hex digits that name the scenes and models."""
        return _digest(self._manifest["scene_digest"], self._manifest["rows"])

    @property
    def is_own(self) -> bool:
        """Whether the record is of the scenes and models of this program."""
        rows = [dict(point.changes) for point in self.points]
        return self.digest == _digest(stepped_scene(1.0, 1.0).digest, json.loads(json.dumps(rows)))

    @property
    def fits(self) -> int:
        """Number of fits."""
        return sum(int(np.isfinite(self.data[f"{model} error L"]).sum()) for model in MODELS)

    def row(self, number: int) -> dict[str, float]:
        """The figures of one point."""
        return {str(name): float(values[number]) for name, values in self.data.items() if values.dtype.kind == "f"}

    def of(self, model: str, kind: str, quantity: str, steps: bool = True) -> Array:
        """Relative errors, or half widths of intervals, (machines, swings, kappas) of velocity steps or of stick-slip."""
        count = len(MACHINES) * SWINGS.size * len(STEPPED)
        values = self.data[f"{model} {kind} {quantity}"].values
        part = values[:count] if steps else values[count:]
        return np.asarray(part.reshape(len(MACHINES), SWINGS.size if steps else -1, len(STEPPED) if steps else 2))

    def worst(self, model: str, steps: bool = True) -> Array:
        """The largest error of a, b and L (machines, swings, kappas); infinite where there was no minimum."""
        errors = np.abs([self.of(model, "error", quantity, steps) for quantity in _CLOSE])
        return np.asarray(np.where(np.isfinite(errors), errors, np.inf).max(axis=0))

    def excluded(self, model: str, steps: bool = True) -> Any:
        """Whether the interval of a, b or L excludes the truth."""
        outside = [np.abs(self.of(model, "error", q, steps)) > self.of(model, "half", q, steps) for q in _CLOSE]
        return np.asarray(np.any(outside, axis=0))

    def limits(self, model: str) -> Array:
        """Largest swing up to which no error exceeds the limit (machines, kappas), interpolated in logarithms."""
        worst, logs = np.log(np.clip(self.worst(model) / ALLOWED, 1e-9, 1e9)), np.log(SWINGS)
        found = np.full((worst.shape[0], worst.shape[2]), SWINGS[-1])
        for machine, kappa in np.ndindex(found.shape):
            line = worst[machine, :, kappa]
            beyond = np.flatnonzero(line >= 0.0)
            if beyond.size:
                k = int(beyond[0])
                share = line[k - 1] / (line[k - 1] - line[k]) if k else 0.0
                found[machine, kappa] = np.exp(logs[k - 1] + share * (logs[k] - logs[k - 1])) if k else SWINGS[0]
        return found

    def rule(self, model: str) -> float:
        """Largest swing up to which no error of a velocity step exceeds the limit, for every kappa and machine."""
        return float(self.limits(model).min())

    def slip_error(self, model: str, quantity: str) -> float:
        """Median modulus of the error of `quantity` in fits to stick-slip."""
        return float(np.nanmedian(np.abs(self.of(model, "error", quantity, False))))

    @property
    def middle(self) -> int:
        """Number of a velocity step in the middle of the atlas."""
        return self.points.index(AtlasPoint(float(SWINGS[SWINGS.size // 2]), STEPPED[2], MACHINES[1]))


def _digest(scene: str, rows: Any) -> str:
    return hashlib.sha256(json.dumps([scene, rows, MODELS], sort_keys=True).encode()).hexdigest()[:16]

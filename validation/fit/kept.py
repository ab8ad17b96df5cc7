"""Checkpoint of a fit: a file of its best values, written whole, from which a killed fit continues."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slipwave.errors import SceneError
from slipwave.files import content_of, require_writable, whole_or_absent
from slipwave.input.wording import shorten
from slipwave.observe.pieces import Array
from validation.fit.least_squares import Best

_SHOWN = 3


@dataclass
class KeptBest(Best):
    """The best values so far, also written to the file `path`, if given, with the `facts` of their fit."""

    path: Path | None = None
    facts: Mapping[str, Any] | None = None

    def see(self, inner: Array, residual: Array) -> None:
        """As `Best`; better values are written."""
        before = self.cost
        super().see(inner, residual)
        if self.path is not None and self.cost < before:
            known = {"facts": self.facts, "best": [*self.inner], "cost": self.cost, "evaluations": self.evaluations}
            with whole_or_absent(self.path) as temporary:
                temporary.write_text(json.dumps(known, indent=1), encoding="utf-8")


def facts_of_fit(scene_digest: str, files: Sequence[str], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Facts that must agree for a fit to continue: the scene, every file's contents, and the settings."""
    contents = {f"contents of {name}": hashlib.sha256(content_of(Path(name), repr(name))).hexdigest()[:12] for name in files}
    return {"scene": scene_digest, **contents, **{name: shorten(value) for name, value in settings.items() if name != "data"}}


def recalled_best(path: Path | None, first: Array, facts: Mapping[str, Any]) -> KeptBest:
    """The best values in the file, `first` if there is none. Raises SceneError for a file that cannot be written, is damaged, or
    belongs to another fit, naming the differences."""
    if path is not None:
        require_writable(path, (".json",), "--checkpoint")
    if path is None or not path.exists():
        return KeptBest(first, path=path, facts=facts)
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        there, inner, evaluations = dict(known["facts"]), np.array(known["best"], dtype=float), int(known["evaluations"])
    except (OSError, ValueError, LookupError, TypeError):
        raise SceneError(f"--checkpoint = {str(path)!r}: is no checkpoint of a fit; remove it, or name another") from None
    other = [key for key in {**there, **facts} if there.get(key) != facts.get(key)]
    if other or inner.shape != first.shape:
        differences = "; ".join(
            f"{key}: {there.get(key, 'not there')}, now {facts.get(key, 'not there')}" for key in other[:_SHOWN]
        )
        raise SceneError(f"--checkpoint = {str(path)!r}: belongs to another fit ({differences}); remove it, or name another")
    return KeptBest(inner, evaluations=evaluations, path=path, facts=facts)

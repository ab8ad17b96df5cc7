"""Kinds of stated errors, measured on random scenes of known truth, and the record of these measurements."""

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias
from zlib import crc32

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.files import whole_or_absent
from slipwave.sources import ROOT, source_digest
from tests.verification.stated_errors.held import Coverage, Held, coverage_of
from tests.verification.stated_errors.measured import WITNESS as KNOWING
from tests.verification.stated_errors.measured import (
    any_orbit,
    chosen_grid,
    default_grid,
    exponents,
    irregular_means,
    limits_of_grids,
    steps,
)
from validation.models.settle import NoCycle
from validation.report import SELF, WITNESS, Evidence

RECORD = ROOT / "reports" / "baseline" / "coverage-computations.json"
SUMMARY = RECORD.with_name("coverage-record.json")
_AT_ONCE = 10  # computations between two writings
# how closely a computation is repeated: share of what is compared, share of the bar, and what is left of rounding
_NEAR, _LITTLE, _ROUNDING = 0.05, 1e-3, 3e-12

Record: TypeAlias = dict[str, list[list[Held]]]
"""Kind -> its computations, in order."""


class Kind(NamedTuple):
    """A kind of stated error: whose `bar`, the `truth` it is compared with, the kind of `evidence`, the function that `measure`s
    it, and the number of computations `recorded`."""

    bar: str
    truth: str
    evidence: Evidence
    measure: Callable[[np.random.Generator], list[Held]]
    recorded: int


_KNOWN = f"delay system; with viscosity `{KNOWING}`"
KINDS = {
    "orbits": Kind("`slipwave orbit`: error of each figure", "a mesh three times finer", SELF, any_orbit, 110),
    "tolerances": Kind("`--tol` of models without a grid", "the orbit, by Newton’s method", SELF, steps, 250),
    "chosen grids": Kind("`--tol` of full waves: estimated error", _KNOWN, WITNESS, chosen_grid, 135),
    "default grids": Kind("default grids of full waves: estimated error", _KNOWN, WITNESS, default_grid, 110),
    "extrapolation": Kind("Richardson’s limit of three grids", "delay system", WITNESS, limits_of_grids, 104),
    "means": Kind("means of motions that never repeat: margin", "1000 cycles more", SELF, irregular_means, 165),
    "exponents": Kind("largest Lyapunov exponents: margin", "600 intervals more", SELF, exponents, 175),
}
"""Kinds by name."""

LEFT_OUT = {("chosen grids", 50)}
"""Computations left out: this one had not ended after 90 s of processor time, on hundreds of cells; its result is unknown."""


def computation(kind: str, number: int) -> list[Held]:
    """Computation `number` of a kind, the same whenever it is repeated; empty without a stated error, or if LEFT_OUT."""
    if (kind, number) in LEFT_OUT:
        return []
    try:
        return KINDS[kind].measure(np.random.default_rng([crc32(kind.encode()), number]))
    except (NumericsError, SceneError, NoCycle):
        return []


def known_computations(path: Path = RECORD) -> Record:
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return {kind: [_read(each, *stored[kind]["figures"]) for each in stored[kind]["computations"]] if kind in stored else []
            for kind in KINDS}  # fmt: skip


def _read(numbers: list[float], *figures: str) -> list[Held]:
    """A computation of the file, which has bar and error of each figure, or nothing."""
    return [Held(*held) for held in zip(figures, numbers[::2], numbers[1::2], strict=False)]


def store_computations(record: Record, path: Path = RECORD) -> None:
    kinds = []
    for kind, found in record.items():
        figures = json.dumps(next(([held.figure for held in one] for one in found if one), []))
        lines = ",\n".join(json.dumps([float(f"{value:.4g}") for held in one for value in held[1:]]) for one in found)
        kinds.append(f'"{kind}": {{"figures": {figures}, "computations": [\n{lines}\n]}}')
    with whole_or_absent(path) as part:
        part.write_text("{\n" + ",\n".join(kinds) + "\n}\n", encoding="utf-8")


def make_record(kinds: Iterable[str], path: Path = RECORD) -> None:
    """Compute the missing computations of some kinds, and store them in batches."""
    record = known_computations(path)
    for kind in kinds:
        found, wanted = record[kind], KINDS[kind].recorded
        while len(found) < wanted:
            found.append(computation(kind, len(found)))
            if len(found) % _AT_ONCE == 0 or len(found) == wanted:
                store_computations(record, path)
                print(f"{kind}: {len(found)} of {wanted}", file=sys.stderr, flush=True)


def summary(record: Record) -> dict[str, Any]:
    """What the report shows of a record: for each kind and figure how many stated errors there are, how many hold the truth, and
    the median of stated over true error."""

    def told(one: Coverage) -> dict[str, Any]:
        return {"number": one.many, "held": round(one.share * one.many), "width": float(f"{one.width:.3g}")}

    return {
        kind: {"bar": one.bar, "truth": one.truth, "evidence": one.evidence.value}
        | {"figures": {found.figure: told(found) for found in coverage_of(record[kind])}}
        for kind, one in KINDS.items()
    }


def chosen(record: Record, kind: str) -> int:
    """Number of a computation to be repeated, which depends on the text of the solvers."""
    able = [number for number, held in enumerate(record[kind]) if held]
    return int(np.random.default_rng(int(source_digest(), 16)).choice(able))


def agree(ours: list[Held], known: list[Held]) -> bool:
    """Whether a repeated computation agrees with the recorded one in each bar and each error."""
    return [one.figure for one in ours] == [one.figure for one in known] and all(map(_near, ours, known))


def _near(one: Held, other: Held) -> bool:
    bar, error = max(one.bar, other.bar), max(one.error, other.error)
    same = abs(one.bar - other.bar) < _NEAR * bar + _ROUNDING
    return same and abs(one.error - other.error) < _NEAR * error + _LITTLE * bar + _ROUNDING

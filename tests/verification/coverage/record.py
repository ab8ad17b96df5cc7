"""Kinds of stated errors, measured on random scenes of known truth, and the record of these measurements."""

import ast
import hashlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias
from zlib import crc32

import numpy as np

from slipwave.errors import NumericsError, SceneError
from slipwave.files import whole_or_absent
from slipwave.sources import ROOT, source_digest
from tests.verification.coverage import scenes
from tests.verification.coverage.held import Held, coverage_of
from tests.verification.coverage.irregular import exponents, irregular_means
from tests.verification.coverage.repeating import WITNESS as KNOWING
from tests.verification.coverage.repeating import any_orbit, chosen_grid, default_grid, limits_of_grids, steps
from validation.compute.settle import NoCycle
from validation.study import SELF, WITNESS, Evidence

RECORD = ROOT / "reports" / "baseline" / "coverage-computations.json"
SUMMARY = RECORD.with_name("coverage-record.json")
_AT_ONCE = 10  # computations between two writings
# how closely a computation is repeated: share of what is compared, share of the bar, and what is left of rounding
_NEAR, _LITTLE, _ROUNDING = 0.05, 1e-3, 3e-12
_ALIKE = 3.0  # ratio of two bars over one irregular motion, and of an error to them
_REPEATED = 10  # computations by which what an earlier definition found is confirmed

Record: TypeAlias = dict[str, list[list[Held]]]
"""Kind -> its computations, in order."""


class Kind(NamedTuple):
    """A kind of stated error: whose `bar`, the `truth` it is compared with, the kind of `evidence`, the function that `measure`s
    it, the number of computations `recorded`. `exact`: whether they repeat exactly on another machine, as irregular motions do
    not."""

    bar: str
    truth: str
    evidence: Evidence
    measure: Callable[[np.random.Generator], list[Held]]
    recorded: int
    exact: bool = True


_KNOWN = f"delay system; with viscosity `{KNOWING}`"
KINDS = {
    "orbits": Kind("`slipwave orbit`: error of each figure", "a mesh three times finer", SELF, any_orbit, 110),
    "tolerances": Kind("`--tol` of models without a grid", "the orbit, by Newton’s method", SELF, steps, 250),
    "chosen grids": Kind("`--tol` of full waves: estimated error", _KNOWN, WITNESS, chosen_grid, 135),
    "default grids": Kind("default grids of full waves: estimated error", _KNOWN, WITNESS, default_grid, 110),
    "extrapolation": Kind("Richardson’s limit of three grids", "delay system", WITNESS, limits_of_grids, 104),
    "means": Kind("means of motions that never repeat: margin", "1000 cycles more", SELF, irregular_means, 165, False),
    "exponents": Kind("largest Lyapunov exponents: margin", "600 intervals more", SELF, exponents, 175, False),
}
"""Kinds by name."""

LEFT_OUT = {("chosen grids", 50)}
"""Computations left out: this one had not ended after 90 s of processor time, on hundreds of cells; its result is unknown."""


def computation(kind: str, number: int) -> list[Held]:
    """Computation `number` of a kind, the same whenever it is repeated. Empty if there is no stated error (no orbit, another kind
    of motion), and if it is LEFT_OUT."""
    if (kind, number) in LEFT_OUT:
        return []
    try:
        return KINDS[kind].measure(np.random.default_rng([crc32(kind.encode()), number]))
    except (NumericsError, SceneError, NoCycle):
        return []


def definition(kind: str) -> str:
    """Digest of the definition of a kind: the program text of the random scenes and of the file that measures it, without
    imports. A record with another digest is not valid."""
    measured = ROOT.joinpath(*KINDS[kind].measure.__module__.split(".")).with_suffix(".py")
    said = [statement for path in (Path(scenes.__file__), measured) for statement in statements(path)]
    return hashlib.sha256("\n".join(said).encode()).hexdigest()[:16]


def statements(path: Path) -> Iterator[str]:
    """The statements of a file, as text, without imports, docstrings and comments."""
    for node in ast.parse(path.read_bytes()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and ast.get_docstring(node):
            node.body = node.body[1:]
        if not isinstance(node, ast.Import | ast.ImportFrom | ast.Expr):
            yield ast.dump(node)


def known_computations(path: Path = RECORD) -> Record:
    """The computations recorded with the present definitions, of every kind."""
    return {kind: found if known == definition(kind) else [] for kind, (known, found) in _stored(path).items()}


def _stored(path: Path) -> dict[str, tuple[str, list[list[Held]]]]:
    """Definition and computations of every kind."""
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    kinds = {kind: stored.get(kind, {"definition": "", "computations": []}) for kind in KINDS}
    return {
        kind: (one["definition"], [[Held(*held) for held in each] for each in one["computations"]]) for kind, one in kinds.items()
    }


def _confirmed(kind: str, path: Path) -> list[list[Held]]:
    """The stored computations of a kind, if they have its present definition, or if some of them, repeated with the new
    definition, agree in every digit: then only the wording of the program changed."""
    known, found = _stored(path)[kind]
    repeated = 0 if known == definition(kind) else min(_REPEATED, len(found))
    drawn = np.random.default_rng(int(definition(kind), 16)).choice(len(found), repeated, replace=False).tolist()
    return found if all(_line(computation(kind, number)) == _line(found[number]) for number in drawn) else []


def store_computations(kind: str, found: list[list[Held]], path: Path = RECORD) -> None:
    """Write a line for each computation of this kind; other kinds are unchanged."""
    every = _stored(path) | {kind: (definition(kind), found)}
    lines = {kind: (known, ",\n".join(map(_line, found))) for kind, (known, found) in every.items()}
    kinds = [f'"{kind}": {{"definition": "{known}", "computations": [\n{text}\n]}}' for kind, (known, text) in lines.items()]
    with whole_or_absent(path) as part:
        part.write_text("{\n" + ",\n".join(kinds) + "\n}\n", encoding="utf-8")


def _line(computed: list[Held]) -> str:
    return json.dumps([[held.figure, float(f"{held.bar:.4g}"), float(f"{held.error:.4g}")] for held in computed])


def make_record(kinds: Iterable[str], path: Path = RECORD) -> None:
    """Compute the missing computations of some kinds, and store them in batches."""
    for kind in kinds:
        found, wanted = _confirmed(kind, path), KINDS[kind].recorded
        while len(found) < wanted:
            found.append(computation(kind, len(found)))
            if len(found) % _AT_ONCE == 0:
                store_computations(kind, found, path)
                print(f"{kind}: {len(found)} of {wanted}", file=sys.stderr, flush=True)
        store_computations(kind, found, path)


def summary(record: Record) -> dict[str, Any]:
    """What the report shows of a record: for each kind and figure how many stated errors there are, how many hold the truth, and
    the median of stated over true error."""
    return {
        kind: {
            "bar": one.bar,
            "truth": one.truth,
            "evidence": one.evidence.value,
            "figures": {
                found.figure: {
                    "number": found.many,
                    "held": round(found.share * found.many),
                    "width": float(f"{found.width:.3g}"),
                }
                for found in coverage_of(record[kind])
            },
        }
        for kind, one in KINDS.items()
    }


def chosen(record: Record, kind: str) -> int:
    """Number of a computation to be repeated, which depends on the text of the solvers."""
    able = [number for number, held in enumerate(record[kind]) if held]
    return int(np.random.default_rng(int(source_digest(), 16)).choice(able))


def agree(kind: str, ours: list[Held], known: list[Held]) -> bool:
    """Whether a repeated computation agrees with the recorded one in each bar and each error; for a motion that never repeats,
    which rounding changes between machines, in their sizes."""
    near = _near if KINDS[kind].exact else _alike
    return [one.figure for one in ours] == [one.figure for one in known] and all(map(near, ours, known))


def _near(one: Held, other: Held) -> bool:
    bar, error = max(one.bar, other.bar), max(one.error, other.error)
    same = abs(one.bar - other.bar) < _NEAR * bar + _ROUNDING
    return same and abs(one.error - other.error) < _NEAR * error + _LITTLE * bar + _ROUNDING


def _alike(one: Held, other: Held) -> bool:
    bar = max(one.bar, other.bar)
    return bar < _ALIKE * min(one.bar, other.bar) and max(one.error, other.error) < _ALIKE * bar

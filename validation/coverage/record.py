"""The record of how often stated errors hold the truth (`validation.coverage.kinds`)."""

import ast
import hashlib
import json
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypeAlias

from slipwave.files import whole_or_absent
from slipwave.sources import ROOT
from validation.coverage import scenes
from validation.coverage.held import Held
from validation.coverage.kinds import KINDS, computation

RECORD = ROOT / "reports" / "baseline" / "coverage-record.json"
_AT_ONCE = 10  # computations between two writings

Record: TypeAlias = dict[str, list[list[Held]]]
"""By kind: its computations, in order."""


def definition(kind: str) -> str:
    """Digest of what is computed: the program text of the random scenes and of the file that measures this kind, but for their
    imports, so that a thing that moves elsewhere changes nothing. Another record is of something else."""
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
    """What was recorded by the present definitions, of every kind."""
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    found = {kind: stored[kind]["computations"] for kind in KINDS if stored.get(kind, {}).get("definition") == definition(kind)}
    return {kind: [[Held(*held) for held in one] for one in found.get(kind, [])] for kind in KINDS}


def store_computations(record: Record, path: Path = RECORD) -> None:
    """A line for each computation."""
    lines = {kind: ",\n".join(map(_line, found)) for kind, found in record.items()}
    kinds = [f'"{kind}": {{"definition": "{definition(kind)}", "computations": [\n{text}\n]}}' for kind, text in lines.items()]
    with whole_or_absent(path) as part:
        part.write_text("{\n" + ",\n".join(kinds) + "\n}\n", encoding="utf-8")


def _line(computed: list[Held]) -> str:
    return json.dumps([[held.figure, float(f"{held.bar:.4g}"), float(f"{held.error:.4g}")] for held in computed])


def make_record(kinds: Iterable[str], path: Path = RECORD) -> None:
    """Compute what the record lacks of some kinds, and store it time and again."""
    for kind in kinds:
        known, wanted = known_computations(path)[kind], KINDS[kind].recorded
        while len(known) < wanted:
            known.append(computation(kind, len(known)))
            if len(known) % _AT_ONCE == 0 or len(known) == wanted:
                store_computations(known_computations(path) | {kind: known}, path)
                print(f"{kind}: {len(known)} of {wanted}", file=sys.stderr, flush=True)

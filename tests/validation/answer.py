"""The answer in README.md and docs/index.md, written from the table of models of a report.

python -m tests.validation.answer reports        # takes the table of reports/ and rewrites the blocks between the markers
"""

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from pydantic import TypeAdapter

from slipwave.files import whole_or_absent
from slipwave.sources import ROOT
from validation.report.model_table import ModelCell, ModelTable
from validation.report.text import markup

TABLE = ROOT / "reports" / "baseline" / "models" / "which-model.json"
PAGES = (ROOT / "README.md", ROOT / "docs" / "index.md")
_STUDY = "which-model"
_BEGIN, _END = "<!-- answer: begin (python -m tests.validation.answer) -->", "<!-- answer: end -->"
_TIME = re.compile(r"~\{([^{}]*)\}")


def read_table(path: Path = TABLE) -> ModelTable:
    """Read a stored table of models."""
    return TypeAdapter(ModelTable).validate_json(path.read_bytes())


def block_of(table: ModelTable) -> str:
    """The block with its markers: the sentences, the table of errors of T, and what its cells mean."""
    lines = [_BEGIN, *(_html(sentence) for sentence in table.sentences), "", *_rows(table), "", _KEY, _END]
    return "\n".join(lines)


_KEY = (
    "Relative errors of the period T against the exact delay system (its own row: T in transits) for the paper's slabs; where "
    "its orbit is unstable, of means over cycles, with two standard errors; a regime that is not that of the waves is named. "
    "Cost: processor time over that of the delay system. Up to 1 % is good; the report has the rule, the stress drop, "
    "the largest slip rate, the onsets, and the same for other scenes."
)


def _rows(table: ModelTable) -> Iterator[str]:
    headings = [_html(f"{table.parameter} = {table.columns[0].title}"), *(column.title for column in table.columns[1:])]
    yield f"| model | {' | '.join(headings)} | {' | '.join(f'cost at {title}' for title in table.costed)} | |"
    yield "|---" * (len(headings) + len(table.costed) + 2) + "|"
    for row in table.rows:
        costs = ("–" if cost is None else f"{cost:.2g}" for cost in row.costs)
        advice = _html(f"{row.advice}: {row.why}" if row.why else row.advice)
        yield f"| `{row.model}` | {' | '.join(map(_shown, row.cells))} | {' | '.join(costs)} | {advice} |"


def _shown(cell: ModelCell) -> str:
    words = cell.words("T")
    return _html(words if cell.right or words == cell.regime else f"{words} ({cell.regime})")


def _html(words: str) -> str:
    """Convert the small markup to HTML, for Markdown; run times unchanged."""
    return markup(_TIME.sub(r"\1", words))


def with_block(page: str, block: str) -> str:
    """The page with this block between its markers. Raises ValueError if it has none."""
    before, begin, rest = page.partition(_BEGIN)
    _, end, after = rest.partition(_END)
    if not begin or not end:
        raise ValueError(f"no markers {_BEGIN} and {_END}")
    return before + block + after


def _take_answer(out: Path) -> None:
    """Copy the table of the report in `out` to the baseline, and rewrite the pages."""
    record = json.loads((out / "data" / _STUDY / "result.json").read_bytes())
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    texts = {TABLE: json.dumps(record["result"]["model_tables"][0], indent=1, ensure_ascii=False) + "\n"}
    block = block_of(TypeAdapter(ModelTable).validate_python(record["result"]["model_tables"][0]))
    texts |= {page: with_block(page.read_text(encoding="utf-8"), block) for page in PAGES}
    for path, text in texts.items():
        with whole_or_absent(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    _take_answer(Path(sys.argv[1]))

"""The answer in README.md and docs/index.md is that of the committed table, whose numbers are those of the baseline."""

import json

import pytest

from slipwave.sources import ROOT
from validation.report.answer import PAGES, block_of, read_table, with_block
from validation.studies.which_model.measured import MODELS, SHOWN

BASELINE = json.loads((ROOT / "reports" / "baseline" / "which-model.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_the_committed_block_is_that_of_the_committed_table(page):
    text = page.read_text(encoding="utf-8")
    assert with_block(text, block_of(read_table())) == text
    with pytest.raises(ValueError, match="no markers"):
        with_block("# A page", "block")


@pytest.mark.parametrize("model", MODELS)
def test_the_committed_table_has_the_numbers_of_the_baseline(model):
    table = read_table()
    cells = {column.log10_r: cell for column, cell in zip(table.columns, table.row(model).cells, strict=True)}
    for log10_r in SHOWN:
        (found,) = (cell for place, cell in cells.items() if abs(place - log10_r) < 1e-9)
        for symbol, name in (("T", "T"), ("Δμ", "drop")):
            assert found.figures[symbol].error == pytest.approx(
                BASELINE[f"{model} error of {name} at {log10_r}"]["value"], rel=1e-2
            )


def test_the_block_names_a_regime_that_is_not_that_of_the_waves():
    rows = [line.split(" | ") for line in block_of(read_table()).splitlines() if line.startswith("| `")]
    of = {row[0].strip("| `"): row[1:] for row in rows}
    assert of["quasidynamic"][0] == "slides steadily"
    assert of["block8"][3].endswith("% (periodic)")
    assert of["delay"][1] == "73.472"
    assert "<sup>" in of["modal:8"][0]

"""What a cell of the first screen's table says, and that the table survives storage."""

import math

import pytest

from validation.report import store
from validation.studies import study_called
from validation.study import StudyResult
from validation.study.model_table import (
    Compared,
    ModelCell,
    ModelColumn,
    ModelQuantity,
    ModelRow,
    ModelTable,
    cell_records,
    shade_of,
    words_of,
)


def cell(value, error, standard_error=1e-9, right=True):
    return ModelCell("periodic", right, 0, {"T": Compared(value, error, standard_error)})


@pytest.mark.parametrize(
    ("shown", "words", "shade"),
    [
        (cell(73.47214, None), "73.472", ""),
        (cell(70.0, -0.0373), "−3.7 %", "amber"),
        (cell(73.5, 9.99e-4), "+1 · 10^{−3}", "none"),
        (cell(73.5, -3.93e-7), "−4 · 10^{−7}", "none"),
        (cell(94.0, -0.0011, 0.0035), "−0.1 ± 0.7 %", "pale"),
        (cell(60.0, -0.45, right=False), "−45.0 %", "wrong"),
        (cell(90.0, 0.1), "+10.0 %", "red"),
        (ModelCell("runs away", False), "runs away", "wrong"),
    ],
)
def test_what_a_cell_says(shown, words, shade):
    assert (words_of(shown, "T"), shade_of(shown, "T")) == (words, shade)


def a_table():
    cells = (cell(73.0, None), ModelCell("torus", True, 99, {"T": Compared(94.0, None, 0.003)}))
    other = (cell(math.inf, 0.1), ModelCell("runs away", False))
    columns = (ModelColumn("−2.68", -2.68, 1.05, "periodic"), ModelColumn("−2.5", -2.5, 1.6, "torus, irregular"))
    onset = Compared(-2.7, None, 1e-12)
    rows = (ModelRow("delay", cells, onset, (1.0,), "use", "exact"), ModelRow("block", other, None, (0.3,), "avoid", "wrong"))
    quantities = (ModelQuantity("T", "period", "transits"),)
    return ModelTable("paper", "caption", "log_{10} r", quantities, columns, ("−2.68",), "delay", rows, ("Use it.",))


def test_a_table_is_stored_and_read_back(tmp_path):
    result = StudyResult("yes", model_tables=(a_table(),))
    study = study_called("scene-facts")
    store.store_result(tmp_path, study, "key", result, 1.0)
    assert store.stored_result(tmp_path, study, "key").result.model_tables == (a_table(),)


def test_a_table_as_lines_of_a_file():
    lines = list(cell_records(a_table()))
    assert [(line["model"], line["log10_r"], line["value"], line["cost"]) for line in lines] == [
        ("delay", -2.68, 73.0, 1.0), ("delay", -2.5, 94.0, None), ("block", -2.68, math.inf, 0.3), ("block", -2.5, None, None),
    ]  # fmt: skip
    assert lines[-1]["regime"] == "runs away"

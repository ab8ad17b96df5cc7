"""Fixtures of the report's tests."""

import pytest
from fake_studies import Fake
from records import FOLDER, assert_as_recorded
from shown import shown


@pytest.fixture
def fake(monkeypatch, tmp_path):
    """Synthetic studies instead of the report's, run in this process unless a test asks for several."""
    monkeypatch.setattr("validation.report.build.cores", lambda: 1)
    return Fake(monkeypatch, tmp_path)


@pytest.fixture
def as_recorded(request):
    """Hold all that a study shows against the record; `--record-shown` writes the record first."""

    def check(name, result):
        lines = shown(name, result)
        if request.config.getoption("record_shown"):
            (FOLDER / f"{name}.txt").write_text("\n".join([*lines, ""]), encoding="utf-8")
        assert_as_recorded(name, lines)

    return check

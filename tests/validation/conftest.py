"""Fixtures of the report's tests."""

import pytest
from fake_studies import Fake


@pytest.fixture
def fake(monkeypatch, tmp_path):
    """Synthetic studies instead of the report's, run in this process unless a test asks for several."""
    monkeypatch.setattr("validation.report.build.cores", lambda: 1)
    return Fake(monkeypatch, tmp_path)

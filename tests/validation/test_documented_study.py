"""The example of docs/reading-the-report.md runs as printed, and its page is written."""

import re
import sys
import types
from pathlib import Path

from validation import studies
from validation.report import make_report
from validation.study import Budget, Outcome

PAGE = Path(__file__).parents[2] / "docs" / "reading-the-report.md"


def test_documented_study_runs(monkeypatch, tmp_path):
    source = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL).group(1)
    path = tmp_path / "drive.py"
    path.write_text(source)
    module = types.ModuleType("validation.studies.drive")
    module.__file__ = str(path)
    exec(compile(source, str(path), "exec"), module.__dict__)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(studies, "STUDIES", {"drive": "drive"})
    html = make_report(tmp_path / "out").read_text()
    assert "Does the stress drop depend on the drive?" in html
    assert module.run(Budget()).verdicts[0].outcome is Outcome.PASS

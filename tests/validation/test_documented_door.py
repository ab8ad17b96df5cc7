"""The pages on Python and on files: their code is executed word by word."""

import re
import shlex
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from validation.cli import main

DOCS = Path(__file__).resolve().parents[2] / "docs"


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", (DOCS / page).read_text(), re.M | re.S)


def test_the_page_on_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks("python.md", "python"):
        exec(block, names)
    period, verdict = capsys.readouterr().out.split()[:2]
    assert (float(period), verdict) == (pytest.approx(4.2205, abs=2e-4), "periodic")
    assert {path.name for path in tmp_path.iterdir()} == {"run.png", "run.nc"}


def test_the_page_on_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    for line in "".join(blocks("output-files.md", "sh")).splitlines():
        words, _, place = line.partition(" > ")
        with redirect_stdout(Path(place or "printed").open("w")):
            assert main(shlex.split(words)[1:]) == 0, line
    assert main(["run", "again.toml", "--model", "block8"]) == 0
    again = capsys.readouterr().out
    assert "model block8, 200 transits" in again

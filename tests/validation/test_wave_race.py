"""The race of full waves: what it reads of another program, which times it compares, and what it prints."""

from pathlib import Path

import pytest

from validation import wave_race
from validation.wave_race import Entrant, _rival, fastest, ratios
from validation.work_precision import Setting

FOUND = [
    Entrant("plain", "coarse", 1e-7, 50.0),
    Entrant("plain", "fine", 9e-10, 800.0),
    Entrant("plain", "finest", 1e-10, 2000.0),
    Entrant("delay", "", 5e-12, 10.0),
    Entrant("exact", "", 1e-8, 10.0),
    Entrant("exact", "", 1e-10, 20.0),
    Entrant("exact", "", 8e-12, 25.0),
    Entrant("explicit", "", 5e-10, 110.0),
    Entrant("fd", "", 2e-6, 30.0),
]
PLAIN = """
import json, time
began = time.perf_counter()
time.sleep(0.2)
print(json.dumps({"degree": 7, "elements": 8.0, "error": 1e-9, "ms": 1e3 * (time.perf_counter() - began)}))
"""


def test_times_are_compared_at_equal_errors() -> None:
    assert [*ratios(FOUND, "plain")] == [
        ("plain to 1e-09 over exact to 1e-9", "40.00"),
        ("explicit to 1e-09 over exact to 1e-9", "5.50"),
        ("fd to 1e-05 over exact to 1e-9", "1.50"),
        ("exact to 1e-11 over exact to 1e-9", "1.25"),
        ("exact over delay, both to 1e-09", "2.00"),
        ("exact over delay, both to 1e-11", "2.50"),
    ]
    assert fastest(FOUND, "plain", 1e-11) is None
    assert next(ratios(FOUND[3:], "plain"))[1] == "-"


def test_another_program_is_timed_by_its_processor_time(tmp_path: Path) -> None:
    """It sleeps for 200 ms, which take no processor time; a module beside it is found."""
    (tmp_path / "beside.py").write_text("")
    (tmp_path / "plain.py").write_text("import beside\n" + PLAIN)
    (found,) = _rival(tmp_path / "plain.py")
    assert found[:3] == ("plain", "degree 7, elements 8", 1e-9)
    assert 0.0 <= found.ms < 100.0


def test_the_race_is_run_and_printed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(wave_race, "SETTINGS", (Setting("delay", tolerance=1e-9), Setting("dg:16", 1e-10, 2, time="exact")))
    monkeypatch.setattr(wave_race, "_ROUNDS", 1)
    monkeypatch.setattr(wave_race, "_EACH", 1)
    (tmp_path / "plain.py").write_text(PLAIN)
    wave_race.main(tmp_path / "plain.py")
    head, other, delay, exact, *rest = capsys.readouterr().out.splitlines()
    assert head.split() == ["march", "error", "of", "psi(600)", "ms"]
    assert other.startswith("plain: degree 7, elements 8 ")
    assert delay.startswith("delay: delay, tolerance 1e-9 ")
    assert exact.startswith("exact: dg:16, 2 cells, exact in time, tolerance 1e-10 ")
    assert float(delay.split()[-2]) < 3e-10  # 3e-11 measured
    assert float(exact.split()[-2]) < 1e-10  # 1e-11 measured
    assert len(rest) == 8

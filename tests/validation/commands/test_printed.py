"""All that the commands print, held line by line against the record `printed.txt`: columns, digits, units, errors, remarks.

Words must be equal and numbers close: BLAS and processor move errors of 1e-12. Every reading of the clock is 0.25 s after the
last one.
"""

import itertools
import math
import re
from difflib import unified_diff
from pathlib import Path

import pytest

from validation.commands.cli import main

RECORD = Path(__file__).with_name("printed.txt")
FAST = ("--set", "drive.velocity=2000", "--until", "200")
"""Cycles of four transits, which repeat after 100."""
ONE_SIDED = (
    "{kind='reflection', coefficient=1}",
    "{kind='reflection', coefficient=-1}",
    "{kind='grip', stiffness=2, impedance=0}",
)
PARTS = (
    "viscosity={kind='standard-linear', time='1 ms', ratio=0.5}",
    "face={kind='machine', stiffness='3 GPa/m', impedance='9 MPa s/m', mass='27 t/m2'}",
    "face={kind='grip', stiffness=2.0, impedance=0.5}",
)
COMMANDS = (
    ("run", "paper", "--model", "kelvin-voigt", *FAST),
    ("run", "paper-si", "--model", "delay", "--set", "drive.velocity=2000", "slab.thickness=0.0335", "--until", "200"),
    ("run", "viscous", "--model", "dg:3", "--cells", "4", "--set", "drive.velocity=2000", "--until", "60"),
    ("run", "layered", "--model", "fd", "--tol", "1e-2", "--until", "2"),
    ("run", "unlike", "--model", "block8", "--set", "run.record=[]", "--until", "20"),
    ("run", "paper", "--model", "quasidynamic", "--set", "slab.r=0.1", "--until", "10"),
    ("run", "paper", "--model", "kelvin-voigt", *FAST, "--json"),
    ("compare", "paper", "--models", "fd,delay,kelvin-voigt,quasidynamic", "--cells", "24", *FAST),
    ("orbit", "paper", "--tol", "1e-6", "--set", "drive.velocity=2000"),
    ("orbit", "paper-si", "--model", "block8", "--tol", "1e-6", "--set", "slab.thickness=0.0335", "--json"),
    ("branch", "paper", "--model", "kelvin-voigt", "--over", "log10_r=-2.72:-2.68", "--tol", "1e-4", "--most-points", "3"),
    ("branch", "paper", "--model", "block8", "--over", "epsilon=2.5e-5:3e-5", "--most-points", "3", "--json"),
    ("stability", "paper"),
    ("stability", "grip", "--model", "fitted:4"),
    ("stability", "ramp"),
    ("stability", "unlike", "--json"),
    *(("show", "unlike", "--set", f"upper.face={face}") for face in ONE_SIDED),
    *(("show", "rock", "--set", "drive.velocity=1 um/s", f"slab.{part}") for part in PARTS),
)

RELATIVE, ABSOLUTE = 1e-5, 1e-9
_NUMBER = re.compile(r"([-−]?\b\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?|\bnan\b|[-−]?\binf\b)")


def differences(expected, got):
    """Where the words of the lines differ; if they are equal, the lines whose numbers are not close."""
    old, new = ([_NUMBER.sub("#", line) for line in lines] for lines in (expected, got))
    pairs = enumerate(zip(expected, got, strict=False), 1)
    return [*unified_diff(old, new, lineterm="", n=0)] or [
        f"line {count}: expected {one.strip()}\n  got {other.strip()}" for count, (one, other) in pairs if not _close(one, other)
    ]


def _close(one, other):
    return all(
        math.isclose(a, b, rel_tol=RELATIVE, abs_tol=ABSOLUTE) or (math.isnan(a) and math.isnan(b))
        for a, b in zip(_numbers(one), _numbers(other), strict=True)
    )


def _numbers(line):
    return [float(text.replace("−", "-").replace(",", "")) for text in _NUMBER.findall(line)]


@pytest.fixture
def clock(monkeypatch):
    readings = itertools.count()
    monkeypatch.setattr("time.perf_counter", lambda: 0.25 * next(readings))
    monkeypatch.setattr("validation.models.run.COMPILING", [])  # real seconds, if this process has not compiled all before


def printed(capsys, folder):
    for words in COMMANDS:
        places = ("--out", str(folder / "compare.pdf")) if words[0] == "compare" else ()
        assert main([*words, *places]) == 0
        out, err = capsys.readouterr()
        yield "$ " + " ".join(words)
        head = "#" if words[0] == "show" else ""
        yield from (line.replace(str(folder), "FOLDER").rstrip() for line in out.splitlines() if line.startswith(head))
        yield from (f"stderr: {line}" for line in err.splitlines())


def test_commands_print_what_is_on_record(clock, capsys, tmp_path, request):
    lines = [*printed(capsys, tmp_path)]
    if request.config.getoption("record_shown"):
        RECORD.write_text("\n".join([*lines, ""]), encoding="utf-8")
    differ = differences(RECORD.read_text(encoding="utf-8").splitlines(), lines)
    assert not differ, "\n".join([*differ, "meant? pytest --record-shown"])

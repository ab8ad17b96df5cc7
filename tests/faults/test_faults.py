"""Every planted fault has its place in the sources, and the tests that should notice it exist."""

import ast
import subprocess
import sys
from functools import cache

import pytest

from tests.faults.planting import ROOMS, ROOT, read_faults

FAULTS = read_faults()


@cache
def functions_in(file):
    return {node.name for node in ast.walk(ast.parse((ROOT / file).read_bytes())) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_fault_still_has_its_place_and_its_check(fault):
    text = (ROOT / fault.file).read_text(encoding="utf-8")
    assert fault.planted(text) != text
    assert fault.user
    assert fault.check
    for check in fault.check:
        file, _, name = check.partition("::")
        assert name.partition("[")[0] in functions_in(file) | {""}


def test_names_differ_and_every_room_has_faults():
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 80
    assert {fault.room for fault in FAULTS} == set(ROOMS)


def test_pytest_finds_every_check_with_its_parameters():
    """A renamed value would end the whole of `make faults`."""
    checks = sorted({check for fault in FAULTS for check in fault.check})
    words = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", *checks]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]

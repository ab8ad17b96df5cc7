"""A pytest plugin: which functions of the house each test runs, and its processor time; used to choose tests for a mutant.

Compiled code leaves no trace here (`mutants` takes the tests that run its callers), nor does another process.
"""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

from tests.faults.planting import ROOMS, ROOT

_reached: dict[str, dict[str, Any]] = {}


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Watch the calls of one test, its fixtures included."""
    seen: set[CodeType] = set()

    def watch(frame: FrameType, event: str, argument: object) -> None:
        if event == "call":
            seen.add(frame.f_code)

    begun = _processor_seconds()
    sys.setprofile(watch)
    try:
        yield
    finally:
        sys.setprofile(None)
        functions = sorted({name for code in seen if (name := _name(code))})
        _reached[item.nodeid] = {"seconds": round(_processor_seconds() - begun, 3), "functions": functions}


def pytest_unconfigure() -> None:
    """One file for each process that ran tests."""
    if _reached:
        Path(os.environ["REACH"], f"{os.getpid()}.json").write_text(json.dumps(_reached), encoding="utf-8")


def _processor_seconds() -> float:
    """Of this process and of those that it waited for: other work on the machine does not decide which tests are tried."""
    return sum(os.times()[:4])


def _name(code: CodeType) -> str:
    """file::qualified name for a function of the house, else empty."""
    path = Path(code.co_filename)
    if not path.is_relative_to(ROOT) or path.relative_to(ROOT).parts[0] not in ROOMS:
        return ""
    return f"{path.relative_to(ROOT).as_posix()}::{code.co_qualname}"

"""A pytest plugin: writes down the first test that says what is wrong, and stops there; other failures are noted as accidents.

A failed assertion, or an exception that was expected and did not come, says what is wrong; a crash somewhere on the way does not.
A process that uses more processor time than it is given is killed: it does not end.
"""

import json
import os
import resource
from pathlib import Path
from typing import Any

import pytest

_noted: dict[str, Any] = {"caught": None, "accidents": []}


def pytest_configure() -> None:
    """Limit the processor time of this process and of each that it starts."""
    seconds = int(os.environ["WITNESS_SECONDS"])
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Any:
    """Look at every outcome as it is made."""
    outcome = yield
    if call.excinfo is None or not outcome.get_result().failed:
        return
    found = {"test": item.nodeid, "says": _says(call.excinfo), "kind": call.excinfo.typename}
    if not issubclass(call.excinfo.type, AssertionError | pytest.fail.Exception):
        _noted["accidents"].append(found)
        return
    if _noted["caught"] is None:
        _noted["caught"] = found
    item.session.shouldfail = "the fault is caught"


def pytest_unconfigure() -> None:
    """Write what was noted."""
    Path(os.environ["WITNESS"]).write_text(json.dumps(_noted), encoding="utf-8")


def _says(excinfo: pytest.ExceptionInfo[BaseException]) -> str:
    """The asserting line of the test, and the first line of what pytest makes of it."""
    here = [entry for entry in excinfo.traceback if "tests" in Path(str(entry.path)).parts]
    statement = " ".join(str((here or list(excinfo.traceback))[-1].statement).split())
    message = next((line.strip() for line in str(excinfo.value).splitlines() if line.strip()), "")
    return f"{statement}  [{message}]" if message else statement

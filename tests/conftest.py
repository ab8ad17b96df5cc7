"""Random tests repeat the same examples in every run; `pytest --hypothesis-profile=explore` looks for new ones."""

import math

import pytest
from hypothesis import HealthCheck, settings

from reduced.families import REDUCTIONS
from slipwave.friction import LAWS
from slipwave.friction.own import LAW_FILES
from validation.models import own
from validation.models.by_name import FAMILIES, GRIDS

# no deadline: the first call may compile
_COMMON = {"deadline": None, "print_blob": True, "suppress_health_check": [HealthCheck.too_slow]}

settings.register_profile("repeatable", derandomize=True, max_examples=200, **_COMMON)
settings.register_profile("explore", max_examples=3000, **_COMMON)
settings.load_profile("repeatable")


def pytest_addoption(parser):
    """The option that writes anew what the commands print (`tests/validation/commands/printed.txt`)."""
    parser.addoption("--record-shown", action="store_true", help="write anew what the commands print")


@pytest.fixture(autouse=True)
def no_progress(monkeypatch):
    """No test is told of progress or of a long run unless it says so."""
    monkeypatch.setattr("validation.models.progress.PATIENCE", math.inf)
    monkeypatch.setattr("validation.models.progress.LONG", math.inf)


@pytest.fixture(autouse=True)
def nothing_left_behind():
    """Laws, families and files that a test registers or loads are gone after it."""
    tables, lists = (LAWS, LAW_FILES, own._OWN), (FAMILIES, GRIDS, REDUCTIONS)
    before = [dict(table) for table in tables], [list(one) for one in lists]
    yield
    for table, old in zip(tables, before[0], strict=True):
        table.clear()
        table |= old
    for one, kept in zip(lists, before[1], strict=True):
        one[:] = kept

"""Random tests repeat the same examples in every run; `pytest --hypothesis-profile=explore` looks for new ones."""

import math

import pytest
from hypothesis import HealthCheck, settings

from slipwave.friction import LAWS
from validation.registry.families import FAMILIES

# no deadline: the first call may compile
_COMMON = {"deadline": None, "print_blob": True, "suppress_health_check": [HealthCheck.too_slow]}

settings.register_profile("repeatable", derandomize=True, max_examples=200, **_COMMON)
settings.register_profile("explore", max_examples=3000, **_COMMON)
settings.load_profile("repeatable")


def pytest_addoption(parser):
    """The option that writes anew what the commands print (`tests/validation/printed.txt`)."""
    parser.addoption("--record-shown", action="store_true", help="write anew what the commands print")


@pytest.fixture(autouse=True)
def no_progress(monkeypatch):
    """Tests of what is printed must not depend on how long it took: no test waits for progress unless it says so."""
    monkeypatch.setattr("validation.run.progress.PATIENCE", math.inf)


@pytest.fixture(autouse=True)
def nothing_left_behind():
    """A friction law or a family of models that a test registers is gone after it: no test may depend on what its process ran
    before."""
    laws, families = dict(LAWS), list(FAMILIES)
    yield
    for name in set(LAWS) - set(laws):
        del LAWS[name]
    FAMILIES[:] = families

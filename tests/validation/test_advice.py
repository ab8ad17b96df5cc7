"""A run that will take more than a minute names the cheaper model."""

import logging
from dataclasses import dataclass, field

import pytest

import slipwave
from slipwave.scene import Scene
from validation.run.simulate import LongRunAdvice, error_without_echoes


@dataclass
class Marching:
    """As much of a solver as is read."""

    model: str
    time: float = 0.0
    scene: Scene = field(default_factory=lambda: slipwave.read("paper"))


@pytest.mark.parametrize(
    ("model", "seconds", "says"), [("delay", 6.1, True), ("delay", 0.5, False), ("quasidynamic", 6.1, False)]
)
def test_one_line_names_the_cheaper_model_and_its_error(model, seconds, says, caplog, monkeypatch):
    """A tenth of the run has taken so many seconds, then two tenths."""
    clock = iter([0.0, seconds, 10.0 + seconds])
    monkeypatch.setattr("validation.run.simulate.time.monotonic", lambda: next(clock))
    advice = LongRunAdvice(Marching(model), 100.0, lambda done: None)  # type: ignore[arg-type]
    with caplog.at_level(logging.INFO, logger="slipwave"):
        advice(10.0)
        advice(90.0)
    told = [record.getMessage() for record in caplog.records]
    assert [("61 s" in line and "quasidynamic" in line and "0.08" in line) for line in told] == [True] * says


def test_the_error_is_that_of_one_echo():
    """2 Z V/a for the ageing law, with Z = epsilon/2."""
    scene = slipwave.read("paper")
    assert error_without_echoes(scene) == pytest.approx(2.8e-5 * 100.0 / 0.0349, rel=1e-9)

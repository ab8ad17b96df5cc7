"""The short examples of docs/extending.md do what the page says."""

import re
from pathlib import Path

import numpy as np
import pytest

import scene
from reduced.delay import Delay
from reduced.ladder import Ladder
from reduced.reduction import REDUCTIONS, Reduction, reduction
from scene.observe import EventObserver, follow, summarise

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")


def example(first_words):
    return next(block for block in re.findall(r"```python\n(.*?)```", PAGE, re.S) if block.startswith(first_words))


def test_a_reduction_is_one_line(monkeypatch):
    line = example('"block10"').strip().rstrip(",")
    monkeypatch.setitem(REDUCTIONS, "block10", eval(f"{{{line}}}", {"Reduction": Reduction})["block10"])
    paper = scene.read("paper")
    periods = {}
    for name in ("block8", "block10", "block12"):
        solver = Ladder(paper, reduction(name))
        observer = EventObserver(paper, solver.nodes)
        follow(solver, 3000, [observer])
        periods[name] = summarise(observer.events, 2000).period.mean
    assert periods["block8"] < periods["block10"] < periods["block12"]


def test_an_observer_is_anything_that_scans():
    scope = {"np": np}
    exec(example("class SlipObserver"), scope)
    observer = scope["SlipObserver"]()
    solver = Delay(scene.read("paper"))
    follow(solver, 2000, [observer])
    assert observer.slip == pytest.approx(2000 * 100 * 0.8, rel=0.25)


def test_a_law_whose_rate_is_no_exponential_is_refused():
    from scene.errors import SceneError
    from scene.friction import LAWS
    from scene.friction.check import check_law

    square = LAWS["ageing"]._replace(rate_of=lambda law, z: z * z, unknown_of=lambda law, v: v**0.5)
    with pytest.raises(SceneError, match="v''"):
        check_law("square", square)

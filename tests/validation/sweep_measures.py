"""Measures of sweeps that tests know in advance."""

import os
import time
from pathlib import Path

import numpy as np


def disc(scene):
    """A regime inside a disc of (a, b) and another one outside, with a figure that is linear there."""
    x, y = (scene.law.a - 0.01) / 0.01, (scene.law.b - 0.02) / 0.01
    return {"regime": float(x * x + y * y < 0.36), "height": 2.0 * x - y}


def slowly(scene):
    """A figure that takes 5 ms."""
    time.sleep(0.005)
    return {"sum": scene.law.a + scene.law.b}


def until_freed(scene):
    """At all points but those of the smallest `a`, waits for a file."""
    freed = Path(os.environ["SLIPWAVE_TEST_MARKS"]) / "freed"
    while scene.law.a > 0.001 and not freed.exists():
        time.sleep(0.01)
    return {"sum": scene.law.a + scene.law.b}


def deadly(scene):
    """Kills its process at one point, always; at another one, twice."""
    if scene.law.a == 0.012:
        os._exit(9)
    marks = Path(os.environ["SLIPWAVE_TEST_MARKS"])
    if scene.law.a == 0.014 and len(list(marks.iterdir())) < 2:
        (marks / str(os.getpid())).touch()
        os._exit(9)
    return {"sum": scene.law.a + scene.law.b}


def wrong(scene):
    return {"inverse": 1.0 / (scene.law.a - 0.012)}


def a_word(scene):
    return {"x": "word"}


def a_list(scene):
    return {"x": np.arange(3.0)}


def a_status(scene):
    return {"status": 3.0}


def a_number(scene):
    return 1.0


def two_lines(scene):
    raise RuntimeError("no\nway")


def sizes(scene):
    return {"flag": np.bool_(True), "count": np.int64(3), "none": None}

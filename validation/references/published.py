"""Reference numbers of the project: values from programs that share no code with this one, and those of the paper."""

import json
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any


@cache
def reference() -> dict[str, Any]:
    """Contents of published.json, with the provenance of each block under its key "how"."""
    content: dict[str, Any] = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))
    return content


@cache
def laboratory() -> dict[str, Any]:
    """Contents of laboratory.json: numbers that others measured, each block with its source."""
    content: dict[str, Any] = json.loads(Path(__file__).with_name("laboratory.json").read_text(encoding="utf-8"))
    return content


def reference_orbit(model: str, log10_r: float) -> dict[str, float]:
    """Known values of a model's orbit in the paper's material at V = 100: any of period, stress_drop, elastic_stress_drop,
    v_max, v_min (empty if nothing is known); transit clock."""
    orbits: list[dict[str, float]] = reference()["orbits"].get(model, [])
    matching = [orbit for orbit in orbits if orbit["log10_r"] == log10_r]
    return {name: value for name, value in matching[0].items() if name != "log10_r"} if matching else {}


def half_digit(value: float) -> float:
    """Half a unit in the last written decimal of a number: 0.005 for 73.47."""
    return 0.5 * 10.0 ** int(Decimal(repr(value)).as_tuple().exponent)

"""What the pages on testing machines and protocols state beside their commands (`test_documented_pages`)."""

import re

import pytest

import slipwave
from slipwave.input.source import parse_toml
from slipwave.sources import ROOT

BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.S)


def blocks(page: str, kind: str) -> list[str]:
    """The text of every block of a kind."""
    return [text for found, text in BLOCK.findall((ROOT / "docs" / page).read_text(encoding="utf-8")) if found == kind]


def test_the_machine_of_a_data_sheet_is_that_of_the_gallery() -> None:
    scene = slipwave.read("steel-on-pmma")
    (table,) = blocks("testing-machine.md", "toml")
    given = parse_toml(table)["upper"]["face"]
    assert slipwave.read("steel-on-pmma", {"upper.face": given}).upper == scene.upper


def test_a_machine_loads_the_interface_as_its_spring_does() -> None:
    """Between two slips the stress rises at stiffness times V: the elastic drop over that is the time of the stick."""
    scene = slipwave.read("steel-on-pmma", {"run.until": "1.2 s"})
    units = scene.units
    assert units is not None
    result = slipwave.run(scene)
    events = result.done.events
    period = float(events.period[-1]) * scene.transit * units.time
    stiffness = scene.stiffness / scene.transit * units.face["stiffness"]
    assert stiffness == pytest.approx(1 / (1e-9 + 0.02 / 79e9 + 0.02 / 2e9), rel=1e-12)
    loading = float(events.elastic_stress_drop[-1]) * units.normal_stress / (stiffness * 1e-3)
    assert loading == pytest.approx(period, rel=0.06)  # 0.02 measured: slip takes the rest
    assert period == pytest.approx(0.283, rel=0.02)

"""Every command of the pages on testing machines and protocols, word by word: what the text blocks show is what it prints."""

import re
from itertools import zip_longest
from pathlib import Path

import pytest

import slipwave
from slipwave.input.source import parse_toml
from slipwave.sources import ROOT
from validation.cli import main

BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.S)


def blocks(page: str, kind: str) -> list[str]:
    """The text of every block of a kind."""
    return [text for found, text in BLOCK.findall((ROOT / "docs" / page).read_text(encoding="utf-8")) if found == kind]


@pytest.mark.parametrize("page", ["testing-machine.md", "protocols.md"])
def test_the_commands_print_what_the_page_shows(
    page: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    commands, shown = blocks(page, "sh"), blocks(page, "text")
    assert len(commands) >= len(shown) > 0  # the last ones write a figure
    for command, text in zip_longest(commands, shown, fillvalue=""):
        for line in command.splitlines():
            assert main(line.split()[1:]) == 0
        printed = capsys.readouterr().out.splitlines()
        assert [line for line in text.splitlines() if line not in printed] == []


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

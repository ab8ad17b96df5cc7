"""Imports run one way: between the rooms, and between the folders and single files of each room.

Imports within functions and those for types alone count too: a circle is a circle whenever it is walked. One arrow leads upwards:
the ground room's own `__init__` hands out the door of `validation`, by name and only on demand.
"""

import subprocess
import sys
from pathlib import Path

import pytest

from slipwave.sources import ROOT, imported_names

BELOW = {
    "slipwave": (),
    "reduced": ("slipwave",),
    "fullwave": ("slipwave",),
    "validation": ("slipwave", "reduced", "fullwave"),
}
"""What each room may import besides itself: the two that hold models never import each other."""

ORDER = {
    "slipwave": "errors extras files sources threads compiled friction scene features input observe solve step family __main__",
    "reduced": "families commensurate parameters delay impedance ode stability closed_forms flows orbit continuation",
    "fullwave": "families options sampling operators leapfrog lines fields * adapt",
    "validation": (
        "output run measure references registry study branches timing studies error_bars wave_race report "
        "benchmark results door commands command_line cli"
    ),
}
"""What a room is made of; each may import those named before it. A star stands for all others: the families of full waves."""


FACE = [("slipwave/__init__.py", "", "validation", part) for part in ("door", "results")]
"""The arrow upwards: named for types alone (below: nothing is imported), walked when a function of the door is first used."""


def arrows(room: str) -> set[tuple[str, str, str, str]]:
    """(file, part of the room it lies in, room imported, part imported); the room's own `__init__` is the part ""."""
    found = set()
    for path in sorted((ROOT / room).rglob("*.py")):
        place = path.relative_to(ROOT)
        for name in imported_names(path):
            words = name.split(".")
            if words[0] in BELOW:
                found.add((str(place), part(place.with_suffix("").parts), words[0], part(words)))
    return found


def part(words: list[str] | tuple[str, ...]) -> str:
    """The folder or file right below the room that a module's name leads to."""
    place = ROOT.joinpath(*words[:2])
    is_one = len(words) > 1 and words[1] != "__init__" and (place.is_dir() or place.with_suffix(".py").is_file())
    return words[1] if is_one else ""


@pytest.mark.parametrize("room", BELOW)
def test_a_room_imports_those_below_it(room: str) -> None:
    assert [arrow for arrow in arrows(room) if arrow[2] not in (room, *BELOW[room]) and arrow not in FACE] == []


@pytest.mark.parametrize("use", ["", "slipwave.read_scene('paper')", "slipwave.SceneError"])
def test_the_ground_room_imports_no_other_room_unless_the_door_is_used(use: str) -> None:
    code = f"import sys, slipwave; {use}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"validation", "reduced", "fullwave"} & set(done.stdout.split())
    assert use or not {"numpy", "numba", "pydantic", "xarray"} & set(done.stdout.split())


@pytest.mark.parametrize("room", ORDER)
def test_a_folder_imports_those_before_it(room: str) -> None:
    order = ["", *ORDER[room].split()]
    parts = {part(path.relative_to(ROOT).with_suffix("").parts) for path in (ROOT / room).rglob("*.py")}
    assert "*" in order or sorted(parts - set(order)) == [], "say in ORDER where it stands"
    floor = {name: order.index(name if name in order else "*") for name in parts}
    assert [a for a in arrows(room) if a[1] and a[2] == room and floor[a[3]] > floor[a[1]]] == []


def test_an_arrow_that_turns_back_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for file, text in {
        "slipwave/scene/slab.py": "def thickness():\n    from slipwave.observe import follow\n",
        "slipwave/observe/follow.py": "import slipwave.scene.slab\n",
        "reduced/delay/system.py": "from fullwave import adapt\n",
    }.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text(text)
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    with pytest.raises(AssertionError, match=r"reduced/delay/system.py"):
        test_a_room_imports_those_below_it("reduced")
    monkeypatch.setitem(ORDER, "slipwave", "scene observe")
    with pytest.raises(AssertionError, match=r"slipwave/scene/slab.py"):
        test_a_folder_imports_those_before_it("slipwave")

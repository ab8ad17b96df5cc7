"""Imports run one way: between the rooms, and between their files.

Imports within functions and those for types alone count too: a circle is a circle whenever it is walked. What a user of
`slipwave` is offered by the rooms above it is found by name (`slipwave/__init__.py`), and is typed in its stub.
"""

import subprocess
import sys

import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from slipwave import sources
from slipwave.sources import ROOT

BELOW = {"slipwave": (), "reduced": ("slipwave",), "fullwave": ("slipwave",), "validation": ("slipwave", "reduced", "fullwave")}
"""What each room may import besides itself: the two that hold models never import each other."""

INSTRUMENT = {f"validation/{one}" for one in ("models", "commands", "data", "fit", "sweep", "chart", "references")}
PROOF = {f"validation/{one}" for one in ("measure", "verification", "studies", "report")}
"""The rooms of `validation`: the proof uses the instrument as any user does; its commands are found by name."""


OFFERED = {"slipwave/__init__.py", "slipwave/errors.py"}
"""What a study may import besides `chart`, `references` and the proof: the public functions."""

ABOUT_KERNELS = {"onset", "bifurcation/doubling", "orders", "snaking", "which_model/laws"}


def arrows(root):
    """(file, file that it imports) for all files of the four rooms."""
    files = [path for room in BELOW for path in sorted((root / room).rglob("*.py"))]
    return [
        (path.relative_to(root).as_posix(), other.relative_to(root).as_posix())
        for path in files
        for other in sources._imported_files(path, False) - {path}
    ]


def circles(pairs):
    names = sorted({name for pair in pairs for name in pair})
    number = {name: k for k, name in enumerate(names)}
    ends = [[number[name] for name in side] for side in zip(*pairs, strict=True)]
    count, label = connected_components(coo_array(([1] * len(pairs), ends), shape=(len(names),) * 2), connection="strong")
    groups = [{name for name, own in zip(names, label, strict=True) if own == k} for k in range(count)]
    return [group for group in groups if len(group) > 1]


def upward(pairs):
    room = {name: name.partition("/")[0] for pair in pairs for name in pair}
    return [(file, other) for file, other in pairs if room[other] not in (room[file], *BELOW[room[file]])]


def folders(pairs):
    """The same between folders; the file `__init__.py` of a room stands for itself."""
    parents = [tuple(name if name.count("/") < 2 else name.rpartition("/")[0] for name in pair) for pair in pairs]
    return [(one, other) for one, other in parents if one != other]


def test_a_room_imports_those_below_it():
    assert upward(arrows(ROOT)) == []


def test_the_instrument_never_imports_its_proof():
    room = {name: "/".join(name.split("/")[:2]) for pair in arrows(ROOT) for name in pair}
    assert {one for one in room.values() if one.startswith("validation/")} - {"validation/__init__.py"} == INSTRUMENT | PROOF
    assert [(file, other) for file, other in arrows(ROOT) if room[file] in INSTRUMENT and room[other] in PROOF] == []


def test_a_study_uses_the_public_functions_unless_it_is_about_a_kernel():
    known = ("validation/__init__.py", *(f"validation/{one}/" for one in ("chart", "references", "measure", "studies", "report")))
    past = {
        file.removeprefix("validation/studies/").removesuffix(".py")
        for file, other in arrows(ROOT)
        if file.startswith("validation/studies/") and other not in OFFERED and not other.startswith(known)
    }
    assert past == ABOUT_KERNELS


def test_no_files_import_each_other():
    assert circles(arrows(ROOT)) == []


def test_no_folders_import_each_other():
    assert circles(folders(arrows(ROOT))) == []


@pytest.mark.parametrize("use", ["", "slipwave.read_scene('paper')", "slipwave.SceneError"])
def test_the_ground_room_imports_no_other_room_unless_a_command_is_used(use):
    code = f"import sys, slipwave; {use}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"validation", "reduced", "fullwave"} & set(done.stdout.split())
    assert use or not {"numpy", "numba", "pydantic", "xarray"} & set(done.stdout.split())


@pytest.mark.parametrize("file", ["validation.py", "reduced.py"])
def test_a_file_of_the_users_own_that_hides_a_room_is_named(file, tmp_path):
    (tmp_path / file).write_text("raise SystemExit('a file of the user was imported')\n")
    line = f"{tmp_path / file} hides slipwave's own package {file[:-3]!r}: rename that file\n"
    for words, status, told in (
        (["-m", "slipwave", "scenes"], 2, f"slipwave: {line}"),
        (["-c", "import slipwave\ntry: slipwave.run\nexcept ImportError as error: print(error); raise SystemExit(3)"], 3, line),
    ):
        environment = {"PYTHONPATH": f"{tmp_path}:{ROOT}"}
        done = subprocess.run([sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, env=environment)
        assert (done.returncode, done.stdout + done.stderr) == (status, told)

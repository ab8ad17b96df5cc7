"""A family of models of the user's own, from a file or an installed package: every command takes it."""

import subprocess
import sys
from pathlib import Path

import pytest

import slipwave as sw
from slipwave.errors import SceneError
from slipwave.input.stored import read_stored
from tests.own_families import removed
from validation.registry.families import FAMILIES
from validation.registry.own import load_families, own_files

ELEMENTS = """
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import FullWave
from reduced.impedance.reduction import Reduction
from slipwave.family import Family

ORDER = lambda p: p + 1
MINE = FullWave("mine:P", f"{__name__}:Mine", "my elements", numbers=range(1, 5), default=3, order_interface=ORDER, cfl=0.75)
BLOCK10 = Family("block10", f"{__name__}:block10", "spring and block of mass rho h/10")


class Mine(DiscontinuousGalerkin):
    family = MINE


def block10(scene, name):
    return Reduction(name, mass=0.1)
"""


@pytest.fixture
def file(tmp_path):
    """A file of families; what it adds is taken away."""
    path = tmp_path / "mine.py"
    path.write_text(ELEMENTS)
    with removed():
        yield path


def test_a_full_wave_and_a_reduction_of_ones_own(file, answer):
    """The elements are ours under another name, so that every digit is the same."""
    ours = sw.run("paper", "dg:3", until=20, cells=4, time="explicit").final
    mine = sw.run("paper", "mine:3", until=20, cells=4, time="explicit", family=file).final
    assert mine == ours
    critical = answer("stability", "paper", "--model", "block10", "--family", str(file))["log10_r_c"]
    lighter, heavier = (sw.stability("paper", model).log10_r_c for model in ("block12", "block8"))
    assert critical != lighter
    assert min(lighter, heavier) < critical < max(lighter, heavier)
    assert sw.models(family=file)["mine:P"] == "my elements"


def test_a_file_that_is_loaded_again_replaces_its_own(file):
    load_families(file)
    file.write_text(ELEMENTS.replace("my elements", "better elements"))
    load_families(file)
    assert [family.title for family in FAMILIES if family.name == "mine"] == ["better elements"]
    assert own_files() == [file.resolve()]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"mine:P"', '"dg:P"', "the name 'dg' is taken by another family of models"),
        ('"mine:P"', '"auto"', "the name 'auto' is taken"),
        (":Mine", ":Yours", "Yours': no such class or function"),
        ("{__name__}:Mine", "nowhere:Mine", "made_by = 'nowhere:Mine': no such class"),
        ("class Mine(DiscontinuousGalerkin)", "class Mine", "class Mine lacks the methods advance, deviation, "),
        ("    family = MINE", "    family, elastic_limit = MINE, None", "class Mine lacks the methods elastic_limit"),
        ("    family = MINE", "    pass", "Mine.family is another one"),
        (ELEMENTS, "import math", "declares no family of models"),
        ("from reduced", "from nowhere", "cannot be run: ModuleNotFoundError: No module named 'nowhere'"),
        ("ORDER = lambda p: p + 1", "ORDER = 1 / 0", "mine.py, line 7, in <module>)"),
        ("ORDER = ", "ORDER = (", "(mine.py, line 7)"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_one_line(file, refused, old, new, told):
    before = list(FAMILIES)
    file.write_text(ELEMENTS.replace(old, new, 1))
    error = refused("run", "paper", "--family", str(file), "--model", "mine")
    assert error.startswith(f"slipwave: --family = {str(file)!r}")
    assert told in error
    assert before == FAMILIES


def test_a_mistake_in_a_method_is_told_by_its_line(file, refused, tmp_path):
    """As a failure of the numerics; in Python it is raised as it is."""
    method = "\n    def grid_of(self, *given):\n        return given[9]\n"
    file.write_text(ELEMENTS.replace("    family = MINE\n", "    family = MINE\n" + method))
    call = ["run", "paper", "--family", str(file), "--model", "mine:3", "--cells", "4", "--until", "2"]
    told = refused(*call, "--out", str(tmp_path / "run.nc"), status=3)
    assert f"slipwave: {file.resolve()}, line 16, in grid_of: IndexError: tuple index out of range" in told
    assert not (tmp_path / "run.nc").exists()
    with pytest.raises(IndexError):
        sw.run("paper", "mine:3", cells=4, until=2, family=file)


def test_a_file_of_results_names_the_family_and_demands_it_again(file, printed, refused, tmp_path):
    first, ours = str(tmp_path / "run.nc"), str(tmp_path / "ours.nc")
    own = ["--family", str(file)]
    printed("run", "paper", *own, "--model", "mine:3", "--cells", "4", "--until", "5", "--out", first)
    printed("run", first, *own, "--until", "5")
    facts = read_stored(first).facts
    assert (facts["family_file"], len(facts["family_digest"])) == ("mine.py", 16)
    file.write_text(ELEMENTS + "\n")
    assert "was computed with another family of 'mine:3'" in refused("run", first, *own)
    printed("run", "paper", "--until", "5", "--model", "dg:3", "--out", ours)
    assert "family_file" not in read_stored(ours).facts


@pytest.mark.parametrize(("name", "told"), [("none.py", "no such file"), ("mine.txt", "must be a Python file")])
def test_a_file_that_is_none(tmp_path, name, told):
    (tmp_path / "mine.txt").write_text("")
    with pytest.raises(SceneError, match=told):
        sw.stability("paper", family=tmp_path / name)


PACKAGE = {
    "mine.py": ELEMENTS,
    "laws.py": "from slipwave.friction import ageing, register\nfrom slipwave.friction.regularised import steady_psi\n"
    "class Mine(ageing.Ageing): pass\nregister('my-ageing', Mine, ageing.respond_ageing, steady_psi)\n",
    "mine-1.0.dist-info/METADATA": "Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n",
    "mine-1.0.dist-info/entry_points.txt": "[slipwave.families]\nmine = mine:MINE\nblock10 = mine:block10\nlost = nowhere:LOST\n"
    "[slipwave.laws]\nmine = laws\n",
}


def test_an_installed_package_brings_its_family_and_its_law(tmp_path):
    for name, text in PACKAGE.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    code = "import slipwave as s; print(s.models()['mine:P'], s.stability('paper', settings='interface.law=my-ageing').stable)"
    environment = {"PYTHONPATH": str(tmp_path), "HOME": str(Path.home())}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert done.stdout.split() == ["my", "elements", "False"]
    assert done.stderr.count("note: mine: slipwave.families") == 2
    assert "block10 = 'mine:block10': is no slipwave.family.Family; it is left out" in done.stderr
    assert "ModuleNotFoundError: No module named 'nowhere'; it is left out" in done.stderr

"""A user's own law, family or measure: nothing goes on with a changed one, and none can end the program."""

import importlib
import sys

import pytest

import slipwave as sw
from slipwave.errors import SceneError
from slipwave.packages import own_file
from slipwave.sources import ROOT
from tests.validation.models.test_models import ELEMENTS, PACKAGE

LAW = (ROOT / "examples" / "own_law.py").read_text(encoding="utf-8").split("\nif __name__")[0]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working folder with the law `law.py`, from which modules can be imported."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "law.py").write_text(LAW)
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]


MEASURE = "def f(scene): return {'twice': 2.0 * scene.law.a}"
OWN_LAW = ("--law", "law.py", "--set", "interface.law=cutoff")
SAME = ("--law", "laws.py", "--set", "interface.law=my-ageing")
BRANCH = ("paper", *SAME, "--model", "block8", "--tol", "1e-4", "--over", "r=1e-3:5e-3", "--most-points")
CURVE = ("--of", "LP", "--and", "V=100:120")
FIT = ("fit", "velocity-steps", *OWN_LAW, "--set", "slab.thickness='20 cm'", "--free", "a", "--data", "steps.csv")
MEMBER = ("--family", "mine.py", "--model", "mine:3", "--cells", "4", "--checkpoint", "kept.npz", "--checkpoint-every", "2")
KEPT = {
    "run": (
        ["run", "paper", *OWN_LAW, "--checkpoint", "kept.npz", "--checkpoint-every", "5", "--until", "8"],
        ["run", "paper", *OWN_LAW, "--checkpoint", "kept.npz", "--until", "9"],
        "delete 'kept.npz'",
        "law law.py",
    ),
    "sweep": (
        ["sweep", "paper", *OWN_LAW, "--vary", "V=50,100", "--measure", "stability", "--workers", "1", "--out", "map"],
        ["sweep", "map", "--law", "law.py", "--workers", "1"],
        "--anew",
        "law law.py",
    ),
    "branch": (
        ["branch", *BRANCH, "2", "--out", "kept.nc"],
        ["branch", *BRANCH, "3", "--resume", "kept.nc"],
        "without --resume",
        "law laws.py",
    ),
    "curve": (
        ["curve", *BRANCH, "2", *CURVE, "--out", "kept.nc"],
        ["curve", *BRANCH, "3", *CURVE, "--resume", "kept.nc"],
        "without --resume",
        "law laws.py",
    ),
    "fit": ([*FIT, "--checkpoint", "kept.json"], [*FIT, "--checkpoint", "kept.json"], "remove it", "law law.py"),
    "family": (
        ["run", "paper", *MEMBER, "--until", "5"],
        ["run", "paper", *MEMBER, "--until", "6"],
        "delete 'kept.npz'",
        "family mine.py",
    ),
    "measure": (
        ["sweep", "paper", "--vary", "V=50,100", "--measure", "mine:f", "--workers", "1", "--out", "map"],
        ["sweep", "map", "--measure", "mine:f", "--workers", "1"],
        "--anew",
        "measure mine.py",
    ),
}


@pytest.mark.parametrize("name", KEPT)
def test_what_was_computed_with_a_file_that_has_changed_is_not_gone_on_with(name, here, refused, printed):
    first, again, way_out, changed = KEPT[name]
    (here / "mine.py").write_text(ELEMENTS if name == "family" else MEASURE)
    (here / "laws.py").write_text(PACKAGE["laws.py"])
    if name == "fit":
        printed("run", *FIT[1:-4], "--model", "quasidynamic", "--until", "90s", "--series", "steps.csv")
    printed(*first)
    sys.modules.pop("mine", None)
    path = here / changed.split()[1]
    text = path.read_text()
    path.write_text(text + "\n# another\n")
    told = refused(*again)
    assert changed in told
    assert way_out in told
    sys.modules.pop("mine", None)
    path.write_text(text)
    printed(*again)


def test_a_digest_is_that_of_the_user_s_text_as_it_was_loaded_with_what_it_imports(here):
    (here / "parts").mkdir()
    for name, text in (
        ("__init__", ""),
        ("whole", "from . import half\ndef f(x): return half.x"),
        ("half", "x = 1"),
    ):
        (here / "parts" / f"{name}.py").write_text(text)
    sys.path.append(str(here))

    def digest():
        for name in [name for name in sys.modules if name.startswith("parts")]:
            del sys.modules[name]
        importlib.invalidate_caches()
        function = importlib.import_module("parts.whole").f
        first = own_file(function)
        (here / "parts" / "half.py").write_text("x = 100")
        assert own_file(function) == first
        return first

    assert digest().path == here / "parts" / "whole.py"
    assert digest() == digest() != own_file(test_a_digest_is_that_of_the_user_s_text_as_it_was_loaded_with_what_it_imports)
    assert own_file(sw.read_scene) is None


END = "import sys\n"
EXITS = {
    "law": (["verify", "--law", "user.py"], "sys.exit(0)"),
    "law, run": (["run", "paper", "--law", "user.py"], "raise SystemExit"),
    "family": (["verify", "--family", "user.py"], "sys.exit(3)"),
    "family, run": (["compare", "paper", "--models", "delay,block8", "--family", "user.py"], "exit()"),
    "measure": (["sweep", "paper", "--vary", "V=50,100", "--measure", "user:f", "--out", "map"], "sys.exit(0)"),
    "function of a measure": (
        ["sweep", "paper", "--vary", "V=50,100", "--measure", "user:f", "--workers", "1", "--out", "map"],
        "def f(scene): sys.exit(0)",
    ),
    "function of a law": (
        ["verify", "--law", "user.py"],
        LAW.replace("v, age = math.exp(z), math.exp(psi)", "sys.exit(0)"),
    ),
    "function of a family": (
        ["run", "paper", "--model", "mine", "--family", "user.py"],
        "from slipwave.family import Family\ndef make(*given, **named): sys.exit(0)\n"
        "MINE = Family('mine', f'{__name__}:make', 'mine')\n",
    ),
}


@pytest.mark.parametrize("name", EXITS)
def test_a_file_that_ends_the_program_is_wrong_input(name, here, refused):
    words, text = EXITS[name]
    (here / "user.py").write_text(END + text)
    junit = ["--junit", "rows.xml"] if words[0] == "verify" else []
    told = refused(*words, *junit)
    assert "ends the program (sys.exit(" in told
    assert "user" in told
    assert not (here / "rows.xml").exists()


def test_a_file_that_ends_the_program_ends_no_program_in_python(here):
    (here / "user.py").write_text("raise SystemExit(0)")
    with pytest.raises(SceneError, match="ends the program"):
        sw.verify(law=here / "user.py")

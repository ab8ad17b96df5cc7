"""What docs/extending.md and the study of docs/reading-the-report.md say is done, word by word, in a copy of the checkout.

A reader writes a file where the text says "Write `FILE`", adds lines where it says "Add at the end of `TABLE` in `FILE`", changes
what it says to change, runs every line of a shell block, and expects what a text block shows of a command that is refused. The
sections whose code takes more than 10 s to compile are run by the full report.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from validation.commands.cli import COMMANDS

ROOT = Path(__file__).parents[3]
BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.S)
KEYS = "tests/slipwave/test_readme_keys.py"
FOR_ALL = ("slipwave", "reduced", "fullwave", "validation", "examples")

ALL = """
import shlex, sys
from validation.commands.cli import main
for line in sys.argv[1:]:
    assert main([*shlex.split(line), "--json"]) == 0
    print(end="\\f")
"""


class Reader:
    """Does what a section says, in `folder`."""

    def __init__(self, folder):
        self.folder, self.output, self.changed = folder, "", set()
        for room in FOR_ALL:
            shutil.copytree(ROOT / room, folder / room, ignore=shutil.ignore_patterns("__pycache__"))
        (folder / KEYS).parent.mkdir(parents=True)
        for file in (KEYS, "README.md"):
            shutil.copy(ROOT / file, folder / file)

    def run(self, line):
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path, "PYTHONPATH": str(self.folder)}
        done = subprocess.run(line, shell=True, cwd=self.folder, env=environment, capture_output=True, text=True, timeout=3600)
        self.output = done.stdout + done.stderr
        return done.returncode

    def json(self, *lines):
        """What the commands print, computed one after the other by one process."""
        assert self.run(f"python -c {shlex.quote(ALL)} {shlex.join(lines)} 2>/dev/null") == 0
        found = [json.loads(text) for text in self.output.split("\f") if text]
        assert len(found) == len(lines)
        return found

    def change(self, file, old, new):
        self.changed.add(file)
        path = self.folder / file
        text = path.read_text()
        assert text.count(old) == 1
        path.write_text(text.replace(old, new))

    def add(self, table, file, lines):
        """Put `lines` last into a class, or into a table that ends with a bracket at the beginning of a line."""
        self.changed.add(file)
        path = self.folder / file
        added = "".join(f"    {line}\n" for line in lines.splitlines())
        end = r"\n\n" if table.startswith("class ") else r"[])}]\n"
        text, count = re.subn(
            rf"(^{table}\b.*?\n)({end})", lambda found: found[1] + added + found[2], path.read_text(), flags=re.M | re.S
        )
        assert count == 1
        path.write_text(text)

    def follow(self, section):
        """Every block in turn, with the words between it and the one before."""
        words, *rest = BLOCK.split(section)
        steps = list(zip(rest[::3], rest[1::3], rest[2::3], strict=True))
        for (kind, content, after), following in zip(steps, [*steps[1:], None], strict=True):
            words = " ".join(words.split())
            for edit in re.findall(r"[Ii]n `([^`]+)`, change `([^`]+)` to `([^`]+)`", words):
                self.change(*edit)
            if kind == "sh":
                fails = following is not None and following[0] == "text"
                for line in content.splitlines():
                    assert (self.run(line) != 0) == fails, f"{line}\n{self.output}"
            elif kind == "text":
                assert content.strip() in self.output
            elif place := re.search(r"Add at the end of `([^`]+)` in `([^`]+)`:$", words):
                self.add(*place.groups(), content)
            elif place := re.search(r"Add before `([^`]+)` in `([^`]+)`:$", words):
                self.change(place[2], place[1], f"{content}\n\n{place[1]}")
            else:
                name = re.search(r"Write `([^`]+)`[^`]*(\[[^]]*\]\([^)]*\))?:$", words)[1]
                self.changed.add(name)
                assert not (self.folder / name).exists()
                (self.folder / name).write_text(content)
            words = after


def sections(page):
    """Title and text of every section that adds something."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    parts = re.split(r"^## (.*)\n", text, flags=re.M)[1:]
    return {title: body for title, body in zip(parts[::2], parts[1::2], strict=True) if title.startswith("Adding")}


JUDGE = """
import sys
from pathlib import Path
from reduced.stability import scaled
from validation.models.own import load_families
from validation.measure import orders as in_space
from validation.studies.orders import _judged_models
from validation.report.grid_verdicts import order_verdict
load_families(Path("finite_volume.py"))
assert "fv" in _judged_models(quick=True)
true = in_space.without_error_in_time
factor = float(sys.argv[1])
in_space.without_error_in_time = lambda model, scene, cells, **o: true(model, scaled(scene, epsilon=factor), cells, **o)
verdict = order_verdict(in_space.climb_of("fv"))
print(verdict.outcome, verdict.ours)
"""
"""The verdict on the volumes' order, in slabs whose impedance is off by a factor."""

EXTENDING, REPORT = sections("extending.md"), sections("reading-the-report.md")


@pytest.fixture
def reader(tmp_path):
    return Reader(tmp_path)


@pytest.mark.slow
def test_a_friction_law(reader):
    """Its models are as far apart as the paper's; a cut-off weakens healing, and shortens the cycle."""
    program, fault = EXTENDING["Adding a friction law of your own"].split("\nIf one is wrong")
    reader.follow(program)
    assert len(reader.changed) == 1
    periods = {line.split(":")[0]: float(line.split()[2]) for line in reader.output.splitlines() if ": period" in line}
    assert set(periods) == {"fd", "kelvin-voigt"}
    assert 60 < periods["kelvin-voigt"] < periods["fd"] < 73.4
    reader.follow(fault)


def test_an_outer_face(reader):
    """Two files: the face and its keys. It is then a machine of the same numbers, in SI too."""
    reader.follow(EXTENDING["Adding an outer face"])
    assert reader.changed == {"slipwave/scene/slab.py", "slipwave/input/schema.py"}
    for scene, stiffness, mass in (("paper", "2", "0.1"), ("paper-si", "5e7", "2")):
        given = {"stiffness": stiffness, "mass": mass}
        faces = ({"kind": "bolt"} | given, {"kind": "machine", "impedance": "0"} | given)
        words = (" ".join(f"--set slab.face.{key}={value}" for key, value in face.items()) for face in faces)
        bolt, machine = reader.json(*(f"stability {scene} {face}" for face in words))
        for key in ("log10_r_c", "leading_roots", "si"):
            assert bolt.get(key) == machine.get(key)
    bolt = "{'face.kind': 'bolt', 'face.stiffness': 5e7, 'face.mass': 2.0}"
    ask = f"print(over_range('slab.face.stiffness=4e7:5e7', slipwave.read('paper-si', {bolt})).si_unit)"
    assert reader.run(f'python -c "import slipwave; from validation.models.parameter import over_range; {ask}"') == 0
    assert reader.output == "Pa/m\n"
    wrong = "--set slab.face.kind=bolt --set slab.face.mass=0 --set slab.face.stiffness=0"
    assert reader.run(f"slipwave run paper {wrong}") == 2
    assert "slab.face.stiffness = 0: must be a number from 1e-09" in reader.output


def test_a_viscosity(reader):
    """Two files: the solid and its keys. It is then a standard linear solid of the same numbers, in SI and in every kind of
    model; where its times are the same, it is elastic, also to the model that knows no viscosity."""
    reader.follow(EXTENDING["Adding a viscosity"])
    assert reader.changed == {"slipwave/scene/slab.py", "slipwave/input/schema.py"}
    ours, theirs, elastic = (
        " ".join(f"--set slab.viscosity.{key}={value}" for key, value in given.items())
        for given in (
            {"kind": "two-times", "early": "1ms", "late": "2ms"},
            {"kind": "standard-linear", "time": "1ms", "ratio": "1"},
            {"kind": "two-times", "early": "1e-3", "late": "1e-3"},
        )
    )
    models = ("quasidynamic", "fitted:4", "fd", "dg:5", "sbp:4 --time explicit")
    commands = ("stability paper-si", *(f"run paper-si --until 20 --model {model}" for model in models))
    found = [reader.json(*(f"{command} {viscosity}" for command in commands)) for viscosity in (ours, theirs)]
    assert found[0][0]["leading_roots"] == found[1][0]["leading_roots"]
    assert found[0][0]["si"] == found[1][0]["si"]
    for one, other in zip(found[0][1:], found[1][1:], strict=True):
        assert one["final"] == other["final"]
    plain, same = reader.json("run paper --until 20", f"run paper --until 20 {elastic}")
    assert (same["model"], same["final"]) == ("delay", plain["final"])


def test_a_reduction(reader):
    reader.follow(EXTENDING["Adding an ODE reduction"])
    assert len(reader.changed) == 2
    compared, alone = reader.json("compare paper --models block8,block10,block12 --until 4000", "stability paper --model block10")
    light, middle, heavy = (row["period"]["mean"] for row in compared["models"])
    assert light < middle < heavy
    assert alone["model"] == "block10"
    assert reader.run("slipwave run --help") == 0
    assert "block10" in reader.output


@pytest.mark.slow
def test_a_discretisation(reader):
    reader.follow(EXTENDING["Adding a discretisation"])
    assert reader.changed == {"finite_volume.py", "pyproject.toml"}
    words = ("delay", "fv --family finite_volume.py --cells 200", "fv --family finite_volume.py --cells 400")
    exact, *found = (run["final"]["psi"] for run in reader.json(*(f"run paper --until 12 --model {model}" for model in words)))
    coarse, fine = (abs(psi - exact) for psi in found)
    assert coarse / fine == pytest.approx(2.0, rel=0.1)
    assert reader.run("slipwave run viscous --until 1 --family finite_volume.py --model fv") == 2
    assert "'fv': cannot do Kelvin-Voigt viscosity" in reader.output
    right, wrong = (reader.run(f"python -c '{JUDGE}' {factor}") or reader.output for factor in (1.0, 1.01))
    assert right.startswith("pass 0.97")
    assert wrong.startswith("fail")


def test_an_observer(reader):
    """In one file; in two if `slipwave run` is to show it by name. Numbers of numpy are figures too."""
    reader.follow(EXTENDING["Adding an observer"])
    assert reader.changed == {"slip.py", "slipwave/observe/excess.py", "slipwave/scene/recorded.py"}
    more = '{"slip": self._slip, "count": np.int64(3), "late": np.bool_(True), "never": None}'
    reader.change("slipwave/observe/excess.py", '{"slip": self._slip}', more)
    run = 'run paper --until 2000 --set \'run.record=["events", "excess"]\' --checkpoint run.npz --out run.nc'
    found = reader.json(run)[0]["observed"]["excess"]["slip"]
    assert found == pytest.approx(0.00209 * 2000 * 100 * 0.8, rel=0.25)
    assert reader.run("slipwave show run.nc") == 0
    assert f"# excess_slip = {found}" in reader.output


def test_a_scene_key(reader):
    """Three files, of which a command writes the third."""
    before = (reader.folder / "README.md").read_text()
    reader.follow(EXTENDING["Adding a scene key"])
    assert reader.changed == {"slipwave/input/schema.py", "slipwave/input/assemble.py"}
    row = "| `drive.factor` | by which every velocity is multiplied | 1e-9..1e9 |"
    assert (reader.folder / "README.md").read_text().replace(f"{row}\n", "") == before
    half, plain = reader.json("stability paper --set factor=0.5", "stability paper --set V=50")
    assert half == plain


def test_an_option(reader):
    reader.follow(EXTENDING["Adding an option"])
    assert len(reader.changed) == 1
    assert reader.run("slipwave show run.nc") == 0
    assert '"remark": "sample 7"' in reader.output
    assert reader.json("run run.nc")[0]["notes"] == ["sample 7"]


def test_a_command(reader):
    """Two files: its own, and the list of what `import slipwave` offers. It is in its place in all that lists commands."""
    reader.follow(EXTENDING["Adding a command"])
    assert reader.changed == {"validation/commands/clocks.py", "slipwave/__init__.pyi"}
    plain, physical = reader.json("clocks paper --transits 2", "clocks paper-si --transits 2")
    assert plain["friction_time"] == pytest.approx(2 * 10**-2.68)
    assert physical["time_s"] > 0.0
    assert reader.run("slipwave --help") == 0
    told = [line.split(maxsplit=1) for line in reader.output.partition("Commands:\n")[2].splitlines()]
    names = [name for name, *_ in told if name in {*COMMANDS, "clocks"}]
    assert names == [*list(COMMANDS)[:-3], "clocks", *list(COMMANDS)[-3:]]
    assert ["clocks", "How long transits of a scene are, on the friction clock and in"] in told
    assert reader.run("slipwave clocks --help") == 0
    assert "--transits" in reader.output
    assert "slipwave clocks paper-si --transits 1000" in reader.output
    assert reader.run("python -c 'import slipwave; print(*dir(slipwave))'") == 0
    assert "clocks" in reader.output.split()


def test_a_study(reader):
    assert "reading-the-report.md" in EXTENDING["Adding a study"]
    reader.follow(REPORT["Adding a study"])
    assert len(reader.changed) == 2
    assert "Does the stress drop depend on the drive?" in (reader.folder / "reports" / "index.html").read_text()


def test_every_section_is_done_by_a_test():
    done = "a friction law of your own|an outer face|a viscosity|an ODE reduction|a discretisation|an observer|a scene key"
    assert set(EXTENDING) | set(REPORT) == {f"Adding {what}" for what in [*done.split("|"), "an option", "a command", "a study"]}

"""What pages and help texts say is what the program does; every page is listed, every link leads somewhere."""

import contextlib
import io
import json
import math
import re
import runpy
import shlex
import subprocess
import sys
from decimal import Decimal
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
from typer.main import get_command

import slipwave
from slipwave.family import ANYTHING, FEATURES, NOTHING
from slipwave.input.overrides import parse_toml
from slipwave.observe.verdict import REPEATING, Kind
from slipwave.sources import ROOT
from tests.validation.answer import PAGES as ANSWERED
from tests.validation.answer import block_of, read_table, with_block
from validation.commands.cli import COMMANDS, app, main
from validation.models.by_name import FAMILIES
from validation.studies.which_model import ORBITS, SHOWN
from validation.sweep.map_figures import SIZES

BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.S)
FILE = re.compile(r"Write `([^`]+)`:\s*$")
ROOMS = ("slipwave", "reduced", "fullwave", "validation")
LONG = ("first-sample.md", "unlike-slabs.md", "what-moves-a-cycle.md")


def steps(page):
    """(kind, content, words before) of every block."""
    words, *rest = BLOCK.split((ROOT / "docs" / page).read_text(encoding="utf-8"))
    return list(zip(rest[::3], rest[1::3], [words, *rest[2::3]], strict=False))


def printed_by(kind, content, names):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        if kind == "python":
            exec(content, names)
        else:
            for line in content.splitlines():
                program, *arguments = shlex.split(line, comments=True)
                if program == "slipwave":
                    main(arguments)
                else:
                    assert program == "python"
                    (script,) = (ROOT / "docs").rglob(arguments[0])
                    out.write(subprocess.run([sys.executable, script, *arguments[1:]], capture_output=True, text=True).stdout)
    return out.getvalue()


PRINTED = re.compile(r"(\d+\.\d+(?:e[+-]?\d+)?)")


def says(line, shown):
    """Whether a printed `line` is the one that a page shows; the rounding of another processor may move a last digit by one."""
    if PRINTED.split(shown)[::2] != PRINTED.split(line)[::2]:
        return False
    pairs = zip(PRINTED.findall(shown), PRINTED.findall(line), strict=True)
    return all(abs(Decimal(one) - Decimal(other)) <= Decimal((0, (1,), Decimal(one).as_tuple().exponent)) for one, other in pairs)


ELSEWHERE = ("extending.md", "reading-the-report.md", "install.md")  # done by `test_documented_extensions.py`, or by pip
TEXTS = {path.name: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"))}
PAGES = [page for page, text in TEXTS.items() if re.search("```text|```sh\nslipwave", text) and page not in ELSEWHERE]


@pytest.mark.parametrize("page", [pytest.param(page, marks=[pytest.mark.slow] * (page in LONG)) for page in PAGES])
def test_a_page_does_what_it_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    printed, shown = "", 0
    for kind, content, words in steps(page):
        if found := FILE.search(" ".join(words.split())):
            Path(found[1]).write_text(content)
        elif kind in ("sh", "python"):
            printed = printed_by(kind, content, names)
        elif kind == "text":
            lines = ["...", *printed.splitlines()]
            assert [shown for shown in content.splitlines() if not any(says(line, shown) for line in lines)] == [], printed
            shown += 1
    assert shown


def test_the_machine_of_a_data_sheet_is_that_of_the_gallery():
    (table,) = [content for kind, content, _ in steps("testing-machine.md") if kind == "toml"]
    given = parse_toml(table)["upper"]["face"]
    assert slipwave.read("steel-on-pmma", {"upper.face": given}).upper == slipwave.read("steel-on-pmma").upper


MARKED = re.compile(r"([\w.+-]+)<!--(.+?)-->")
WORDS = {"eight": 8.0, "sixteen": 16.0}
NUMBER = re.compile(r"(?<![\w.:=-])\d[\d.]*(?:e-?\d+)?(?![\w:]|\.\d)")
HELP = {
    "run --fields": "validation.models.run.FIELD_WINDOW",
    "run --checkpoint-every": "validation.models.run._EVERY",
    "orbit --tol": "validation.commands.orbit.ORBIT_TOLERANCE",
    "branch --tol": "validation.commands.branch.BRANCH_TOLERANCE",
    "branch --most-points": "validation.commands.branch.BRANCH_POINTS",
    "curve --tol": "validation.commands.branch.BRANCH_TOLERANCE",
    "curve --most-points": "validation.commands.curve.CURVE_POINTS",
    "sweep --refine": "2.0",
    "sweep --until": "validation.sweep.measures.TRANSITS",
}
RANGES = {"--cfl": {0.0, 1.0}, "--size": set(SIZES.values())}
"""Several numbers; the ends of --cfl are refused or taken in `tests/fullwave`."""


def value(expression):
    """Of constants by their full names, and what is computed from them."""

    def constant(name):
        module, _, attribute = name[0].rpartition(".")
        return repr(getattr(import_module(module), attribute))

    return float(eval(re.sub(r"[a-z]\w*(?:\.\w+)+", constant, expression)))


def number(text):
    return WORDS[text] if text in WORDS else float(text)


MARKED_PAGES = sorted(page for page in (ROOT / "docs").glob("*.md") if MARKED.search(page.read_text(encoding="utf-8")))


@pytest.mark.parametrize("page", MARKED_PAGES, ids=lambda page: page.name)
def test_numbers_of_a_page_are_those_of_the_program(page):
    marked = MARKED.findall(page.read_text(encoding="utf-8"))
    assert [(text, name) for text, name in marked if number(text) != pytest.approx(value(name), rel=1e-12)] == []


def test_numbers_of_help_texts_are_those_of_the_program():
    commands = {name: get_command(app).get_command(None, name) for name in COMMANDS}
    told = {}
    for name, command in commands.items():
        for option in command.params:
            found = {float(text) for text in NUMBER.findall(option.help or "")}
            if found and found != RANGES.get(option.opts[0]):
                told[f"{name} {option.opts[0]}"] = found
    assert told == {key: {value(name)} for key, name in HELP.items()}


PAGE = (Path(__file__).parents[3] / "docs" / "what-a-run-says.md").read_text(encoding="utf-8")


def rows(heading):
    """Cells of the first table below a heading."""
    lines = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")]


def test_every_verdict_has_a_row_that_says_whether_it_has_means():
    found = {row[0].strip("`"): row[2] for row in rows("The verdict")}
    assert set(found) == set(get_args(Kind))
    assert {kind for kind, means in found.items() if means != "none"} == set(REPEATING)


def test_every_key_has_a_row(printed):
    """Of a run on a default grid that rounding has a share in, so that `grid` and `notes` are there."""
    printed = set(json.loads(printed("run", "paper", "--model", "dg:7", "--until", "10", "--json", "--set", "slab.r=0.1")))
    documented = {key for row in rows("The JSON of `run --json`") for key in re.findall("`(\\w+)`", row[0])}
    assert documented == printed | {"failed", "si", "left_out", "lyapunov", "protocol"}


README = Path(__file__).parents[3] / "README.md"


def row(family):
    numbers, letter = family.numbers, family.pattern[-1]
    told = f"{numbers[0]} to {numbers[-1]}" if isinstance(numbers, range) else ", ".join(map(str, numbers))
    name = f"`{family.pattern}`" + (f", {letter} = {told}" if numbers else "")
    scenes = {ANYTHING: "all", NOTHING: "two alike, plain slabs"}.get(family.honours)
    return f"| {name} | {family.title} | {family.error} | {scenes or ', '.join(f for f in FEATURES if f in family.honours)} |"


def test_the_table_of_models_is_read_from_the_facts():
    table = [
        "| name | what it is | error | scenes |",
        "|---|---|---|---|",
        *(row(family) for family in FAMILIES),
        "| `auto` | the first of these that is exact for the scene (default) | | all |",
    ]
    assert "\n".join(table) in README.read_text(encoding="utf-8")


BASELINE = json.loads((ROOT / "reports" / "baseline" / "which-model.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", ANSWERED, ids=lambda path: path.name)
def test_the_committed_block_is_that_of_the_committed_table(page):
    text = page.read_text(encoding="utf-8")
    assert with_block(text, block_of(read_table())) == text
    with pytest.raises(ValueError, match="no markers"):
        with_block("# A page", "block")


@pytest.mark.parametrize("model", ORBITS)
def test_the_committed_table_has_the_numbers_of_the_baseline(model):
    table = read_table()
    cells = {column.log10_r: cell for column, cell in zip(table.columns, table.row(model).cells, strict=True)}
    for log10_r in SHOWN:
        (found,) = (cell for place, cell in cells.items() if abs(place - log10_r) < 1e-9)
        for symbol, name in (("T", "T"), ("Δμ", "drop")):
            assert found.figures[symbol].error == pytest.approx(
                BASELINE[f"{model} error of {name} at {log10_r}"]["value"], rel=1e-2
            )


def our_file(frame):
    """The file of a function of ours, relative to the checkout; empty for any other."""
    name = frame.f_code.co_filename.removeprefix(f"{ROOT}/")
    return name if name.startswith(ROOMS) else ""


def is_import(frame):
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


def test_every_folder_of_the_rooms_is_in_the_table_of_the_house():
    table = README.read_text(encoding="utf-8").partition("## The packages")[2].partition("\n## ")[0]
    named = set()
    for row in re.findall(r"^\| (`.*?) \|", table, re.M):
        first, *others = re.findall(r"`([\w/*.]+)`", row)
        named |= {first, *others, *(f"{first.partition('/')[0]}/{other}" for other in others)}
    folders = {path.parent.relative_to(ROOT) for room in ROOMS for path in (ROOT / room).glob("*/*.py")}
    assert {str(folder) for folder in folders} - named == set()


def test_the_walk_is_no_longer_than_it_is_written(printed):
    """(file that calls, file that is called) from the command line to the printed table; it climbs back at most three times."""
    calls = set()

    def note(frame, event, argument):
        called = our_file(frame) if event == "call" else ""
        if called and not is_import(frame):
            caller = frame.f_back
            while caller is not None and not our_file(caller):
                caller = caller.f_back
            calls.add((our_file(caller) if caller else "", called))

    printed("run", "paper")  # what is compiled is loaded from the disk
    sys.setprofile(note)
    try:
        printed("run", "paper")
    finally:
        sys.setprofile(None)
    calls = {(caller, called) for caller, called in calls if caller != called}
    section = (ROOT / "docs" / "design.md").read_text(encoding="utf-8").partition("## The walk of a run")[2].partition("\n## ")[0]
    touched = {called for _, called in calls}
    listed = set(re.findall(r"`((?:validation|slipwave|reduced)/[\w/]+\.py)`", section))
    assert {file for file in touched if file.startswith("validation/")} <= listed <= touched
    most, ours, onwards = (int(number) for number in re.findall(r"\*\*(\d+)\*\*", section))
    assert len(touched) <= most
    assert sum(file.startswith("validation/") for file in touched) <= ours
    assert len({caller for caller, _ in calls} - {""}) <= onwards
    assert len({pair for pair in calls if not pair[0].startswith("validation/") and pair[0] and pair[1].startswith("valid")}) <= 3


DOCS = ROOT / "docs"
SITE_PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))


def test_every_page_is_in_the_navigation_once():
    navigation = (ROOT / "mkdocs.yml").read_text().split("nav:\n")[1].split("\n\n")[0]
    assert sorted(re.findall(r": (\S+\.md)$", navigation, re.M)) == SITE_PAGES


@pytest.mark.parametrize("page", [*(f"docs/{page}" for page in SITE_PAGES), "README.md", "CONTRIBUTING.md"])
def test_links_lead_to_files(page):
    text = re.sub(r"```.*?```", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.S)
    links = [link for link in re.findall(r"\]\(([^)\s#]+\.\w+)", text) if "://" not in link]
    assert [link for link in links if not ((ROOT / page).parent / link).exists()] == []


def test_the_page_of_slipwave_has_every_function_that_it_offers():
    """By the place where each is written; names that begin with _ are left out of all pages."""
    page = (DOCS / "code" / "slipwave.md").read_text()
    functions = [getattr(slipwave, name) for name in slipwave.__all__ if name not in ("NumericsError", "SceneError", "read")]
    assert [one.__name__ for one in functions if f"::: {one.__module__}.{one.__name__}\n" not in page] == []
    assert 'filters: ["!^_"]' in (ROOT / "mkdocs.yml").read_text()


@pytest.mark.parametrize("room", ["slipwave", "reduced", "fullwave", "validation"])
def test_every_room_has_a_page_of_its_code(room):
    assert f"::: {room}\n" in (DOCS / "code" / f"{room}.md").read_text()


BIAS = SimpleNamespace(**runpy.run_path(str(ROOT / "examples" / "bias" / "bias.py")))


@pytest.mark.parametrize("mass", BIAS.MACHINES)
def test_a_sample_has_its_swing_its_stiffness_and_its_mass(mass):
    """The slowest swing: K - m w^2 = rho c w tan(w h/c); without a machine w h/c = pi/2."""
    held, alone = BIAS.scenes(BIAS.Point(0.3, 5.0, mass))
    slab = held.tables["slab"]
    speed, rate = math.sqrt(slab["shear_modulus"] / slab["density"]), 2.0 * math.pi / 0.3
    angle = rate * slab["thickness"] / speed
    if not mass:
        assert angle == pytest.approx(0.5 * math.pi)
    else:
        face = slab["face"]
        assert face["mass"] == pytest.approx(mass * slab["density"] * slab["thickness"])
        left = face["stiffness"] - face["mass"] * rate**2
        assert left == pytest.approx(slab["density"] * speed * rate * math.tan(angle))
    assert (held.stiffness / held.transit, held.impedance) == pytest.approx((alone.stiffness / alone.transit, alone.impedance))
    assert held.stiffness / held.transit == pytest.approx(5.0 * (0.015 - 0.01))


def test_the_record_says_what_the_page_on_fits_says():
    rows = BIAS.recorded()
    rules = {model: BIAS.limit(rows, model) for model in BIAS.MODELS}
    assert rules == pytest.approx({"quasistatic": 0.042, "quasidynamic": 0.0089, "block12": 0.057}, rel=1e-2)
    slips = {model: [row for row in rows if row["model"] == model and row["kappa"] < 1.0] for model in BIAS.MODELS}
    of_length = {model: float(np.median([abs(row["error L"]) for row in found])) for model, found in slips.items() if found}
    assert of_length == pytest.approx({"quasidynamic": 0.58, "block12": 0.29}, abs=0.01)
    for model in of_length:
        assert max(abs(row["error k"]) for row in slips[model]) < 0.03
        assert all(max(abs(row[f"error {q}"]) - row[f"half {q}"] for q in "abL") > 0.0 for row in slips[model])
    page = (ROOT / "docs" / "fit.md").read_text(encoding="utf-8")
    assert [words for words in ("Below 4 %", "0.9 % for the quasi-dynamic", "58 % in L", "29 %") if words not in page] == []


@pytest.mark.slow
def test_a_part_computed_anew_is_what_is_recorded():
    chosen = [BIAS.Point(BIAS.SWINGS[5], 5.0, 10.0), BIAS.Point(BIAS.SWINGS[5], 0.5, 0.0)]
    for new in BIAS.rows_of(chosen):
        [old] = [row for row in BIAS.recorded() if [row[key] for key in ("model", "swing", "kappa", "mass")] == new[:4]]
        errors, widths = list(old.values())[4:8], list(old.values())[8:]
        assert new[4:8] == pytest.approx(errors, abs=2e-3, rel=0.05)
        assert new[8:] == pytest.approx(widths, abs=2e-3, rel=0.15)  # 12 % between two processors

"""The benchmark for other programs: page and table agree, both programs compute a part again, `score.py` counts digits."""

import csv
import hashlib
import math
import re
import subprocess
import sys
from importlib import import_module
from types import SimpleNamespace

import pytest

import slipwave as sw
from slipwave.sources import ROOT
from validation.references.others import sem2dpack

FOLDER = ROOT / "docs" / "benchmark"


def table_of(name):
    with (FOLDER / name).open(newline="") as stream:
        return {row["id"]: (float(row["value"]), float(row["bar"])) for row in csv.DictReader(stream)}


KNOWN, PAIRS = table_of("benchmark.csv"), table_of("pairs.csv")

FROZEN = "e5d57a93c6dab8010a33f4c3dc2fc8a2bab4a01c2b92feabb9bb92ee88ab1988"
"""Of benchmark.csv: numbers that others have compared with do not change."""


@pytest.fixture(scope="module")
def values():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FOLDER)
        yield import_module("values")


def astray(found, known=KNOWN):
    """Names of values that lie outside the bars of the table."""
    return [name for name, value in found if not abs(value - known[name][0]) <= known[name][1]]


def test_the_page_and_the_table_are_one():
    page = (ROOT / "docs" / "benchmark.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| ([a-z][\w-]*\.\S+) \| (\S+) \| (\S+) \| \S+ \|$", page, re.M)
    assert {name: (float(value), float(bar)) for name, value, bar in shown} == KNOWN
    points = {name.rpartition(".")[0] for name in KNOWN if name.endswith(".log10_r")}
    assert len(points) == 12


def test_pairs_on_the_page_are_those_of_their_table(values):
    page = (ROOT / "docs" / "benchmark.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| (one-pair|pair-\S+|leaking-\S+) \| (\S+) \| (\S+) \| (\S+) \| (.+) \|$", page, re.M)
    assert [name for name, *_ in shown] == [*values.PAIRS]
    for name, q, p, share, cells in shown:
        assert [float(q), float(p), float(share)] == pytest.approx([*values.PAIRS[name][:3]], abs=5e-5)
        whats = ("period", "onset.log10_r", "fold.log10_r", "torus.log10_r")
        for what, cell in zip(whats, cells.split(" | "), strict=True):
            assert cell == (f"{PAIRS[key][0]:.10f}" if (key := f"{name}.{what}") in PAIRS else "")


def test_two_programs_agree_on_pairs_to_the_digits_asked_for():
    """Orbits to 1e-9, folds and Hopf points to 1e-8, torus points to 1e-6, and far nearer."""
    nearest = {name: bar for name, (_, bar) in PAIRS.items() if name.endswith(".log10_r")}
    assert len(nearest) == 21
    assert max(nearest.values()) < 1e-11
    assert all(bar < 1e-11 * value for name, (value, bar) in PAIRS.items() if name.count(".") - name.count("0.") == 1)


def test_slabs_of_equal_round_trips_are_one_pair(values):
    for name in ("period", "stress_drop", "v_max", "v_min"):
        assert PAIRS[f"one-pair.{name}"][0] == pytest.approx(KNOWN[f"orbit.{name}"][0], rel=1e-12)
    for name in ("onset", "fold"):
        known = KNOWN["onset.log10_r" if name == "onset" else "fold.1.log10_r"][0]
        upper = math.log10(values.upper_r("one-pair")) + 2.68
        assert PAIRS[f"one-pair.{name}.log10_r"][0] - upper == pytest.approx(known, abs=1e-11)


def test_the_second_program_shares_nothing_with_slipwave_and_the_score_needs_nothing():
    def imported_by(name):
        lines = re.findall(r"^(?:import|from) (\S+)", (FOLDER / name).read_text(), re.M)
        return {line.partition(".")[0] for line in lines}

    assert imported_by("second_program.py") == {"collections", "typing", "numpy"}
    assert imported_by("score.py") == {"csv", "math", "sys", "pathlib"}
    assert len((FOLDER / "score.py").read_text().splitlines()) <= 160


def test_the_table_is_the_one_that_was_frozen():
    digest = hashlib.sha256((FOLDER / "benchmark.csv").read_bytes()).hexdigest()
    assert digest == FROZEN


@pytest.mark.parametrize("program", ["psi_of", "psi_of_second"])
def test_psi_after_each_start_is_that_of_both_programs(program, values, monkeypatch):
    """At the times up to 40 transits."""
    short = {name: (*start, tuple(t for t in times if t <= 40.0)) for name, (*start, times) in values.STARTS.items()}
    monkeypatch.setattr(values, "STARTS", short)
    found = [pair for start in short for pair in getattr(values, program)(start)]
    assert len(found) == 7
    assert astray(found) == []


@pytest.mark.parametrize("second", [False, True])
def test_psi_in_other_slabs_and_laws_is_that_of_both_programs(second, values, monkeypatch):
    monkeypatch.setattr(values, "SCENES_AT", (8.0, 20.0))
    found = [pair for scene in values.SCENES for pair in values.psi_in(scene, second)]
    assert len(found) == 14
    assert astray(found) == []


def test_the_onset_is_that_of_the_closed_form(values):
    assert astray(zip(("onset.log10_r", "onset.period"), values.other.onset(), strict=True)) == []


@pytest.mark.slow
def test_orbit_and_multipliers_are_those_of_both_programs(values, monkeypatch):
    monkeypatch.setattr(values, "STARTS", {})
    monkeypatch.setattr(values, "SCENES", {})
    orbit = sw.orbit("paper", model="delay", tol=1e-11)
    onset = {"onset": SimpleNamespace(log10_r=KNOWN["onset.log10_r"][0], period=KNOWN["onset.period"][0])}
    for program in (values.by_slipwave, values.by_second):
        found = list(program(orbit, onset))
        assert len(found) == 10
        assert astray(found) == []


@pytest.mark.parametrize("time", [8.0, 20.0])
def test_psi_of_unlike_slabs_is_that_of_two_delay_lines(time, values):
    """The frozen values are those of full waves. Round trips of 2 : 1 and of sqrt(2) : 1, where no panel returns whole."""
    for name, r, trips in (("unlike", 0.00244, 2.0), ("unlike-irrational", 0.00275, math.sqrt(2.0))):
        mesh = values.other.Mesh(8, 16, (values.other.Line(2.8e-5), values.other.Line(8.4e-5, trips)))
        found = values.other.psi_at(mesh, r, [time], nudge=0.5)
        assert astray([(f"{name}.psi.{time:g}", found[0])]) == []


def test_onsets_of_pairs_are_those_of_the_characteristic_equation(values):
    for pair in values.PAIRS:
        names = [f"{pair}.onset.{what}" for what in ("log10_r", "period")]
        guess = PAIRS[names[0]][0] + 0.01, PAIRS[names[1]][0] + 1.0
        assert astray(zip(names, values.other.hopf(values.lines_of(pair), *guess), strict=True), PAIRS) == []


@pytest.mark.slow
@pytest.mark.parametrize("pair", ["one-pair", "pair-2", "pair-root2", "leaking-0.9985"])
def test_orbits_and_points_of_pairs_are_those_of_both_programs(pair, values):
    found = values.orbit_of(pair), values.points_of(pair)
    for program in (values.pair_by_slipwave, values.pair_by_second):
        known = list(program(pair, *found))
        assert len(known) == sum(name.startswith(f"{pair}.") for name in PAIRS)
        assert astray(known, PAIRS) == []


@pytest.mark.slow
def test_a_curve_of_torus_points_behind_leaking_faces_is_that_of_the_second_program(values):
    """Of a pair, over the share 1 - R that its faces lose: some points of slipwave's curve, each found anew."""
    scene, point = values.as_scene("leaking-0.999"), values.points_of("leaking-0.999")["torus"]
    leaks = {f"{slab}.face.coefficient": "1 - leak" for slab in ("upper", "lower")}
    over = {"log10_r": (point.log10_r - 0.02, point.log10_r + 0.02)}
    curve = sw.curve(scene, "NS", over, {"leak": (0.001, 0.003)}, set=leaks, model="delay", most_points=16)
    points = curve.summary["points"][::5]
    assert len(points) == 4
    line, start = values.lines_of("leaking-0.999"), None
    for one in points:
        mesh = values.other.Mesh(6, 14, tuple(each._replace(share=1.0 - one["leak"]) for each in line))
        start = values.as_start(sw.orbit(point), mesh) if start is None else start
        place, period = values.other.special(mesh, "torus", 10.0 ** one["log10_r"], one["period"], start)
        assert place == pytest.approx(one["log10_r"], abs=1e-9)
        assert period == pytest.approx(one["period"], abs=1e-6)


@pytest.mark.slow
def test_points_of_the_branch_behind_leaking_faces_are_those_of_the_second_program(values):
    """A fold and a torus point behind faces of R = 0.999, found by both: far nearer than 1e-8 and 1e-6."""
    mesh = values.other.Mesh(6, 14, (values.other.Line(share=0.999),))
    scene = sw.read("paper", {"slab.face.kind": "reflection", "slab.face.coefficient": 0.999})
    branch = sw.branch(scene, "log10_r=-2.72:-2.64", model="delay", tol=1e-9, longest_period=78.5)
    for kind, name in (("LP", "fold"), ("NS", "torus")):
        point = [one for one in branch.special if one.type == kind][-1]
        place, period = values.other.special(
            mesh, name, 10.0**point.log10_r, point.period, values.as_start(sw.orbit(point), mesh)
        )
        assert place == pytest.approx(point.log10_r, abs=1e-11)
        assert period == pytest.approx(point.period, abs=1e-6)


@pytest.fixture
def score(tmp_path):
    """Status and output of `score.py` on a table, in a process that sees no packages."""

    def scored(*texts, digits="6"):
        paths = [tmp_path / f"theirs{number}.csv" for number in range(len(texts))]
        for path, text in zip(paths, texts, strict=True):
            path.write_text(text, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-I", "-S", FOLDER / "score.py", *paths, digits], capture_output=True, text=True, cwd=tmp_path
        )
        return done.returncode, done.stdout, done.stderr

    return scored


THEIRS = "id,value\norbit.period,73.4721\norbit.v_max,4413\nfold.1.log10_r,-2.7002517033056\n"


def test_score_says_how_many_digits_are_right(score):
    """|4413/4412.32 - 1| is 1.5e-4: three digits; 73.4721 is off by 6e-7: six. Bars of 1e-12 leave twelve."""
    status, said, _ = score(THEIRS, digits="3")
    assert status == 0
    digits = {line.split()[0]: line.split()[2:5] for line in said.splitlines()[:3]}
    assert digits == {"orbit.period": ["6", "of", "12"], "orbit.v_max": ["3", "of", "12"], "fold.1.log10_r": ["12", "of", "12"]}
    assert said.endswith("3 of 3 rows have 3 digits right, or all in which the two programs agree\n")
    status, said, _ = score(THEIRS + "fold.1.perod,59.1\n")
    assert status == 3
    assert "is not in the benchmark\n" in said
    assert said.endswith("2 of 4 rows have 6 digits right, or all in which the two programs agree\n")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("id;value\na;1\n", "line 1: must be id,value, or the columns t, slip, slip_rate, shear_stress, state"),
        ("t slip state\n0 0 1\n1 0\n", "line 3: must have 3 numbers"),
        ("t state\n0 1\n1 1\n2 -1\n3 1\n", "a station needs four lines or more, times that rise, and states above 0"),
        ("id,value\norbit.period,x\n", "line 2: x is no number"),
        ("id,value\norbit.period,73.4721\norbit.v_max,nan\n", "line 3: nan is no number"),
        ('id,value\norbit.period,"73,4721"\n', "line 2: 73,4721 is no number"),
        ("id,value\norbit.period,73,4721\n", "line 2: must be an id and one number, with a decimal point and no comma"),
        ("id,value\n\norbit.period,1\norbit.period,2\n", "line 4: orbit.period is there twice"),
        ("id,value\n", "no row"),
    ],
)
def test_wrong_tables_are_refused_with_their_line(text, told, score):
    status, said, error = score(text)
    assert (status, said) == (2, "")
    assert error.endswith(f": {told}\n")
    assert error.count("\n") == 1


with (FOLDER / "others" / "sem2dpack.csv").open(newline="") as stream:
    SEM2DPACK = list(csv.DictReader(stream))


def runs_of(scheme, *steps):
    """Tables of another program's runs."""
    wanted = [[row for row in SEM2DPACK if (row["scheme"], row["steps_per_transit"]) == (scheme, str(one))] for one in steps]
    return ["name,value\n" + "".join(f"{row['id']},{row['value']}\n" for row in rows) for rows in wanted]


def test_runs_at_halved_steps_are_extrapolated_and_stages_pass(score):
    """Digits that the notes of the runs state: all that are known of the smooth start, 11 and more of unlike slabs."""
    status, said, _ = score(*runs_of("newmark", 400, 800, 1600), digits="10")
    assert status == 3
    lines = dict(line.split(": ") for line in said.splitlines() if "passes" in line or "misses" in line)
    passed = {stage for stage, words in lines.items() if words.startswith("passes")}
    assert passed == {"smooth start", "unlike slabs", "layered slabs", "reflecting faces"}
    assert "smooth.psi.20              -3.729267484199237  12 of 12 digits, extrapolated at order 2.00\n" in said
    assert "usually" not in said


def test_a_scheme_of_the_first_order_is_named(score):
    _, said, _ = score(*runs_of("leapfrog", 200, 400, 800))
    assert "extrapolated at order 1.00" in said
    assert "this usually means: order 1: friction takes the slip rate half a step late" in said


with (FOLDER / "mistakes.csv").open(newline="") as stream:
    MISTAKEN = list(csv.DictReader(stream))


@pytest.mark.parametrize("mistake", sorted({row["mistake"] for row in MISTAKEN}))
def test_a_mistake_is_named_and_no_other(mistake, score):
    rows = [(row["id"], float(row["value"]) * (1.0 + 1e-9)) for row in MISTAKEN if row["mistake"] == mistake]
    _, said, _ = score("id,value\n" + "".join(f"{name},{value!r}\n" for name, value in rows))
    assert [line for line in said.splitlines() if "usually" in line] == [f"this usually means: as if {mistake}"]


def test_mistakes_are_as_they_are_computed(values, monkeypatch):
    monkeypatch.setattr(values, "MISTAKES_AT", (8.0, 20.0))
    known = {(row["id"], row["mistake"]): float(row["value"]) for row in MISTAKEN}
    for name, psi, mistake in values.mistaken():
        assert psi == pytest.approx(known[name, mistake], rel=1e-11)


def test_a_station_file_is_read_as_it_is(score):
    run = sw.run("paper", "delay", until=21.0, tol=1e-10, interface=True).dataset
    columns = zip((run["time"].values * 10.0**-2.68).tolist(), run["interface_psi"].values.tolist(), strict=True)
    lines = [f"{time!r} 0 1e-6 1e5 {math.exp(psi)!r}" for time, psi in dict(columns).items()]
    _, said, _ = score("# a run\nt slip slip_rate shear_stress state\n" + "\n".join(lines) + "\n", digits="9")
    assert said.endswith(
        "smooth start: passes (4 of 4 rows)\n4 of 4 rows have 9 digits right, or all in which the two programs agree\n"
    )


@pytest.mark.parametrize(
    ("name", "within"), [*((f"smooth.psi.{t}", 1e-12) for t in (6, 8, 12, 20, 40, 100, 400)), ("orbit.period", 1e-10)]
)
def test_its_extrapolated_values_are_those_of_the_frozen_table(name, within):
    assert 0.0 < abs(sem2dpack()[name] / KNOWN[name][0] - 1.0) < within


def test_values_of_continuation_programs_have_all_their_digits():
    """Half of a unit of the last digit that is written; for log10 r that of the bar of the frozen table, if that is larger."""
    with (FOLDER / "others" / "continuation.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    for row in rows:
        half = 0.5 * 10.0 ** -len(row["value"].partition(".")[2])
        value, bar = KNOWN[row["id"]]
        assert abs(float(row["value"]) - value) <= 1.2 * half + bar, row

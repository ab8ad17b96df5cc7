"""The frozen benchmark: its page and both files agree, a part is computed again by both programs, `slipwave score` compares."""

import json
import re

import pytest

import slipwave as sw
from slipwave.errors import SceneError
from slipwave.sources import ROOT
from validation.cli import main
from validation.frozen import values
from validation.frozen.values import FILE, PAGE, frozen


def test_the_page_and_both_files_are_one():
    assert FILE.read_bytes() == PAGE.read_bytes()
    page = (ROOT / "docs" / "benchmark.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| ([a-z]\w*\.\S+) \| (\S+) \| (\S+) \|", page, re.M)
    assert [(name, float(value), float(bar)) for name, value, bar in shown] == [row[:3] for row in frozen().values()]
    points = {name.rpartition(".")[0] for name in frozen() if name.endswith(".log10_r")}
    assert len(points) == 12


def test_the_second_program_shares_nothing_with_slipwave():
    imports = re.findall(r"^(?:import|from) (\S+)", values.SECOND.read_text(), re.M)
    assert {name.partition(".")[0] for name in imports} == {"collections", "typing", "numpy"}


@pytest.mark.parametrize("program", [values.psi_of, values.psi_of_second])
def test_psi_after_each_start_is_that_of_both_programs(program, monkeypatch):
    """At the times up to 40 transits."""
    known = frozen()
    short = {name: (changes, tuple(t for t in times if t <= 40.0)) for name, (changes, times) in values.STARTS.items()}
    monkeypatch.setattr(values, "STARTS", short)
    found = [pair for start in short for pair in program(start)]
    assert len(found) == 7
    assert [name for name, psi in found if not abs(psi - known[name].value) <= known[name].bar] == []


def test_the_onset_is_that_of_the_closed_form():
    known, (log10_r, period) = frozen(), values.second_program().onset()
    assert abs(log10_r - known["onset.log10_r"].value) < known["onset.log10_r"].bar
    assert abs(period - known["onset.period"].value) < known["onset.period"].bar


@pytest.mark.slow
def test_orbit_and_multipliers_are_those_of_both_programs():
    from reduced.orbit.figures import figures_of
    from reduced.orbit.multipliers import floquet
    from validation.study.memo import own_orbit
    from validation.study.over_r import scene_at

    other, known = values.second_program(), frozen()
    near = own_orbit("delay", scene_at(-2.68), 1e-11).closed
    mesh = other.Mesh(5, 16)
    orbit = other.closed(mesh, 10.0**-2.68, near.cycle.period, values._as_start(other, mesh, near))
    one = values._of_orbit(near.cycle.period, figures_of(near), floquet(near.monodromy)[0])
    two = values._of_orbit(orbit.period, other.figures(mesh, orbit), orbit.multipliers)
    found = [*one, *two]
    assert len(found) == 16
    assert [name for name, value in found if not abs(value - known[name].value) <= known[name].bar] == []


def test_a_bar_is_three_times_the_distance_and_no_less_than_rounding():
    one, two = {"orbit.period": 70.0, "orbit.v_max": 4000.0}, {"orbit.period": 70.001, "orbit.v_max": 4000.0000000001}
    first, second = values.rows_of(one, two)
    assert (first.value, first.bar, first.digits) == (70.0005, 3e-3, 4)
    assert (second.bar, second.digits) == (4e-9, 12)


THEIRS = "id,value,remark\norbit.period,73.4721,ours\norbit.v_max,4413,\nfold.1.log10_r,-2.7002517033056,\n"


def test_score_says_how_many_digits_agree_and_what_is_missing_or_unknown(tmp_path, capsys, printed):
    path = tmp_path / "theirs.csv"
    path.write_text(THEIRS)
    out = printed("score", str(path), "--digits", "3")
    assert "3 of 3 rows agree to 3 digits or all that are certified; 1 within the bar" in out
    assert "missing, not judged: orbit.stress_drop, orbit.v_min" in out
    path.write_text(THEIRS + "fold.1.perod,59.1\n")
    assert main(["score", str(path), "--json"]) == 3
    done = capsys.readouterr()
    found = json.loads(done.out)
    assert [(row["id"], row["digits"], row["within_bar"], row["agrees"]) for row in found["rows"]] == [
        ("orbit.period", 6, False, True),
        ("orbit.v_max", 3, False, False),
        ("fold.1.log10_r", 12, True, True),
    ]
    assert found["unknown"] == ["fold.1.perod"]
    assert done.err == "slipwave: score: 2 rows do not agree: orbit.v_max, fold.1.perod\n"
    assert main(["score", str(path)]) == 3
    assert "'fold.1.perod' (did you mean fold.1.period?)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name,value\na,1\n", "must name the columns id and value"),
        ("id,value\norbit.period,x\n", "line 2: value = 'x': must be a number"),
        ("id,value\norbit.period,1\norbit.period,2\n", "line 3: 'orbit.period' is given twice"),
        ("id,value\na,1\n", "has no row of the benchmark"),
    ],
)
def test_wrong_files_are_refused_in_one_line(tmp_path, text, told):
    path = tmp_path / "theirs.csv"
    path.write_text(text)
    with pytest.raises(SceneError, match=told):
        sw.score(path)


def test_nan_and_infinity_do_not_agree(tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_text("id,value\norbit.period,nan\norbit.v_max,inf\n")
    assert [row["agrees"] for row in sw.score(path).summary["rows"]] == [False, False]

"""What is expected of a run, what is noted, and the reasons below its verdict, against values by hand."""

import json
import logging
import math

import pytest

import slipwave
from fullwave.finite_difference import Leapfrog
from reduced.stability import characteristic, leading_roots
from slipwave.errors import SceneError
from slipwave.scene.drive import Drive, steady_drive
from slipwave.solve import follow
from slipwave.solve.follow import DAY
from tests.granite import GRANITE, THIN
from validation.commands.cli import NUMERICS_FAILED, main
from validation.models import progress as module
from validation.models.build import build
from validation.models.cycle import watch
from validation.models.outlook import amplified_rounding, expected_period, growth_rate, is_stable
from validation.models.progress import LongRunAdvice, RemainingTime, progress, share_of_run
from validation.models.run import simulate


def told(*settings, until, scene="paper"):
    return list(slipwave.run(scene, "delay", until=until, settings=settings).summary["reasons"])


def test_a_stable_sample_says_what_would_make_it_slip():
    (line,) = told(until=5e4, scene=THIN)[-1:]
    assert line.endswith("it would slip with slabs over 6 m (here 200 mm) or a normal stress over 150 MPa (here 5 MPa)")
    assert "(8.92 s)" in line  # of the slower root of a s^2 + (a - b + k) s + k = 0, k = 0.15, on the clock of 10 s
    assert pytest.approx((0.145 - math.sqrt(0.145**2 - 4 * 0.01 * 0.15)) / 0.02, rel=1e-3) == 10.0 / 8.92


def test_a_run_that_fails_is_not_told_to_be_longer(capsys):
    """Before: try --until 1200, where the slip rate runs away at 773 transits whatever the end."""
    assert main(["run", "grip", "--model", "quasistatic", "--until", "800"]) == NUMERICS_FAILED
    told = capsys.readouterr()
    assert "too few cycles to judge; it failed before its end" in told.out
    assert "--until" not in told.out
    assert "it runs away" in told.err


def test_a_decaying_run_says_how_fast():
    """At r = 10^-2.75 the leading root decays by e in 228 transits, and so does the motion."""
    lines = told("slab.log10_r=-2.75", until=3000.0)
    assert lines[0] == "it changes by a factor e in 228 transits"
    assert lines[1].startswith(
        "steady sliding is stable; a disturbance decays by a factor e in 228 transits; it would slip with r over"
    )


def test_unlike_slabs_are_scaled_together():
    (line,) = told("upper.r=0.002", "lower.r=0.004", until=50.0, scene="unlike")[-1:]
    assert "r of the upper slab, both slabs scaled together, over 0.00239 (here 0.002)" in line


def test_an_interface_that_is_hardly_loaded_has_no_expected_cycle():
    """The spring of the machine takes 1e11 transits, or 1e300, to load it: the run gives its verdict, and no length to try."""
    done = slipwave.run("machine", settings=["slab.face.stiffness=1e-9"], until=20.0)
    assert done.summary["verdict"] == "too short"
    assert math.isinf(done.needed)
    assert expected_period(slipwave.read("machine", ["slab.face.stiffness=1e-300"])) > 1e290
    soft = {"kind": "machine", "stiffness": 1e-300, "impedance": 1e15, "mass": 1e9}  # an infinite time in SI
    done = slipwave.run(GRANITE | {"slab": GRANITE["slab"] | {"face": soft}}, "quasidynamic", until=20.0)
    assert done.summary["reasons"][0] == "no cycle is expected: the drive hardly loads the interface"


@pytest.mark.parametrize("name", ["paper", "paper-2.3", "rock", "grip", "layered", "unlike-irrational"])
def test_the_period_is_expected_within_a_factor_of_two_and_a_half(name):
    scene = slipwave.read(name)
    period = float(watch(build("delay", scene, tolerance=1e-6), 1500.0).events(750.0).period.mean())
    assert 0.4 < expected_period(scene) / period < 2.5


def test_the_stress_that_an_event_of_granite_releases():
    """D = 2 w ln(1 + T v) with w = b - a = 0.005, T = D/(k V), v = D/(2 Z), by hand: k = epsilon/r = 3e-3 per L/V* (plain alike
    slabs, epsilon = 1.8e-6, r = 6e-4) and Z = epsilon/2."""
    found = 1.8e-6 * expected_period(slipwave.read(GRANITE))
    assert found == pytest.approx(0.01 * math.log(1.0 + found / 3e-3 * found / 1.8e-6), rel=1e-9)
    assert found == pytest.approx(0.153, abs=0.001)


def test_near_the_onset_the_period_is_that_of_the_critical_frequency():
    """omega_c = V sqrt((b - a)/a), with b so close to a that hardly any stress is released."""
    scene = slipwave.read("paper", ["interface.b=0.035", "slab.r=1"])
    assert expected_period(scene) == pytest.approx(2.0 * math.pi / (100.0 * math.sqrt(1e-4 / 0.0349)), rel=1e-9)


def test_whether_steady_sliding_holds_and_how_fast_it_returns():
    thin = slipwave.read(GRANITE, ["slab.thickness=0.2"])
    assert is_stable(thin, "delay") is True
    assert growth_rate(thin, "delay") == pytest.approx(
        thin.transit * leading_roots(characteristic(thin, "delay"))[0].real, rel=1e-12
    )
    assert is_stable(slipwave.read(GRANITE), "delay") is False
    strengthening = slipwave.read("paper", ["interface.b=0.01"])
    assert is_stable(strengthening, "delay") is True
    assert math.isfinite(expected_period(strengthening))


def test_it_is_that_of_the_velocity_with_which_the_drive_ends():
    ramp = slipwave.read("paper", ["drive.velocity=[[0, 100], [10, 2000]]"])
    fast, hold = (slipwave.read("paper", [f"drive.velocity={drive}"]) for drive in ("2000", "[[0, 100], [10, 0]]"))
    ours, theirs, rest = (
        (is_stable(one, "delay"), growth_rate(one, "delay"), expected_period(one)) for one in (ramp, fast, hold)
    )
    assert ours == theirs
    assert rest == (None, 0.0, math.inf)


@pytest.mark.parametrize(
    ("model", "seconds", "says"), [("delay", 7.0, True), ("delay", 0.5, False), ("quasidynamic", 7.0, False)]
)
def test_one_line_names_the_cheaper_model_and_its_error(model, seconds, says, caplog, monkeypatch):
    """A tenth of the run has taken so many seconds; what came before it, as compilation, does not count."""
    clock = iter([90.0, 100.0, 100.0 + seconds, 110.0 + seconds])
    monkeypatch.setattr("validation.models.progress.LONG", 60.0)
    monkeypatch.setattr("validation.models.progress.time.monotonic", lambda: next(clock))
    advice = LongRunAdvice(build(model, slipwave.read("paper")))
    with caplog.at_level(logging.INFO, logger="slipwave"), progress("run", 110.0, advise=advice) as report:
        for done in (10.0, 20.0, 90.0):
            report(done)
    told = [record.getMessage() for record in caplog.records]
    assert [("63 s left" in line and "quasidynamic" in line and "0.08" in line) for line in told] == [True] * says


@pytest.mark.parametrize(
    ("scene", "model", "seconds", "told"),
    [
        ("viscous", "fd", 7200.0, "this run is long; --model fitted:8 is cheaper"),
        ("paper", "dg:7", 7200.0, "this run is long; --model quasidynamic is cheaper"),
        ("paper", "fd", 60.0, ""),
        ("paper", "delay", math.nan, ""),
        ("paper", "quasidynamic", 7200.0, ""),
    ],
)
def test_a_run_of_hours_is_foretold_with_a_cheaper_model(scene, model, seconds, told, caplog, monkeypatch):
    monkeypatch.setattr("validation.models.progress.LONG", 60.0)
    advice = LongRunAdvice(build(model, slipwave.read(scene)))
    with caplog.at_level(logging.INFO, logger="slipwave"):
        advice.foretell(seconds)
        if told:
            advice((7000.0, 7100.0))  # is not told again
    assert [record.getMessage()[: len(told)] for record in caplog.records] == [told] * bool(told)


def test_the_time_of_fixed_steps_is_foretold_before_the_first_of_them(monkeypatch, caplog):
    """Until a tenth of the run is over nothing else would say that it takes hours."""
    solver = build("fd", slipwave.read("viscous"))
    monkeypatch.setattr("validation.models.progress.LONG", 60.0)
    monkeypatch.setattr(Leapfrog, "seconds_per_piece", 36000.0 * solver.transits_per_piece / 2.0)
    with caplog.at_level(logging.INFO, logger="slipwave"):
        simulate(solver, 2.0)
    assert caplog.messages[0].startswith("this run is long; --model fitted:8")


def test_a_continued_run_is_predicted_from_where_it_goes_on():
    """From a half on at 5 % in 2 s; the first news, of any time, is the beginning."""
    remaining = RemainingTime()
    assert [remaining(share, now) for share, now in ((0.5, 70.0), (0.54, 72.0))] == [None, None]
    assert remaining(0.6, 74.0) == pytest.approx((0.4 * 2.0 / 0.06, 16.0))


@pytest.mark.parametrize(
    ("drive", "shares"),
    [
        (steady_drive(100.0), (0.05, 0.3, 1.0)),
        (Drive((0.0, 10.0, 10.0, 90.0, 90.0), (1.0, 1.0, 0.0, 0.0, 1.0)), (0.15, 0.4, 1.0)),
        (Drive((0.0, 50.0, 50.0), (1.0, 1.0, -1.0)), (0.05, 0.3, 1.0)),
        (steady_drive(0.0), (0.05, 0.3, 1.0)),
    ],
)
def test_work_is_shared_by_time_and_by_what_the_drive_has_travelled(drive, shares):
    """A hold of 80 in 100 transits has nothing of the way. A drive that reverses or rests says nothing."""
    share = share_of_run(drive, 100.0)
    assert [share(time) for time in (5.0, 30.0, 100.0)] == pytest.approx(shares)


@pytest.mark.parametrize("model", ["delay", "block8"])
def test_a_march_whose_steps_adapt_is_judged_by_those_it_took(model, monkeypatch):
    paper = slipwave.read("paper")
    solver = build(model, paper)
    with monkeypatch.context() as slow:
        slow.setattr(type(solver), "seconds_per_piece", DAY / 2e6)
        with pytest.raises(SceneError, match=r"4e\+07 transits would take about [\d.]+ days"):
            simulate(solver, 4e7)
    assert solver.time < 40_000.0
    simulate(build(model, paper), 3000.0)


@pytest.mark.parametrize("words", ["run paper --model fd", "compare paper --models fd --out x.png"])
def test_yes_runs_it_all_the_same(words, tmp_path, monkeypatch, printed, refused):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Leapfrog, "seconds_per_piece", DAY)
    words = [*words.split(), "--cells", "16", "--until", "30", "--json"]
    assert refused(*words).startswith("slipwave: model fd: 30 transits would take about")
    assert list(tmp_path.iterdir()) == []
    assert json.loads(printed(*words, "--yes"))["until"] == 30.0


def test_lines_come_every_ten_seconds_and_tell_share_and_time_left(monkeypatch, caplog):
    """At 40 of 200 after 11 s, 10 of which brought 20: 160 are left, at 2 a second. The last tenth took 60 s in the end."""
    now = [100.0]
    monkeypatch.setattr(module, "PATIENCE", 2.0)
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    caplog.set_level(logging.INFO, "slipwave")
    told = []
    with progress("run", 200.0) as report:
        for seconds, done in ((1.0, 20.0), (3.0, 30.0), (9.9, 37.0), (10.0, 37.0), (11.0, 38.0), (21.0, 110.0), (81.0, 130.0)):
            now[0] = 100.0 + seconds
            report(done)
            told.append(" ".join(caplog.messages))
            caplog.clear()
    assert told == ["", "", "", "run: 18%", "", "run: 55%, 17 s left", "run: 65%, 51 to 210 s left"]


@pytest.mark.parametrize("command", ["run --until 1", "stability", "compare --models quasidynamic --until 1"])
def test_a_doubt_is_a_note_on_stderr_and_in_the_json(command, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, *options = command.split()
    words = [name, "paper-si", *options, "--set", "slab.shear_modulus=30", "--set", "slab.density=30 g/cm3", "--json"]
    assert main(words) == 0
    printed = capsys.readouterr()
    told = [line for line in json.loads(printed.out)["notes"] if line.startswith("slab.")]
    assert [line.partition(" (")[0] for line in told] == ["slab.density = 3e+04 kg/m3", "slab.shear_modulus = 30 Pa"]
    assert [line for line in printed.err.splitlines() if line.startswith("note: slab.")] == [f"note: {one}" for one in told]


@pytest.mark.parametrize(
    ("files", "told"), [("--json", "every rate"), ("--events x.csv", "every rate"), ("--out x.nc", ""), ("--series x.csv", "")]
)
def test_a_part_of_a_history_that_no_file_holds_is_noted(files, told, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    noted = []
    for name in ("every", "rate"):
        assert main(["run", "paper", "--model", "block8", "--until", "5", f"--{name}", "3", *files.split()]) == 0
        noted += [name] if f"note: --{name} changes nothing" in capsys.readouterr().err else []
    assert " ".join(noted) == told


STIFF = ["interface.a=0.0296", "interface.b=0.0591", "drive.velocity=80", "slab.epsilon=7.2e-5", "slab.r=0.0124"]
"""Thirty-two cells of sbp:6 end at ln v = -6.27 after 60 transits where the delay system has -5.31."""


def parted(r, model, at):
    """Relative difference, at `at` transits, of two departures from steady sliding whose psi(0) differ by one rounding."""
    scene = slipwave.read("paper", [f"slab.r={r}"])
    left = []
    for rounding in (0.0, 2.0**-52):
        solver = build(model, scene, tolerance=1e-11)
        state = solver.state()
        state["now"][1] *= 1.0 + rounding
        solver.restore(state)
        left.append(follow(solver, at).psi - scene.steady_psi)
    return abs(left[1] - left[0]) / max(map(abs, left))


@pytest.mark.parametrize("model", ["delay", "kelvin-voigt"])
@pytest.mark.parametrize(("r", "at"), [(0.1, 5.0), (0.2, 4.0), (0.3, 2.5), (0.5, 1.5)])
def test_the_share_of_rounding_is_what_two_runs_differ_by(model, r, at):
    found = amplified_rounding(slipwave.read("paper", [f"slab.r={r}"]), model, 40.0)
    assert found is not None
    ratio = parted(r, model, at) / min(found[0], 1.0)
    assert 1.0 / 30.0 < ratio < 10.0


def test_a_scene_that_is_determined_says_nothing():
    for name in ("paper", "paper-2.3", "rock", "unlike", "ramp", "jump", "grip", "slip-law"):
        assert amplified_rounding(slipwave.read(name), "delay", 4000.0) is None
    jump = ['start.kind="jump"', "start.size=0.1", "slab.r=1"]
    assert amplified_rounding(slipwave.read("paper", jump), "delay", 40.0) is None
    assert amplified_rounding(slipwave.read("paper", ["slab.r=0.5"]), "delay", 0.3) is None  # rounding has not grown yet


@pytest.mark.parametrize(("step", "is_told"), [(20, False), (5000, True)])
def test_a_velocity_step_disturbs_more_than_rounding(step, is_told):
    """Without a nudge, sliding at log10 r = -2.5 is left by the step, or, if that comes late, by rounding before it."""
    keys = ["start.size=0", "slab.log10_r=-2.5", f"drive.velocity=[[0, 100], [{step}, 100], [{step}, 150]]"]
    told = amplified_rounding(slipwave.read("paper", keys), "delay", 6000.0)
    assert (told is not None) == is_told
    assert not is_told or "the start disturbs nothing: rounding decides" in told[1]


def test_a_run_that_rounding_decides_says_so():
    """`printed.txt` has a run in which its share is small."""
    (note,) = slipwave.run("paper", "quasidynamic", until=10, r=0.5).notes
    assert note.startswith("not determined: steady sliding is unstable, disturbances grow at 17.1 per transit")
    assert 10.0 < float(note.split("outgrows the start ")[1].split(" times")[0]) < 500.0
    assert slipwave.run("paper", until=10).notes == []


@pytest.mark.parametrize("model", ["sbp:6", "dg:7"])
def test_a_default_grid_that_is_too_coarse_says_so(model):
    result = slipwave.run("paper", model, until=60, settings=STIFF).summary
    exact = follow(build("delay", slipwave.read("paper", STIFF), tolerance=1e-10), 60.0)
    error = max(abs(result["final"][name] / getattr(exact, name) - 1.0) for name in ("ln_v", "psi"))
    cells, estimate = result["grid"]["cells"], result["grid"]["error_estimate"]
    assert error < 2.0 * estimate < 30.0 * error
    assert f"the default grid of {cells} cells is too coarse for this scene: estimated error {estimate:.1e}" in result["notes"][0]


@pytest.mark.parametrize(
    ("model", "jump", "options", "told"),
    [
        ("fd", 1.0, {"cells": 8}, []),
        ("fd", 1.01, {"cells": 8}, ["steps"]),
        ("dg:3", 1.01, {"cells": 2, "time": "explicit"}, ["steps"]),  # late steps cost as the front
        ("dg:3", 1.01, {"cells": 2}, ["no"]),
        ("dg:3", 0.0, {"cells": 2}, []),
        ("delay", 1.01, {}, []),
        ("block8", 1.01, {}, []),
    ],
)
def test_what_a_step_of_the_drive_costs_is_told(model, jump, options, told):
    drive = [[0.0, 100.0], [jump, 100.0], [jump, 120.0]] if jump else [[0.0, 100.0], [1.0, 120.0]]
    found = slipwave.run("paper", model, until=2, **options, **{"drive.velocity": drive})
    lines = {"steps": "steps of V are placed to within one time step (", "no": "no grid resolves the front of a step of V: "}
    assert [word for word, line in lines.items() for note in found.notes if note.startswith(line)] == told
    assert all("the delay system of elastic slabs" in note for note in found.notes if note.startswith(tuple(lines.values())))


def test_a_limit_on_the_way_to_which_the_model_has_no_answer_ends_nothing():
    """Before, `run` and `stability` of this scene were refused: thin slabs have no passive fit of order 4."""
    found = slipwave.stability("steel-on-pmma", "fitted:4")
    assert "the critical thickness was not found: model = 'fitted:4': no passive fit" in found.summary["notes"][-1]
    assert found.summary["stable"] is False
    reasons = slipwave.run("steel-on-pmma", "fitted:4", until=1000.0).summary["reasons"]
    assert reasons[-1].endswith("it would slide steadily with a normal stress under 158 kPa (here 2 MPa)")

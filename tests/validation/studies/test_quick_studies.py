"""Quick runs of the studies: verdicts, findings, near limits, numbers, and the key of a stored result."""

import json
import math
import re
import shlex
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import pytest
from shown import outcomes, quick, too_roomy

import slipwave
from slipwave.sources import ROOT, import_closure, program
from tests.validation.answer import read_table
from validation.commands.cli import main
from validation.measure.memo import critical_r
from validation.report import Budget, Outcome, sources, store
from validation.report.compared import EXACT_MODEL
from validation.report.grid_verdicts import limit_verdict, medium_verdict, noise_verdict
from validation.report.registered import STUDIES as ALL_STUDIES
from validation.report.registered import study_called
from validation.studies import checks
from validation.studies import which_model as study
from validation.studies.stability_attacks import CELLS as ATTACKED
from validation.studies.stability_attacks import _attack, _attack_verdict, _AttackOutcome
from validation.studies.which_model import judged, laws


class Expected(NamedTuple):
    """How many verdicts, the first words of the findings among them, and (value, relative tolerance) of some numbers."""

    verdicts: int
    findings: tuple[str, ...] = ()
    numbers: dict[str, tuple[float, float]] = {}  # noqa: RUF012


ERRORS = {"kelvin-voigt": -3.7290e-2, "block8": 4.2715e-2, "modal:1": 5.809e-4, "modal:2": -5.53e-6}
DELAY = {"period": 73.4721449, "stress_drop": 0.1739634, "elastic_stress_drop": 0.1547375, "v_max": 4412.3205, "v_min": 2.860302}
REGIMES = {"quasidynamic": (80.0, 0.02), "block12": (32.7, 0.05)}

STUDIES = {
    "one-cycle": Expected(8, (), {f"delay {name}": (value, 5e-7) for name, value in DELAY.items()}),
    "reflection": Expected(
        7,
        (),
        {
            "T, bare, both faces, R = 0.99, r = 1.05 r_{c}": (67.618950, 1e-7),
            "T, grip, both faces, R = −0.9, r = 1.05 r_{c}": (90.408412, 1e-7),
        },
    ),
    "which-model": Expected(
        43,
        ("The",),
        {f"{model} error of T at -2.68": (value, 2e-3) for model, value in ERRORS.items()}
        | {"rock: kelvin-voigt error of T at 1.02": (-3.144e-2, 1e-2)},
    ),
    "cost-and-error": Expected(10),
    "bifurcation": Expected(
        14,
        ("P14",),
        {
            "delay LP 1": (-2.700251703, 2e-9),
            "delay NS 1": (-2.657545713, 2e-9),
            "kelvin-voigt PD 1": (-2.595727667, 2e-9),
            "T": (79.09, 1e-4),
        },
    ),
    "snaking": Expected(
        11, (), {f"T at -2.66, orbit {n}": (T, 2e-9) for n, T in enumerate((77.46265115, 77.78897533, 78.08866464), 1)}
    ),
    "laboratory": Expected(
        18, ("Leeman",), {"ageing 14 MPa period, 6 samples": (9.4, 0.1), "rise time, drop 0.19 MPa": (18.89, 1e-3)}
    ),
    "claims": Expected(
        24, ("P11", "P12", "P5", "P6", "Table"), {"r_c delay": (10**-2.6995497159, 1e-9), "delay T at -2.68": (73.4721449, 1e-9)}
    ),
    "regime-map": Expected(1, (), {f"{model} other regime, 13 x 7 points": near for model, near in REGIMES.items()}),
    "asymmetry": Expected(
        8,
        (),
        {
            "unlike: ψ(600)": (-5.25812015405, 4e-12),
            "unlike-irrational: ψ(600)": (-3.22732303547, 6e-12),
            "T at q = 1, p = 1": (73.47214494430, 1e-11),
            "T at q = 10, p = 5": (55.643049, 1e-8),
        },
    ),
    "orders": Expected(43, (), {"dg:2 order": (3.9972, 5e-4), "error, fem:2, alike": (5.73e-5, 0.02)}),
    "stability-attacks": Expected(48),
    "energy": Expected(
        21, (), {"order of dg:2": (5.0217, 5e-4)}
    ),  # rounding, 6e-16 of the least residual of 4e-13, moves it by 1e-4
    "onset": Expected(
        25, (), {"log10 r_c, quasistatic": (-2.698970004336, 1e-11), "error of (27) at V = 1e4": (-0.07672436, 1e-6)}
    ),
}


def held(name):
    result, expected = quick(name), STUDIES[name]
    told = [(verdict.claim, verdict.outcome) for verdict in result.verdicts]
    assert [one for one in told if one[1] is Outcome.FAIL] == []
    assert sorted({title.split()[0] for title, outcome in told if outcome is Outcome.FINDING}) == sorted(expected.findings)
    assert len(told) == expected.verdicts
    assert too_roomy(result.verdicts) == []
    assert [o.what for o in result.omissions if re.search(r"\d", o.what + o.why) and not o.claims] == []
    for number, (value, tolerance) in expected.numbers.items():
        assert result.numbers[number].value == pytest.approx(value, rel=tolerance), number
    assert all(number.value == number.value for number in result.numbers.values())
    return result


ELSEWHERE = {"which-model", "claims"}
"""Studies that a test file of their own runs, once."""
SLOW = {"regime-map", "laboratory", "orders", "stability-attacks"}
LONG = {"cost-and-error", "asymmetry", "bifurcation", "reflection", "snaking", "onset", "energy"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW) + [pytest.mark.studies] * (name in LONG))
        for name in STUDIES
        if name not in ELSEWHERE
    ],
)
def test_a_quick_run_holds_within_near_limits(name):
    held(name)


READ_BYTES = Path.read_bytes


def changes(monkeypatch, study, path):
    before = store.study_key(study, False)
    with monkeypatch.context() as patch:
        patch.setattr(store, "program", lambda file: "edited" if file == path else program(file))
        patch.setattr(Path, "read_bytes", lambda file: b"edited" if file == path else READ_BYTES(file))
        return store.study_key(study, False) != before


USED = """slipwave/friction/ageing.py slipwave/friction/__init__.py slipwave/gallery/paper.toml reduced/impedance/fit.py
fullwave/finite_element.py validation/models/settle.py validation/references/published.json validation/studies/claims.py"""
UNUSED = "validation/commands/cli.py validation/report/page.py validation/studies/energy.py README.md"


@pytest.mark.parametrize("path", [*USED.split(), *UNUSED.split()])
def test_a_key_follows_each_file_of_each_room_that_the_study_uses(monkeypatch, path):
    assert (ROOT / path).exists()
    assert changes(monkeypatch, study_called("claims"), ROOT / path) == (path in USED)


@pytest.mark.parametrize("name", ALL_STUDIES)
def test_all_that_a_study_imports_and_all_data_are_in_its_key(name):
    study = study_called(name)
    files = set(sources.sources_of(study))
    assert set(import_closure([Path(study.__file__)], packages=False)) <= files
    assert set((ROOT / "validation").rglob("*.json")) <= files
    assert {ROOT / "slipwave" / "gallery" / f"{scene}.toml" for scene in study.SCENES} <= files


@pytest.mark.parametrize(
    ("name", "called"), [("orders", "orbit run"), ("bifurcation", "branch curve orbit"), ("laboratory", "fit")]
)
def test_the_public_functions_that_a_study_calls_are_in_its_key(name, called):
    files = set(sources.sources_of(study_called(name)))
    assert {ROOT / "validation" / "commands" / f"{one}.py" for one in called.split()} <= files
    assert ROOT / "validation" / "commands" / "bench.py" not in files


def test_a_key_follows_every_package_python_the_settings_and_the_format(monkeypatch):
    study = study_called("claims")
    before = store.study_key(study, False)
    assert before == store.study_key(study, False) != store.study_key(study, True)
    packages = [line.split()[0] for line in sources.packages_of(sources.sources_of(study))[1:]]
    assert {"numpy", "scipy", "numba", "llvmlite", "scikit-fem", "pydantic", "matplotlib"} <= set(packages)
    true, changed = metadata.version, []
    for package in packages:
        changed.append((sources.metadata, "version", lambda name, package=package: "0" if name == package else true(name)))
    for change in (*changed, (sources.platform, "python_version", lambda: "3.0.0"), (store, "_FORMAT", 0)):
        with monkeypatch.context() as patch:
            patch.setattr(*change)
            assert store.study_key(study, False) != before, change


def test_a_key_follows_the_files_that_a_study_reads(fake, tmp_path):
    module = fake.add("first")
    module.FILES = (tmp_path, tmp_path / "missing")
    keys = set()
    for name, text in (("a.py", "x = 1"), ("b.toml", "x = 1"), ("b.toml", "x = 2"), ("c.json", "1")):
        (tmp_path / name).write_text(text)
        keys.add(store.study_key(module, False))
    assert len(keys) == 4


def test_a_key_follows_the_scenes_that_a_program_names(fake):
    module = fake.add("first")
    before = store.study_key(module, False)
    module.SCENES = ("rock",)
    declared = store.study_key(module, False)
    module.SCENES = ()
    fake.edit(module, "\nnamed = 'rock'")
    names = [path.stem for path in store.sources_of(module) if path.suffix == ".toml"]
    assert names == ["rock"]
    assert declared != before


def test_every_claim_of_the_paper_is_settled_or_said_to_be_left_out():
    result = held("claims")
    settled = {verdict.claim.split()[0] for verdict in result.verdicts}
    left_out = {omission.what.split(",")[0] for omission in result.omissions}
    assert {f"P{n}" for n in range(1, 15)} <= settled | (left_out & {"P8", "P9", "P10", "P14"})
    paper, _, rock = zip(*(row[1:] for row in result.tables[0].rows), strict=True)
    assert (paper[-1], rock[3]) == pytest.approx((1.04604, 5e-8), rel=1e-5)


@pytest.mark.parametrize("name", ["V 4", "jump back"])
def test_late_cycles_are_right(name):
    found = _attack(name, late=True)
    assert set(found) == set(ATTACKED)
    assert not any(outcome.is_silently_wrong for outcome in found.values())


def test_an_attack_must_end_right_to_1_percent_or_with_a_message():
    ends = [(0.0099, 0.0099), (math.nan, 0.0, "too stiff"), (0.011, 0.0), (0.0, 0.011), (math.nan,)]
    found = [{"fd": _AttackOutcome(0.005), "dg:4": _AttackOutcome(*end)} for end in ends]
    assert outcomes(_attack_verdict("jump", one) for one in found) == "pass pass fail fail fail"


def limits(*shares):
    return limit_verdict("fd", dict(zip((-4, 0, 8), shares, strict=True)))


def medium(*pair):
    return medium_verdict("alike", {"fd": (1.0, math.inf), "dg:4": pair})


def noise(left):
    """The leapfrog loses what friction takes: 1.60458e-6 in 1000 transits, known to 1.6e-3."""
    return noise_verdict("fd", 1.0 - left, 1e3)


@pytest.mark.parametrize(
    ("judge", "held", "missed"),
    [
        (limits, [(1.0, 1.3, 1.031), (0.969, 1.3, 1.0)], [(1, 1.3, 1.12), (0.88, 1.3, 1), (1, 0.88, 1)]),
        (medium, [(90.0, 110.0), (90.0, math.inf)], [(300.0, math.inf), (5.0, 33.0)]),
        (noise, [(1.6025e-6,), (1.6065e-6,)], [(0.0,), (1.61e-6,), (math.nan,)]),
    ],
)
def test_limits_and_noise_are_held_on_both_sides(judge, held, missed):
    assert [judge(*one).outcome for one in held + missed] == ["pass"] * len(held) + ["fail"] * len(missed)


@pytest.mark.studies
def test_the_tables_have_every_model_at_every_r():
    """At log10 r = -2.65 the period is 79.3225 in the mean (lifted shooting); eight modes keep the torus."""
    result = held("which-model")
    table, elsewhere = result.model_tables
    assert [row.model for row in table.rows] == list(study.EVERY)
    assert [column.group for column in table.columns] == ["periodic"] * 3 + ["torus, irregular"] * 2
    assert [cell.words("T") for cell in table.row("quasidynamic").cells][:3] == ["slides steadily"] * 3
    assert {cell.regime for cell in table.row("quasistatic").cells} == {"runs away"}
    assert table.row("quasidynamic").onset.value == pytest.approx(-2.6532125, abs=1e-7)
    assert (table.row("delay").advice, table.row("kelvin-voigt").advice) == ("use", "avoid")
    at = {row.model: row.cells[3] for row in table.rows}
    assert [at[model].regime for model in ("delay", "modal:8", "kelvin-voigt")] == ["torus", "torus", "periodic"]
    damped, mean = at["quasidynamic"].figures, at["delay"].figures["T"]
    assert (damped["T"].value, damped["Δμ"].value) == pytest.approx((48.371789354, 0.0221755339), rel=1e-8)
    assert result.numbers["quasidynamic T at -2.65"].value == damped["T"].value
    assert abs(mean.value - 79.3225) < 2.0 * mean.standard_error * mean.value < 0.1
    assert (at["kelvin-voigt"].figures["T"].value, at["kelvin-voigt"].right) == (pytest.approx(75.30034, abs=1e-5), False)
    tried = {row.model: [column.title for column, *_ in judged.cells_of(elsewhere, row.model)] for row in elsewhere.rows}
    assert (tried["modal:8"], tried["fitted:4"]) == (["unlike", "rock"] * 2, ["grip"] * 2)
    assert {row.model for row in elsewhere.rows if row.advice == "avoid"} >= {"kelvin-voigt", "block12", "quasistatic"}


FIGURES = {"T": "period", "Δμ": "stress_drop"}


def repeats(cell, command, capsys):
    """Whether a command of the page prints the figures of its cell in all digits of the page; means of irregular motions, whose
    digits are those of a processor, within four standard errors."""
    assert main([*shlex.split(command)[1:], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    found = {symbol: told[name]["mean"] if "run" in command else told[name] for symbol, name in FIGURES.items()}
    found["v_{max}"] = told["v_max_median" if cell.cycles else "v_max"]
    ours = {symbol: (one.value, one.standard_error) for symbol, one in cell.figures.items()}
    off = {
        symbol: abs(found[symbol] / value - 1.0) / (8e6 * error if cell.regime == "irregular" else 1.0)
        for symbol, (value, error) in ours.items()
    }
    return all(one < 5e-7 for one in off.values())


@pytest.mark.parametrize(("model", "place"), [("modal:1", 1), ("modal:2", 3)])
def test_a_printed_command_repeats_an_orbit_and_a_mean(model, place, capsys):
    table = read_table()
    cell, column = table.row(model).cells[place], table.columns[place]
    assert (cell.regime, cell.cycles > 0) == (("periodic", False) if place == 1 else ("torus", True))
    assert repeats(cell, cell.command_for(table.row(model), column), capsys)


@pytest.mark.slow
def test_ten_printed_commands_repeat_their_figures(capsys):
    """Of both tables, every so many of those that take seconds; the first is of an orbit, the last of a scene in SI."""
    cells = [found for table in held("which-model").model_tables for found in judged.cells_of(table) if found[2].figures]
    quick = [found for found in cells if "e+06" not in found[2].command]
    chosen = quick[:: len(quick) // 10][:10]
    assert len({cell.command.partition(" ")[0] for _, _, cell in chosen}) == 2
    assert [column.title for column, row, cell in chosen if not repeats(cell, cell.command_for(row, column), capsys)] == []


@pytest.mark.parametrize("name", ["unlike", "grip", "rock"])
def test_the_settings_of_a_place_make_its_scene(name):
    """Both slabs scaled together, 1.1 times the onset; the column names the options that make it."""
    column, own = study.place(name, 1.1), slipwave.read(name)
    first, *options = [word for word in column.settings.split() if word != "--set"]
    scene = slipwave.read(first, options)
    factor = scene.transit / own.transit
    for slab, other in zip(scene.slabs, own.slabs, strict=True):
        assert (slab.round_trip, slab.epsilon) == pytest.approx((factor * other.round_trip, other.epsilon), rel=1e-5)
    assert scene.start.size == 0.5
    assert scene.transit == pytest.approx(1.1 * critical_r(EXACT_MODEL, scene), rel=1e-4)
    assert 10.0**column.log10_r == pytest.approx(scene.transit)


def test_the_cycles_error_does_not_fall():
    measured = [laws.measure_cycle(slipwave.read("paper"), scale) for scale in (1.0, 0.5)]
    assert [one.error() for one in measured] == pytest.approx([-0.0318, -0.0292], abs=2e-4)
    assert [one.outcome for one in laws.law_verdicts({}, measured)] == [Outcome.FINDING]


CAUGHT = {
    "name": "half-impedance",
    "where": "slipwave/scene/scene.py::Scene.impedance",
    "user": "periods 4 % long",
    "caught_by": "tests/slipwave/test_scene.py::test_impedance_of_two_slabs",
}
SURVIVES = CAUGHT | {"name": "late-nudge", "where": "reduced/delay/march.py::march_delay", "caught_by": ""}


@pytest.fixture
def shown(monkeypatch, tmp_path):
    def run(faults, **held):
        figures = {figure: {"number": 100, "held": count, "width": 3.0} for figure, count in held.items()}
        kinds = {"means": {"bar": "margin", "truth": "more cycles", "evidence": "self-convergence", "figures": figures}}
        for name, record in (("FAULTS", {"faults": faults}), ("COVERAGE", kinds)):
            monkeypatch.setattr(checks, name, tmp_path / name)
            (tmp_path / name).write_text(json.dumps(record))
        return checks.run(Budget())

    return run


def test_a_fault_that_survives_is_red(shown):
    found = shown([CAUGHT, SURVIVES, CAUGHT | {"name": "other"}], period=99)
    assert [(one.outcome, one.ours, one.remark) for one in found.verdicts[:2]] == [
        (Outcome.PASS, "2 of 2", "in `slipwave`"),
        (Outcome.FAIL, "0 of 1", "in `reduced`; survives: late-nudge"),
    ]
    assert found.tables[0].rows[1] == ("late-nudge", "reduced/delay/march.py", "nothing")
    assert found.tables[0].emphasis == (1,)
    assert shown([CAUGHT], period=99).conclusion.startswith("1 of 1 planted faults are noticed")


@pytest.mark.parametrize(("held", "outcome"), [(94, Outcome.FAIL), (95, Outcome.PASS)])
def test_94_of_100_are_too_few_though_chance_may_have_made_them_so(shown, held, outcome):
    found = shown([CAUGHT], period=99, drop=held)
    assert found.verdicts[-1].outcome is outcome
    assert found.numbers["held, means"].value == held / 100
    assert found.tables[1].rows[0][3:5] == ("drop", 100)
    assert found.tables[1].rows[0][6:8] == pytest.approx({94: (87.5, 97.2), 95: (88.8, 97.8)}[held], abs=0.1)


def test_without_its_records_it_says_why(monkeypatch, tmp_path):
    monkeypatch.setattr(checks, "FAULTS", tmp_path / "none.json")
    found = checks.run(Budget())
    assert (found.verdicts, len(found.omissions), found.conclusion) == ((), 1, "Not answered in this report.")

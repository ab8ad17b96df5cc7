"""Quick runs of the studies: verdicts, findings, limits near what is measured, numbers, and the key of a stored result."""

import re
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import pytest
from shown import quick, too_roomy

from slipwave.sources import ROOT, import_closure, program
from validation.report import Outcome, sources, store
from validation.report.registered import STUDIES as ALL_STUDIES
from validation.report.registered import study_called


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
    "partial-reflection": Expected(
        9, (), {"grip 1, Z_{g}/ε = 1: T": (185.5406, 1e-5), "grip 10, Z_{g}/ε = 1: T": (114.2073, 1e-5)}
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
        9, (), {"unlike: ψ(600)": (-5.25812015405, 4e-12), "unlike-irrational: ψ(600)": (-3.22732303547, 6e-12)}
    ),
    "orders": Expected(43, (), {"dg:2 order": (3.9972, 5e-4), "error, fem:2, alike": (5.73e-5, 0.02)}),
    "stability-attacks": Expected(48),
    "energy": Expected(21, (), {"order of dg:2": (5.0217, 1e-4)}),
    "onset": Expected(
        25, (), {"log10 r_c, quasistatic": (-2.698970004336, 1e-11), "error of (27) at V = 1e4": (-0.07672436, 1e-6)}
    ),
}


def held(name):
    """The study's quick run, which must be what is expected of it."""
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
LONG = {"cost-and-error", "asymmetry", "bifurcation", "partial-reflection", "snaking", "onset", "energy"}


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
    """Whether an edit of the file `path` changes the study's key."""
    before = store.study_key(study, False)
    with monkeypatch.context() as patch:
        patch.setattr(sources, "program", lambda file: "edited" if file == path else program(file))
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


def test_a_key_follows_every_package_and_python(monkeypatch):
    study = study_called("claims")
    before = store.study_key(study, False)
    packages = [line.split()[0] for line in sources.packages_of(sources.sources_of(study))[1:]]
    assert {"numpy", "scipy", "numba", "llvmlite", "scikit-fem", "pydantic", "matplotlib"} <= set(packages)
    true = metadata.version
    for changed in packages:
        with monkeypatch.context() as patch:
            patch.setattr(sources.metadata, "version", lambda name, changed=changed: "0" if name == changed else true(name))
            assert store.study_key(study, False) != before, changed
    monkeypatch.setattr(sources.platform, "python_version", lambda: "3.0.0")
    assert store.study_key(study, False) != before


def test_a_key_follows_the_settings_and_the_format(monkeypatch):
    study = study_called("claims")
    before = store.study_key(study, False)
    assert before == store.study_key(study, False) != store.study_key(study, True)
    monkeypatch.setattr(store, "_FORMAT", 0)
    assert store.study_key(study, False) != before


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
    names = [path.stem for path in sources.sources_of(module) if path.suffix == ".toml"]
    assert names == ["rock"]
    assert declared != before

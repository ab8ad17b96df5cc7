"""What stability, compare and bench say, number by number: closed forms and the runs of the models themselves."""

import math

import pytest

import slipwave
from tests.one_port_by_hand import pair_impedance

A, B, EPSILON, V = 0.0349, 0.0489, 2.8e-5, 100.0


def test_stability_of_unlike_slabs_in_its_table(answer, printed):
    """The table's roots are the JSON's, in cycles per round trip of the upper slab beside them."""
    found = answer("stability", "unlike")
    chosen = slipwave.read("unlike")
    for re, im in found["leading_roots"]:
        s = complex(re, im)
        friction = (A / V * s + (A - B)) / (s + V)
        assert abs(friction + pair_impedance(chosen, s)) < 1e-8 * abs(friction)
    lines = printed("stability", "unlike").splitlines()
    rows = [line.split() for line in lines[lines.index(next(line for line in lines if "leading roots" in line)) + 1 :]]
    upper_half = [root for root in found["leading_roots"] if root[1] >= 0.0]
    assert len(rows) == len(upper_half)
    for row, (re, im) in zip(rows, upper_half, strict=True):
        assert [float(row[0]), float(row[1])] == pytest.approx([re, im], rel=1e-6)
        assert float(row[-1]) == pytest.approx(im * 0.00244 / (2.0 * math.pi), rel=1e-5)
    critical = {line.split("  ")[0]: line.split() for line in lines if line.startswith("critical")}
    assert float(critical["critical frequency omega_c [V*/L]"][4]) == pytest.approx(found["omega_c"], rel=1e-10)


COMPARE = ["--until", "4000", "--cells", "24"]


def test_compare_gives_every_models_own_run_and_its_signed_errors(answer, tmp_path):
    """Errors are (ours - reference)/reference."""
    found = answer("compare", "paper", "--models", "fd,delay,kelvin-voigt", *COMPARE, "--out", str(tmp_path / "three.png"))
    rows = {row["model"]: row for row in found["models"]}
    assert (found["reference"], found["until"], list(rows)) == ("delay", 4000.0, ["fd", "delay", "kelvin-voigt"])
    reference = answer("run", "paper", "--model", "delay", "--until", "4000")
    for model, row in rows.items():
        alone = answer("run", "paper", "--model", model, "--until", "4000", *(["--cells", "24"] if model == "fd" else []))
        for key in ("events", "period", "stress_drop", "elastic_stress_drop", "v_max", "v_min", "failures"):
            assert row[key] == alone[key], (model, key)
        for key in ("period", "stress_drop"):
            theirs = reference[key]["mean"]
            assert row["error"][key] == pytest.approx((alone[key]["mean"] - theirs) / theirs, rel=1e-9, abs=1e-15)
    assert rows["kelvin-voigt"]["error"]["period"] == pytest.approx(70.7323 / 73.4721 - 1.0, abs=2e-5)


def test_bench_errors_are_those_of_the_runs_it_timed(answer, monkeypatch):
    """|T/T_reference - 1| of each setting, of one cheap family and the delay system; runs made again here."""
    from validation.registry.choice import families

    chosen = [family for family in families() if family.name in ("delay", "fd")]
    monkeypatch.setattr("validation.results.bench.honouring", lambda _: chosen)
    found = answer("bench", "paper", "--until", "2000")
    tight = answer("run", "paper", "--until", "2000", "--model", "delay", "--tol", "1e-11")
    assert found["reference"] == "delay"
    options = {"cells": "--cells", "tolerance": "--tol"}
    for row in found["models"]:
        setting = [word for name, value in row["setting"].items() for word in (options[name], str(value))]
        alone = answer("run", "paper", "--until", "2000", "--model", row["model"], *setting)
        for key in ("period", "stress_drop"):
            wanted = abs(alone[key]["mean"] - tight[key]["mean"]) / tight[key]["mean"]
            assert row["error"][key] == pytest.approx(wanted, rel=1e-6, abs=1e-14)
        assert row["failures"] == 0
    errors = [row["error"]["period"] for row in found["models"] if row["model"] == "fd"]
    assert errors[0] / errors[-1] > 10.0

"""`examples/bias`: what its record says, and a part of it computed anew."""

import math
import runpy
from types import SimpleNamespace

import numpy as np
import pytest

from slipwave.sources import ROOT

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
        assert new[4:] == pytest.approx(list(old.values())[4:], abs=2e-3, rel=0.05)

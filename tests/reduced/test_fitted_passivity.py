"""Fits are passive at every frequency, not only on a grid: certified where Re Z can change its sign, held against scans."""

import numpy as np
import pytest
from one_port_scenes import LOSSY, paper

import reduced.impedance.fit as fit
import slipwave
from reduced.impedance import check_passivity, reduction_of
from reduced.impedance.of_reduction import dissipation, sign_frequencies
from reduced.impedance.reduction import Reduction
from slipwave.errors import SceneError

GALLERY = ("grip", "reflection", "viscous", "paper", "unlike", "layered", "rock", "unlike-irrational", "slip-law", "regularised")
SCENES = {**LOSSY, **{f"gallery {name}": slipwave.read(name) for name in GALLERY}}


def scanned(model):
    """Smallest Re Z/epsilon on a fine grid that knows nothing of the certificate, narrow around every resonance."""
    widths = np.maximum(np.array([decay for _, _, decay, _ in model.modes]), 1e-9)
    across = np.add.outer(np.linspace(-30.0, 30.0, 2001), np.zeros(widths.size)) * widths + np.array(model.frequencies)
    omega = np.concatenate([np.linspace(0.0, 300.0, 30_001), np.geomspace(300.0, 1e6, 500), np.abs(across.ravel())])
    return float(dissipation(model, omega).min())


def certified(scene, count):
    model = reduction_of(scene, f"fitted:{count}")
    if not model.is_lossless:
        assert dissipation(model, sign_frequencies(model)).min() >= 0.0
        assert scanned(model) >= 0.0
        assert min(model.decays, default=0.0) >= 0.0
    assert check_passivity(scene, f"fitted:{count}").passive


@pytest.mark.parametrize("count", [9, 16])
def test_fits_that_were_active_between_the_points_of_a_grid(count):
    certified(LOSSY["grip below"], count)


@pytest.mark.parametrize("name", ["grip", "standard linear", "kelvin-voigt solid", "gallery viscous", "gallery unlike"])
def test_a_fit_of_each_kind(name):
    certified(SCENES[name], 7)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 4, 8, 12, 18])
@pytest.mark.parametrize("name", SCENES)
def test_every_fit_of_every_scene(name, count):
    certified(SCENES[name], count)


NARROW = Reduction("m", mass=0.01, damping=0.5, frequencies=(33.333333,), residues=(0.0,), decays=(1e-7,), offsets=(3e-5,))


@pytest.mark.parametrize(
    ("wrong", "where"),
    [
        (Reduction("m", mass=1 / 12, frequencies=(6.0,), residues=(-0.1,)), None),
        (Reduction("m", damping=-1e-3), None),
        (NARROW, 33.333333),
    ],
    ids=["active mode", "active dashpot", "a resonance narrower than any grid"],
)
def test_an_active_reduction_is_seen(wrong, where, monkeypatch):
    monkeypatch.setattr("reduced.impedance.models.reduction_of", lambda scene, name: wrong)
    found = check_passivity(paper(), "modal:1")
    assert not found.passive
    if where:
        assert found.where.imag == pytest.approx(where, abs=1e-3)
        assert dissipation(wrong, sign_frequencies(wrong)).min() < -0.1


def test_where_a_sign_changes_is_exact():
    """G = 1/2 - 0.3 s/(s^2 + s/5 + 4), of which Re G = 0 where ((4 - w^2)^2 + 0.04 w^2)/2 = 0.06 w^2."""
    model = Reduction("modal:1", damping=0.5, frequencies=(2.0,), residues=(-0.3,), decays=(0.1,))
    crossings = np.sqrt(np.roots([0.5, -4.0 + 0.02 - 0.06, 8.0]))
    cuts = sign_frequencies(model)
    assert np.abs(np.subtract.outer(crossings, cuts)).min(axis=1).max() < 1e-9
    assert dissipation(model, crossings) == pytest.approx(np.zeros(2), abs=1e-12)


def test_refusals_say_what_is_wrong_and_what_helps(monkeypatch):
    with pytest.raises(SceneError, match=r"model = 'fitted:0': a fit needs at least one oscillator; .* is quasidynamic"):
        reduction_of(LOSSY["grip"], "fitted:0")
    bare = {"kind": "machine", "stiffness": 1e3, "impedance": 0.0, "mass": 0.0}
    with pytest.raises(SceneError, match=r"model = 'fitted:2': no passive fit .* undamped, at a frequency that is fitted"):
        reduction_of(slipwave.read("paper", {"slab.face": bare}), "fitted:2")
    fit.fit_scene.cache_clear()
    monkeypatch.setattr(fit, "_ROUNDS", 1)
    with pytest.raises(SceneError, match=r"model = 'fitted:16': the fit is not passive at \d+\.?\d* rad.*; try another N"):
        reduction_of(LOSSY["grip below"], "fitted:16")

import math

import pytest

from reduced.impedance.reduction import TABULATED, reduction
from slipwave.errors import SceneError


@pytest.mark.parametrize("name", [*TABULATED, "modal:0", "modal:1", "modal:7"])
def test_every_name_gives_a_passive_description(name):
    model = reduction(name)
    assert model.name == name
    assert model.mass >= 0.0
    assert model.damping >= 0.0
    assert len(model.frequencies) == len(model.residues) == len(model.decays) == len(model.offsets)
    assert all(residue > 0.0 for residue in model.residues)
    assert model.is_lossless == (name != "quasidynamic")


def test_modal_zero_is_the_consistent_block_and_no_mass_is_lost():
    assert reduction("modal:0").mass == reduction("block12").mass
    for modes in (1, 5, 64):
        model = reduction(f"modal:{modes}")
        total = model.mass + sum(c / w**2 for c, w in zip(model.residues, model.frequencies, strict=True))
        assert math.isclose(total, 1.0 / 12.0, rel_tol=1e-14)
        assert model.mass > 0.0


def test_only_the_quasistatic_pair_runs_away():
    assert [name for name in TABULATED if reduction(name).runs_away] == ["quasistatic"]


@pytest.mark.parametrize("name", ["modal:-1", "modal:65", "modal:", "modal:x", "modal:1.5", "block9", "taylor", "", "modal:²"])
def test_a_wrong_name_is_the_users_error(name):
    with pytest.raises(SceneError, match="model = "):
        reduction(name)

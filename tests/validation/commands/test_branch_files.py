"""Files of `slipwave branch` and `curve`: the scene and the figures that they hold."""

import numpy as np
import pytest
import xarray

import slipwave as sw
from validation.models.followed import read_branch, write_followed


def test_the_file_of_a_branch_with_ends_has_the_scene_of_its_points(tmp_path):
    """At the first value; before, it was that of the scene, and a curve could not begin on the branch."""
    path, over = tmp_path / "branch.nc", "log10_r=-2.702:-2.6997"
    found = sw.branch("paper", over, "kelvin-voigt", ends="V=120,121", tol=1e-3, most_points=3, out=path)
    assert "V = 120" in next(iter(found.lines({})))
    assert found.dataset.attrs["V"] == 120.0
    curve = sw.curve(start=path, point="HB1", along="V=120:121").summary["points"]
    assert np.interp(120.0, *zip(*((one["V"], one["log10_r"]) for one in curve), strict=True)) == pytest.approx(
        found.special[0].log10_r, abs=1e-5
    )


def test_the_file_of_a_branch_with_ends_over_no_key_of_scenes_knows_its_value(tmp_path):
    """Its scene cannot be written; before, the file was taken for a branch of the scene without it."""
    path, over = tmp_path / "branch.nc", "log10_r=-2.622:-2.6216"
    beside = sw.branch("unlike", over, "modal:1", ends="ratio_r=2.01,2.02", tol=1e-3, most_points=2, out=path)
    assert "scene_toml" in beside.dataset.attrs
    for known in (beside.followed, read_branch(path, "--from")):
        assert known.over.scene_at(-2.622).lower.round_trip == pytest.approx(2.01 * 10**-2.622, rel=1e-12)
    with pytest.raises(sw.SceneError, match=r"fixed is \{'ratio_r': 2\.01\}; this branch has \{\}"):
        sw.branch("unlike", over, "modal:1", tol=1e-3, resume=path)


def test_files_that_can_be_continued_have_figures_in_si(tmp_path):
    """As the dataset in Python and files of curves of Hopf points; before, they had none.."""
    path, over = tmp_path / "branch.nc", "slab.thickness=31 mm:34 mm"
    for most, again in ((2, {}), (3, {"resume": path})):
        found = sw.branch("paper-si", over, "kelvin-voigt", tol=1e-4, most_points=most, out=path, **again)
        with xarray.open_dataset(path) as data:
            for name in ("point_period_s", "point_stress_drop_Pa", "point_v_max_m_per_s", "special_period_s"):
                assert data[name].values.tolist() == found.dataset[name].values.tolist()
                assert data[name].attrs == found.dataset[name].attrs
    write_followed(path, found.followed, found.end, False, {})
    with xarray.open_dataset(path) as data:
        assert "point_period_s" not in data

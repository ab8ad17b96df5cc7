"""What the figures and datasets of results show: the numbers of the JSON, each under its own name and on its own axis."""

import io

import numpy as np
import pytest

import slipwave as sw
from validation.branches.branch import FollowedBranch
from validation.branches.curve import Curve
from validation.branches.parameter import Over
from validation.branches.points import BranchPoint, CurvePoint
from validation.registry.choice import families
from validation.results.branch import BranchOptions, BranchResult
from validation.results.curve import CurveOptions, CurveResult

PAPER = sw.read("paper")
RANGES = Over(PAPER, "log10_r", -2.8, -2.6, lambda value: PAPER), Over(PAPER, "V", 90.0, 120.0, lambda value: PAPER)


def values(axes):
    """x and y of every line of a panel."""
    return [(np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist()) for line in axes.get_lines()]


def test_every_root_of_steady_sliding_lies_in_the_plane_where_the_json_has_it():
    found = sw.stability("unlike")
    real, imaginary = (list(part) for part in zip(*found.summary["leading_roots"], strict=True))
    assert max(np.abs(np.subtract(np.abs(real), np.abs(imaginary)))) > 1.0
    assert found.dataset["root_real"].values.tolist() == real
    assert found.dataset["root_imaginary"].values.tolist() == imaginary
    assert values(found.plot().axes[0])[0] == (real, imaginary)
    for name in ("omega_c", "log10_r_c", "epsilon_c"):
        assert float(found.dataset[name]) == found.summary[name]


def test_the_ranges_of_the_motion_are_drawn_in_both_units():
    """Each step of the reduction has an interval of its own or shares it."""
    found = sw.run("paper-si", "block8", until=100, interface=True, **{"drive.velocity": 2000})
    above, below = found.plot().axes
    data = found.dataset
    for axes, name in ((above, "interface_stress"), (below, "interface_slip_rate")):
        (time, low), (_, high) = values(axes)
        assert (time[-1], low[-1], high[-1]) == (100.0, data[name].values[-1], data[name].values[-1])
        assert (min(low), max(high)) == (data[name].values.min(), data[name].values.max())
        assert np.interp(data["time"].values, time, low) == pytest.approx(data[name].values, rel=0.1)
    above.figure.savefig(io.BytesIO())  # second axes take their limits when they are drawn
    transit = 9e-7 / 1e-6 * found.done.solver.scene.transit
    sizes = (above.child_axes[0].get_xlim, above.get_xlim, transit), (above.child_axes[1].get_ylim, above.get_ylim, 1000.0)
    for second, own, size in (*sizes, (below.child_axes[0].get_ylim, below.get_ylim, 1e-6)):
        assert second() == pytest.approx([limit * size for limit in own()], rel=1e-12)


def assert_table(found, rows):
    """The dataset has what the rows have, by their dotted keys; NaN where these have nothing."""
    for number, row in enumerate(rows):
        for name, value in leaves(row).items():
            mine = found.dataset[name].values[number]
            assert mine == value if value is not None else np.isnan(mine), name


def leaves(row, above=""):
    flat = {}
    for key, value in row.items():
        flat |= leaves(value, f"{above}{key}_") if isinstance(value, dict) else {f"{above}{key}": value}
    return flat


def test_what_a_model_does_not_have_is_missing_in_the_table_of_compare():
    found = sw.compare("paper", ["delay", "quasidynamic"], until=200, **{"drive.velocity": 2000, "slab.r": 2.2e-3})
    rows = found.summary["models"]
    assert [row["error"]["period"] for row in rows] == [0.0, None]
    assert_table(found, rows)
    notes = {name: found.dataset[name].attrs for name in ("period_std", "error_period", "wall_s", "model")}
    assert notes == {
        "period_std": {"long_name": "period standard deviation; time to the next event", "units": "1", "in_units_of": "transit"},
        "error_period": {"long_name": "relative error of period", "units": "1"},
        "wall_s": {"long_name": "run time in seconds", "units": "s"},
        "model": {"long_name": "model"},
    }


def test_bench_draws_the_error_of_the_period_over_the_time_of_each_run(monkeypatch):
    chosen = [family for family in families() if family.name in ("block8", "kelvin-voigt", "delay")]
    monkeypatch.setattr("validation.results.bench.honouring", lambda _: chosen)
    found = sw.bench("paper", until=200, **{"drive.velocity": 2000})
    rows = found.summary["models"]
    assert_table(found, rows)
    wanted = {
        model: (
            [row["wall_s"] for row in rows if row["model"] == model],
            [row["error"]["period"] for row in rows if row["model"] == model],
        )
        for model in ("block8", "kelvin-voigt", "delay")
    }
    axes = found.plot().axes[0]
    assert dict(zip([line.get_label() for line in axes.get_lines()], values(axes), strict=True)) == wanted
    assert all(row["error"]["period"] != row["error"]["stress_drop"] for row in rows)


@pytest.mark.filterwarnings("error")
def orbits(count):
    """Parameter, period, both drops and extreme rates, all different."""
    rows = np.array([[-2.7, 50.0, 0.1, 0.2, 900.0, 20.0]]) * (1.0 + 0.01 * np.arange(count)[:, None])
    return [tuple(row) for row in rows.tolist()]


def test_a_branch_shows_its_figures_and_where_stability_is_not_decided():
    decided = (True, False, None)
    points = [BranchPoint(*row, unstable, stable) for row, unstable, stable in zip(orbits(3), (0, 1, 0), decided, strict=True)]
    found = BranchResult(FollowedBranch(RANGES[0], "delay", 1e-6, points=points), BranchOptions(), 1.0)
    assert found.dataset["point_stable"].values.tolist() == [1, 0, -1]
    assert [point["stable"] for point in found.summary["points"]] == list(decided)
    names = ("period", "stress_drop", "elastic_stress_drop")
    for axes, name in zip(found.plot().axes, names, strict=True):
        drawn = [line for line in values(axes) if line[0]]
        assert drawn == [([point.value], [getattr(point, name)]) for point in points]
        assert found.dataset[f"point_{name}"].values.tolist() == [getattr(point, name) for point in points]


def test_a_curve_has_both_parameters_and_the_period_in_their_places():
    points = [CurvePoint(row[0], 100.0 + k, *row[1:], 1e-9, 1, 0, 0.6, 0.8) for k, row in enumerate(orbits(3))]
    found = CurveResult(Curve("NS", *RANGES, "delay", 1e-6, points=points), CurveOptions(), 1.0)
    first, second, period = ([getattr(point, name) for point in points] for name in ("first", "second", "period"))
    left, right = found.plot().axes
    assert (values(left), values(right)) == ([(first, second)], [(period, second)])
    assert (left.get_xlabel(), left.get_ylabel()) == ("log10_r", "V")
    for name, wanted in (("log10_r", first), ("V", second), ("period", period), ("multiplier_im", [0.8] * 3)):
        assert found.dataset[name].values.tolist() == wanted

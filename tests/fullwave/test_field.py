"""Field records: right values at right places, files that other programs read, nothing half-written."""

import dataclasses

import meshio
import numpy as np
import pytest
import xarray
from grid_scenes import PAPER, SCENES

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.fields.files import profile, write_field
from fullwave.fields.record import FieldRecord
from fullwave.finite_difference import Leapfrog
from slipwave.errors import SceneError
from slipwave.observe import HistoryObserver
from slipwave.scene.drive import Start, StartKind
from slipwave.scene.units import Units
from slipwave.solve import follow
from tests.field_window import record_field


@pytest.fixture(scope="module", params=["alike", "unlike"])
def recorded(request):
    chosen = SCENES[request.param]
    solver = Leapfrog(chosen, 32, 0.9)
    history = HistoryObserver(chosen.law, solver.nodes)
    field, final = record_field(solver, 60.0, 64.0, 1 / 8, [history])
    return field, final, history.columns(), chosen


def both_slabs(field):
    """Position, velocity and stress from the lower outer face (-1) to the upper one (1); alike slabs mirror each other."""
    upper = field.upper
    lower = field.lower or dataclasses.replace(upper, velocity=-upper.velocity)
    order = np.arange(lower.depth.size)[::-1]
    return (
        np.append(-lower.depth[order], upper.depth),
        np.append(lower.velocity[:, order], upper.velocity, axis=1),
        np.append(lower.stress[:, order], upper.stress, axis=1),
    )


def test_the_interface_agrees_with_the_observer(recorded):
    field, final, columns, _ = recorded
    position, velocity, stress = profile(field)
    middle = position.size - field.upper.depth.size
    assert (position[middle], position[middle - 1]) == (0.0, 0.0)
    slip = velocity[:, middle] - velocity[:, middle - 1]
    at = np.searchsorted(columns["time"], field.time - 1e-9)
    assert np.abs(columns["time"][at] - field.time).max() < 1e-9
    assert slip == pytest.approx(columns["slip_rate"][at], rel=1e-9)
    assert stress[:, middle] == pytest.approx(columns["stress"][at], rel=1e-12)
    assert stress[:, middle - 1] == pytest.approx(columns["stress"][at], rel=1e-12)
    assert final.mu == pytest.approx(stress[-1, middle], abs=2e-3)
    assert field.time[0] >= 60.0
    assert 63.99 < field.time[-1] < 64.2


def test_stress_between_unlike_layers_is_that_of_the_cells():
    """After 12 transits the stress is 1.6e-2 beyond that of steady sliding, and differs by 3e-7 from node to node."""
    chosen = slipwave.read("layered")
    solver = Leapfrog(chosen, 64, 0.5)
    follow(solver, 12.0)
    stress = solver.snapshot().upper.stress - chosen.steady_stress
    assert stress[0] > 1e-2
    assert np.abs(np.diff(stress)).max() < 1e-6


@pytest.mark.parametrize("name", ["alike", "unlike"])
def test_the_first_frame_after_a_jump_is_the_first_sample_and_the_run_stays_the_same(name):
    chosen = dataclasses.replace(SCENES[name], start=Start(StartKind.JUMP, 0.1))
    one, two = Leapfrog(chosen, 32, 0.9), Leapfrog(chosen, 32, 0.9)
    history = HistoryObserver(chosen.law, one.nodes)
    field, final = record_field(one, 0.0, 2.0, observers=[history])
    lower = -field.upper.velocity if field.lower is None else field.lower.velocity
    slip, columns = field.upper.velocity[:, 0] - lower[:, 0], history.columns()
    assert slip[0] == pytest.approx(columns["slip_rate"][0], rel=1e-12)
    assert slip[0] != pytest.approx(chosen.velocity, rel=0.01)
    assert field.upper.stress[0, 0] == pytest.approx(columns["stress"][0], rel=1e-12)
    assert follow(two, 2.0) == final
    assert one.state()["memory"].tobytes() == two.state()["memory"].tobytes()


def test_netcdf_has_names_units_and_coordinates(recorded, tmp_path):
    field, _, _, chosen = recorded
    path = tmp_path / "field.nc"
    write_field(path, field)
    with xarray.open_dataset(path) as found:
        assert (found.attrs["scene_digest"], found.attrs["transit_in_friction_time"]) == (chosen.digest, chosen.upper.round_trip)
        assert [found[name].attrs["in_units_of"] for name in ("time", "upper_velocity")] == ["transit", "V*"]
        assert np.array_equal(found["time"].values, field.time)
        parts = [(slab, name) for slab in field.slabs for name in ("depth", "velocity", "stress")]
        assert set(found.variables) == {"time", *("_".join(part) for part in parts)}
        assert ("lower" in field.slabs) == (not chosen.alike)
        for slab, name in parts:
            assert np.array_equal(found[f"{slab}_{name}"].values, getattr(field.slabs[slab], name))
            assert (field.slabs[slab].depth[0], field.slabs[slab].depth[-1]) == (0.0, 1.0)


def test_sheet_is_read_back(recorded, tmp_path):
    field, *_ = recorded
    path = tmp_path / "field.vtu"
    write_field(path, field)
    mesh = meshio.read(path)
    position, velocity, stress = both_slabs(field)
    moments = field.time.size
    assert mesh.points[:, 0].reshape(moments, -1) == pytest.approx(np.tile(field.time[:, None], position.size))
    assert mesh.points[:, 1].reshape(moments, -1) == pytest.approx(np.tile(position, (moments, 1)))
    assert mesh.point_data["velocity"].reshape(moments, -1) == pytest.approx(velocity)
    assert mesh.point_data["stress"].reshape(moments, -1) == pytest.approx(stress)
    quads = mesh.cells_dict["quad"]
    assert quads.shape[0] == (field.time.size - 1) * (position.size - 2)
    x, y = mesh.points[quads, 0], mesh.points[quads, 1]
    area = 0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1))
    assert area.min() > 0
    assert area.sum() == pytest.approx(2.0 * np.ptp(field.time))


def test_a_scene_with_units_has_them_in_its_files(tmp_path):
    """V* = 2.7 um/s, sigma = 5 MPa; the time from L/V* = 3.7 s."""
    units = Units(1e-5, 2.7e-6, 5e6)
    chosen = dataclasses.replace(slipwave.read("paper"), units=units)
    field, _ = record_field(DiscontinuousGalerkin(chosen, number=3, cells=2), 0.0, 1.0)
    sizes = {"time_s": chosen.upper.round_trip * 1e-5 / 2.7e-6, "velocity_m_per_s": 2.7e-6, "stress_Pa": 5e6}
    write_field(tmp_path / "field.vtu", field)
    mesh, seen = meshio.read(tmp_path / "field.vtu"), field.dataset()
    plain = {"time_s": mesh.points[:, 0], "velocity_m_per_s": mesh.point_data["velocity"], "stress_Pa": mesh.point_data["stress"]}
    for name, size in sizes.items():
        assert mesh.point_data[name] == pytest.approx(size * plain[name], rel=1e-14)
        told = seen["time" if name == "time_s" else f"upper_{name.split('_')[0]}"].attrs
        assert told["si_factor"] == pytest.approx(size, rel=1e-14)
        assert told["si_units"] == {"time_s": "s", "velocity_m_per_s": "m s-1", "stress_Pa": "Pa"}[name]
    assert "si_factor" not in seen["upper_depth"].attrs
    write_field(tmp_path / "field.xdmf", field)
    with meshio.xdmf.TimeSeriesReader(tmp_path / "field.xdmf") as reader:
        reader.read_points_cells()
        data = reader.read_data(3)[1]
    assert data["stress_Pa"] == pytest.approx(5e6 * data["stress"])
    assert data["velocity_m_per_s"] == pytest.approx(2.7e-6 * data["velocity"])


def test_series_is_read_back(recorded, tmp_path):
    field, *_ = recorded
    path = tmp_path / "field.xdmf"
    write_field(path, field)
    position, velocity, stress = both_slabs(field)
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, cells = reader.read_points_cells()
        assert reader.num_steps == field.time.size
        for step in (0, 3, field.time.size - 1):
            time, data, _ = reader.read_data(step)
            assert time == pytest.approx(field.time[step])
            assert (data["velocity"], data["stress"]) == (pytest.approx(velocity[step]), pytest.approx(stress[step]))
    assert points[:, 1] == pytest.approx(position)
    assert np.abs(points[:, [0, 2]]).max() == 0.0
    ends = position[cells[0].data]
    assert (ends[:, 1] > ends[:, 0]).all()
    assert np.sum(ends[:, 1] - ends[:, 0]) == pytest.approx(2.0)
    assert [entry.name for entry in tmp_path.iterdir()] == ["field.xdmf"]


def test_wrong_names_and_windows_are_refused(recorded, tmp_path):
    with pytest.raises(SceneError, match=r"must end in \.nc, \.vtu, \.xdmf"):
        write_field(tmp_path / "field.png", recorded[0])
    with pytest.raises(SceneError, match="cannot be written"):
        write_field(tmp_path / "absent" / "field.vtu", recorded[0])
    for start, end in ((5.0, 5.0), (5.0, 1.0), (float("nan"), 2.0)):
        with pytest.raises(SceneError, match="window"):
            FieldRecord(Leapfrog(PAPER, 16), start, end)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("interval", [1 / 16, 1 / 128])
def test_steps_that_are_exact_in_time_are_divided_as_finely_as_asked(interval):
    solver = DiscontinuousGalerkin(SCENES["unlike"], number=5, cells=2, time="exact")
    field, _ = record_field(solver, 10.0, 13.0, interval)
    assert np.diff(field.time).max() < 1.001 * interval
    assert solver.step > 8.0 * interval


def test_frames_lie_closer_than_the_pieces_of_a_march_of_high_order():
    """Eight steps of order 8 are half a transit: the record has every step, and the run is the same to the bit."""
    chosen = SCENES["unlike"]
    solver, plain = (DiscontinuousGalerkin(chosen, number=5, cells=2, time="explicit") for _ in range(2))
    field, final = record_field(solver, 10.0, 13.0)
    assert np.diff(field.time).max() < 1.001 * max(solver.step, 1 / 32)
    assert follow(plain, 13.0) == final
    assert field.time[-1] == plain.time
    assert np.array_equal(field.upper.velocity[-1], plain.snapshot().upper.velocity)
    # its pieces end where the record has frames in the midst of pieces
    other = DiscontinuousGalerkin(chosen, number=5, cells=2, cfl=0.25 * solver.cfl)
    follow(other, 10.9)
    at = np.argmin(np.abs(field.time - other.time))
    assert field.time[at] == pytest.approx(other.time, abs=1e-9)
    assert field.lower.stress[at] == pytest.approx(other.snapshot().lower.stress, abs=1e-7)


@pytest.mark.parametrize("name", ["alike", "unlike", "everything"])
def test_a_record_that_goes_on_is_the_one_of_a_run_in_one_piece(name):
    """Depths, times and both fields of both slabs."""
    straight, first, later = (Leapfrog(SCENES[name], 32, 0.9) for _ in range(3))
    whole, begun, resumed = (FieldRecord(solver, 20.0, 24.0, 1 / 8) for solver in (straight, first, later))
    follow(straight, 24.0, marks=[whole])
    follow(first, 22.0, marks=[begun])
    later.restore(first.state())
    resumed.restore(begun.state())
    follow(later, 24.0, marks=[resumed])
    assert resumed.field.time.tolist() == whole.field.time.tolist()
    assert resumed.field.slabs.keys() == whole.field.slabs.keys()
    for mine, wanted in zip(resumed.field.slabs.values(), whole.field.slabs.values(), strict=True):
        for part in ("depth", "velocity", "stress"):
            assert np.array_equal(getattr(mine, part), getattr(wanted, part)), part

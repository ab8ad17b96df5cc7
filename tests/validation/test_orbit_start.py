"""A run that starts on its orbit: all that it reports is on the clock that is 0 there, fields and ledger included."""

import numpy as np
import pytest
import xarray
from scipy.interpolate import CubicSpline

import slipwave
from fullwave.fields.record import record_field
from slipwave.observe import HistoryObserver
from slipwave.solve import follow
from validation.cli import main
from validation.registry.build import build
from validation.registry.families import explicit_time

CELLS, END = {"fd": 24, "dg:5": 4}, 10.0
SHARPNESS = {"fd": 1e-9, "dg:5": 3e-3}
"""Of a grid's own value at the interface against the friction solve's, relative: one and the same in the leapfrog."""


@pytest.fixture(scope="module", params=CELLS)
def recorded(request):
    chosen = slipwave.read("paper", ["start.kind=orbit"])
    solver = build(request.param, chosen, cells=CELLS[request.param], time=explicit_time(request.param))
    solver.keep_ledger()
    history = HistoryObserver(chosen.law, solver.nodes)
    field, final = record_field(solver, solver.time, END, 1 / 16, [history])
    return solver, field, final, history.columns()


def test_fields_carry_the_times_of_the_run(recorded):
    solver, field, final, columns = recorded
    sharpness = SHARPNESS[solver.model]
    assert field.time[0] == 0.0
    assert END - 1e-9 <= field.time[-1] == pytest.approx(solver.time, abs=1e-9)
    assert np.diff(field.time).min() > 0.05
    at = np.searchsorted(columns["time"], field.time[1:] - 1e-9)
    assert columns["time"][at] == pytest.approx(field.time[1:], abs=1e-9)
    assert 2.0 * field.upper.velocity[1:, 0] == pytest.approx(columns["slip_rate"][at], rel=sharpness)
    assert field.upper.stress[1:, 0] == pytest.approx(columns["stress"][at], abs=0.1 * sharpness)
    assert np.interp(END, columns["time"], columns["psi"]) == pytest.approx(final.psi, abs=1e-3)


def test_the_ledger_begins_on_the_orbit(recorded):
    """Friction's work from t = 0 on, by quadrature of the recorded motion: the approach is hundreds of times as much.

    Measured: 7e-3 of it for the leapfrog, whose powers are half a step late at the fastest moment of all; 6e-8 for dg."""
    solver, _, _, columns = recorded
    ledger = solver.energy()
    assert ledger is not None
    assert ledger.friction == pytest.approx(friction_work(solver, columns), rel=3e-2 if solver.model == "fd" else 1e-6)
    assert abs(ledger.residual) < 1e-11


def friction_work(solver, columns):
    times, first = np.unique(columns["time"], return_index=True)
    assert times[0] == pytest.approx(0.0, abs=0.2)
    power = (columns["stress"] * columns["slip_rate"])[first]
    return solver.scene.transit * float(CubicSpline(times, power).integrate(times[0], times[-1]))


def test_the_ledger_of_the_exact_march_is_asked_for_on_the_orbit():
    """It is kept from there on only, and so is the change of the stored energy. The samples miss the first part of the first
    step, 1e-3 of friction's work; that on the way to the orbit is hundreds of times as much."""
    chosen = slipwave.read("paper", ["start.kind=orbit"])
    solver = build("dg:5", chosen, cells=CELLS["dg:5"], time="exact")
    assert solver.energy() is None
    solver.keep_ledger()
    history = HistoryObserver(chosen.law, solver.nodes)
    follow(solver, END, [history])
    ledger = solver.energy()
    assert ledger.friction == pytest.approx(friction_work(solver, history.columns()), rel=1e-2)
    assert abs(ledger.residual) < 1e-11


def test_the_file_of_fields_begins_at_zero(tmp_path, capsys):
    out = tmp_path / "orbit.nc"
    words = ["run", "paper", "--set", "start.kind=orbit", "--model", "fd", "--cells", "16", "--until", "10"]
    assert main([*words, "--fields", str(out)]) == 0
    with xarray.open_dataset(out) as data:
        assert float(data["time"][0]) == 0.0
        assert 10.0 - 1e-9 <= float(data["time"][-1]) < 10.5

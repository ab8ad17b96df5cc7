"""The integrator marches what the impedance says: a small nudge grows or decays as the leading root of H + Z = 0 does."""

import dataclasses
import math

import numpy as np
import pytest
from one_port_scenes import EVERY
from scipy.interpolate import CubicSpline

from reduced.impedance import reduction_of
from reduced.ladder import Ladder
from reduced.stability import characteristic, critical_round_trip, leading_roots, scaled
from scene.observe import HistoryObserver, follow
from scene.scene import Scene
from scene.start import Start

_BEFORE, _AFTER, _STEP = 60.0, 160.0, 0.25


def measured_root(scene: Scene, model: str) -> complex:
    """Slow root per transit, by fitting x(t + 2h) - 2 e^(sigma h) cos(omega h) x(t + h) + e^(2 sigma h) x(t) = 0 to psi."""
    solver = Ladder(dataclasses.replace(scene, start=Start(size=1e-4)), reduction_of(scene, model), tolerance=1e-10)
    history = HistoryObserver(scene.law, solver.nodes, _BEFORE, _AFTER)
    follow(solver, _AFTER, [history])
    columns = history.columns()
    times, first = np.unique(columns["time"], return_index=True)
    grid = np.arange(_BEFORE + 2.0, _AFTER - 2.0, _STEP)
    x = CubicSpline(times, columns["psi"][first] - scene.steady_psi)(grid)
    gap = round(8.0 / _STEP)
    rows = np.column_stack([x[gap:-gap], x[: -2 * gap]])
    twice_cosine, product = np.linalg.lstsq(rows, x[2 * gap :], rcond=None)[0]
    roots = np.roots([1.0, -twice_cosine, -product])
    return complex(np.log(roots[np.argmax(roots.imag)])) / (gap * _STEP)


CASES = [
    ("plain", "kelvin-voigt"),
    ("ratio sqrt 2", "modal:3"),
    ("ratio 2", "kelvin-voigt"),
    ("layered", "modal:4"),
    ("grip", "quasidynamic"),
    ("grip", "fitted:3"),
    ("matched grip", "fitted:2"),
    ("standard linear", "fitted:3"),
    ("kelvin-voigt solid", "fitted:3"),
]


@pytest.mark.parametrize(("name", "model"), CASES)
def test_a_nudge_grows_as_the_leading_root_says(name, model):
    r_c, _ = critical_round_trip(EVERY[name], model)
    scene = scaled(EVERY[name], round_trip=1.01 * r_c / EVERY[name].transit)
    root = leading_roots(characteristic(scene, model))[0] * scene.transit
    assert measured_root(scene, model) == pytest.approx(root, rel=1e-4)


def test_without_a_spring_the_growth_is_real():
    scene = EVERY["reflection"]
    root = leading_roots(characteristic(scene, "fitted:3"))[0] * scene.transit
    solver = Ladder(dataclasses.replace(scene, start=Start(size=1e-9)), reduction_of(scene, "fitted:3"), tolerance=1e-10)
    at = [follow(solver, until).psi - scene.steady_psi for until in (60.0, 90.0)]
    assert math.log(at[1] / at[0]) / 30.0 == pytest.approx(root.real, rel=1e-3)

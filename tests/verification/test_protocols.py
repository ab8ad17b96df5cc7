"""Velocity steps and a hold against closed forms: a stiff loading that radiates nothing shows the friction law itself.

With x = V2/V1 and slip d since the step: the direct effect is a ln x, the evolution b ln x. What is left of the evolution is
b ln x exp(-d/L) with the slip law, b ln(1 + (x - 1) exp(-d/L)) with the ageing law. A hold of time t after steady sliding at V
heals b ln(1 + t V/L) with the ageing law, and nothing with the slip law, whose state needs slip.
"""

import math
from functools import cache

import pytest

import slipwave
from slipwave.observe.protocol import ProtocolObserver
from slipwave.solve import follow
from validation.compute.build import prepare

A, B, X = 0.01, 0.015, 10.0
HOLD = 30.0
"""In L/V."""

LEFT = {
    ("slip", X): 1.0,
    ("slip", 1 / X): 1.0,
    ("ageing", X): -math.log((X ** (1 / math.e) - 1) / (X - 1)),
    ("ageing", 1 / X): -math.log((X ** (-1 / math.e) - 1) / (1 / X - 1)),
}
"""Slip (in L) until 1/e of the evolution is left."""


@cache
def figures(model, law, transits, stiffness):
    """Stages of a step up, a step down, a hold and a restart; one L of slip at V takes so many `transits`; `stiffness` in
    sigma/L."""
    n = transits
    knots = [[0, 1], [n, 1], [n, X], [3 * n, X], [3 * n, 1], [15 * n, 1], [15 * n, 0], [(15 + HOLD) * n, 0], [(15 + HOLD) * n, 1]]
    scene = slipwave.read(
        "paper",
        {
            "interface": {"law": law, "a_star": 0.6, "a": A, "b": B},
            "slab": {"r": 1 / n, "epsilon": stiffness / n},
            "start.size": 0.0,
            "drive.velocity": knots,
            "run.until": (30 + HOLD) * n,
        },
    )
    solver = prepare(model, scene).solver
    observer = ProtocolObserver(scene, solver.nodes, scene.until)
    follow(solver, scene.until, [observer])
    return observer.figures


@pytest.mark.parametrize("law", ["ageing", "slip"])
def test_a_stiff_loading_shows_the_law(law):
    start, up, down, hold, slide = figures("quasistatic", law, 200, 1e4)
    assert [stage.kind for stage in (start, up, down, hold, slide)] == ["start", "step", "step", "hold", "slide"]
    for stage, x in ((up, X), (down, 1 / X)):
        assert stage.direct_effect == pytest.approx(A * math.log(x), abs=2e-5)  # 2e-6 measured: b/stiffness
        assert stage.evolution == pytest.approx(B * math.log(x), abs=2e-5)
        assert stage.slip_to_recovery == pytest.approx(LEFT[law, x], abs=2e-4)  # 2e-5 measured
    healed = B * math.log1p(HOLD) if law == "ageing" else 0.0
    assert slide.healing == pytest.approx(healed, abs=3e-5)  # 3e-6 measured
    assert start.steady_stress == pytest.approx(0.6, abs=1e-12)
    assert slide.steady_stress == pytest.approx(0.6, abs=2e-6)  # B HOLD exp(-15)
    assert hold.relaxation is not None
    assert not any(stage.stick_slips for stage in (start, up, down, hold, slide))


def test_the_wave_shows_it_but_for_what_it_radiates():
    """A wave needs some transits, of a thousandth of L each, to bring the slip rate to V; radiation is a part of a."""
    _, up, down, hold, slide = figures("delay", "ageing", 1000, 1.0)
    assert up.direct_effect == pytest.approx(A * math.log(X), rel=0.1)  # 0.02 measured
    assert down.direct_effect == pytest.approx(-A * math.log(X), rel=0.3)  # 0.11 measured
    assert up.evolution == pytest.approx(up.direct_effect + (B - A) * math.log(X), abs=1e-8)
    assert up.slip_to_recovery == pytest.approx(LEFT["ageing", X], rel=0.03)  # 0.004 measured
    assert slide.healing == pytest.approx(B * math.log1p(HOLD), rel=0.05)  # 0.009 measured
    assert hold.relaxation is not None
    assert hold.relaxation > 2 * A


def test_a_full_wave_shows_the_stages_of_the_delay_system():
    """Slabs whose waves matter: without them the direct effect is 9 % smaller."""
    knots = [[0, 100], [20.3, 100], [20.3, 300], [120, 300], [120, 0], [150, 0], [150, 300]]
    changes = {"slab.log10_r": -3.2, "start.size": 0.0, "drive.velocity": knots, "run.until": 260}
    exact, grid, still = (
        slipwave.run("paper", model, cells=cells, **changes).summary["protocol"]
        for model, cells in (("delay", None), ("fd", 100), ("quasidynamic", None))
    )
    for stage, name in ((1, "direct_effect"), (1, "evolution"), (1, "slip_to_recovery"), (2, "relaxation"), (3, "healing")):
        assert grid[stage][name] == pytest.approx(exact[stage][name], rel=3e-3)  # 4e-4 measured
        assert abs(still[stage][name] / exact[stage][name] - 1) > 1e-2

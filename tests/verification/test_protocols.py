"""Velocity steps and a hold against closed forms: a stiff loading that radiates nothing shows the friction law itself.

With x = V2/V1 and slip d since the step: the direct effect is a ln x, the evolution b ln x. What is left of the evolution is
b ln x exp(-d/L) with the slip law, b ln(1 + (x - 1) exp(-d/L)) with the ageing law. A hold of time t after steady sliding at V
heals b ln(1 + t V/L) with the ageing law, and nothing with the slip law, whose state needs slip.
"""

import math

import pytest

import slipwave
from slipwave.observe.protocol import ProtocolObserver
from slipwave.solve import follow
from validation.models.build import prepare

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


@pytest.mark.parametrize("law", ["ageing", "slip"])
def test_a_stiff_loading_shows_the_law(law):
    """A step up, a step down, a hold and a restart, by the quasi-static pair; one L of slip at V takes so many transits."""
    n, stiffness = 200, 1e4  # in sigma/L
    knots = [[0, 1], [n, 1], [n, X], [3 * n, X], [3 * n, 1], [15 * n, 1], [15 * n, 0], [(15 + HOLD) * n, 0], [(15 + HOLD) * n, 1]]
    interface, slab = {"law": law, "a_star": 0.6, "a": A, "b": B}, {"r": 1 / n, "epsilon": stiffness / n}
    run = {"start.size": 0.0, "drive.velocity": knots, "run.until": (30 + HOLD) * n}
    scene = slipwave.read("paper", {"interface": interface, "slab": slab} | run)
    solver = prepare("quasistatic", scene).solver
    observer = ProtocolObserver(scene, solver.nodes, scene.until)
    follow(solver, scene.until, [observer])
    start, up, down, hold, slide = observer.figures
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

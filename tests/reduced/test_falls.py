"""Slip that reverses, for laws that allow v <= 0: random pairs of slabs, mirrored motions, the kink of |v| in one step."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from reduced.delay.system import delay_system
from slipwave import read
from slipwave.errors import NumericsError
from slipwave.friction import law_of_step, rate_of, rates, respond, to_own, to_step, unknown_of
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.scene.drive import Drive
from slipwave.solve import follow
from slipwave.step.collocation import rule_of
from slipwave.step.impedance import Diagonal
from slipwave.step.newton import solve
from slipwave.step.nodal import NOT_SMOOTH, nodal_of
from tests.reduced.test_random_networks import fit_out
from validation.models.build import build

KINDS = ("alike", "unlike", "irrational", "layered", "grip", "reflection", "machine")
LAWS = ("ageing-regularised", "slip-regularised", "spinodal")
CELLS = (512, 2048)
ALLOWED, BY_FD = 10.0, 0.05


class Fall(NamedTuple):
    """`halved`: the largest difference of psi and mu at the end from those by steps half as long, over the tolerance; `fd`: that
    from `fd`; whether v `reverses` in the run."""

    seed: int
    halved: float
    fd: float
    reverses: bool

    @property
    def is_right(self):
        return self.halved <= ALLOWED and self.fd <= BY_FD


def random_fall(seed):
    rng = np.random.default_rng(seed)
    kind, law = KINDS[seed % len(KINDS)], LAWS[seed // len(KINDS) % len(LAWS)]
    a = rng.uniform(0.01, 0.05)
    epsilon, r = 10.0 ** rng.uniform(-5.0, -4.0), 10.0 ** rng.uniform(-3.2, -2.3)
    upper = {"epsilon": epsilon, "r": r}
    lower = dict(upper)
    if kind != "alike":
        lower = {"epsilon": epsilon * rng.uniform(0.3, 3.0), "r": r * rng.choice([0.5, 1.0, 1.5, 2.0])}
    if kind == "irrational":
        lower["r"] = r * rng.uniform(0.5, 2.0)
    fit_out(rng, upper, kind, [0.25, 0.5, 0.75])
    ratio = 10.0 ** rng.uniform(np.log10(30.0), 6.0)
    velocity = 10.0 ** rng.uniform(-0.3, 0.5) / min(upper["epsilon"], lower["epsilon"])  # waves that friction cannot carry
    rise, fall = np.round(rng.uniform([2.0, 12.0], [6.0, 18.0]) * 4.0) / 4.0
    if rng.random() < 0.3:
        rise, fall = rng.uniform([2.0, 12.0], [6.0, 18.0])
    after = velocity / ratio if rng.random() < 0.8 else 0.0
    ramp = rng.uniform(0.2, 2.0) if rng.random() < 0.3 else 0.0
    knots = [[0.0, 100.0], [rise, 100.0], [rise, velocity], [fall, velocity], [fall + ramp, after]]
    interface = {"law": law, "a_star": 0.369, "a": a, "b": a * rng.uniform(0.7, 2.0)}
    if law == "spinodal":
        interface |= {"cutoff_velocity": 10.0 ** rng.uniform(3.0, 6.0), "saturation_velocity": 10.0 ** rng.uniform(-4.0, -1.0)}
    drive = {"velocity": [[float(t), float(v)] for t, v in knots]}
    slabs = {"upper": upper, "lower": lower}
    return read(slabs | {"interface": interface, "drive": drive, "start": {"size": 0.0}, "run": {"until": 31.87}})


class Lowest:
    least = np.inf

    def scan(self, pieces):
        self.least = min(self.least, pieces.z.min())


def judge(seed, tolerance=1e-9):
    scene, lowest = random_fall(seed), Lowest()
    solver = delay_system(scene, tolerance)
    final = follow(solver, scene.until, observers=[lowest])
    finer = delay_system(scene, tolerance)
    while finer.steps < 2.0 * solver.steps:
        finer._refine(NOT_SMOOTH)
    ends = [np.array([one.psi, one.mu]) for one in (final, follow(finer, scene.until), by_leapfrog(scene))]
    differences = [float(np.abs(one - ends[0]).max()) for one in ends[1:]]
    return Fall(seed, differences[0] / tolerance, differences[1], bool(lowest.least < 0.0))


def by_leapfrog(scene):
    """The end of the run by `fd`, with more cells where its steps are too long for the state."""
    try:
        return follow(build("fd", scene, cells=CELLS[0]), scene.until)
    except NumericsError:
        return follow(build("fd", scene, cells=CELLS[1]), scene.until)


FALL = {"velocity": [[0.0, 100.0], [4.0, 100.0], [4.0, 2e4], [8.0, 2e4], [8.0, 1.0]]}
PLAIN = {"interface": {"law": "ageing-regularised", "a_star": 0.369, "a": 0.0349, "b": 0.0489}, "start": {"size": 0.0}}
SLABS = {"upper": {"epsilon": 5.6e-05, "r": 10.0**-2.8}, "lower": {"epsilon": 2.8e-05, "r": 10.0**-2.8}}
FALLS = PLAIN | SLABS | {"drive": FALL}


@pytest.mark.parametrize("seed", range(0, 24, 2))
def test_falls_march_through_rest(seed):
    found = judge(seed)
    assert found.is_right, found


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 105, 15))
def test_many_falls_march_through_rest(first):
    found = [judge(seed) for seed in range(first, first + 15)]
    assert not [one for one in found if not one.is_right]
    assert sum(one.reverses for one in found) >= 9


@pytest.mark.parametrize("seed", range(len(KINDS)))
@pytest.mark.parametrize("model", ["delay", "dg:4"])
def test_a_mirrored_drive_mirrors_slip_and_stress(seed, model):
    """V -> -V: v and mu change their signs, psi does not."""
    scene = random_fall(seed)
    mirrored = replace(scene, drive=Drive(scene.drive.times, tuple(-v for v in scene.drive.velocities)))
    there, back = (follow(build(model, one), 20.0) for one in (scene, mirrored))
    assert back.psi == pytest.approx(there.psi, abs=1e-12)
    assert (back.v, back.mu) == pytest.approx((-there.v, -there.mu), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_a_step_integrates_the_kink_of_the_state_where_slip_reverses(law):
    """One step in which the stress falls through zero, against an adaptive integration that stops there."""
    changes = {"cutoff_velocity": 1e4, "saturation_velocity": 1e-3} if law == "spinodal" else {}
    scene = read(PLAIN | SLABS | {"interface": PLAIN["interface"] | {"law": law} | changes, "drive": {"velocity": 100.0}})
    law, size, h, psi = scene.law, scene.impedance, 4e-3, -3.0

    def stress(x):
        return 0.04 - 0.1 * x

    def rate(x, state):
        z = brentq(lambda z: respond(law, z, state[0])[2] + size * rate_of(law, z) - stress(x), -90.0, 90.0, xtol=1e-15)
        return [h * respond(law, z, state[0])[5]]

    state = [psi]
    for begin, end in ((0.0, 0.4), (0.4, 1.0)):
        state = solve_ivp(rate, (begin, end), state, rtol=1e-12, atol=1e-13).y[:, -1]
    (rule, compiled, nodes), nodal, here = rule_of(8), nodal_of(8), law_of_step(law, psi)
    nodal.incoming[:], nodal.left[:], nodal.psi[:], nodal.z[:] = stress(rule.nodes), psi, psi, unknown_of(law, 1.0)
    to_step(here, law, nodal.z)
    assert solve(here, nodes, Diagonal(size), h, compiled, 1e-13, nodal) > 0
    assert nodal.psi[-1] == pytest.approx(state[0], abs=1e-9)
    to_own(here, nodal.z)
    assert nodal.v == pytest.approx(rates(law, nodal.z), rel=1e-12, abs=1e-18)


MODELS = ("fd", "sbp:4", "fem:4", "dg:7", "quasidynamic", "block8", "kelvin-voigt", "modal:4", "fitted:4")


@pytest.mark.parametrize("model", MODELS)
def test_every_model_marches_through_rest(model):
    same = {"upper": SLABS["lower"], "lower": SLABS["lower"]}
    solver = build(model, read(FALLS | same))
    lowest = HistoryObserver(solver.scene.law, solver.nodes)
    assert math.isfinite(follow(solver, 12.0, [lowest]).v)
    assert model == "quasidynamic" or lowest.columns()["slip_rate"].min() < 0.0  # its slip follows V without a swing


def test_explicit_grids_march_through_rest_as_exact_ones():
    scene = read(FALLS)
    ends = [follow(build("dg:7", scene, cells=16, time=time), 11.9) for time in ("exact", "explicit")]
    assert [ends[1].psi, ends[1].mu] == pytest.approx([ends[0].psi, ends[0].mu], abs=1e-2)


def test_samples_between_nodes_and_extrema_are_those_of_a_smooth_rate():
    """A coarse march, read between its nodes, against one in many more steps; slip events find v below zero."""
    scene, seen = read(FALLS), []
    for tolerance in (1e-9, 1e-12):
        solver = delay_system(scene, tolerance)
        history, events = HistoryObserver(scene.law, solver.nodes), EventObserver(scene, solver.nodes)
        final = follow(solver, 11.9, [history, events])
        seen.append(rates(scene.law, history.at(np.linspace(8.31, 11.8, 801))[1]))
        assert final.v == pytest.approx(rate_of(scene.law, history.at(np.array([11.9]))[1, 0]), rel=1e-9)
    assert seen[1].min() < -1e-2
    assert seen[0] == pytest.approx(seen[1], rel=1e-5, abs=1e-6)


def test_a_law_that_needs_slip_says_where_it_stopped_and_which_law_does_not_need_it():
    law = {"law": "ageing", "a_star": 0.369, "a": 0.005, "b": 0.006}
    drive = {"velocity": [[0.0, 100.0], [20.0, 100.0], [20.0, 3e4], [30.0, 3e4], [30.0, 1.0]]}
    scene = read(FALLS | {"interface": law, "drive": drive, "upper": SLABS["lower"]})
    with pytest.raises(
        NumericsError, match=r"t = 30 .*stops or reverses slip, but law 'ageing' needs v > 0: ageing-regularised, "
    ):
        follow(delay_system(scene), 48.0)
    follow(delay_system(read(scene, {"interface.law": "ageing-regularised"})), 48.0)

"""Roots, counts and critical values of every scene and model, also in SI; closed forms as yardsticks."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from one_port_scenes import EPSILON, EVERY, LOSSY, PAPER, ROUND_TRIP, paper, scene_of, slab

import slipwave
from reduced import closed_forms
from reduced.parameters import thickened
from reduced.stability import (
    analyse,
    characteristic,
    critical_epsilon,
    critical_round_trip,
    crossing,
    error_law,
    essential_abscissa,
    friction_slopes,
    leading_roots,
    scaled,
    spectrum,
    unstable_count,
)
from reduced.stability.analyse import stability_in_si
from reduced.stability.boundary import boundary
from reduced.stability.spectrum import _polish, _zeros_in
from slipwave.errors import NumericsError, SceneError
from slipwave.friction import respond, steady_state, unknown_of
from slipwave.friction.ageing import Ageing, AgeingRegularised
from slipwave.friction.cutoff import AgeingCutoff, SlipCutoff
from slipwave.friction.slip import Slip, SlipRegularised
from slipwave.friction.spinodal import Spinodal
from slipwave.scene.slab import KelvinVoigtViscosity, ReflectingFace, StandardLinearViscosity
from tests.granite import GRANITE

SLOPES = friction_slopes(PAPER, 100.0)
LAWS = [PAPER, Slip(*PAPER), AgeingRegularised(*PAPER), SlipRegularised(*PAPER), Ageing(0.6, 0.01, 0.015)]
LAWS += [AgeingCutoff(*PAPER, 40.0), SlipCutoff(*PAPER, 40.0), Spinodal(*PAPER, 0.02, 40.0)]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("velocity", [1e-3, 1.0, 100.0, 1e4])
def test_friction_impedance_of_every_law(law, velocity):
    """F_ss' by differencing the steady state itself; H(s) by solving the linearised law as a 2 x 2 system."""
    slopes = friction_slopes(law, velocity)

    def steady_stress(v):
        return respond(law, unknown_of(law, v), steady_state(law, v))[2]

    step = 1e-5 * velocity
    assert slopes.steady == pytest.approx(
        (steady_stress(velocity + step) - steady_stress(velocity - step)) / (2 * step), rel=1e-6
    )
    assert slopes.healing == pytest.approx(math.hypot(velocity, getattr(law, "saturation_velocity", 0.0)), rel=1e-9)
    _, v_z, _, f_z, f_psi, _, g_z, g_psi = respond(law, unknown_of(law, velocity), steady_state(law, velocity))
    omega = 0.7 * velocity
    z, psi = np.linalg.solve([[v_z, 0.0], [-g_z, 1j * omega - g_psi]], [1.0, 0.0])
    assert slopes.impedance_at(omega) == pytest.approx(f_z * z + f_psi * psi, rel=1e-12)


def quasidynamic_r(slopes, epsilon):
    """Critical r with radiation damping, r_*/(1 - r_* G_phi/2); inf where the damping alone stabilises (Z = eps/s + eps/2; not in
    the paper)."""
    left = 1.0 - 0.5 * closed_forms.quasistatic_r(slopes, epsilon) * slopes.healing
    return closed_forms.quasistatic_r(slopes, epsilon) / left if left > 0.0 else math.inf


@pytest.mark.parametrize("velocity", np.geomspace(1.0, 1e4, 9))
@pytest.mark.parametrize(
    ("model", "closed"),
    [
        ("delay", closed_forms.delay_r),
        ("kelvin-voigt", closed_forms.kelvin_voigt_r),
        ("quasistatic", closed_forms.quasistatic_r),
        ("quasidynamic", quasidynamic_r),
    ],
)
def test_critical_r_against_its_closed_form(model, closed, velocity):
    slopes = friction_slopes(PAPER, velocity)
    r, omega = critical_round_trip(paper(velocity=velocity), model)
    expected = closed(slopes, EPSILON)
    if math.isinf(expected):
        assert math.isnan(r)
        return
    assert r == pytest.approx(expected, rel=1e-12)
    if model != "quasidynamic":
        assert omega == pytest.approx(slopes.omega_c, rel=1e-13)


def test_a_crossing_above_which_other_roots_still_grow_is_no_critical_epsilon():
    """A pair crosses at 1.4498e-6, but 22 roots grow above it, whatever epsilon is."""
    rock = slipwave.read("rock")
    rock = scaled(rock, round_trip=0.01 / rock.transit)
    shares = (1.43e-6, 1.47e-6, 1e-4, 1e-1)
    counts = [unstable_count(characteristic(scaled(rock, epsilon=size / rock.upper.epsilon))) for size in shares]
    assert counts == [24, 22, 22, 22]
    assert math.isnan(critical_epsilon(rock))


def test_critical_epsilon_closed_forms():
    for exponent in (-3.0, -2.68, -2.0, -1.6):
        r = 10**exponent
        assert critical_epsilon(paper(r)) == pytest.approx(closed_forms.delay_epsilon(SLOPES, r), rel=1e-12)
        wanted = closed_forms.kelvin_voigt_epsilon(SLOPES, r)
        assert critical_epsilon(paper(r), "kelvin-voigt") == pytest.approx(wanted, rel=1e-12)
    assert math.isnan(critical_epsilon(paper(4.0 / SLOPES.omega_c), "kelvin-voigt"))
    assert closed_forms.kelvin_voigt_epsilon(SLOPES, 4.0 / SLOPES.omega_c) < 0.0


MODELS = ["delay", "quasidynamic", "block12", "kelvin-voigt", "modal:3"]
CASES = [(name, model) for name in EVERY for model in MODELS] + [("grip", "fitted:3"), ("standard linear", "fitted:3")]

NOT_FOR_LOSS = [("block12", name) for name in LOSSY] + [("kelvin-voigt", name) for name in [*LOSSY, "layered"]]
NOT_FOR_LOSS += [("modal:3", name) for name in LOSSY] + [("quasidynamic", "reflection")]


@pytest.mark.parametrize(("name", "model"), [case for case in CASES if case[::-1] not in NOT_FOR_LOSS])
def test_critical_values_part_stable_from_unstable(name, model):
    scene = EVERY[name]
    r, _ = critical_round_trip(scene, model)
    assert math.isnan(r) == (name == "reflection")  # without a spring steady sliding gives way at s = 0, whatever r
    epsilon = critical_epsilon(scene, model)
    counts = [unstable_count(characteristic(scaled(scene, epsilon=epsilon / EPSILON * f), model)) for f in (0.999, 1.001)]
    assert counts == ([1, 0] if name == "reflection" else [2, 0])
    if name == "reflection":
        return
    counts = [unstable_count(characteristic(scaled(scene, round_trip=r / scene.transit * f), model)) for f in (0.999, 1.001)]
    assert counts == [0, 2]


def test_no_critical_r_is_told_where_the_root_that_grows_cannot_be_told_from_zero(monkeypatch):
    """As without a spring at the critical epsilon, where steady sliding gives way at s = 0 whatever r."""
    monkeypatch.setattr(crossing, "leading_roots", lambda *_: np.empty(0, dtype=complex))
    with pytest.raises(NumericsError, match="neutral within rounding"):
        crossing.critical_factor(lambda factor: paper(ROUND_TRIP * factor), "delay")


def test_a_phase_at_which_the_frequency_is_zero_has_no_round_trip():
    """Here it is zero to the last bit at one phase, and the round trip there was divided by it, with a warning."""
    scene = slipwave.read("steel-on-pmma", {"interface.normal_stress": "0.31622776601683794 MPa", "lower.thickness": "500 mm"})
    r, omega = critical_round_trip(scene)
    assert (math.log10(r), omega) == (pytest.approx(-5.20998334821, abs=1e-10), pytest.approx(696.147261, rel=1e-8))


def test_a_boundary_ends_where_its_frequency_falls_to_zero():
    """Z(0) = epsilon (1 + R)/(1 - R) of a face without a spring: a single root crosses at V = (b - a)/Z(0), whatever r."""
    scene = scene_of(slab(face=ReflectingFace(0.5)), slab())
    ranges = (0.001, 0.02), (100.0, 220.0)
    (found,) = boundary(lambda r, v: scaled(scene, round_trip=r / scene.transit, velocity=v), "fitted:2", ranges)
    (end,) = found.vanishing
    assert found.second[end] == pytest.approx((PAPER.b - PAPER.a) / (3.0 * EPSILON), rel=1e-4)
    assert found.omega[end] < 0.01 * found.omega.max()
    assert np.count_nonzero(found.second > 1.01 * found.second[end]) > 20  # few points where it hardly moves
    assert np.count_nonzero(found.second < 1.01 * found.second[end]) < 20


@pytest.mark.parametrize("name", EVERY)
def test_leading_roots_solve_the_equation_and_tell_stability(name):
    problem = characteristic(EVERY[name])
    roots = leading_roots(problem)
    assert roots.size >= 4
    assert np.all(np.abs(problem.imbalance(roots)) < 1e-9)
    assert np.all(np.diff(roots.real) <= 1e-9 * np.abs(roots[0]))
    assert np.sum(roots.real > 0.0) == unstable_count(problem)


@pytest.mark.parametrize(("time", "ratio"), [(10.0, 0.2), (3.0, 20.0)])
def test_no_root_is_sought_where_the_modulus_of_a_viscous_slab_vanishes(time, ratio):
    """Left of the relaxed rate D is not analytic, and a count there certifies nothing."""
    zener = StandardLinearViscosity(time * ROUND_TRIP, ratio)
    roots = leading_roots(characteristic(scene_of(slab(viscosity=zener))))
    assert roots.real.min() > -1.0 / (zener.time * (1.0 + ratio))


def test_leading_roots_of_an_ode_are_its_eigenvalues():
    quartic = closed_forms.kelvin_voigt_quartic(SLOPES, EPSILON, ROUND_TRIP)
    eigenvalues = np.roots(quartic)
    roots = leading_roots(characteristic(paper(), "kelvin-voigt"))
    in_order = [values[np.argsort(values.imag)] for values in (roots, eigenvalues)]
    assert in_order[0] == pytest.approx(in_order[1], rel=1e-9)


@pytest.mark.parametrize("name", [n for n in EVERY if n not in ("kelvin-voigt solid", "matched grip", "layered", "ratio sqrt 2")])
def test_fast_roots_pile_up_at_the_essential_abscissa(name):
    """Newton from far up the imaginary axis, at 300 phases: the rightmost fast root found lies where the formula says."""
    scene = EVERY[name]
    problem = characteristic(scene)
    abscissa = essential_abscissa(scene)
    phases = np.linspace(0.0, 4.0 * np.pi, 60)[None, :] + 1e5
    shifts = np.linspace(0.5, 1.5, 5)[:, None]
    starts = (abscissa * shifts + 1j * phases / scene.transit).ravel()
    found = _polish(problem.jet, starts)
    found = found[np.isfinite(found)]
    found = found[~problem.idle(found) & (found.imag > 9e4 / scene.transit)]
    assert found.real.max() == pytest.approx(abscissa, rel=2e-3)


def test_essential_abscissa_closed_form():
    for velocity in (1.0, 100.0, 3e3):
        slopes = friction_slopes(PAPER, velocity)
        direct = 2.0 * slopes.direct
        wanted = -math.log(abs((direct + EPSILON) / (direct - EPSILON))) / ROUND_TRIP  # (37) at high frequency
        assert essential_abscissa(paper(velocity=velocity)) == pytest.approx(wanted, rel=1e-10)
    assert essential_abscissa(EVERY["matched grip"]) == -math.inf
    assert essential_abscissa(EVERY["ratio sqrt 2"]) == pytest.approx(0.0, abs=1e-6)
    assert essential_abscissa(scene_of(slab(viscosity=KelvinVoigtViscosity(0.5)))) == -2.0


def test_a_face_that_swallows_the_load_fails_without_oscillating():
    found = analyse(EVERY["reflection"])
    assert (found.unstable_roots, found.leading_roots[0].imag) == (1, 0.0)


@pytest.mark.parametrize("model", ["quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:3"])
def test_error_laws(model):
    """The measured error of the critical r tends to the law as theta = r omega_c -> 0, at the law's power."""
    law = error_law(model, SLOPES)
    ratios = []
    for epsilon in (EPSILON, 0.5 * EPSILON, 0.25 * EPSILON):
        exact, omega = critical_round_trip(paper(epsilon=epsilon))
        reduced, _ = critical_round_trip(paper(epsilon=epsilon), model)
        ratios.append((reduced / exact - 1.0) / law.at(exact * omega))
    assert ratios[0] == pytest.approx(1.0, abs=0.2 if model == "quasidynamic" else 0.02)
    assert abs(ratios[1] - 1.0) < 0.6 * abs(ratios[0] - 1.0) + 1e-4


def test_error_laws_known_coefficients():
    known = {"quasistatic": (1 / 12, 2), "block8": (-1 / 24, 2), "block12": (1 / 720, 4), "kelvin-voigt": (-1 / 480, 4)}
    for model, (coefficient, power) in known.items():
        law = error_law(model, SLOPES)
        assert (law.coefficient, law.power) == (pytest.approx(coefficient, rel=1e-12), power)
    assert error_law("modal:1", SLOPES).coefficient == pytest.approx(1 / 720 - 2 / (2 * math.pi) ** 4, rel=1e-10)
    with pytest.raises(SceneError):
        error_law("fd", SLOPES)


def polynomial(*zeros):
    def jet(s):
        factors = np.array([s - zero for zero in zeros])
        others = [np.prod(np.delete(factors, k, axis=0), axis=0) for k in range(len(zeros))]
        return SimpleNamespace(value=np.prod(factors, axis=0), slope=np.sum(others, axis=0))

    return jet


@pytest.mark.parametrize("apart", [1.0, 1e-3, 1e-6])
def test_all_zeros_are_found_each_once(apart):
    true = np.array([0.3 + 0.2j, 0.3 + apart + 0.2j, 1.7 - 0.6j, *(0.1 * k + 0.9j for k in range(1, 9))])
    found = _zeros_in(polynomial(*true), -1.0 - 1.0j, 2.0 + 1.5j, true.size)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(true), abs=1e-9)


def test_a_double_zero_is_refused():
    with pytest.raises(NumericsError, match=r"2 roots near s = 0.3\+0.19999\dj are too close to be distinguished"):
        _zeros_in(polynomial(0.3 + 0.2j, 0.3 + 0.2j), -1.0 - 1.0j, 2.0 + 1.5j, 2)


LAYERS = [{"fraction": 0.25, "impedance": 1.0}, {"fraction": 0.75, "impedance": 1.3205112733541364}]
WEAK = {"a": 0.01637744400505154, "b": 0.019652932806061847, "drive.velocity": 64.26056043569865}
SLABS = {"upper.epsilon": 2.2149407956191375e-05, "upper.r": 0.00720178162771619, "upper.layers": LAYERS}
BELOW = {"lower.epsilon": 0.00010064574189421088, "lower.r": 0.010802672441574285}


def test_the_list_begins_with_the_leading_root_however_fast_it_is():
    """Another program found -0.00268 + 10.37 i per transit, beyond two ripples of the thicker slab."""
    scene = slipwave.read_scene("unlike", **WEAK, **SLABS, **BELOW)
    found = analyse(scene)
    assert found.leading_roots[0] * scene.transit == pytest.approx(-0.00267959 + 10.3696119j, rel=1e-7)
    assert abs(complex(characteristic(scene).imbalance(found.leading_roots[0]))) < 1e-12
    assert not found.endless


@pytest.mark.parametrize("seed", range(12))
def test_no_root_of_many_starts_lies_right_of_the_list_and_of_where_roots_accumulate(seed):
    random = np.random.default_rng(seed)
    parts = random.permutation([0.25, 0.25, 0.5])[: random.integers(2, 4)]
    layers = [{"fraction": part / parts.sum(), "impedance": random.uniform(0.3, 3.0)} for part in parts]
    ratio = random.choice([1.0, 1.5, 2.0, 3.0])
    thickness = {"upper.r": 0.003, "lower.r": 0.003 * ratio, "upper.layers": layers}
    impedances = {"upper.epsilon": 10 ** random.uniform(-5, -4), "lower.epsilon": 10 ** random.uniform(-5, -4)}
    scene = slipwave.read_scene("unlike", **WEAK, **thickness, **impedances)
    found, problem = analyse(scene), characteristic(scene)
    heights, depths = np.linspace(0.1, 200.0, 1500), np.array([0.0, -0.01, -0.1])
    roots = _polish(problem.jet, (depths[:, None] + 1j * heights).ravel() / scene.transit)
    roots = roots[np.isfinite(roots)]
    roots = roots[~problem.idle(roots)]
    assert roots.size > 100
    assert roots.real.max() * scene.transit < max(found.rate, found.essential_abscissa) * scene.transit + 1e-9


def test_a_solid_that_creeps_has_no_finite_list_of_leading_roots():
    """Its fastest creep, 1/(time (1 + ratio)), is where roots accumulate; all others decay faster."""
    viscous = {"slab.viscosity": {"kind": "standard-linear", "time": 0.05, "ratio": 1.0}}
    scene = slipwave.read_scene("paper", **viscous, **{"drive.velocity": 2000.0, "a": 0.03, "b": 0.0301})
    result = slipwave.stability(scene)
    assert result.summary["leading_roots"] == []
    assert result.analysis.endless
    assert result.analysis.rate == result.summary["essential_abscissa"] == pytest.approx(-10.0)
    assert "no finite list" in " ".join(result.summary["notes"])


MACHINE = GRANITE | {
    "slab": GRANITE["slab"] | {"thickness": 0.2, "face": {"kind": "machine", "stiffness": 1.6e9, "impedance": 2e6, "mass": 400.0}}
}
GRIP = GRANITE | {"slab": GRANITE["slab"] | {"face": {"kind": "grip", "stiffness": "10 GPa/m", "impedance": 0.0}}}
"""1/k = 2 (h/G + 1/K) is L/((b - a) sigma) at h = 3 m; over 5 GPa/m is needed for any h."""
OTHER = {"density": 1190.0, "shear_modulus": 2e9, "thickness": 0.4}
UNLIKE = {key: value for key, value in GRANITE.items() if key != "slab"} | {"upper": GRANITE["slab"], "lower": OTHER}
VISCOUS = GRANITE | {"slab": GRANITE["slab"] | {"viscosity": {"kind": "kelvin-voigt", "time": 1e-6}}}


def leading(scene):
    """Real part of the leading root over its frequency."""
    root = analyse(scene).leading_roots[0]
    return root.real / abs(root.imag)


def test_granite_by_hand():
    """Quasi-static spring G/(2 h) of two slabs h thick: stable if it is above (b - a) sigma/L, so h_c = G L/(2 sigma (b - a)),
    and inertia changes that by less than 1e-7 here; sigma_c = G L/(2 h (b - a)). Roots of the spring-slider at h = 10 m:
    a s^2 + (a + k - b) s + k = 0 in units of V/L with k = G L/(2 h sigma) = 0.003: s = 0.1 +- i sqrt(0.3 - 0.01)."""
    scene = slipwave.read(GRANITE)
    found = stability_in_si(scene, analyse(scene))
    assert found.thickness == pytest.approx(10.0, rel=1e-12)
    assert found.critical_thickness == pytest.approx(30e9 * 1e-5 / (2.0 * 5e6 * 0.005), rel=1e-6)
    assert found.critical_normal_stress == pytest.approx(30e9 * 1e-5 / (2.0 * 10.0 * 0.005), rel=1e-6)
    assert found.growth_time == pytest.approx(10.0 / 0.1, rel=1e-5)
    assert math.isnan(found.decay_time)
    assert found.frequency == pytest.approx(math.sqrt(0.29) / (2.0 * math.pi * 10.0), rel=1e-5)


@pytest.mark.parametrize(
    "tables", [GRANITE, MACHINE, GRIP, UNLIKE, VISCOUS], ids=["granite", "machine", "grip", "unlike", "viscous"]
)
def test_the_scene_read_again_at_its_critical_values_is_neutral(tables):
    scene = slipwave.read(tables)
    found = stability_in_si(scene, analyse(scene))
    assert abs(leading(scene)) > 1e-3
    stressed = slipwave.read(tables, [f"interface.normal_stress={found.critical_normal_stress!r}"])
    assert abs(leading(stressed)) < 1e-8
    if math.isfinite(found.critical_thickness):
        factor = found.critical_thickness / found.thickness
        keys = ("upper", "lower") if "upper" in tables else ("slab",)
        thick = slipwave.read(tables, [f"{key}.thickness={tables[key]['thickness'] * factor!r}" for key in keys])
        assert abs(leading(thick)) < 1e-8


def test_a_grip_in_si_stays_as_it_is_where_the_critical_thickness_is_looked_for():
    """By hand, up to inertia: 3 m behind 10 GPa/m, none behind 4 GPa/m; a grip relative to the slab scales with it."""
    scene = slipwave.read(GRIP)
    assert stability_in_si(scene, analyse(scene)).critical_thickness == pytest.approx(3.0, rel=1e-6)
    soft = slipwave.read(GRIP, ["slab.face.stiffness='4 GPa/m'"])
    assert math.isnan(stability_in_si(soft, analyse(soft)).critical_thickness)
    relative = slipwave.read(GRIP, [f"slab.face.stiffness={scene.upper.face.stiffness!r}"])
    critical = 10.0 * 10.0 ** analyse(relative).log10_r_c / relative.transit
    assert stability_in_si(relative, analyse(relative)).critical_thickness == pytest.approx(critical, rel=1e-12)


def test_a_thicker_slab_keeps_its_machine():
    """What the scene would be if it were read with that thickness: the machine is given per area, in SI."""
    thick = thickened(slipwave.read(MACHINE), 3.0).upper
    again = slipwave.read(MACHINE, [f"slab.thickness={0.6!r}"]).upper
    assert thick.round_trip == pytest.approx(again.round_trip, rel=1e-12)
    for name in ("stiffness", "impedance", "mass"):
        assert getattr(thick.face, name) == pytest.approx(getattr(again.face, name), rel=1e-12)


def test_no_units_no_thickness_and_no_weakening():
    paper = slipwave.read("paper")
    assert stability_in_si(paper, analyse(paper)) is None
    bare = slipwave.read(GRANITE, {"slab": {"epsilon": 1.8e-6, "r": 6e-4}})
    found = stability_in_si(bare, analyse(bare))
    assert math.isnan(found.thickness)
    assert math.isnan(found.critical_thickness)
    strengthening = slipwave.read(MACHINE, ["interface.b=0.005"])
    values = stability_in_si(strengthening, analyse(strengthening))
    assert math.isnan(values.critical_thickness)
    assert math.isnan(values.critical_normal_stress)


def test_the_roots_of_friction_without_a_state_effect_are_those_of_a_vanishing_one():
    none, little = (analyse(slipwave.read("paper", {"interface.b": b})) for b in (0.0, 1e-12))
    assert none.stable
    apart = np.abs(np.subtract.outer(none.leading_roots[:3], little.leading_roots)).min(axis=1)
    assert apart.max() < 1e-9 * abs(none.leading_roots[0])
    problem = characteristic(slipwave.read("paper", {"interface.b": 0.0}), "delay")
    assert problem.imbalance(np.array([-problem.slopes.healing + 0.0j])) == [0.0]


HELD = {"kind": "machine", "stiffness": 1e11, "impedance": 1e6, "mass": 400.0}
FAST = GRANITE | {"slab": GRANITE["slab"] | {"thickness": 1.0, "face": HELD}}


def fast(velocity, thickness=1.0):
    return slipwave.read(FAST, [f"drive.velocity='{velocity!r} m/s'", f"slab.thickness={thickness!r}"])


@pytest.mark.parametrize(
    ("velocity", "model", "thickness", "stress"),
    [
        (10.0, "delay", 6.363672418, 5011556.958),
        pytest.param(10.0, "fitted:4", 6.364458, 20437217.7, marks=pytest.mark.slow),
        (0.01, "quasistatic", 5.7, 5e6 * 60.0 / 13.0),
        (1.0, "quasidynamic", None, 923076923.0),
    ],
)
def test_fast_sliding_on_a_machine_loses_stability_where_roots_begin_to_grow(velocity, model, thickness, stress):
    """Quasi-static: of both slabs 1/k = 2 (h/G + 1/k_machine) = 2 (h/30e9 + 1e-11) is L/((b - a) sigma); other values measured.
    Quasi-dynamic slabs of any thickness are stable there."""
    scene = fast(velocity)
    values = stability_in_si(scene, analyse(scene, model))
    assert values.missing == ()
    assert values.critical_normal_stress == pytest.approx(stress, rel=1e-6)
    if thickness is None:
        assert math.isnan(values.critical_thickness)
    else:
        assert values.critical_thickness == pytest.approx(thickness, rel=1e-6)
    for side in (0.999, 1.001):
        changed = [scaled(scene, epsilon=5e6 / (values.critical_normal_stress * side))]
        changed += [thickened(scene, values.critical_thickness * side)] if thickness else []
        assert [unstable_count(characteristic(one, model)) > 0 for one in changed] == [side > 1.0] * len(changed)


def test_a_growing_pair_beside_hundreds_of_slow_decaying_ones_is_unstable():
    """Fast roots decay at 0.0023 there, a slow pair grows at 0.793: none is neutral."""
    scene = fast(10.0, 8.0)
    assert spectrum(scene).stable is False
    found = analyse(scene)
    assert (found.stable, found.unstable_roots) == (False, 2)
    assert found.leading_roots[0] == pytest.approx(0.7928570494 + 6308.306341j, rel=1e-8)
    assert found.leading_roots[2].real == pytest.approx(-0.002303594, rel=1e-5)
    values = stability_in_si(scene, found)
    assert values.critical_normal_stress == pytest.approx(3223113.77, rel=1e-6)
    assert values.growth_time == pytest.approx(10.0 / 0.7928570494, rel=1e-8)


def test_all_roots_decay_within_a_transit():
    """Quasi-static at 1 m/s: two roots, -0.9e6 +- 1.2e6 i, decay 54 times in a transit."""
    found = analyse(fast(1.0), "quasistatic")
    k = 1.0 / (2.0 * (1.0 / 30e9 + 1e-11)) * 1e-5 / 5e6 * 1e6
    a, gap, rate = 0.01, 0.005, 1e6
    roots = np.roots([a / rate, (k / rate - gap), k])
    assert found.stable is True
    assert found.leading_roots[0] == pytest.approx(roots[np.argmax(roots.imag)], rel=1e-9)


def test_roots_that_accumulate_to_within_rounding_are_listed():
    """A dashpot swallows a fifth of each of some thousand waves alike, friction hardly any: Re s = ln |R_face R_friction| / r."""
    epsilon, r, a, b, velocity, impedance = 5e-7, 250.0, 0.06084, 0.06083, 24.0, 0.127
    slab = {"epsilon": epsilon, "r": r, "face": {"kind": "grip", "stiffness": 0.75, "impedance": impedance}}
    interface = {"law": "ageing", "a_star": 0.25, "a": a, "b": b}
    analysis = analyse(slipwave.read({"interface": interface, "drive": {"velocity": velocity}, "slab": slab}))
    friction = 2.0 * a / velocity / epsilon
    kept = (1.0 - impedance) / (1.0 + impedance) * (friction - 1.0) / (friction + 1.0)
    assert analysis.stable
    assert [root.real for root in analysis.leading_roots] == pytest.approx([math.log(kept) / r] * 8, rel=1e-6)


@pytest.mark.parametrize(("coefficient", "factor"), [(0.5, 1.0), (0.0, 1e3), (0.9, 1e-3)])
def test_a_single_root_is_listed_once_however_near_to_zero(coefficient, factor):
    """Without a spring one root crosses at s = 0 as epsilon grows, in proportion to the distance from the critical one; rounding
    of the rates of friction, by which roots differ, exceeds any share of |s| there."""
    scene = scaled(scene_of(slab(face=ReflectingFace(coefficient))), round_trip=factor)
    critical = scaled(scene, epsilon=critical_epsilon(scene) / EPSILON)
    rate = analyse(scaled(critical, epsilon=1.0 + 1e-4)).leading_roots[0].real / 1e-4
    for distance, verdict in ((0.0, None), (1e-12, None), (1e-8, True), (1e-6, True), (-1e-8, False), (-1e-6, False)):
        analysis = analyse(scaled(critical, epsilon=1.0 + distance))
        assert (analysis.stable, analysis.unstable_roots) == (verdict, int(verdict is False))
        assert [root.imag for root in analysis.leading_roots[:1]] == [0.0]
        assert analysis.leading_roots[0].real == pytest.approx(distance * rate, rel=1e-3, abs=1e-11)
        assert all(root.real < -1e-3 for root in analysis.leading_roots[1:])

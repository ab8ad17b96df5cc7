"""Critical r over V, boundaries in the (r, epsilon) plane and the next Taylor truncation: what they must show."""

import cmath
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import slipwave
from reduced import closed_forms
from reduced.impedance import check_passivity, taylor_poles
from reduced.parameters import scaled, with_parameter
from reduced.stability import Boundary, FrictionSlopes, Stability, analyse, critical_round_trip, friction_slopes
from reduced.stability.characteristic import characteristic
from reduced.stability.spectrum import follow_root, unstable_count
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.study import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim, every, holding, of_paper
from validation.study.known import error_of_27
from validation.study.text import plain

TRACED = {"delay": closed_forms.delay_epsilon, "kelvin-voigt": closed_forms.kelvin_voigt_epsilon}
"""Models whose boundary is traced, with its closed form."""


class Curves(NamedTuple):
    """Critical r over V (Fig 2): computed from impedance, and closed forms; `gap` the largest relative difference of the two."""

    velocity: Array
    delay: Array
    kelvin_voigt: Array
    gap: float

    @property
    def error(self) -> Array:
        """Relative error of the Kelvin-Voigt system's critical r, (27) against (39)."""
        return self.kelvin_voigt / self.delay - 1.0


def critical_over_velocity(paper: Scene, velocities: Array) -> Curves:
    """r_c(V) of the delay and the Kelvin-Voigt system from their impedance, compared with (39) and (27)."""
    forms = {"delay": closed_forms.delay_r, "kelvin-voigt": closed_forms.kelvin_voigt_r}
    every, epsilon = velocities.tolist(), paper.upper.epsilon
    found = [[critical_round_trip(scaled(paper, velocity=v), model)[0] for v in every] for model in forms]
    known = [[closed(friction_slopes(paper.law, v), epsilon) for v in every] for closed in forms.values()]
    delay, kelvin_voigt = np.array(found)
    return Curves(velocities, delay, kelvin_voigt, float(np.abs(np.array(found) / known - 1.0).max()))


_ROUNDING = 2e-14  # relative
_STEP = 1e-6  # log10 r
_THIN, _ON_LINE = 1e-5, 1e-6
_TRACED = 4e-10  # Newton's method ends at steps of about this size squared
_FIRST_TRACED = 2e-3  # at eps = 1e-6 the branch (28) lies 9e-4 beyond its asymptote, relative


def closed_form_verdicts(paper: Scene, curves: Curves) -> Iterator[Verdict]:
    """The closed forms against each other and against roots found from impedance."""
    speeds = (1.0, 10.0, 100.0, 1e3, 1e4)
    every = [_gaps(paper, friction_slopes(paper.law, v), paper.upper.epsilon, v) for v in speeds]
    worst = {name: max(gaps[name] for gaps in every) for name in every[0]}
    for title, gap in (worst | {"r_{c} from impedance alone equals (39) and (27), all V": curves.gap}).items():
        yield claim(title, EXACT, gap, _ROUNDING, "relative, V = 1 to 10^{4}")


def _gaps(paper: Scene, slopes: FrictionSlopes, epsilon: float, velocity: float) -> dict[str, float]:
    r = closed_forms.kelvin_voigt_r(slopes, epsilon)
    cubic, x = closed_forms.kelvin_voigt_cubic(slopes, epsilon), r / closed_forms.quasistatic_r(slopes, epsilon)
    quartic, s = closed_forms.kelvin_voigt_quartic(slopes, epsilon, r), 1j * slopes.omega_c
    at_39 = replace(paper.upper, round_trip=closed_forms.delay_r(slopes, epsilon))
    driven = replace(scaled(paper, velocity=velocity), upper=at_39, lower=at_39)
    off = [float(abs(np.polyval(one, at) / (np.polyval(np.polyder(one), at) * at))) for one, at in ((cubic, x), (quartic, s))]
    return {
        "(27) is the middle root of the cubic (21)": off[0],
        "(27) makes the quartic (18) vanish at i ω_{c}": off[1],
        "at r of (39) the delay system’s own equation has the root i ω_{c}": abs(
            follow_root(characteristic(driven), s * (1.0 + 1e-3j)) / s - 1.0
        ),
    }


def fig_2(curves: Curves) -> tuple[Verdict, ...]:
    """What the paper concludes from its Fig 2."""
    slow, fast = float(np.abs(curves.error[curves.velocity <= 1e3]).max()), abs(float(curves.error[-1]))
    return error_of_27("Fig 2:", slow, fast)


def fig_3(traced: dict[str, list[Boundary]], slopes: FrictionSlopes, paper: Scene) -> Iterator[Verdict]:
    """The branches of Fig 3, traced and counted."""
    off = [
        np.abs(10**curve.second / np.array([closed(slopes, 10**x) for x in curve.first]) - 1.0).max()
        for model, closed in TRACED.items()
        for curve in traced[model]
    ]
    delay, ode = (len(traced[model]) for model in TRACED)
    yield claim(
        "Fig 3: boundaries traced in the (r, ε) plane without knowing them lie on (28) and (40)",
        EXACT,
        float(max(off)) if delay == ode == 2 else math.inf,
        _TRACED,
        f"{delay} branches of the delay system, {ode} of the ODE",
    )
    counts = [_beside(paper, model, curve) for model, curves in traced.items() for curve in curves]
    parted = all(abs(above - below) == 2 for above, below in counts)
    asymptote = math.sqrt(24.0) / slopes.omega_c
    begins = (float(10 ** curve.first.min()) for curve in traced["kelvin-voigt"])
    second = min(begin for begin in begins if begin > 0.5 * asymptote)
    yield of_paper(
        "Fig 3: beyond r = √24/ω_{c} a second pair of roots of the ODE crosses",
        f"from r = {plain(asymptote, '.5g')}",
        f"from r = {plain(second, '.5g')}",
        0.0 <= second / asymptote - 1.0 < _FIRST_TRACED and parted,
        "traced down to ε = 10^{-6}; the certified number of growing roots changes by 2 across every branch: "
        f"{'yes' if parted else 'no'}",
    ).with_margin(abs(second / asymptote - 1.0), _FIRST_TRACED)


def thin_slabs(slopes: FrictionSlopes) -> Verdict:
    """The asymptote that the paper names below (28)."""
    line = -slopes.healing * slopes.steady * _THIN
    off = [abs(closed(slopes, _THIN) / line - 1.0) for closed in TRACED.values()]
    title = "Fig 3: as r → 0 both boundaries approach the quasi-static line ε = −G_{φ} F_{ss}′ r"
    return claim(
        title, ASYMPTOTIC, max(off), _ON_LINE, f"relative distance of (28) and (40) from it at r = {plain(_THIN, '.0e')}"
    )


def _around(scene: Scene, model: str, name: str, value: float, step: float) -> list[int]:
    """The certified count of growing roots a step below and beyond a value of a parameter."""
    scenes = (with_parameter(scene, name, value + shift) for shift in (-step, step))
    return [unstable_count(characteristic(one, model)) for one in scenes]


def _beside(paper: Scene, model: str, curve: Boundary) -> list[int]:
    """The counts around the middle of a boundary."""
    middle = len(curve.first) // 2
    at = with_parameter(paper, "log10_r", float(curve.first[middle]))
    return _around(at, model, "log10_epsilon", float(curve.second[middle]), 1e-3)


def crossed(paper: Scene, onsets: Mapping[str, tuple[float, float]], found: Mapping[str, Stability]) -> Verdict:
    """The certified count of growing roots just below and beyond every onset, which the onset was found without."""
    places = {f"`{model}`": (paper, model, math.log10(r)) for model, (r, _) in onsets.items()}
    places |= {name: (slipwave.read(name), "delay", one.log10_r_c) for name, one in found.items() if math.isfinite(one.log10_r_c)}
    counts = {name: _around(scene, model, "log10_r", at, _STEP) for name, (scene, model, at) in places.items()}
    wrong = [name for name, (below, beyond) in counts.items() if beyond - below != 2]
    title, beside = "Beyond every onset a pair of roots grows that decays below it", f"certified count {plain(_STEP, '.0e')} in"
    remark = f"{beside} log_{{10}} r on both sides" + (f"; not so: {', '.join(wrong)}" if wrong else "")
    return every(title, WITNESS, len(counts) - len(wrong), len(counts), remark, "onsets")


def taylor(paper: Scene) -> Verdict:
    """The next truncation, which has growing roots of its own."""
    pole = max(taylor_poles(), key=lambda value: (value.real, value.imag))
    known = cmath.sqrt(complex(-40.0, math.sqrt(320.0)))  # 1 + s^2/24 + s^4/1920 = 0
    stable_scene = with_parameter(paper, "log10_r", -3.5)
    growing = analyse(stable_scene, "taylor").unstable_roots
    passive = check_passivity(paper, "taylor").passive
    return holding(
        "The next Taylor truncation after the paper’s cannot be used",
        EXACT,
        f"poles at {known.real:.4f} ± {known.imag:.4f} i",
        f"{pole.real:.4f} ± {abs(pole.imag):.4f} i per transit",
        abs(pole / known - 1.0) < _ROUNDING and pole.real > 0.0 and growing == 2 and not passive,
        f"its slab is {'' if passive else 'not '}passive: at r = 10^{{-3.5}}, where sliding is stable, it has {growing} growing "
        "roots of its own",
    ).with_margin(abs(pole / known - 1.0), _ROUNDING)

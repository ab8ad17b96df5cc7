"""Reductions for scenes beyond alike plain slabs, each derived from the scene's own impedance.

Any pair of slabs is ONE one-port with one slip rate v: two slabs in series have Y = Y_1 + Y_2, and the modes are those of the
pair with its interface locked.

The modes of a lossless pair are the poles of its impedance. On s = i omega a lossless section turns Y = i Y_c tan(alpha) at its
far end into i Y_c tan(alpha + omega T) at its near end. So the phase alpha of a chain of layers grows monotonically with omega
with a known branch, so that no mode is missed. If the phases of both slabs refer to the same impedance, Y_1 + Y_2 = 0 means
beta_1 + beta_2 = k pi.
"""

import math
from dataclasses import replace
from typing import cast

import numpy as np

from reduced.families import FAMILIES, REDUCTIONS
from reduced.impedance.reduction import TABULATED, TAYLOR, Reduction, mode_count, reduction
from reduced.impedance.transmission_line import Jet, drive_ratio, pair_ratio
from slipwave.errors import SceneError
from slipwave.friction.ageing import Ageing
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from slipwave.scene.drive import Drive
from slipwave.scene.slab import Slab

_NOT_COUPLED = 1e-9


def is_lossless(slab: Slab) -> bool:
    """Whether it is elastic with a rigid face, so that Z is imaginary on the imaginary axis; layers are allowed."""
    return slab.viscosity is None and slab.termination.is_rigid


def _rescale(angle: float, factor: float) -> float:
    """The angle whose tangent is `factor` times as large, on the same branch (by atan2, because tan has poles)."""
    turns = math.floor(angle / math.pi + 0.5) * math.pi
    return math.atan2(factor * math.sin(angle - turns), math.cos(angle - turns)) + turns


def _phase(slab: Slab, omega: float, reference: float) -> float:
    """beta(omega) with Y = (i/reference) tan beta; monotone."""
    angle, before = 0.0, slab.epsilon * slab.layers[-1].impedance
    for layer in reversed(slab.layers):
        here = slab.epsilon * layer.impedance
        angle = _rescale(angle, here / before) + 0.5 * omega * slab.round_trip * layer.fraction
        before = here
    return _rescale(angle, reference / before)


def _mode(scene: Scene, number: int, longest: float) -> float:
    """omega at which beta_1 + beta_2 = number * pi, by bisection down to rounding."""
    wanted, reference = number * math.pi, scene.impedance
    low, high = 0.0, 2.0 * math.pi * number / longest
    while _phase(scene.upper, high, reference) + _phase(scene.lower, high, reference) < wanted:
        high *= 2.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if _phase(scene.upper, middle, reference) + _phase(scene.lower, middle, reference) < wanted:
            low = middle
        else:
            high = middle


def _locked_modes(scene: Scene, count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """(frequencies, residues) of the `count` lowest modes, relative to the upper slab's epsilon and transit.

    Near such a mode Z/epsilon = residue s/(s^2 + omega^2) + ..., residue = 2/(epsilon dY/ds) at s = i omega. Modes in which both
    slabs move together without stress at the interface do not couple to it and are left out.
    """
    frequencies: list[float] = []
    residues: list[float] = []
    longest = max(scene.upper.round_trip, scene.lower.round_trip)
    number = 0
    while len(frequencies) < count:
        number += 1
        omega = _mode(scene, number, longest)
        p, q = pair_ratio(scene, Jet.variable(1j * omega))
        residue = 2.0 * float((q.value / p.slope).real) * scene.transit / scene.upper.epsilon
        if residue > _NOT_COUPLED:
            frequencies.append(float(omega * scene.transit))
            residues.append(residue)
    return tuple(frequencies), tuple(residues)


def _low_frequency(slab: Slab) -> tuple[float, float, float]:
    """(c_1, c_2, c_3) of Y = c_1 s + c_2 s^2 + c_3 s^3 + ... of an elastic slab, s on the friction clock, to first order in the
    dashpot of its face.

    Per layer, with x = s T and the coefficients f of the layers beyond: a_1 = f_1 + Y_c T,  a_2 = f_2,  a_3 = f_3 - Y_c T^3/3 -
    a_1 f_1 T/Y_c. A face is s/(spring + dashpot s + mass s^2).
    """
    held = slab.termination
    first, second, third = 0.0, 0.0, 0.0
    if not held.is_rigid:
        first, second, third = 1.0 / held.spring, -held.dashpot / held.spring**2, -held.mass / held.spring**2
    for layer in reversed(slab.layers):
        admittance = 1.0 / (slab.epsilon * layer.impedance)
        delay = 0.5 * slab.round_trip * layer.fraction
        total = first + admittance * delay
        third += -admittance * delay**3 / 3.0 - total * first * delay / admittance
        first = total
    return first, second, third


def _spring_damping_mass(scene: Scene) -> tuple[float, float, float]:
    """(spring, damping, mass) of Z/epsilon = spring/s + damping + mass s + ... of an elastic pair, transit clock; (1, 0, 1/12)
    for the plain one. They are those of the pair's quasi-static motion, and so never negative."""
    first, second, third = np.add(_low_frequency(scene.upper), _low_frequency(scene.lower))
    epsilon, transit = scene.upper.epsilon, scene.transit
    terms = transit / (first * epsilon), -second / (first**2 * epsilon), -third / (first**2 * epsilon * transit)
    return float(terms[0]), float(terms[1]), float(terms[2])


def reduction_of(scene: Scene, name: str) -> Reduction:
    """The reduction `name` of this scene's slab pair, relative to the upper slab's epsilon and transit.

    Alike plain slabs use the closed form if there is one; any other scene is reduced from its own impedance. Raises SceneError
    for an unknown name, and for a scene that the reduction does not honour.
    """
    kind = name.partition(":")[0]
    if scene.alike and scene.upper.is_plain and (kind in TABULATED or kind == "modal"):
        return reduction(name)
    family = next((family for family in REDUCTIONS if family.name == kind), None)
    if family is None:
        return reduction(name)  # raises the SceneError for an unknown name
    refusal = family.refusal(scene)
    if refusal:
        able = ", ".join(other.pattern for other in FAMILIES if not other.refusal(scene))
        raise SceneError(f"model = {name!r}: cannot do {refusal}; models that can: {able}, or a full wave")
    made = family.maker()(scene, name)
    if family in FAMILIES:
        return cast(Reduction, made)
    if not isinstance(made, Reduction):
        raise SceneError(f"model = {name!r}: {family.made_by} must return a Reduction, not {shorten(made)}")
    return made.of_slabs()


def analysed(scene: Scene, name: str) -> Reduction:
    """As `reduction_of`, and for alike plain slabs also `TAYLOR`, which cannot be integrated."""
    if name != TAYLOR.name:
        return reduction_of(scene, name)
    if not (scene.alike and scene.upper.is_plain):
        raise SceneError("model = 'taylor' is built for alike homogeneous slabs behind rigid faces only")
    return TAYLOR


def _relaxed_spring(scene: Scene) -> float:
    """Quasi-static stiffness of the pair over the upper slab's epsilon, per transit; a standard linear solid is relaxed."""
    if any(slab.termination.has_dead_load for slab in scene.slabs):
        return 0.0
    return scene.stiffness / scene.upper.epsilon


def quasistatic(scene: Scene, name: str) -> Reduction:
    """The spring alone."""
    return Reduction(name, spring=_relaxed_spring(scene))


def quasidynamic(scene: Scene, name: str) -> Reduction:
    """The spring, and the radiation damping of waves that never return."""
    return Reduction(name, spring=_relaxed_spring(scene), damping=scene.impedance / scene.upper.epsilon)


def block12(scene: Scene, name: str) -> Reduction:
    """Spring and mass of Z at low frequency; damping too, if there are dashpots on the faces."""
    spring, damping, mass = _spring_damping_mass(scene)
    return Reduction(name, mass=mass, damping=damping, spring=spring)


def block8(scene: Scene, name: str) -> Reduction:
    """The paper's truncation with the larger mass."""
    spring, _, mass = _spring_damping_mass(scene)
    return Reduction(name, mass=1.5 * mass, spring=spring)


def modal(scene: Scene, name: str) -> Reduction:
    """The lowest modes of the pair with its interface locked; the low-frequency mass of all other modes is kept."""
    count = mode_count(name)
    spring, _, mass = _spring_damping_mass(scene)
    frequencies, residues = _locked_modes(scene, count)
    remainder = mass - sum(residue / omega**2 for residue, omega in zip(residues, frequencies, strict=True))
    reduced = Reduction(name, mass=remainder, frequencies=frequencies, residues=residues, spring=spring)
    at_modes = Jet.variable(1j * np.array(frequencies) / scene.transit)
    passed = (drive_ratio(scene, at_modes)[1].value / pair_ratio(scene, at_modes)[1].value).real
    return reduced.driven(tuple((np.array(residues) * passed).tolist()))


def kelvin_voigt(scene: Scene, name: str) -> Reduction:
    """Both slabs' Z_i = (2 eps_i/(s r_i))(1 + x_i/8)/(1 + x_i/24), x_i = (s r_i)^2, in series (11): two pole pairs, or one
    if the round trips are equal. Poles in X = s^2 (transit clock) from sum_i k_i (1 + rho_i X/24)(1 + rho_j X/8) = 0. A free
    slab passes the velocity of its drive on with the factor 1/(1 + x_i/8), as in (41)."""
    spring, _, _ = _spring_damping_mass(scene)
    rho = (scene.lower.round_trip / scene.transit) ** 2
    upper, lower = 0.5, 0.5 * scene.lower.round_trip * scene.upper.epsilon / (scene.transit * scene.lower.epsilon)
    if math.isclose(rho, 1.0, rel_tol=1e-12):
        return Reduction(name, frequencies=(math.sqrt(24.0),), residues=(2.0 * spring,), spring=spring).driven((-spring,))
    a = (upper + lower) * rho / 192.0
    b = upper * (1 / 24 + rho / 8) + lower * (rho / 24 + 1 / 8)
    c = upper + lower
    q = -0.5 * (b + math.sqrt(b * b - 4.0 * a * c))  # without cancellation: b > 0
    squares = c / q, q / a
    slopes = [upper * _slab_slope(x, 1.0) + lower * _slab_slope(x, rho) for x in squares]
    residues = tuple(2.0 / slope for slope in slopes)
    passed = (0.5 / (1.0 + x / 8.0) + 0.5 / (1.0 + rho * x / 8.0) for x in squares)
    reduced = Reduction(name, frequencies=tuple(math.sqrt(-x) for x in squares), residues=residues, spring=spring)
    return reduced.driven(tuple(residue * share for residue, share in zip(residues, passed, strict=True)))


def fitted(scene: Scene, name: str) -> Reduction:
    """The exact modes if they are known, else a passive rational fit; without any oscillator the block of elastic slabs and of
    what is on their faces."""
    if is_lossless(scene.upper) and is_lossless(scene.lower):
        return modal(scene, name)
    if mode_count(name) == 0 and not any(slab.viscosity or slab.termination.has_dead_load for slab in scene.slabs):
        return block12(scene, name)
    from reduced.impedance.fit import fit_scene

    upper, lower = scene.upper, scene.lower
    if not (upper.viscosity or lower.viscosity):
        # Z/epsilon of elastic slabs depends on s r alone: one fit serves every r, without the noise of rounding in between
        epsilon, transit = upper.epsilon, upper.round_trip
        upper, lower = (
            replace(slab, epsilon=slab.epsilon / epsilon, round_trip=slab.round_trip / transit, material=None)
            for slab in (upper, lower)
        )
    drive = Drive((0.0,), (1.0,)) if scene.drive.is_constant else scene.drive
    pair = Scene("", Ageing(0.0, 0.0, 0.0), upper, lower, drive)  # and every friction and constant V
    return fit_scene(pair, name, mode_count(name), _relaxed_spring(pair))


def _slab_slope(x: float, rho: float) -> float:
    """d/ds of s (1 + rho s^2/24)/(1 + rho s^2/8) at s^2 = x."""
    top, bottom = 1.0 + rho * x / 24.0, 1.0 + rho * x / 8.0
    return top / bottom + 2.0 * x * (rho / 24.0 * bottom - rho / 8.0 * top) / bottom**2

"""Reductions for scenes beyond alike plain slabs, each derived from the scene's own impedance.

Any pair of slabs is ONE one-port with one slip rate v: two slabs in series have Y = Y_1 + Y_2, and the modes are those of the
pair with its interface locked.
"""

import math

from reduced.families import REDUCTIONS
from reduced.impedance.modes import is_lossless, locked_modes, spring_and_mass
from reduced.impedance.reduction import TABULATED, Reduction, mode_count, reduction
from slipwave.errors import SceneError
from slipwave.scene import Scene


def reduction_of(scene: Scene, name: str) -> Reduction:
    """The reduction `name` of this scene's slab pair, relative to the upper slab's epsilon and transit.

    Alike plain slabs use the closed form if there is one; any other scene is reduced from its own impedance. Raises SceneError
    for an unknown name, and for a scene that the reduction does not honour.
    """
    kind = name.partition(":")[0]
    if scene.alike and scene.upper.is_plain and (kind in TABULATED or kind == "modal"):
        return reduction(name)
    return reduce_scene(scene, name)


def reduce_scene(scene: Scene, name: str) -> Reduction:
    """The reduction `name` of any scene that its family honours, from the scene's own impedance."""
    family = next((family for family in REDUCTIONS if family.name == name.partition(":")[0]), None)
    if family is None:
        return reduction(name)  # raises the SceneError for an unknown name
    refusal = family.refusal(scene)
    if refusal:
        raise SceneError(f"model = {name!r}: cannot do {refusal}; use fitted:N, delay or a full wave for this scene")
    made: Reduction = family.maker()(scene, name)
    return made


def relaxed_spring(scene: Scene) -> float:
    """Quasi-static stiffness of the pair over the upper slab's epsilon, per transit; a standard linear solid is relaxed."""
    if any(slab.termination.has_dead_load for slab in scene.slabs):
        return 0.0
    return scene.stiffness / scene.upper.epsilon


def quasistatic(scene: Scene, name: str) -> Reduction:
    """The spring alone."""
    return Reduction(name, spring=relaxed_spring(scene))


def quasidynamic(scene: Scene, name: str) -> Reduction:
    """The spring, and the radiation damping of waves that never return."""
    return Reduction(name, spring=relaxed_spring(scene), damping=scene.impedance / scene.upper.epsilon)


def block12(scene: Scene, name: str) -> Reduction:
    """Spring and mass of Z at low frequency."""
    spring, mass = spring_and_mass(scene)
    return Reduction(name, mass=mass, spring=spring)


def block8(scene: Scene, name: str) -> Reduction:
    """The paper's truncation with the larger mass."""
    spring, mass = spring_and_mass(scene)
    return Reduction(name, mass=1.5 * mass, spring=spring)


def modal(scene: Scene, name: str) -> Reduction:
    """The lowest modes of the pair with its interface locked; the low-frequency mass of all other modes is kept."""
    count = mode_count(name)
    spring, mass = spring_and_mass(scene)
    frequencies, residues = locked_modes(scene, count)
    remainder = mass - sum(residue / omega**2 for residue, omega in zip(residues, frequencies, strict=True))
    return Reduction(name, mass=remainder, frequencies=frequencies, residues=residues, spring=spring)


def kelvin_voigt(scene: Scene, name: str) -> Reduction:
    """Both slabs' Z_i = (2 eps_i/(s r_i))(1 + x_i/8)/(1 + x_i/24), x_i = (s r_i)^2, in series (11): two pole pairs, or one
    if the round trips are equal. Poles in X = s^2 (transit clock) from sum_i k_i (1 + rho_i X/24)(1 + rho_j X/8) = 0."""
    spring, _ = spring_and_mass(scene)
    rho = (scene.lower.round_trip / scene.transit) ** 2
    upper, lower = 0.5, 0.5 * scene.lower.round_trip * scene.upper.epsilon / (scene.transit * scene.lower.epsilon)
    if math.isclose(rho, 1.0, rel_tol=1e-12):
        return Reduction(name, frequencies=(math.sqrt(24.0),), residues=(2.0 * spring,), spring=spring)
    squares = _quadratic_roots(
        (upper + lower) * rho / 192.0, upper * (1 / 24 + rho / 8) + lower * (rho / 24 + 1 / 8), upper + lower
    )
    slopes = [upper * _slab_slope(x, 1.0) + lower * _slab_slope(x, rho) for x in squares]
    return Reduction(
        name, frequencies=tuple(math.sqrt(-x) for x in squares), residues=tuple(2.0 / slope for slope in slopes), spring=spring
    )


def fitted(scene: Scene, name: str) -> Reduction:
    """The exact modes if they are known, else a passive rational fit."""
    if is_lossless(scene.upper) and is_lossless(scene.lower):
        return modal(scene, name)
    from reduced.impedance.fit import fit_scene

    return fit_scene(scene, name, mode_count(name), relaxed_spring(scene))


def _slab_slope(x: float, rho: float) -> float:
    """d/ds of s (1 + rho s^2/24)/(1 + rho s^2/8) at s^2 = x."""
    top, bottom = 1.0 + rho * x / 24.0, 1.0 + rho * x / 8.0
    return top / bottom + 2.0 * x * (rho / 24.0 * bottom - rho / 8.0 * top) / bottom**2


def _quadratic_roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Both (negative) roots of a x^2 + b x + c without cancellation, the smaller one in size first."""
    q = -0.5 * (b + math.sqrt(b * b - 4.0 * a * c))
    return c / q, q / a

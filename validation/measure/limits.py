"""Noise at the scale of the grid: measured step limits, and noise in slabs that are locked by friction.

For a limit, slabs that slide steadily, with noise, are marched beyond the declared one. Friction depends on the rate alone
(b = 0), so that steady sliding is stable and all growth comes from the scheme. Its stiffness is a/v over Z, the impedance of the
interface: 0 leaves the interface free, 1 absorbs waves, infinity locks it. The relaxation of psi is stepped explicitly and limits
the step where r v is large; it is tested separately.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

import slipwave
from fullwave.options import AnyShare
from slipwave.errors import NumericsError
from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from slipwave.scene.drive import Start, StartKind
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, ReflectingFace, StandardLinearViscosity
from slipwave.solve import FieldSolver, follow
from validation.models.build import build_full_wave
from validation.models.by_name import GRIDS, explicit_time, grid_of

ATTACKED = {family.called(number): cells for family in GRIDS for number, cells in family.attacks.items()}
"""The tested models, with their coarse and fine grids."""

EXPLICIT = {model: explicit_time(model) for model in ATTACKED}
"""Model -> the option `time` of its march in explicit steps."""

CELLS = {model: cells.coarse for model, cells in ATTACKED.items()}
"""Cells of cheap runs; the limit does not depend on them."""

_ROUND_TRIP = slipwave.read("paper").upper.round_trip
MEDIA: dict[str, tuple[dict[str, Any], dict[str, Any] | None]] = {
    "alike slabs": ({}, None),
    "impedances 1 : 1000": ({}, {"epsilon": 2.8e-2}),
    "round trips 1 : π": ({}, {"round_trip": math.pi * _ROUND_TRIP}),
    "layers 1 : 100": ({"layers": (Layer(0.5, 1.0), Layer(0.5, 100.0))}, None),
    "stiff grip": ({"face": GripFace(1e4, 1e3)}, None),
    "spring on a weak dashpot": ({"face": GripFace(1e3, 1e-2)}, None),
    "free face": ({"face": ReflectingFace(-1.0)}, None),
    "Kelvin-Voigt, 0.02 transits": ({"viscosity": KelvinVoigtViscosity(0.02 * _ROUND_TRIP)}, None),
    "Kelvin-Voigt, 1 transit": ({"viscosity": KelvinVoigtViscosity(_ROUND_TRIP)}, None),
    "Kelvin-Voigt over elastic": ({"viscosity": KelvinVoigtViscosity(0.02 * _ROUND_TRIP)}, {}),
    "standard linear, 3 transits": ({"viscosity": StandardLinearViscosity(3.0 * _ROUND_TRIP, 0.5)}, None),
}
"""Changes to the paper's upper slab and to the lower one (None: alike)."""

FEW_MEDIA = ("alike slabs", "impedances 1 : 1000", "layers 1 : 100", "Kelvin-Voigt, 0.02 transits")

SOFT_AND_STIFF = (-2.0, 4.0)
"""log10 of a/v over Z."""

STEPS = 400
"""Steps of a run that searches for the limit."""

AROUND = ((0.99, STEPS), (1.05, 2000))
"""Share of the limit and number of steps at which noise must not grow, and at which it must."""

BEYOND = 1.25
"""Share of the limit at which a run has to stop."""

GROWN = 100.0
"""Noise that is so many times as large has grown: the one definition of every limit."""
SHARPNESS = 1.01
"""Ratio of a step that is stable to one that is not, where the search for a limit ends."""
_LONG = 120.0  # transits
_LOW, _HIGH = 0.8, 1.5


def _with_step(model: str, scene: Scene, share: float) -> FieldSolver:
    """The solver at `share` of its declared step limit, which may exceed 1, unlike for users."""
    return build_full_wave(model, scene, cells=CELLS.get(model, grid_of(model)[0].cells), cfl=AnyShare(share))


def rubbing(decade: float, medium: str = "alike slabs") -> Scene:
    """The slabs of MEDIA sliding steadily on F = a ln v, a/v = 10^decade times Z."""
    plain = slipwave.read("paper", ["start.size=0"])
    above, below = MEDIA[medium]
    upper = replace(plain.upper, **above)
    slabs = replace(plain, upper=upper, lower=upper if below is None else replace(plain.upper, **below))
    return replace(slabs, law=plain.law._replace(a=10.0**decade * slabs.impedance * plain.velocity, b=0.0))


def growth(model: str, scene: Scene, share: float, steps: int = STEPS) -> float:
    """Largest field after `steps` at `share` of the limit, over the noise's amplitude; infinite if the run broke down."""
    solver = _with_step(model, scene, share)
    noise = 1e-3 * scene.velocity
    draw = np.random.default_rng(2).standard_normal
    solver.disturb(lambda size: noise * draw(size))
    try:
        while solver.time < steps * solver.step:
            solver.advance(steps * solver.step)
    except NumericsError:
        return math.inf
    largest = solver.deviation()
    return largest / noise if math.isfinite(largest) else math.inf


def limit_at(model: str, decade: float) -> float:
    """Largest share of the declared step, to 1 per cent, at which noise does not grow on friction of stiffness 10^decade Z."""
    scene = rubbing(decade)
    return _largest(lambda share: growth(model, scene, share) < GROWN)


def state_reach(model: str) -> float:
    """Largest stable step times the relaxation rate of psi, to 1 per cent, of alike slabs, a/v = Z, after a jump of psi; infinite
    if psi sets no limit."""
    if grid_of(model)[0].implicit_state:
        return math.inf
    plain, relaxation = rubbing(0.0), 1e4  # of psi per transit, which is r V
    slab = replace(plain.upper, round_trip=relaxation / plain.velocity)
    scene = replace(plain, upper=slab, lower=slab, start=Start(StartKind.JUMP, 1e-3))
    return _largest(lambda share: _calms_down(model, scene, share)) * _with_step(model, scene, 1.0).step * relaxation


def _calms_down(model: str, scene: Scene, share: float) -> bool:
    solver = _with_step(model, scene, share)
    return _goes_through(solver, STEPS * solver.step) and solver.failures == 0


def _goes_through(solver: FieldSolver, until: float) -> bool:
    try:
        follow(solver, until)
    except NumericsError:
        return False
    return True


def _largest(stable: Callable[[float], bool]) -> float:
    """The largest stable share by geometric bisection; 0 if 0.8 is not, 1.5 if that is."""
    low, high = _LOW, _HIGH
    if not stable(low):
        return 0.0
    if stable(high):
        return high
    while high / low > SHARPNESS:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return math.sqrt(low * high)


def growth_at(model: str, medium: str, share: float, steps: int) -> float:
    """Growth of noise at this share of the limit, the larger of soft and stiff friction."""
    return max(growth(model, rubbing(decade, medium), share, steps) for decade in SOFT_AND_STIFF)


def around_the_limit(model: str, medium: str) -> tuple[float, float]:
    """Growth of noise on both sides of the limit (AROUND)."""
    below, above = (growth_at(model, medium, *around) for around in AROUND)
    return below, above


def stops_beyond(model: str, share: float) -> bool:
    """Whether a run of the paper's scene at `share` of the declared step stops with a message."""
    return not _goes_through(_with_step(model, slipwave.read("paper"), share), _LONG)


def _locked() -> Scene:
    """The slabs of the paper locked by friction: where hardly anything slides, a wave hardly changes the slip rate."""
    return slipwave.read("paper", ["drive.velocity=1e-6", "start.size=0"])


def noise_left(transits: float) -> Estimate:
    """What friction leaves of the energy of waves in a locked slab after `transits`. A wave of velocity u makes slip at a rate of
    4 Z u V/a, which takes a share 4 Z V/a of the energy in every transit; a/v is not constant, by that slip over V: the error."""
    scene = _locked()
    share = 4.0 * scene.impedance * scene.velocity / scene.law.a
    left = math.exp(-share * transits)
    return Estimate(left, (1.0 - left) * share / scene.velocity)


def locked_noise(model: str, transits: float) -> float:
    """Energy left of noise in a locked slab after `transits`, over its mean in the first ten; infinite if the run broke down."""
    scene = _locked()
    solver = _with_step(model, scene, 1.0)
    solver.disturb(np.random.default_rng(1).standard_normal, stressed=False)
    try:
        first = np.mean([_energy(solver, moment) for moment in 2.0 * np.arange(1.0, 6.0)])
        last = np.mean([_energy(solver, moment) for moment in transits + 2.0 * np.arange(1.0, 6.0)])
    except NumericsError:
        return math.inf
    return float(last / first)


def _energy(solver: FieldSolver, moment: float) -> float:
    follow(solver, moment)
    return solver.deviation_energy()

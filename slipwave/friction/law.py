"""What a friction law is, and how to register one.

A law consists of a NamedTuple of its parameters and one pure function of two well-scaled variables: the rate unknown z, usually
ln v, and the state psi = ln phi. numba specialises every solver on that NamedTuple's class, so other laws are not compiled in.

    respond(law, z, psi) -> (v, v_z, F, F_z, F_psi, G, G_z, G_psi)

v is the slip rate, F the friction coefficient (1), and psi' = G(z, psi) on the friction clock L/V*; subscripts are partial
derivatives. `steady_state(law, v) -> psi` solves G = 0. Laws that allow v <= 0 also supply `rate_of(law, z) -> v` and its inverse
`unknown_of(law, v) -> z`. Solvers rely on v'' = v in z, which holds for e^z and sinh z. Argument names are part of the interface
(numba matches them).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import njit
from slipwave.compiled.dispatch import ByClass, by_class
from slipwave.errors import SceneError

Law: TypeAlias = Any
"""An instance of a registered parameter class (a NamedTuple of floats)."""

Response: TypeAlias = tuple[float, float, float, float, float, float, float, float]
"""(v, v_z, F, F_z, F_psi, G, G_z, G_psi)."""


class Registered(NamedTuple):
    """A registered law: the class of its parameters and its functions in plain Python."""

    parameters: type[Any]
    respond: Callable[..., Response]
    steady_state: Callable[..., float]
    rate_of: Callable[..., float]
    unknown_of: Callable[..., float]


LAWS: dict[str, Registered] = {}
HOUSE = Path(__file__).resolve().parent


@by_class()
def respond(law: Law, z: float, psi: float) -> Response:
    """(v, v_z, F, F_z, F_psi, G, G_z, G_psi) of `law` at rate unknown z and state psi; G on the friction clock L/V*."""
    raise NotImplementedError(type(law))


@by_class()
def steady_state(law: Law, v: float) -> float:
    """psi_ss(v): the state at which sliding at rate v is steady."""
    raise NotImplementedError(type(law))


@by_class()
def rate_of(law: Law, z: float) -> float:
    """Slip rate v (in V*) at the rate unknown z."""
    raise NotImplementedError(type(law))


@by_class()
def unknown_of(law: Law, v: float) -> float:
    """Rate unknown z at the slip rate v (in V*); ln v for laws that need v > 0."""
    raise NotImplementedError(type(law))


def rates(law: Law, unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slip rates (V*) at the rate unknowns z; an array of the same shape."""
    found = np.empty_like(unknowns, order="C")
    _fill_rates(law, unknowns.ravel(), found.ravel())
    return found


@njit
def _fill_rates(law: Law, unknowns: NDArray[np.float64], found: NDArray[np.float64]) -> None:
    """found <- `rates` of (n,) unknowns; without creating an array, which would triple the time to compile and load."""
    for i in range(unknowns.size):
        found[i] = rate_of(law, unknowns[i])


def unknowns(law: Law, speeds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rate unknowns z at the slip rates (V*); an array of the same shape."""
    found = np.empty_like(speeds, order="C")
    _fill_unknowns(law, speeds.ravel(), found.ravel())
    return found


@njit
def _fill_unknowns(law: Law, speeds: NDArray[np.float64], found: NDArray[np.float64]) -> None:
    """found <- `unknowns` at (n,) slip rates."""
    for i in range(speeds.size):
        found[i] = unknown_of(law, speeds[i])


@dataclass(frozen=True)
class FrictionSlopes:
    """Slopes of a law at steady sliding: `direct` F_v, `healing` G_phi (1/(L/V*)), `steady` F_ss' = d mu_ss/dV."""

    direct: float
    healing: float
    steady: float

    @property
    def weakening(self) -> bool:
        """Whether friction falls with the steady rate, which is necessary for instability."""
        return self.steady < 0.0

    @property
    def omega_c(self) -> float:
        """omega_c = G_phi sqrt(-F_ss'/F_v) (20), (38): the critical frequency of every lossless slab; nan if strengthening."""
        return self.healing * float(np.sqrt(-self.steady / self.direct)) if self.weakening else float("nan")

    @property
    def reach(self) -> float:
        """Bound of the roots: for passive slabs every root with Re s >= 0 has |s + G_phi| <= reach, because beyond it Re H > 0
        and Re Z >= 0."""
        return self.healing * abs(self.direct - self.steady) / self.direct

    @property
    def growing(self) -> tuple[float, float]:
        """(centre, radius) of the disc that contains every root with Re s >= 0: outside it Re H > 0, and passive slabs have Re Z
        >= 0. It meets the imaginary axis at omega_c."""
        return 0.5 * self.reach - self.healing, 0.5 * self.reach

    def impedance_at(self, omega: float | NDArray[np.float64]) -> NDArray[np.complex128]:
        """H(i omega), delta_mu = H delta_v: (F_v s + G_phi F_ss')/(s + G_phi)."""
        s = 1j * np.asarray(omega)
        return np.asarray((self.direct * s + self.healing * self.steady) / (s + self.healing))


def friction_slopes(law: Law, velocity: float) -> FrictionSlopes:
    """Slopes of `law` in steady sliding at `velocity` (V*), from its derivatives in the unknowns (z, psi):

    F_v = F_z/v_z,  G_phi = -G_psi (psi' = G),  F_ss' = F_v - F_psi G_z/(G_psi v_z).
    """
    psi = steady_state(law, velocity)
    _, v_z, _, f_z, f_psi, _, g_z, g_psi = respond(law, unknown_of(law, velocity), psi)
    return FrictionSlopes(f_z / v_z, -g_psi, (f_z - f_psi * g_z / g_psi) / v_z)


_GENERIC: tuple[ByClass[..., Any], ...] = (respond, steady_state, rate_of, unknown_of)


def steady_psi(law: Law, v: float) -> float:
    """psi_ss = -ln |v|: at steady sliding the age of contacts is L/V. The default of `register`."""
    return -math.log(abs(v))


def _exponential(law: Law, z: float) -> float:
    return math.exp(z)


def _logarithm(law: Law, v: float) -> float:
    return math.log(v)


def register(
    name: str,
    parameters: type[Any],
    respond: Callable[..., Response],
    steady_state: Callable[..., float] = steady_psi,
    rate_of: Callable[..., float] = _exponential,
    unknown_of: Callable[..., float] = _logarithm,
) -> None:
    """Make a law known to every solver under `name`.

    A law from outside this package is checked first: its derivatives against finite differences, its steady state against G = 0.
    Raises SceneError naming the first wrong function.
    """
    law = Registered(parameters, respond, steady_state, rate_of, unknown_of)
    if Path(respond.__code__.co_filename).parent != HOUSE:
        from slipwave.friction.check import check_law

        check_law(name, law)
    if LAWS.get(name, law) != law and LAWS[name].parameters is parameters:
        raise SceneError(
            f"friction law {name!r} is already registered with the same parameter class; give the new one its own class"
        )
    LAWS[name] = law
    for generic, version in zip(_GENERIC, law[1:], strict=True):
        generic.register(parameters)(version)


def name_of(law: Law) -> str:
    """The name under which the class of `law` is registered."""
    return next(name for name, known in LAWS.items() if known.parameters is type(law))

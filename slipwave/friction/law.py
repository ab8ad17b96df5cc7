"""What a friction law is, and how to register one.

A law consists of a NamedTuple of its parameters and one pure function of two well-scaled variables: the rate unknown z, usually
ln v, and the state psi = ln phi. numba specialises every solver on that NamedTuple's class, so other laws are not compiled in.

    respond(law, z, psi) -> (v, v_z, F, F_z, F_psi, G, G_z, G_psi)

v is the slip rate, F the friction coefficient (1), and psi' = G(z, psi) on the friction clock L/V*; subscripts are partial
derivatives. `steady_state(law, v) -> psi` solves G = 0. Laws that allow v <= 0 also supply `rate_of(law, z) -> v` and its inverse
`unknown_of(law, v) -> z`. Solvers rely on v'' = v in z, which holds for e^z and sinh z. Argument names are part of the interface
(numba matches them).

Where v passes through zero, such a law's own z runs through all its range, because its floor lies far below every rate that
matters. There the law is linear in v, up to a rate that depends on the state. Every step measures its rate unknown on that rate
(`OfStep`): w = asinh(v/(2 floor)) is as smooth as the stress at all rates, and ln v but for a constant where v is large.
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
from slipwave.packages import line_of_user

Array = NDArray[np.float64]

Law: TypeAlias = Any
"""An instance of a registered parameter class (a NamedTuple of floats)."""

Response: TypeAlias = tuple[float, float, float, float, float, float, float, float]
"""(v, v_z, F, F_z, F_psi, G, G_z, G_psi)."""

Sample: TypeAlias = Callable[[Array], Array]
"""Values at points of pieces, (m, p), from those at their nodes, (m, n)."""


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


@by_class()
def law_of_step(law: Law, psi: float) -> Law:
    """`law` with the rate unknown of a step that begins at the state `psi`: itself if it needs v > 0, else `OfStep`."""
    return law


@by_class()
def to_step(law: Law, own: Law, z: Array) -> None:
    """z (n,) <- the rate unknowns of `law`, a `law_of_step`, from those of the law itself, `own`."""


@by_class()
def to_own(law: Law, z: Array) -> None:
    """z (n,) <- the rate unknowns of the law itself from those of `law`, a `law_of_step`."""


def allows_rest(law: Law) -> bool:
    """Whether `law` allows v <= 0; False if None."""
    return law_of_step(law, 0.0) is not law


@by_class(inline=True)
def with_bend(law: Law, share: float, v_z: float) -> float:
    """`share` and a bound of |F_zz|/F_z, which is 0 for laws that are linear in ln v."""
    return share


class OfStep(NamedTuple):
    """`law`, which allows v <= 0, with the rate unknown of a step: v = 2 `floor` sinh z."""

    law: Law
    floor: float


_LARGE, _FAR, _LEAST = 1e12, 100.0, 1e-200  # V*; floors; V*


def _of_step(law: Law, psi: float) -> OfStep:
    """The floor is half the rate at which friction, continued with its slope F_v = F_z/v_z at rest, reaches the direct effect F_z
    of much larger rates."""
    _, v_z, _, friction_z, _, _, _, _ = respond(law, unknown_of(law, 0.0), psi)
    rate = _LARGE
    for _ in range(3):  # F_z of a law that also has viscous friction falls with the rate
        rate = min(rate, _FAR * respond(law, unknown_of(law, rate), psi)[3] * v_z / friction_z)
    return OfStep(law, max(0.5 * rate / _FAR, _LEAST))


def smooth(law: Law, z: Array, psi: Array) -> Array:
    """Rate unknowns as smooth as the stress, also where v changes its sign, from the law's own `z` and psi (m, n) at the nodes of
    m pieces."""
    return np.arcsinh(rates(law, z) / _double_floors(law, psi)) if allows_rest(law) else z


def resampled(law: Law, z: Array, psi: Array, sample: Sample) -> Array:
    """The law's own rate unknowns at other points of m pieces, (m, p), by `sample` of `smooth`."""
    if not allows_rest(law):
        return sample(z)
    return unknowns(law, _double_floors(law, psi) * np.sinh(sample(smooth(law, z, psi))))


def _double_floors(law: Law, psi: Array) -> Array:
    floors = np.empty((len(psi), 1))
    _fill_floors(law, psi, floors)
    return 2.0 * floors


@njit
def _fill_floors(law: Law, psi: Array, floors: Array) -> None:
    for i in range(floors.size):
        floors[i, 0] = law_of_step(law, psi[i, 0]).floor


def rates(law: Law, unknowns: Array) -> Array:
    """Slip rates (V*) at the rate unknowns z; an array of the same shape."""
    speeds = np.empty_like(unknowns, order="C")
    _fill_rates(law, unknowns.ravel(), speeds.ravel())
    return speeds


@njit
def _fill_rates(law: Law, unknowns: Array, speeds: Array) -> None:
    """speeds <- `rates` of (n,) unknowns; without creating an array, which would triple the time to compile and load."""
    for i in range(unknowns.size):
        speeds[i] = rate_of(law, unknowns[i])


def unknowns(law: Law, speeds: Array) -> Array:
    """Rate unknowns z at the slip rates (V*); an array of the same shape."""
    z = np.empty_like(speeds, order="C")
    _fill_unknowns(law, speeds.ravel(), z.ravel())
    return z


@njit
def _fill_unknowns(law: Law, speeds: Array, z: Array) -> None:
    """z <- `unknowns` at (n,) slip rates."""
    for i in range(speeds.size):
        z[i] = unknown_of(law, speeds[i])


_LEAST_REACH = 1e-9  # of the healing rate

ALWAYS_STABLE = "friction does not weaken with the slip rate, so that steady sliding is always stable"
"""What is said of a law and a velocity that are not `weakening`."""


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
        and Re Z >= 0. Not 0 without a state effect: it is a scale of rates too."""
        return self.healing * max(abs(self.direct - self.steady) / self.direct, _LEAST_REACH)

    @property
    def growing(self) -> tuple[float, float]:
        """(centre, radius) of the disc that contains every root with Re s >= 0: outside it Re H > 0, and passive slabs have Re Z
        >= 0. It meets the imaginary axis at omega_c."""
        return 0.5 * self.reach - self.healing, 0.5 * self.reach

    def impedance_at(self, omega: float | Array) -> NDArray[np.complex128]:
        """H(i omega), delta_mu = H delta_v: (F_v s + G_phi F_ss')/(s + G_phi)."""
        s = 1j * np.asarray(omega)
        return np.asarray((self.direct * s + self.healing * self.steady) / (s + self.healing))


def steady_sliding(law: Law, velocity: float) -> tuple[float, Response]:
    """psi_ss and what `law` answers in steady sliding at `velocity` (V*). Raises SceneError for parameters with which a user's
    law has none, as with the logarithm of a negative number, or is wrong: its keys have no ranges, and a mistake may be hidden by
    the defaults with which it was registered."""
    try:
        psi = steady_state(law, velocity)
        answer = respond(law, unknown_of(law, velocity), psi)
    except (ArithmeticError, ValueError) as error:
        values = ", ".join(f"{key} = {value:g}" for key, value in law._asdict().items())
        why = ", ".join(filter(None, [f"{type(error).__name__}: {error}", line_of_user(error)]))
        raise SceneError(f"law {name_of(law)!r}: no steady sliding at V = {velocity:g} with {values}: {why}") from error
    if is_registered(law) and not _of_house(LAWS[name_of(law)]):
        from slipwave.friction.check import check_at

        check_at(name_of(law), LAWS[name_of(law)], law, velocity)
    return psi, answer


def friction_slopes(law: Law, velocity: float) -> FrictionSlopes:
    """Slopes of `law` in steady sliding at `velocity` (V*), from its derivatives in the unknowns (z, psi):

    F_v = F_z/v_z,  G_phi = -G_psi (psi' = G),  F_ss' = F_v - F_psi G_z/(G_psi v_z).
    """
    _, (_, v_z, _, f_z, f_psi, _, g_z, g_psi) = steady_sliding(law, velocity)
    return FrictionSlopes(f_z / v_z, -g_psi, (f_z - f_psi * g_z / g_psi) / v_z)


@respond.register(OfStep)
def _respond_of_step(law: OfStep, z: float, psi: float) -> Response:
    v, v_z = 2.0 * law.floor * math.sinh(z), 2.0 * law.floor * math.cosh(z)
    _, own, friction, by_z, by_psi, growth, growth_z, growth_psi = respond(law.law, unknown_of(law.law, v), psi)
    scale = v_z / own
    return v, v_z, friction, by_z * scale, by_psi, growth, growth_z * scale, growth_psi


@to_step.register(OfStep)
def _to_step(law: OfStep, own: Law, z: Array) -> None:
    for i in range(z.size):
        z[i] = math.asinh(rate_of(own, z[i]) / (2.0 * law.floor))


@to_own.register(OfStep)
def _to_own(law: OfStep, z: Array) -> None:
    for i in range(z.size):
        z[i] = unknown_of(law.law, 2.0 * law.floor * math.sinh(z[i]))


@with_bend.register(OfStep)
def _with_bend(law: OfStep, share: float, v_z: float) -> float:
    return share + 8.0 * (law.floor / v_z) ** 2


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

    A law from outside this package is checked first: the form of its parts, its derivatives against finite differences, its
    steady state against G = 0. Raises SceneError naming what is wrong first, and for a name or a class that another law has.
    """
    functions: Any = (getattr(part, "py_func", part) for part in (respond, steady_state, rate_of, unknown_of))  # as written
    law = Registered(parameters, *functions)
    if not _of_house(law):
        from slipwave.friction.check import check_form, check_law

        check_form(name, law)
        if name in LAWS and _of_house(LAWS[name]):
            raise SceneError(f"friction law {name!r}: is one of slipwave's own; give yours another name")
        check_law(name, law)
    owner = next((other for other, known in LAWS.items() if known.parameters is parameters), name)
    if owner != name or (name in LAWS and LAWS[name].parameters is parameters and LAWS[name] != law):
        raise SceneError(
            f"friction law {name!r}: {owner!r} is already registered with the same parameter class; give this one its own class"
        )
    LAWS[name] = law
    for operator, function in (("__eq__", _equal), ("__ne__", _unequal), ("__hash__", _hash)):
        setattr(parameters, operator, function)
    for generic, version in zip(_GENERIC, law[1:], strict=True):
        generic.register(parameters)(version)
    if law.rate_of is not _exponential:
        law_of_step.register(parameters)(_of_step)


def _equal(law: Law, other: Any) -> bool:
    """Equality of laws, and with them of scenes, in plans and caches: tuples of the same numbers would be the same law."""
    return type(law) is type(other) and tuple(law) == tuple(other)


def _unequal(law: Law, other: Any) -> bool:
    return not _equal(law, other)


def _hash(law: Law) -> int:
    return hash((type(law), *law))


def _of_house(law: Registered) -> bool:
    code = getattr(law.respond, "__code__", None)
    return code is not None and Path(code.co_filename).parent == HOUSE


def is_registered(law: Law) -> bool:
    """Whether the class of `law` is that of a name: no longer, once the user has registered another under its name."""
    return any(known.parameters is type(law) for known in LAWS.values())


def name_of(law: Law) -> str:
    """The name under which the class of `law` is registered. Raises SceneError if it no longer is."""
    if not is_registered(law):
        text = f"friction law {type(law).__qualname__}"
        raise SceneError(f"{text}: was loaded anew since; read the scene, or compute the result, again")
    return next(name for name, known in LAWS.items() if known.parameters is type(law))


_AT_REST = 1e-9  # V*
_NEAR = 0.5  # of z, a factor of the rate of 1.6


def said_of_edge(law: Law, z: float, psi: float) -> str:
    """What an error adds if a user's `law` has no value at a rate near that of `z`, at the state psi: no step or grid helps."""
    if not math.isfinite(z + psi):
        return ""
    rates = [rate_of(law, z + step) for step in (-_NEAR, _NEAR) if not math.isfinite(respond(law, z + step, psi)[2])]
    return f"law {name_of(law)!r} has no value at v = {rates[0]:.3g} V*" if rates else ""


def said_of_rest(law: Law, incoming: Array, z: float, psi: float) -> str:
    """What an error adds if `law` has no value near z, or if it needs v > 0 and the `incoming` stress stops or reverses slip, at
    the state psi."""
    if edge := said_of_edge(law, z, psi):
        return f"; {edge}"
    if allows_rest(law) or not incoming.min() < respond(law, unknown_of(law, _AT_REST), psi)[2]:
        return ""
    others = [name for name, known in LAWS.items() if known.rate_of is not _exponential]
    return f"; the stress that arrives stops or reverses slip, but law {name_of(law)!r} needs v > 0: {', '.join(others)} do not"

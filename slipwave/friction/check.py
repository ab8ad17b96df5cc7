"""Numerical check of a user's friction law: a wrong derivative is refused before it can falsify a result."""

import math
from numbers import Real
from types import FunctionType
from typing import Any

from slipwave.errors import SceneError

_RATES = (1e-2, 0.7, 3.0, 40.0, 900.0)
_STATE_OFFSETS = (-0.8, 0.0, 0.6)
_STEP = 1e-5
_WIDE = 0.5
_TOLERANCE = 1e-6
_PARAMETERS = (0.4, 0.02, 0.03)
_SLOPES = ("v_z", "F_z", "F_psi", "G_z", "G_psi")
_ARGUMENTS = {"respond": ("law", "z", "psi"), "steady_state": ("law", "v"), "rate_of": ("law", "z"), "unknown_of": ("law", "v")}
_TAKEN = ("law", "normal_stress", "memory_length", "reference_velocity")  # keys of [interface] that every law has
_ANSWERS = ("v", "v_z", "F", "F_z", "F_psi", "G", "G_z", "G_psi")


class LawError(SceneError):
    """A law whose functions are wrong."""


def check_form(name: Any, law: Any) -> None:
    """Raises LawError for a name, a class of parameters or a function of the `Registered` law that no scene or solver can use."""
    text = f"friction law {name!r}"
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise LawError(f"{text}: its name must be a text of printable characters")
    kind, fields = law.parameters, getattr(law.parameters, "_fields", None)
    if fields is None or not isinstance(kind, type):
        raise LawError(f"{text}: parameters = {kind!r}: must be a class, a NamedTuple of numbers")
    for field in fields:
        default = law.parameters._field_defaults.get(field, 0.0)
        if field in _TAKEN:
            raise LawError(f"{text}: parameter {field!r}: is a key that every law has; give it another name")
        if not isinstance(default, Real) or not math.isfinite(default):
            raise LawError(f"{text}: parameter {field!r}: its default {default!r} must be a number")
    for label, wanted in _ARGUMENTS.items():
        function = getattr(law, label)
        if not isinstance(function, FunctionType):
            raise LawError(f"{text}: {label} = {function!r}: must be a function written with def")
        given = function.__code__.co_varnames[: function.__code__.co_argcount]
        if given[: len(wanted)] != wanted:
            raise LawError(f"{text}: the arguments of {label} must be named {', '.join(wanted)}, not {', '.join(given)}")


def check_law(name: str, law: Any, parameters: tuple[float, ...] = _PARAMETERS) -> None:
    """`check_at` five decades of rates; raises what it does.

    `law` is a `Registered`; it is checked with the parameter class's own defaults, else with `parameters` (a_star, a, b).
    """
    sample = sample_of(name, law, parameters)
    for rate in _RATES:
        check_at(name, law, sample, rate)


def check_at(name: str, law: Any, sample: Any, rate: float) -> None:
    """Compare v_z, F_z, F_psi, G_z, G_psi with central differences, G(v, psi_ss(v)) with 0 and its slope with its sign, for the
    parameters `sample` at the `rate` and three states.

    Raises LawError naming the law, the wrong function and both values, or the error that the law's code raised.
    """
    try:
        z, steady = law.unknown_of(sample, rate), law.steady_state(sample, rate)
        _require(name, "rate_of(unknown_of(v))", law.rate_of(sample, z), rate)
        bend = (law.rate_of(sample, z + _WIDE) - 2.0 * rate + law.rate_of(sample, z - _WIDE)) / (2.0 * math.cosh(_WIDE) - 2.0)
        _require(name, f"v'' at z = {z:.6g} (solvers continue v by v'' = v: use e^z or 2 c sinh z)", bend, rate)
        still = law.respond(sample, z, steady)
        if len(still) != len(_ANSWERS):
            raise LawError(f"friction law {name!r}: respond must return {', '.join(_ANSWERS)}, not {len(still)} values")
        _require(name, "v of respond at z = unknown_of(v)", still[0], rate)
        _require(name, "state rate G at psi = steady_state(v)", still[5], 0.0, scale=rate)
        for offset in _STATE_OFFSETS:
            _check_derivatives(name, law, sample, z, steady + offset)
        if not still[7] < 0.0:
            raise LawError(
                f"friction law {name!r}: G_psi = {still[7]:.6g} at z = {z:.6g}: must be < 0 in steady sliding, so that the state "
                "returns to it; for friction without a state let G = -psi"
            )
    except (ArithmeticError, TypeError, ValueError, AttributeError, NameError) as error:
        if isinstance(error, SceneError):
            raise
        raise LawError(f"friction law {name!r}: its code failed: {type(error).__name__}: {error}") from error


def sample_of(name: str, law: Any, parameters: tuple[float, ...] = _PARAMETERS) -> Any:
    """An instance of the law's parameters for the check. Raises LawError if its class lacks defaults."""
    for values in ((), parameters):
        try:
            return law.parameters(*values)
        except TypeError:
            continue
    raise LawError(f"friction law {name!r}: give the fields of {law.parameters.__qualname__} defaults, so that it can be checked")


def derivative_error(law: Any, sample: Any, z: float, psi: float) -> float:
    """Largest difference between the law's derivatives and central differences at (z, psi), relative to the largest value."""
    answer, slopes = _slopes(law, sample, z, psi)
    sizes = {label: max(abs(wanted), 1e-2 * abs(answer[label.partition("_")[0]]), 1e-3) for label, wanted in slopes.items()}
    return max(float(abs(answer[label] - wanted) / sizes[label]) for label, wanted in slopes.items())


def _slopes(law: Any, sample: Any, z: float, psi: float) -> tuple[dict[str, float], dict[str, float]]:
    """The law's answer, and its slopes by central differences."""
    answer = dict(zip(_ANSWERS, law.respond(sample, z, psi), strict=True))
    slopes = {
        "z": _difference(law, sample, (z + _STEP, psi), (z - _STEP, psi)),
        "psi": _difference(law, sample, (z, psi + _STEP), (z, psi - _STEP)),
    }
    return answer, {label: slopes[variable][quantity] for label in _SLOPES for quantity, variable in [label.split("_")]}


def _check_derivatives(name: str, law: Any, sample: Any, z: float, psi: float) -> None:
    answer, slopes = _slopes(law, sample, z, psi)
    if not answer["F_z"] > 0.0:
        raise LawError(f"friction law {name!r}: F_z = {answer['F_z']:.6g} at z = {z:.6g}: must be > 0 (the direct effect)")
    for label, wanted in slopes.items():
        scale = 1e-3 * max(1.0, abs(answer[label[0]]))
        _require(name, f"{label} at z = {z:.6g}, psi = {psi:.6g}", answer[label], wanted, scale)


def _difference(law: Any, sample: Any, ahead: tuple[float, float], behind: tuple[float, float]) -> dict[str, float]:
    forward, backward = law.respond(sample, *ahead), law.respond(sample, *behind)
    return {key: (f - b) / (2 * _STEP) for key, f, b in zip(_ANSWERS, forward, backward, strict=True)}


def _require(name: str, what: str, given: float, wanted: float, scale: float = 0.0) -> None:
    allowed = _TOLERANCE * max(abs(wanted), 10.0 * scale, 1e-3)
    if not abs(given - wanted) <= allowed:
        raise LawError(f"friction law {name!r}: {what} = {given:.10g}, but must be {wanted:.10g} (finite differences)")

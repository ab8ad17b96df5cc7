"""Predicts the error of a reduction without running it: the leading error of its critical r as theta = r omega_c -> 0.

On s = i theta (transit clock) the alike pair's reactance over epsilon is

    exact     -(1/2) cot(theta/2) = -1/theta + theta/12 + theta^3/720 + theta^5/30240 + ...
    reduced   -1/theta + (mass + sum c_k/w_k^2) theta + (sum c_k/w_k^4) theta^3 + ...

At a crossing this reactance equals a number that depends on friction alone. Therefore a deficit of coefficient theta^(p-1)
changes r_c by the relative amount coefficient theta^p. Radiation damping acts at first order: quasidynamic has r_c = r_*/(1 - r_*
G_phi/2), an error of (G_phi/(2 omega_c)) theta.
"""

from dataclasses import dataclass

from reduced.impedance.reduction import reduction
from slipwave.friction.law import FrictionSlopes

_EXACT = (1.0 / 12.0, 1.0 / 720.0, 1.0 / 30240.0)
_ROUNDING = 1e-12


@dataclass(frozen=True)
class ErrorLaw:
    """Relative error of the critical r ~ coefficient * (r omega_c)^power."""

    coefficient: float
    power: int

    def at(self, theta: float) -> float:
        """The law's value at theta = r omega_c (radians per transit)."""
        return self.coefficient * theta**self.power


def error_law(model: str, slopes: FrictionSlopes) -> ErrorLaw:
    """Leading relative error of the critical r of an alike plain pair under `model`.

    quasistatic theta^2/12, quasidynamic (G_phi/(2 omega_c)) theta, block8 -theta^2/24, block12 theta^4/720, kelvin-voigt
    -theta^4/480, modal:N theta^4 sum_{k>N} 2/(2 pi k)^4.

    Raises SceneError for a name that is not a reduction, ValueError for a reduction with other damping than radiation.
    """
    reduced = reduction(model)
    if reduced.damping:
        return ErrorLaw(0.5 * slopes.healing / slopes.omega_c * (2.0 * reduced.damping), 1)
    if not reduced.is_lossless:
        raise ValueError(f"no error law for {model}: only radiation damping and lossless reductions have one")
    modes = list(zip(reduced.residues, reduced.frequencies, strict=True))
    first, third, fifth = (sum(c / w**p for c, w in modes) for p in (2, 4, 6))  # coefficients of theta, theta^3, theta^5
    for power, exact, own in zip((2, 4, 6), _EXACT, (reduced.mass + first, third, fifth), strict=True):
        if abs(exact - own) > _ROUNDING * exact:
            return ErrorLaw(exact - own, power)
    return ErrorLaw(0.0, 8)

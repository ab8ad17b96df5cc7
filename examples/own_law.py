"""A friction law of one's own, at compiled speed in every model: ageing whose strengthening with age fades below a cut-off age.

mu = a_* + a ln v + b ln(phi + cutoff),   phi' = 1 - v phi.    Run it:  .venv/bin/python examples/own_law.py
"""

import math
from typing import NamedTuple

import slipwave
from slipwave.friction import register
from validation.models.build import build
from validation.models.run import simulate


class Cutoff(NamedTuple):
    """Parameters, with defaults to be checked with; they become keys of [interface]."""

    a_star: float = 0.369
    a: float = 0.0349
    b: float = 0.0489
    cutoff: float = 1e-3


def respond(law: Cutoff, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """(v, v_z, F, F_z, F_psi, G, G_z, G_psi) at z = ln v and psi = ln phi; psi' = G."""
    v, age = math.exp(z), math.exp(psi)
    strength = law.a_star + law.a * z + law.b * math.log(age + law.cutoff)
    return v, v, strength, law.a, law.b * age / (age + law.cutoff), 1.0 / age - v, -v, -1.0 / age


def steady_state(law: Cutoff, v: float) -> float:
    """psi at which sliding at rate v is steady: G = 0."""
    return -math.log(v)


register("cutoff", Cutoff, respond, steady_state)


def main() -> None:
    """Compare the law's orbit by the full wave and in the paper's ODE."""
    mine = slipwave.read("paper", ["interface.law=cutoff", "interface.cutoff=1e-5", "run.until=3000"])
    for model in ("fd", "kelvin-voigt"):
        found = simulate(build(model, mine), mine.until).statistics
        print(f"{model}: period {found.period.mean:.6f} transits, stress drop {found.stress_drop.mean:.7f}")


if __name__ == "__main__":
    main()

"""What a fit without waves, or with some, makes of data of the exact delay system: computed once and kept in the checkout.

`python -m validation.studies.bias.measured` computes the record again.
"""

import hashlib
import json
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from slipwave.errors import NumericsError
from slipwave.files import whole_or_absent
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.sources import ROOT
from validation.fit.least_squares import Best, intervals, minimise, profiled
from validation.fit.synthetic import NOISE, stepped_problem, stepped_scene, true_friction, truth_of

RECORD = ROOT / "reports" / "baseline" / "fits.json"
MODELS = ("quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:2")
QUANTITIES = ("a", "b", "b - a", "L", "k")
SHARES = np.logspace(-2.5, 0.0, 14)
KAPPAS = np.logspace(np.log10(1.2), 1.5, 12)

COVERED = (0.1, 5.0)
"""Share and kappa of the records whose intervals are counted."""

FITS = dict.fromkeys(("delay", *MODELS), 200)
_ASIDE = 0.05  # spread of the starts, in logarithms
_STARTS = (0.0, 0.1, -0.2)  # shifts of the logarithms of all parameters from the truth


def biases_of(scene: Scene, friction: Array, model: str) -> dict[str, float]:
    """Relative errors of a, b, b - a, L and stiffness of a fit by `model`, and half widths of its own 95 % intervals with the
    noise of the record. NaN where the fit finds no minimum."""
    problem = stepped_problem(scene, model, friction, stiffness=True)
    truth = truth_of(problem)
    try:
        found = minimise(problem, [truth + shift for shift in _STARTS], Best(truth), 1.0)
    except NumericsError:
        return {f"{kind} {name}": float("nan") for kind in ("error", "half") for name in QUANTITIES}
    noise = np.random.default_rng(1).standard_normal(friction.size)  # the record has none of its own
    noisy = found._replace(residual=found.residual + noise)
    spread = intervals(problem, noisy)
    half = (spread.high - spread.low) / 2.0
    moved = found.inner - truth
    a, b = np.exp(found.inner[:2])
    by = np.array([-a, b, 0.0, 0.0]) / (b - a)
    scale = half[0] / np.sqrt(spread.covariance[0, 0])
    errors = [*np.expm1(moved[:2]), (b - a) / float(np.diff(np.exp(truth[:2]))[0]) - 1.0, *np.expm1(moved[2:])]
    halves = [*half[:2], scale * float(np.sqrt(by @ spread.covariance @ by)), *half[2:]]
    return {
        f"{kind} {name}": float(x)
        for kind, row in (("error", errors), ("half", halves))
        for name, x in zip(QUANTITIES, row, strict=True)
    }


def all_biases(scene: Scene) -> dict[str, float]:
    """Of every model, for data of the delay system."""
    friction = true_friction(stepped_problem(scene, "delay"))
    return {f"{model} {name}": value for model in MODELS for name, value in biases_of(scene, friction, model).items()}


def intervals_held(model: str, seeds: Sequence[int]) -> list[list[bool]]:
    """Whether the 95 % intervals of a, b and L hold the truth, for each of `seeds`: noisy data of a model fitted by itself."""
    scene = stepped_scene(*COVERED)
    exact = stepped_problem(scene, model)
    truth, friction = truth_of(exact), true_friction(exact)
    found = []
    for seed in seeds:
        noise = np.random.default_rng([len(model), seed])
        problem = stepped_problem(scene, model, friction + NOISE * noise.standard_normal(friction.size))
        best = minimise(problem, [truth + _ASIDE * noise.standard_normal(truth.size)], Best(truth), 1.0)
        spread = intervals(problem, best)
        if problem.models[0].is_cheap:
            spread = profiled(problem, best, spread)
        found.append([bool(low < x < high) for low, x, high in zip(spread.low, truth, spread.high, strict=True)])
    return found


def grid() -> Iterator[tuple[float, float]]:
    """The points of the atlas."""
    for share in SHARES.tolist():
        for kappa in KAPPAS.tolist():
            yield share, kappa


def grid_digest() -> str:
    """Sixteen hex digits that name the fits: scenes, models, seeds."""
    facts = ([stepped_scene(*point).digest for point in grid()], MODELS, FITS, COVERED, NOISE)
    return hashlib.sha256(repr(facts).encode()).hexdigest()[:16]


def recorded() -> dict[str, Any]:
    """What was kept: `points` (share, kappa) with their `rows`, and `covered` per model."""
    return dict(json.loads(RECORD.read_text(encoding="utf-8")))


if __name__ == "__main__":
    every = list(grid())
    record = {
        "points": every,
        "digest": grid_digest(),
        "rows": [all_biases(stepped_scene(*point)) for point in every],
        "covered": {model: intervals_held(model, range(count)) for model, count in FITS.items()},
    }
    with whole_or_absent(RECORD) as path:
        path.write_text(json.dumps(record))

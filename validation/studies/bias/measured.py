"""Fits of models without waves, or with some, to data of the exact delay system at every point of an atlas: a measure for
`slipwave sweep`. `python -m validation.studies.bias.measured FOLDER` computes the record again, or continues the sweep in this
folder.
"""

import csv
import json
import math
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

import slipwave
from slipwave.errors import NumericsError
from slipwave.files import whole_or_absent
from slipwave.scene import Scene
from slipwave.sources import ROOT
from validation.fit.cycles import disturbed
from validation.fit.forward import OfSolver
from validation.fit.least_squares import Best, intervals, minimise, profiled
from validation.fit.parameters import Schedule, Variants
from validation.fit.records import Experiment, stick_slip
from validation.fit.synthetic import FAST, NOISE, STEP, TRUTH, problem_for, stepped_record, stepped_scene, true_friction, truth_of

if TYPE_CHECKING:
    from xarray import Dataset
else:
    Dataset = Any

RECORD = ROOT / "reports" / "baseline" / "atlas.nc"
COVERED_RECORD = RECORD.with_name("fits.json")
MODELS = ("quasistatic", "quasidynamic", "block8", "block12", "one mass", "kelvin-voigt", "modal:2")
"""Fitted models; `one mass`: a spring and a block whose mass is fitted too."""

MEASURE = "validation.studies.bias.measured:all_biases"
QUANTITIES = ("a", "b", "b - a", "L", "k")
MACHINES = (None, 1.0, 10.0)
SWINGS = np.logspace(-2.5, 0.0, 9)
STEPPED, SLIPPING = (1.2, 2.0, 5.0, 12.0, 32.0), (0.5, 0.8)
SLIPPING_SWINGS = SWINGS[4:8]
RINGING = ("kelvin-voigt", "modal:2")
"""Models not fitted to stick-slip: they oscillate during stick, and need every sample of a repeating motion instead of means over
a recorder's filter."""

COVERED = (0.1, 5.0)
"""Share and kappa of the records for the coverage of intervals."""

FITS = dict.fromkeys(("delay", *(model for model in MODELS if model != "one mass")), 200)
_ASIDE = 0.05  # spread of the starts, in logarithms
_STARTS = ((0.0, 0.0), (0.1, 1.5), (-0.2, 1.5))  # shifts of logarithms from the truth: of all parameters, of a fitted mass
_LENGTH, _LATE = 300.0, 0.5  # of a record of stick-slip, in times of slip by L over kappa; the share that is not fitted
_SAMPLE, _WITHIN = 0.2, 100  # from sample to sample, the same; each is the mean of so many values, as of a recorder's filter


class AtlasPoint(NamedTuple):
    """A point of the atlas: the period of the slowest vibration of sample and machine with a free interface over the time of slip
    by L, `swing`; `kappa` = k/k_c, above 1 a velocity step, below 1 stick-slip; the mass of the machine over that of the slab, or
    None without a machine."""

    swing: float
    kappa: float
    mass: float | None

    @property
    def changes(self) -> dict[str, float | str]:
        """The keys that give this point of any `stepped_scene`. Half of the compliance is the machine's, if there is one."""
        slab = (stepped_scene(1.0, self.kappa).tables or {})["slab"]
        thickness, modulus, angle = slab["thickness"], slab["shear_modulus"], math.pi / 2.0
        face: dict[str, float | str] = {"kind": "rigid"}
        mass = self.mass or 0.0
        if self.mass is not None:
            modulus *= 2.0
            angle = brentq(lambda x: (1.0 - mass * x * x) * math.cos(x) - x * math.sin(x), 0.0, angle)
            face = {"kind": "machine", "stiffness": modulus / thickness, "impedance": 0.0}
        density = modulus * (self.swing * angle / math.pi / (2.0 * thickness)) ** 2  # slip by L takes one second
        if self.mass is not None:
            face["mass"] = mass * density * thickness
        keys = {"shear_modulus": modulus, "density": density} | {f"face.{key}": value for key, value in face.items()}
        return {f"slab.{key}": value for key, value in keys.items()}


def atlas_points() -> list[AtlasPoint]:
    """All points, in the order of the record."""
    steps = [AtlasPoint(swing, kappa, mass) for mass in MACHINES for swing in SWINGS.tolist() for kappa in STEPPED]
    return steps + [
        AtlasPoint(swing, kappa, mass) for mass in MACHINES for swing in SLIPPING_SWINGS.tolist() for kappa in SLIPPING
    ]


def scene_of_point(point: AtlasPoint) -> Scene:
    """The scene of a point."""
    return slipwave.read(stepped_scene(1.0, 1.0), point.changes)


def kappa_of(scene: Scene) -> float:
    """k/k_c of a scene."""
    return scene.stiffness / scene.transit / (TRUTH["interface.b"] - TRUTH["interface.a"])


def seen_record(scene: Scene, model: str = "delay") -> Experiment:
    """The record of this scene in a laboratory: a velocity step, or stick-slip where kappa < 1."""
    if kappa_of(scene) > 1.0:
        record = stepped_record()
        return record._replace(friction=OfSolver(Variants(scene, (), STEP), record.times, model, 1e-8).friction(np.empty(0)))
    steady, random, kappa = Schedule((0.0,), (FAST,)), np.random.default_rng(1), kappa_of(scene)
    times = np.arange(_LATE * _LENGTH, _LENGTH, _SAMPLE) / kappa
    within = np.sort(times[:, None] + _SAMPLE / kappa * random.random((times.size, _WITHIN)), axis=1)
    seen = OfSolver(disturbed(Variants(scene, (), steady)), within.ravel(), model, 1e-7).friction(np.empty(0))
    friction = seen.reshape(within.shape).mean(axis=1) + NOISE * random.standard_normal(times.size)
    return stick_slip("stick-slip", times - times[0], friction, steady, [])


def all_biases(scene: Scene) -> dict[str, float]:
    """For each model the relative errors of a, b, b - a, L and stiffness fitted to data of the delay system, and the half widths
    of the 95 % intervals; NaN without a minimum and for undetermined parameters."""
    record = seen_record(scene)
    return {f"{model} {name}": value for model in MODELS for name, value in biases_of(scene, record, model).items()}


def stand_in(scene: Scene) -> Scene:
    """Slabs of the same impedance and stiffness as those of `scene`, without a machine."""
    return stepped_scene(2.0 * scene.impedance * scene.transit / scene.stiffness * FAST / STEP.velocities[0], kappa_of(scene))


def biases_of(scene: Scene, record: Experiment, model: str) -> dict[str, float]:
    """As `all_biases` for one model, from a record of the scene."""
    kappa, none = kappa_of(scene), {f"{kind} {name}": math.nan for kind in ("error", "half") for name in QUANTITIES}
    if kappa < 1.0 and model in RINGING:
        return none
    known = stand_in(scene)
    by_mass = ["slab.density"] if model == "one mass" else []
    problem = problem_for(known, "block12" if by_mass else model, record, "slab.shear_modulus", *by_mass)
    truth, found = truth_of(problem), None
    starts = [truth + shift + np.array([0.0] * 4 + [mass] * len(by_mass)) for shift, mass in _STARTS]
    with suppress(NumericsError):
        found = minimise(problem, starts if kappa > 1.0 else starts[:1], Best(truth), 1.0)
    if not found or found.failed:
        return none
    if kappa > 1.0:  # the record has no noise of its own
        found = found._replace(residual=found.residual + np.random.default_rng(1).standard_normal(found.residual.size))
    spread = intervals(problem, found)
    half, moved = (spread.high - spread.low) / 2.0, found.inner - truth
    a, b = np.exp(found.inner[:2])
    by = np.array([-a, b]) / (b - a)
    of_difference = half[0] * math.sqrt(by @ spread.covariance[:2, :2] @ by / spread.covariance[0, 0])
    errors = [*np.expm1(moved[:2]), (b - a) / float(np.diff(np.exp(truth[:2]))[0]) - 1.0, *np.expm1(moved[2:4])]
    halves = [*half[:2], of_difference, *half[2:4]]
    known_ones = np.isfinite(halves)
    rows = {"error": np.where(known_ones, errors, math.nan), "half": np.where(known_ones, halves, math.nan)}
    return {f"{kind} {name}": float(x) for kind, row in rows.items() for name, x in zip(QUANTITIES, row, strict=True)}


def intervals_held(model: str, seeds: Sequence[int]) -> list[list[bool]]:
    """Whether the 95 % intervals of a, b and L contain the truth, for each of `seeds`: noisy data of a model fitted by itself."""
    scene = stepped_scene(*COVERED)
    exact = problem_for(scene, model, stepped_record())
    truth, friction = truth_of(exact), true_friction(exact)
    found = []
    for seed in seeds:
        noise = np.random.default_rng([len(model), seed])
        problem = problem_for(scene, model, stepped_record(friction + NOISE * noise.standard_normal(friction.size)))
        best = minimise(problem, [truth + _ASIDE * noise.standard_normal(truth.size)], Best(truth), 1.0)
        spread = intervals(problem, best)
        if problem.models[0].is_cheap:
            spread = profiled(problem, best, spread)
        found.append([bool(low < x < high) for low, x, high in zip(spread.low, truth, spread.high, strict=True)])
    return found


def recorded_coverage() -> dict[str, list[list[bool]]]:
    """Model -> recorded results of `intervals_held`."""
    return dict(json.loads(COVERED_RECORD.read_text(encoding="utf-8")))


def sweep_points(folder: Path) -> Dataset:
    """Sweep all points into a folder, with a table of their scenes; continues an existing sweep."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [point.changes for point in atlas_points()]
    with (folder / "places.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
        table.writeheader()
        table.writerows(rows)
    swept = slipwave.sweep(stepped_scene(1.0, 1.0), rows=folder / "places.csv", measure=MEASURE, out=folder / "sweep")
    return swept.dataset


if __name__ == "__main__":
    sweep_points(Path(sys.argv[1])).to_netcdf(RECORD)
    with whole_or_absent(COVERED_RECORD) as part:
        part.write_text(json.dumps({model: intervals_held(model, range(count)) for model, count in FITS.items()}))

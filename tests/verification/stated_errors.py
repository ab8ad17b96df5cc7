"""Stated errors of this program on random scenes of known truth: how often they hold it, and the record of these computations.

python -m tests.verification.stated_errors orbits 20       # the first 20 computations of a kind, as a table
python -m tests.verification.stated_errors --record        # all kinds into reports/baseline/coverage-computations.json; resumes
python -m tests.verification.stated_errors --record means  # one kind
"""

import json
import math
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias
from zlib import crc32

import numpy as np
from scipy.stats import binomtest

import slipwave
from fullwave.adapt import _difference_of, _probe
from reduced.orbit.closing import close
from reduced.orbit.periodic import figures_of
from reduced.parameters import scaled
from reduced.stability.critical import critical_round_trip
from slipwave.errors import NumericsError, SceneError
from slipwave.files import whole_or_absent
from slipwave.observe.events import Events
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import summarise
from slipwave.scene import Scene
from slipwave.solve import Solver, follow
from slipwave.solve.lyapunov import INTERVALS, largest_exponent
from slipwave.sources import ROOT, source_digest
from tests.verification.order import richardson
from validation.commands.result import aligned
from validation.models.build import build, build_full_wave, judged_grid, prepare
from validation.models.by_name import one_port_of
from validation.models.cycle import watch
from validation.models.orbits import find_orbit
from validation.models.settle import NoCycle, settle
from validation.report import SELF, WITNESS, Evidence

_CHANCE = 1e-15  # rounding error of what is taken for the truth, relative


class Held(NamedTuple):
    """A `figure` with its stated error `bar` and its true `error`, relative to the figure."""

    figure: str
    bar: float
    error: float


class Coverage(NamedTuple):
    """Coverage of a kind of `figure`: the number of bars (`many`), the `share` that contain the truth with its 95 % interval
    (Wilson), and `width`, the median ratio of bar to error."""

    figure: str
    many: int
    share: float
    low: float
    high: float
    width: float


def coverage_of(computations: Iterable[list[Held]]) -> list[Coverage]:
    found = sorted((held for one in computations for held in one), key=lambda held: held.figure)
    return [_covered(figure, list(members)) for figure, members in groupby(found, key=lambda held: held.figure)]


def _covered(figure: str, group: list[Held]) -> Coverage:
    holds = sum(held.error <= held.bar for held in group)
    low, high = binomtest(holds, len(group)).proportion_ci(method="wilson")
    width = float(np.median([held.bar / max(held.error, _CHANCE) for held in group]))
    return Coverage(figure, len(group), holds / len(group), float(low), float(high), width)


_CLOSE = (1.01, 1.25)  # times the round trip at which steady sliding loses its stability

ReportPart = Callable[[np.random.Generator], dict[str, Any]]
SLABS: dict[str, ReportPart] = {
    "alike": lambda random: {},
    "unlike": lambda random: {},
    "layered": lambda random: {
        "layers": [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": random.uniform(0.5, 2.0)}]
    },
    "grip": lambda random: {
        "face": {"kind": "grip", "stiffness": 10.0 ** random.uniform(0.5, 1.5), "impedance": 10.0 ** random.uniform(-0.5, 0.7)}
    },
    "machine": lambda random: {
        "face": {"kind": "machine", "stiffness": 10.0 ** random.uniform(0.5, 1.5)}
        | {"impedance": random.uniform(0.1, 2.0), "mass": random.uniform(0.1, 2.0)}
    },
    "viscous": lambda random: {"viscosity": {"kind": "kelvin-voigt", "time": 10.0 ** random.uniform(-6.0, -4.7)}},
}
"""Kind of slabs -> keys of a random slab other than impedance and round trip."""


def random_scene(kind: str, model: str, random: np.random.Generator, beyond: tuple[float, float] = _CLOSE) -> Scene:
    """A scene with a kind of SLABS, a little beyond the loss of stability of steady sliding of `model`."""
    a, transit = 0.0349 * 10.0 ** random.uniform(-0.1, 0.1), 0.002
    slab = {"epsilon": 2.8e-5 * 10.0 ** random.uniform(-0.3, 0.3), "r": transit} | SLABS[kind](random)
    ratio = random.choice([0.5, 0.75, 1.5, 2.0, 3.0]) if random.random() < 0.7 else random.uniform(0.5, 2.0)
    other = slab | {"epsilon": slab["epsilon"] * 10.0 ** random.uniform(-0.4, 0.4), "r": transit * float(ratio)}
    scene = slipwave.read(
        {
            "name": kind,
            "interface": {"law": "ageing", "a_star": 0.369, "a": a, "b": a * random.uniform(1.2, 1.6)},
            "drive": {"velocity": 10.0 ** random.uniform(1.5, 2.8)},
            **({"upper": slab, "lower": other} if kind == "unlike" else {"slab": slab}),
        }
    )
    critical, _ = critical_round_trip(scene, one_port_of(model))
    return scaled(scene, round_trip=random.uniform(*beyond) * critical / scene.transit)


OF_VISCOUS = "dg:9"
"""The reference model for viscous slabs."""

_FINER = 3.0
_DEFAULT, _LOOSEST, _TIGHTEST = 1e-8, 1e-4, 1e-10  # tolerances of orbits; four in ten have the default
_WITNESS_CELLS = 8
_EXACT = 1e-11
_SETTLED = 0.1  # of the tolerance: how closely cycles repeat
_GRIDS = {"fd": 1e-3, "sbp:2": 1e-3, "sbp:4": 1e-4, "sbp:6": 1e-5, "fem:4": 1e-6, "dg": 1e-6}  # asked for, and near them


def of_orbit(model: str, scene: Scene, random: np.random.Generator) -> list[Held]:
    """Figures of an orbit to a random tolerance, compared with those on a much finer mesh."""
    tolerance = _DEFAULT if random.random() < 0.4 else 10.0 ** random.uniform(math.log10(_TIGHTEST), math.log10(_LOOSEST))
    found = find_orbit(model, scene, tolerance).periodic
    flow, start = found.closed.flow.remeshed(found.closed.cycle, _FINER)
    truth = figures_of(close(flow, start, found.closed.cycle.period, 0.0))
    stated = {name: getattr(found.orbit, name).error for name in truth}
    return [Held(name, stated[name] / true, abs(found.orbit.values()[name] / true - 1.0)) for name, true in truth.items()]


def any_orbit(random: np.random.Generator) -> list[Held]:
    kind = str(random.choice(list(SLABS)))
    able = {"alike": ["delay", "kelvin-voigt", "block8", "modal:2"], "unlike": ["delay", "modal:1"], "viscous": ["sbp:6"]}
    model = str(random.choice(able.get(kind, ["delay"])))
    return of_orbit(model, random_scene(kind, model, random), random)


def _grid_scene(model: str, random: np.random.Generator) -> tuple[str, Scene]:
    kind = str(random.choice(["alike", "unlike", "layered", "grip", "viscous"]))
    viscous = kind == "viscous"
    return OF_VISCOUS if viscous else "delay", random_scene(kind, model if viscous else "auto", random)


def _exact(model: str, scene: Scene) -> Solver:
    return build_full_wave(model, scene, cells=_WITNESS_CELLS) if model == OF_VISCOUS else build(model, scene, tolerance=_EXACT)


def chosen_grid(random: np.random.Generator) -> list[Held]:
    """Periods and drops of the probe's cycles on a grid chosen by a tolerance."""
    model = str(random.choice(list(_GRIDS)))
    known, scene = _grid_scene(model, random)
    built = prepare(model, scene, tolerance=_GRIDS[model] * 10.0 ** random.uniform(-0.5, 0.5))
    assert built.choice is not None
    return [Held("cycles", built.choice.error_estimate, _difference_of(_probe(_exact(known, scene)), _probe(built.solver)))]


def default_grid(random: np.random.Generator) -> list[Held]:
    """As `chosen_grid` on a default grid; a warning without a number states no error."""
    model = str(random.choice([*_GRIDS, "dg:7"]))
    known, scene = _grid_scene(model, random)
    solver = prepare(model, scene).solver
    choice = judged_grid(solver, solver.state())
    assert choice is not None
    if not math.isfinite(choice.error_estimate):
        return []
    return [Held("cycles", choice.error_estimate, _difference_of(_probe(_exact(known, scene)), _probe(solver)))]


def steps(random: np.random.Generator) -> list[Held]:
    """The cycle on which a run of a model without a grid settles, compared with the orbit. The stated error of a cycle is the
    run's tolerance plus the remaining difference of its cycles."""
    kind = str(random.choice(["alike", "unlike", "layered", "grip"]))
    model = str(random.choice(["delay", "kelvin-voigt", "block8", "modal:2"] if kind == "alike" else ["delay"]))
    scene, tolerance = random_scene(kind, model, random), 10.0 ** random.uniform(-9.0, -4.0)
    settled = settle(build(model, scene, tolerance=tolerance), _SETTLED * tolerance)
    if settled.unrest > tolerance:
        raise NumericsError("the motion does not settle")
    truth = find_orbit(model, scene, _EXACT).periodic.orbit.values()
    found = {name: getattr(settled.orbit, name) for name in ("period", "stress_drop")}
    return [Held(name, tolerance + one.error / one.value, abs(one.value / truth[name] - 1.0)) for name, one in found.items()]


def limits_of_grids(random: np.random.Generator) -> list[Held]:
    """State and slip rate after a while, from three grids of order 2."""
    model, kind = str(random.choice(["fd", "sbp:2"])), str(random.choice(["alike", "unlike", "layered"]))
    scene = replace(random_scene(kind, "auto", random), until=float(random.integers(30, 90)))
    cells, cfl = int(random.integers(24, 64)), 0.5 if model == "fd" else None
    coarse, middle, fine = (_final(build_full_wave(model, scene, cells=n * cells, cfl=cfl)) for n in (1, 2, 4))
    truth = _final(build("delay", scene, tolerance=_EXACT))
    found = {name: (richardson(coarse[k], middle[k], fine[k], 2.0), truth[k]) for k, name in enumerate(("ln v", "psi"))}
    return [Held(name, one.error, abs(one.value - known)) for name, (one, known) in found.items()]


def _final(solver: Solver) -> tuple[float, float]:
    assert solver.scene.until is not None
    final = follow(solver, solver.scene.until)
    return final.ln_v, final.psi


_BEYOND = (1.15, 2.5)  # times the round trip at which steady sliding loses its stability: many motions never repeat there
_TOLERANCE = 1e-7
_TRANSIENT = 1500.0  # transits
_LEAST_SPREAD, _FEWEST = 1e-3, 6  # change of the periods, relative, and number of them, in motions that never repeat
_CYCLES = (16.0, 240.0)  # of a run: their range
_LONG = 1000  # cycles of the run that goes on
_TIMES = 3  # as many intervals in that of an exponent


def irregular_motion(random: np.random.Generator) -> tuple[Solver, float]:
    """A solver past its transient, in a motion that never repeats, and its mean period. Raises NumericsError if the motion
    repeats."""
    model = str(random.choice(["delay", "kelvin-voigt", "modal:2"]))
    solver = build(model, random_scene("alike", model, random, _BEYOND), tolerance=_TOLERANCE)
    period = watch(solver, 2.0 * _TRANSIENT).events(_TRANSIENT).period
    require_irregular(period)
    return solver, float(period.mean())


def require_irregular(periods: Array) -> None:
    """Raises NumericsError for cycles that repeat after some number of them, and for too few to decide."""
    repeats = [np.ptp(periods[lag:] - periods[:-lag]) < _LEAST_SPREAD * periods.mean() for lag in range(1, periods.size // 2)]
    if periods.size < _FEWEST or any(repeats):
        raise NumericsError("the motion repeats")


def irregular_means(random: np.random.Generator) -> list[Held]:
    """Means over the first cycles of a run, with their stated margins, compared with those over all later cycles."""
    solver, period = irregular_motion(random)
    cycles, begin = round(math.exp(random.uniform(*np.log(_CYCLES)))), solver.time
    events = watch(solver, begin + (cycles + _LONG) * period).events(begin)
    require_irregular(events.period[-_LONG // 10 :])
    return held_means(events, cycles)


def held_means(events: Events, count: int) -> list[Held]:
    """Means over the first `count` cycles, compared with those over the others."""
    first, rest = (summarise(Events(*(column[part] for column in events)), False) for part in (slice(count), slice(count, None)))
    certain = 1.0 / math.sqrt(1.0 + first.cycles / rest.cycles)
    return [
        Held(name, margin / getattr(rest, name).mean, certain * abs(getattr(first, name).mean / getattr(rest, name).mean - 1.0))
        for name, margin in first.margins.items()
        if name in first.spreads
    ]


def exponents(random: np.random.Generator) -> list[Held]:
    """The largest Lyapunov exponent times the period, with its margin, compared with that of a longer continuation."""
    solver, period = irregular_motion(random)
    twin = build(solver.model, solver.scene, tolerance=_TOLERANCE)
    found, truth = (largest_exponent(solver, twin, period, intervals=count) for count in (INTERVALS, _TIMES * INTERVALS))
    certain = 1.0 / math.sqrt(1.0 + found.transits / truth.transits)
    return [Held("exponent", found.margin * period, certain * abs(found.rate - truth.rate) * period)]


RECORD = ROOT / "reports" / "baseline" / "coverage-computations.json"
SUMMARY = RECORD.with_name("coverage-record.json")
_AT_ONCE = 10  # computations between two writings
# how closely a computation is repeated: share of what is compared, share of the bar, and what is left of rounding
_NEAR, _LITTLE, _ROUNDING = 0.05, 1e-3, 3e-12

Record: TypeAlias = dict[str, list[list[Held]]]
"""Kind -> its computations, in order."""


class Kind(NamedTuple):
    """A kind of stated error: whose `bar`, the `truth` it is compared with, the kind of `evidence`, the function that `measure`s
    it, and the number of computations `recorded`."""

    bar: str
    truth: str
    evidence: Evidence
    measure: Callable[[np.random.Generator], list[Held]]
    recorded: int


_KNOWN = f"delay system; with viscosity `{OF_VISCOUS}`"
KINDS = {
    "orbits": Kind("`slipwave orbit`: error of each figure", "a mesh three times finer", SELF, any_orbit, 110),
    "tolerances": Kind("`--tol` of models without a grid", "the orbit, by Newton’s method", SELF, steps, 250),
    "chosen grids": Kind("`--tol` of full waves: estimated error", _KNOWN, WITNESS, chosen_grid, 135),
    "default grids": Kind("default grids of full waves: estimated error", _KNOWN, WITNESS, default_grid, 110),
    "extrapolation": Kind("Richardson’s limit of three grids", "delay system", WITNESS, limits_of_grids, 104),
    "means": Kind("means of motions that never repeat: margin", "1000 cycles more", SELF, irregular_means, 330),
    "exponents": Kind("largest Lyapunov exponents: margin", "600 intervals more", SELF, exponents, 175),
}
"""Kinds by name."""

LEFT_OUT = {("chosen grids", 50)}
"""Computations left out: this one had not ended after 90 s of processor time, on hundreds of cells; its result is unknown."""


def computation(kind: str, number: int) -> list[Held]:
    """Computation `number` of a kind, the same whenever it is repeated; empty without a stated error, or if LEFT_OUT."""
    if (kind, number) in LEFT_OUT:
        return []
    try:
        return KINDS[kind].measure(np.random.default_rng([crc32(kind.encode()), number]))
    except (NumericsError, SceneError, NoCycle):
        return []


def known_computations(path: Path = RECORD) -> Record:
    stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return {kind: [_read(each, *stored[kind]["figures"]) for each in stored[kind]["computations"]] if kind in stored else []
            for kind in KINDS}  # fmt: skip


def _read(numbers: list[float], *figures: str) -> list[Held]:
    """A computation of the file, which has bar and error of each figure, or nothing."""
    return [Held(*held) for held in zip(figures, numbers[::2], numbers[1::2], strict=False)]


def store_computations(record: Record, path: Path = RECORD) -> None:
    kinds = []
    for kind, found in record.items():
        figures = json.dumps(next(([held.figure for held in one] for one in found if one), []))
        lines = ",\n".join(json.dumps([float(f"{value:.4g}") for held in one for value in held[1:]]) for one in found)
        kinds.append(f'"{kind}": {{"figures": {figures}, "computations": [\n{lines}\n]}}')
    with whole_or_absent(path) as part:
        part.write_text("{\n" + ",\n".join(kinds) + "\n}\n", encoding="utf-8")


def make_record(kinds: Iterable[str], path: Path = RECORD) -> None:
    """Compute the missing computations of some kinds, and store them in batches."""
    record = known_computations(path)
    for kind in kinds:
        found, wanted = record[kind], KINDS[kind].recorded
        while len(found) < wanted:
            found.append(computation(kind, len(found)))
            if len(found) % _AT_ONCE == 0 or len(found) == wanted:
                store_computations(record, path)
                print(f"{kind}: {len(found)} of {wanted}", file=sys.stderr, flush=True)


def summary(record: Record) -> dict[str, Any]:
    """What the report shows of a record: for each kind and figure how many stated errors there are, how many hold the truth, and
    the median of stated over true error."""

    def told(one: Coverage) -> dict[str, Any]:
        return {"number": one.many, "held": round(one.share * one.many), "width": float(f"{one.width:.3g}")}

    return {
        kind: {"bar": one.bar, "truth": one.truth, "evidence": one.evidence.value}
        | {"figures": {found.figure: told(found) for found in coverage_of(record[kind])}}
        for kind, one in KINDS.items()
    }


def chosen(record: Record, kind: str) -> int:
    """Number of a computation to be repeated, which depends on the text of the solvers."""
    able = [number for number, held in enumerate(record[kind]) if held]
    return int(np.random.default_rng(int(source_digest(), 16)).choice(able))


def agree(ours: list[Held], known: list[Held]) -> bool:
    """Whether a repeated computation agrees with the recorded one in each bar and each error."""
    return [one.figure for one in ours] == [one.figure for one in known] and all(map(_near, ours, known))


def _near(one: Held, other: Held) -> bool:
    bar, error = max(one.bar, other.bar), max(one.error, other.error)
    same = abs(one.bar - other.bar) < _NEAR * bar + _ROUNDING
    alike = one.error == other.error  # both are infinite where the numbers of cycles differ
    return same and (alike or abs(one.error - other.error) < _NEAR * error + _LITTLE * bar + _ROUNDING)


def main(words: list[str]) -> None:
    if words[0] == "--record":
        make_record(words[1:] or KINDS)
        SUMMARY.write_text(json.dumps(summary(known_computations()), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        return
    kind, count = words
    found = coverage_of(computation(kind, number) for number in range(int(count)))
    rows = [
        [one.figure, str(one.many), f"{one.share:.3f}", f"{one.low:.3f} .. {one.high:.3f}", f"{one.width:.1f}"] for one in found
    ]
    print("\n".join(aligned([kind, "number", "held", "95 % interval", "bar / error"], rows)))


if __name__ == "__main__":
    main(sys.argv[1:])

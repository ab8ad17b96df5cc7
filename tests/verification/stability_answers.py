"""Random scenes, and whether the answers on their steady sliding agree: certified count, roots, critical values, and a run.

.venv/bin/python -m tests.verification.stability_answers 200
"""

import math
import signal
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import slipwave
from reduced.stability import analyse, characteristic, scaled, unstable_count
from reduced.stability.analyse import stability_in_si, thickened
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.ageing import Ageing, AgeingRegularised
from slipwave.friction.slip import Slip, SlipRegularised
from slipwave.observe import HistoryObserver
from slipwave.scene import Scene
from slipwave.scene.drive import steady_drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, MachineFace, ReflectingFace, Slab, StandardLinearViscosity
from slipwave.scene.start import Start
from slipwave.solve import follow
from validation.registry.build import build
from validation.registry.families import one_port_of

MODELS = ["delay"] * 6 + ["quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:2", "fitted:3"]
KINDS = ["plain", "plain", "unlike", "irrational", "layers", "grip", "machine", "reflection", "kelvin-voigt", "zener", "si"]
LONGEST, SECONDS, NUDGE, ENDS = 4000.0, 8, 1e-6, 14.0


def scene_of(number: int) -> tuple[Scene, str, str]:
    """(scene, model, kind) of this number: from deep inside the stable to far beyond the onset, a fifth of them close to it."""
    rng = np.random.default_rng([2026, number])

    def among(low: float, high: float) -> float:
        """A number from `low` to `high`, its logarithm uniform."""
        return float(10.0 ** rng.uniform(math.log10(low), math.log10(high)))

    kind, model = str(rng.choice(KINDS)), str(rng.choice(MODELS))
    a = among(0.003, 0.05)
    gap = a * among(0.05, 1.0) * (-1.0 if rng.random() < 0.08 else 1.0)
    velocity = among(1e-3, 1e4) if rng.random() < 0.85 else among(1e4, 1e7)
    if kind == "si":
        return _in_si(among, a, gap, rng), model, kind
    law = rng.choice(np.array([Ageing, AgeingRegularised, Slip, SlipRegularised], dtype=object))(0.5, a, a + gap)
    r = among(1e-4, 3.0 if rng.random() < 0.7 else 100.0) / velocity
    epsilon = abs(gap) * r * (among(0.1, 10.0) if rng.random() < 0.8 else 1.0 + among(1e-6, 1e-2))
    upper = lower = Slab(epsilon, r)
    if kind in ("unlike", "irrational"):
        ratio = rng.integers(1, 7) / rng.integers(1, 7) if kind == "unlike" else among(0.2, 5.0)
        lower = Slab(epsilon * among(0.1, 10.0), r * float(ratio))
    elif kind == "layers":
        parts = rng.dirichlet(np.ones(rng.integers(2, 5)))
        lower = upper = replace(upper, layers=tuple(Layer(float(part), among(0.1, 10.0)) for part in parts))
    elif kind == "reflection":
        lower = upper = replace(upper, face=ReflectingFace(float(rng.uniform(-0.9, 0.999))))
    elif kind in ("grip", "machine"):
        face = GripFace(among(0.01, 100.0), among(0.01, 100.0))
        held = replace(upper, face=face if kind == "grip" else MachineFace(face.stiffness, face.impedance, among(0.01, 10.0)))
        upper, lower = held, held if rng.random() < 0.5 else lower
    elif kind == "kelvin-voigt":
        lower = upper = replace(upper, viscosity=KelvinVoigtViscosity(r * among(1e-3, 1.0)))
    elif kind == "zener":
        lower = upper = replace(upper, viscosity=StandardLinearViscosity(r * among(0.1, 100.0), among(0.05, 2.0)))
    return Scene(f"{kind}-{number}", law, upper, lower, steady_drive(velocity)), model, kind


def _in_si(among: Any, a: float, gap: float, rng: np.random.Generator) -> Scene:
    """A rock sample, bare or on a testing machine."""
    slab: dict[str, Any] = {"density": among(1e3, 8e3), "shear_modulus": among(1e9, 1e11), "thickness": among(1e-3, 30.0)}
    if rng.random() < 0.5:
        face = {"stiffness": among(1e9, 1e12), "impedance": among(1e3, 1e7), "mass": among(1.0, 1e4)}
        slab["face"] = {"kind": "machine"} | face
    law = {
        "law": "ageing",
        "a_star": 0.6,
        "a": a,
        "b": a + gap,
        "normal_stress": among(1e5, 1e8),
        "memory_length": among(1e-7, 1e-4),
    }
    tables = {"interface": law | {"reference_velocity": 1e-6}, "slab": slab, "drive": {"velocity": among(1e-9, 1.0) * 1e6}}
    return slipwave.read(tables)


def disagreements(scene: Scene, model: str, run: bool = True) -> tuple[list[str], str]:
    """What contradicts what, and whether a run could be made. Raises what the analysis raises."""
    port = one_port_of(model)
    found = analyse(scene, port)
    problem, wrong = characteristic(scene, port), list(found.missing)
    growing = [root for root in found.leading_roots if root.real > 0.0]
    certain = 1e-9 * problem.slopes.reach
    if found.stable is True and any(root.real > certain for root in growing):
        wrong.append(f"stable, yet a root {growing[0]:.6g} grows")
    if found.stable is False and len(growing) < min(found.unstable_roots, len(found.leading_roots) - 1):
        wrong.append(f"{found.unstable_roots} roots grow, {len(growing)} were found")
    for root in found.leading_roots:
        if not abs(complex(problem.imbalance(root))) < (1e-6 if root.real * scene.transit > -100.0 else 1e-3):
            wrong.append(f"{root:.6g} is no root: {abs(complex(problem.imbalance(root))):.1e}")
    wrong += [text for name, below, above in _sides(scene, found, port) if (text := _beside(name, below, above, port))]
    told = _run(scene, model, found) if run and found.stable is not None else "none"
    return [*wrong, *([told] if told not in ("agrees", "none") else [])], told


def _sides(scene: Scene, found: Any, model: str) -> Iterator[tuple[str, Scene, Scene]]:
    """(name, scene that ought to be stable, scene that ought to be unstable) of every critical value."""
    near = 1e-3
    if math.isfinite(found.log10_r_c):
        r = 10.0**found.log10_r_c / scene.transit
        yield "log10_r_c", scaled(scene, round_trip=r * (1.0 - near)), scaled(scene, round_trip=r * (1.0 + near))
    if math.isfinite(found.epsilon_c):
        factor = found.epsilon_c / scene.upper.epsilon
        yield "epsilon_c", scaled(scene, epsilon=factor * (1.0 + near)), scaled(scene, epsilon=factor * (1.0 - near))
    physical = stability_in_si(scene, found)
    if physical is not None and math.isfinite(physical.critical_thickness):
        factor = physical.critical_thickness / physical.thickness
        yield "thickness", thickened(scene, factor * (1.0 - near)), thickened(scene, factor * (1.0 + near))


def _beside(name: str, below: Scene, above: Scene, model: str) -> str:
    counts = [unstable_count(characteristic(one, model)) for one in (below, above)]
    return "" if counts[0] == 0 and counts[1] > 0 else f"{name}: {counts[0]} and {counts[1]} grow on its sides"


def _run(scene: Scene, model: str, found: Any) -> str:
    """Whether a small nudge does what the roots say; "none" if that cannot be seen within so many transits and seconds."""
    rate = found.rate * scene.transit
    slow = max((root.real for root in found.leading_roots if abs(root.imag) * scene.transit < 2.0), default=math.nan)
    seen = rate if rate > 0.0 else slow * scene.transit  # a smooth nudge hardly excites ripples that decay
    if not math.isfinite(seen) or seen == 0.0:
        return "none"
    end = 2.0 * ENDS + 3.0 / abs(seen) if seen < 0.0 else ENDS + 20.0 / seen
    if end > LONGEST:
        return "none"
    signal.signal(signal.SIGALRM, _give_up)
    signal.alarm(SECONDS)
    try:
        solver = build(model, replace(scene, start=Start(size=NUDGE)))
        history = HistoryObserver(scene.law, solver.nodes, 0.0, end)
        follow(solver, end, [history])
    except (TimeoutError, SceneError):
        return "none"
    except NumericsError as failure:
        return "agrees" if rate > 0.0 else f"stable, yet the run fails: {failure}"
    finally:
        signal.alarm(0)
    columns = history.columns()
    away = np.abs(columns["psi"] - scene.steady_psi)
    early, late = (away[(columns["time"] >= a * end) & (columns["time"] <= b * end)].max() for a, b in ((0.0, 0.6), (0.8, 1.0)))
    if (late < early) == (rate < 0.0) or max(late, early) < 1e-12:
        return "agrees"
    return f"rate {rate:.3g} a transit, but a nudge goes from {early:.3g} to {late:.3g} in {end:.4g} transits"


def _give_up(*_: object) -> None:
    raise TimeoutError


def main(count: int, first: int = 0, runs: bool = True) -> int:
    """Prints each disagreement and the sums; the number of disagreements. A model that cannot do a scene is replaced by one that
    can; an analysis that fails is told and counted as refused."""
    sums: Counter[str] = Counter(scenes=count)
    for number in range(first, first + count):
        scene, model, kind = scene_of(number)
        try:
            characteristic(scene, model)
        except SceneError:
            model = "delay"
        runs_here = runs and not (model == "delay" and kind in ("kelvin-voigt", "zener"))
        try:
            wrong, told = disagreements(scene, model, runs_here)
        except NumericsError as failure:
            wrong, told = [], "refused"
            print(f"{number} {kind} {model}: {failure}", flush=True)
        sums.update([told if told in ("agrees", "none", "refused") else "contradicts", *(["disagree"] if wrong else [])])
        for text in wrong:
            print(f"{number} {kind} {model}: {text}", flush=True)
    print(dict(sums))
    return sums["disagree"]


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) > 0)

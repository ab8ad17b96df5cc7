"""The measures that a sweep computes at each point; each is one function and one line of `MEASURES`."""

import os
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from numbers import Real
from typing import Any, NamedTuple, cast, get_args

import numpy as np
from numpy.typing import NDArray

import slipwave
from slipwave.errors import NumericsError, SceneError
from slipwave.input.wording import shorten
from slipwave.observe.verdict import Kind
from slipwave.packages import no_exit
from slipwave.scene import Scene
from validation.data.variables import Meaning
from validation.models.build import prepare
from validation.models.by_name import one_port_of
from validation.models.outlook import Length, UntilSettled, needed
from validation.models.run import Run, reconsidered, simulate

VERDICTS: tuple[str, ...] = get_args(Kind)
"""The words of a verdict, in the order of their numbers in files."""

REGIME_OF = {"steady": 0, "decaying": 0, "periodic": 1, "torus": 2, "irregular": 3, "growing": 4}
"""Verdict -> regime; points with other, undecided verdicts are not compared."""

TRANSITS = 4000.0
"""Length (transits) of the longest run of a scene without `run.until`."""

Options = Mapping[str, Any]
Figures = Mapping[str, float | str | bool | NDArray[np.float64] | None]

MOST_CYCLES = 64
"""Number of last cycles of a point that are stored one by one."""


class Measure(NamedTuple):
    """`of` computes the figures of a model on a scene with the options of the sweep; `columns`: their meanings; `words`: those
    that are words; `lists`: those with a number per cycle; `regime`: those that distinguish regimes. The columns of a user's own
    function are those it returns."""

    of: Callable[[Scene, str, Options], Figures]
    columns: Mapping[str, Meaning] = {}
    words: Mapping[str, tuple[str, ...]] = {}
    lists: tuple[str, ...] = ()
    regime: tuple[str, ...] = ()


def _march_point(scene: Scene, model: str, options: Options, whole: bool = False) -> Run:
    """The run of a point: until its verdict is certain, at most to `run.until`, or, if `whole`, to that. Raises SceneError for a
    scene that the model cannot compute, NumericsError where it fails."""
    solver = prepare(model, scene, tolerance=options.get("tol"), cells=options.get("cells")).solver
    one_port = one_port_of(solver.model)
    until = scene.until if scene.until is not None else TRANSITS
    length = Length(until=until) if whole else UntilSettled(scene, one_port, until=until)
    run = reconsidered(simulate(solver, length), one_port)
    if run.failed:
        raise NumericsError(run.failed)
    return run


def _figures(run: Run) -> dict[str, Any]:
    verdict = run.verdict
    means = run.statistics.values() if verdict and verdict.repeats else {}
    counts = {"multiplicity": verdict.multiplicity, "cycles": verdict.cycles} if verdict else {}
    longer = needed(verdict, run.solver.scene, one_port_of(run.solver.model))
    return {"verdict": run.kind, **counts, **means, "until": run.until, "needed": longer}


def _verdict_of(scene: Scene, model: str, options: Options) -> Figures:
    """The verdict on the motion and the means of its cycles, of a run until the verdict is certain."""
    return _figures(_march_point(scene, model, options))


def _run_of(scene: Scene, model: str, options: Options) -> Figures:
    """As `_verdict_of` for the whole run, and the interface at its end."""
    run = _march_point(scene, model, options, whole=True)
    return _figures(run) | ({f"final_{name}": getattr(run.final, name) for name in _ENDS} if run.final else {})


def _cycles_of(scene: Scene, model: str, options: Options) -> Figures:
    """As `_verdict_of` for the whole run, and every cycle of its second half, for a brush diagram."""
    run = _march_point(scene, model, options, whole=True)
    late = run.events.time >= 0.5 * run.until
    figures = {"cycle_period": run.events.period[late], "cycle_stress_drop": run.events.stress_drop[late]}
    return _figures(run) | {name: values[-MOST_CYCLES:] for name, values in figures.items()}


def _orbit_of(scene: Scene, model: str, options: Options) -> Figures:
    """The periodic orbit, stable or not."""
    given = {name: options[name] for name in ("tol", "cells") if options.get(name) is not None}
    orbit = slipwave.orbit(scene, model, **given).scene_orbit.periodic  # its summary may need another orbit
    outside = int((np.abs(orbit.multipliers.values) > 1.0 + 1e-6).sum())
    return orbit.orbit.values() | {"stable": orbit.multipliers.stable, "unstable_multipliers": outside}


def _stability_of(scene: Scene, model: str, options: Options) -> Figures:
    """Whether steady sliding is stable, and its leading root."""
    stability = slipwave.stability(scene, model).summary
    leading = stability["leading_roots"][0] if stability["leading_roots"] else (None, None)
    counted = {name: stability[name] for name in ("stable", "unstable_roots", "log10_r_c", "epsilon_c")}
    return counted | {"growth_rate": leading[0], "angular_frequency": leading[1]}


def _lyapunov_of(scene: Scene, model: str, options: Options) -> Figures:
    """The largest Lyapunov exponent, with the verdict; the verdict alone of a motion without one, as a transient."""
    given = {name: options[name] for name in ("tol", "cells") if options.get(name) is not None}
    try:
        result = slipwave.run(scene, model, lyapunov=True, **given)
    except NumericsError as error:
        result = error.result
        if result is None or result.done.failed or result.done.verdict is None or result.done.verdict.repeats:
            raise
    exponent = result.exponent
    return _figures(result.done) | ({"exponent": exponent.rate, "exponent_error": exponent.margin} if exponent else {})


_CYCLE = {
    "period": Meaning("mean period of the cycles", "transit"),
    "stress_drop": Meaning("mean stress drop of the cycles", "normal stress"),
    "elastic_stress_drop": Meaning("mean elastic stress drop of the cycles", "normal stress"),
    "v_max": Meaning("largest slip rate of the cycles", "V*"),
    "v_min": Meaning("smallest slip rate of the cycles", "V*"),
}
_VERDICT = {
    "verdict": Meaning("verdict on the motion"),
    "multiplicity": Meaning("slip events in a period"),
    "cycles": Meaning("cycles in the second half of the run"),
    **_CYCLE,
    "until": Meaning("length of the run", "transit"),
    "needed": Meaning("length of a run with enough cycles, where this one is too short", "transit"),
}
_CYCLES = {
    "cycle_period": Meaning("period of each cycle of the second half of the run", "transit"),
    "cycle_stress_drop": Meaning("stress drop of each cycle of the second half of the run", "normal stress"),
}
_ENDS = {"ln_v": "", "psi": "", "mu": "", "v": "V*"}
_FINAL = {f"final_{name}": Meaning(f"{name} at the end of the run", unit) for name, unit in _ENDS.items()}
_EXPONENT = {
    "exponent": Meaning("largest Lyapunov exponent", "1/transit"),
    "exponent_error": Meaning("half its 95 % interval", "1/transit"),
}
_STABILITY = {
    "stable": Meaning("whether steady sliding is stable"),
    "unstable_roots": Meaning("number of roots of growing disturbances"),
    "log10_r_c": Meaning("log10 of the critical round trip"),
    "epsilon_c": Meaning("critical epsilon"),
    "growth_rate": Meaning("growth rate of the leading root", "V*/L"),
    "angular_frequency": Meaning("angular frequency of the leading root", "V*/L"),
}
_ORBIT = {**_CYCLE, "stable": Meaning("whether the orbit is stable")}
_ORBIT["unstable_multipliers"] = Meaning("number of multipliers outside the unit circle")
_KINDS, _YES_NO = {"verdict": VERDICTS}, {"stable": ("no", "yes")}
_REGIME = ("verdict", "multiplicity")

MEASURES: Mapping[str, Measure] = {
    "verdict": Measure(_verdict_of, _VERDICT, _KINDS, regime=_REGIME),
    "run": Measure(_run_of, {**_VERDICT, **_FINAL}, _KINDS, regime=_REGIME),
    "cycles": Measure(_cycles_of, {**_VERDICT, **_CYCLES}, _KINDS, tuple(_CYCLES), _REGIME),
    "orbit": Measure(_orbit_of, _ORBIT, _YES_NO, regime=("stable", "unstable_multipliers")),
    "stability": Measure(_stability_of, _STABILITY, _YES_NO, regime=("stable", "unstable_roots")),
    "lyapunov": Measure(_lyapunov_of, {**_VERDICT, **_EXPONENT}, _KINDS, regime=_REGIME),
}


def decided_regimes(verdict: Any) -> Any:
    """Convert the numbers of verdicts to numbers of regimes, -1 if undecided. Steady sliding and the return to it are one
    regime."""
    numbers = np.array([REGIME_OF.get(word, -1) for word in VERDICTS] + [-1])
    return numbers[np.asarray(verdict, dtype=int)]


def measure_of(name: str) -> Measure:
    """The measure called `name`; "module:function" is a user's own function of a scene that returns numbers by name; a number
    `regime`, if returned, distinguishes regimes. Nothing is imported before a point is computed."""
    return MEASURES.get(name) or Measure(
        lambda scene, model, options: _numbers(name, own_measure(name)(scene)), regime=("regime",)
    )


def _numbers(name: str, figures: Any) -> Figures:
    """The `figures` of a user's measure. Raises NumericsError unless they are numbers by name: nothing else can be stored."""
    label = f"--measure = {name!r}"
    if not isinstance(figures, Mapping):
        raise NumericsError(f"{label}: returns {shorten(figures)}; must return numbers by name, as {{'x': 1.0}}")
    for key, value in figures.items():
        if not isinstance(key, str) or key in ("status", "reason"):
            raise NumericsError(f"{label}: returns a number called {shorten(key)}; its name must be another text")
        if not (value is None or isinstance(value, Real | np.bool_)):
            raise NumericsError(f"{label}: returns {key} = {shorten(value)}; must return numbers by name, as {{'x': 1.0}}")
    return dict(figures)


def own_measure(name: str) -> Callable[[Scene], Figures]:
    """The user's function "module:function", which is imported, also from the working folder. Raises SceneError if it cannot
    be."""
    if os.getcwd() not in sys.path:  # that of the console script begins with its own folder
        sys.path.append(os.getcwd())
    label, (module, _, function) = f"--measure = {name!r}", name.partition(":")
    try:
        with no_exit(label):
            own = getattr(import_module(module), function)
    except SceneError:
        raise
    except Exception as error:
        must = f"must be one of {', '.join(MEASURES)}, or an importable module:function"
        raise SceneError(f"{label}: {must} ({type(error).__name__}: {error})") from error
    if not callable(own):
        raise SceneError(f"{label}: {function} is no function")
    return cast(Callable[[Scene], Figures], own)


def measure_name(measure: str | Callable[[Scene], Figures]) -> str:
    """The name of a measure, by which another process finds it. Raises SceneError for a function inside another one."""
    if isinstance(measure, str):
        return measure
    if "<" in measure.__qualname__ or measure.__module__ == "__main__":
        raise SceneError(
            f"measure = {measure.__qualname__}: must be a function of a module that other processes can import, not of the main "
            "part of a script or of another function"
        )
    return f"{measure.__module__}:{measure.__qualname__}"

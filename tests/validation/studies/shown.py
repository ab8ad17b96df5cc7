"""A study's quick run, as the tests hold it: its progress, the scenes that it read, that each of its figures can be drawn; and
every study again, with the figures of one model displaced at the place where the study gets them: a verdict must fail.

Calls of a place are recorded in the study's quick run and played back, so that a counterfeit run costs verdicts and tables only.
A verdict that compares a thing with itself, or looks elsewhere, stays green and is found.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import pytest

from slipwave.input import assemble
from slipwave.observe.statistics import Estimate
from validation.chart.draw import draw, styled
from validation.measure.orders import ALMOST
from validation.measure.regimes import UNTRIED
from validation.models import stopwatch
from validation.report import Budget, Evidence, Outcome, Verdict
from validation.report.names import by_claim
from validation.report.registered import study_called
from validation.report.sources import sources_of

Change = Callable[[Any], Any]


def scaled(value, by=1e-3):
    """Every number in `value` larger by a share; a truth turned round, words taken away."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return ""
    if isinstance(value, float | complex | np.ndarray):
        return value * (1.0 + by)
    if isinstance(value, Estimate):
        return replace(value, value=value.value * (1.0 + by))
    if isinstance(value, dict):
        return {key: scaled(one, by) for key, one in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*(scaled(one, by) for one in value))
    if isinstance(value, list | tuple):
        return type(value)(scaled(one, by) for one in value)
    if is_dataclass(value) and not isinstance(value, type):
        kept = {one.name: getattr(value, one.name) for one in fields(value) if one.init}
        return replace(value, **{name: scaled(one, by) for name, one in kept.items() if isinstance(one, float | Estimate)})
    return value


def part(*names, change=scaled):
    """`change` of some fields only, of a NamedTuple or dataclass; "a.b" is the field b of the field a."""

    def changed(value):
        """`value` with these fields changed."""
        for name in names:
            first, _, rest = name.partition(".")
            new = (part(rest, change=change) if rest else change)(getattr(value, first))
            value = value._replace(**{first: new}) if hasattr(value, "_fields") else replace(value, **{first: new})
        return value

    return changed


def displaced(by):
    """Every number larger by an amount: what is wrong in the limit of a fine grid does not fall."""

    def changed(value):
        """`value` displaced."""
        return {key: changed(one) for key, one in value.items()} if isinstance(value, dict) else value + by

    return changed


def each(change):
    return lambda value: (
        {k: change(one) for k, one in value.items()} if isinstance(value, dict) else [change(one) for one in value]
    )


def first(change):
    return lambda found: (change(found[0]), *found[1:])


def only(name, change):
    return lambda value: value | {name: change(value[name])}


def beating(values):
    """Values that nearly repeat after two of them."""
    return values + 20.0 * np.mean(values) * (-1.0) ** np.arange(values.size)


class Place(NamedTuple):
    """`where`, "module:function" within the studies, is the place at which a study gets figures of a model: the argument number
    `model` names it (or the attribute `model` of that argument). `fakes` are changes of its results, each of which must turn the
    study red for every model but those `unjudged`; `few` tries the first and the last. Without fakes it is only played back.
    `claimed`: only claims of a paper rest on it, of which one must become a finding."""

    where: str
    fakes: tuple[Change, ...] = ()
    model: int = 0
    unjudged: tuple[str, ...] = ()
    few: bool = False
    claimed: bool = False


@dataclass
class Tape:
    """Calls of one place: arguments and results in turn."""

    place: Place
    calls: list[tuple[str, Any]] = field(default_factory=list)

    def record(self, patch):
        """From now on keep what the place returns."""
        true = self._true

        def recording(*args, **options):
            result = true(*args, **options)
            self.calls.append((self._model(args), result))
            return result

        patch.setattr(*self._home, recording)

    def play(self, patch, model="", change=lambda value: value):
        """Return the same again, changed for one model."""
        results = iter([change(result) if name == model else result for name, result in self.calls])
        patch.setattr(*self._home, lambda *args, **options: next(results))

    @property
    def _home(self):
        module, _, name = self.place.where.partition(":")
        return import_module(f"validation.studies.{module}"), name

    @property
    def _true(self):
        true = getattr(*self._home)
        return true

    def _model(self, args):
        who = args[self.place.model] if len(args) > self.place.model else ""
        who = getattr(who, "setting", who)
        return str(getattr(who, "model", getattr(who, "name", who)))


def tapes_of(name):
    return [Tape(place) for place in PLACES[name]]


def green(study, tapes):
    """The counterfeits that no verdict of the study notices; played back unchanged, none may fail, and each place is called."""

    def judged(fake=None, model="", change=lambda value: value):
        with pytest.MonkeyPatch.context() as patch:
            for tape in tapes:
                tape.play(patch, *((model, change) if tape is fake else ()))
            return [verdict.outcome for verdict in study.run(Budget(quick=True)).verdicts]

    assert [tape.place.where for tape in tapes if not tape.calls] == []
    true = judged() if tapes else []
    assert Outcome.FAIL not in true, f"{study.NAME}: played back, its verdicts differ"
    for tape in tapes:
        models = list(dict.fromkeys(name for name, _ in tape.calls if name not in tape.place.unjudged))
        for model in models[:: max(1, len(models) - 1)] if tape.place.few else models:
            for number, change in enumerate(tape.place.fakes):
                found = judged(tape, model, change)
                if not (
                    found.count(Outcome.FINDING) > true.count(Outcome.FINDING) if tape.place.claimed else Outcome.FAIL in found
                ):
                    yield f"{study.NAME}: {tape.place.where} of {model!r}, change {number}"


S, DISPLACED = (scaled,), part("words", "figures", change=lambda value: scaled(value, 3e-2))
PLACES = {
    "one-cycle": (Place("one_cycle:_run_model", (first(scaled),)),),
    "orders": (
        Place("orders:climb_of", (part("errors", change=displaced(1e-3)),), few=True),
        Place("orders:_leapfrog_at", (part("errors", change=displaced(1e-3)),)),
        Place("orders:_jump_errors", (displaced(0.1),)),
        Place("orders:_shared", (lambda common: ("one", *common),), unjudged=("fd", "sbp", "fem")),
        Place("orders:_figures", (only("period", scaled), only("stress_drop", scaled))),
        Place("orders:_means_of", (first(lambda means: scaled(means, 0.04)),)),  # four standard errors are up to 3 %
        Place("orders:_march_errors", (lambda both: (1e-3 + both[0], both[1]), lambda both: (both[0], 1e-3 + both[1]))),
        Place("orders:error_of_motion", (lambda error: 100.0 * error,), few=True),
        Place("orders:_recorded_event", (lambda event: (event[0], scaled(event[1]), *event[2:]),)),
    ),
    "stability-attacks": (
        Place("stability_attacks:limit_at", (lambda share: 0.9 * share,)),
        Place("stability_attacks:around_the_limit", (lambda pair: (1e3, pair[1]), lambda pair: (pair[0], 1.0))),
        Place("stability_attacks:state_reach", (lambda reach: 0.9 * reach,), unjudged=("fd",)),
        Place("stability_attacks:stops_beyond", (scaled,)),
        Place("stability_attacks:_attack", (each(lambda one: replace(one, error=0.02 + one.error, message="")),)),
        Place("stability_attacks:advised", (lambda found: (found[0], found[1] + 0.02),)),
        Place("stability_attacks:locked_noise", (lambda left: 1.1 + left,)),
    ),
    "onset": (
        Place("onset:boundary", (each(part("second")),), 1),
        Place("onset:critical_round_trip", S, 1),
        Place("onset:_gaps_at", (displaced(6e-14),)),
        Place("onset:_counts_across"),
        Place("onset:_taylor"),
        Place("onset:analyse", (part("log10_r_c"),), unjudged=("paper",), few=True),
    ),
    "energy": (Place("energy:_balance", (first(only("residual", displaced(1e-6))),)),),
    "reflection": (
        Place("reflection:state_at", S, 2),
        Place("reflection:_face_onset"),
        Place("reflection:motion_at", (DISPLACED,)),
        Place("reflection:branch_points", (each(part("log10_r")),)),
        Place("reflection:relative_costs"),
    ),
    "which-model": (
        Place("which_model:_costs_at"),
        Place("which_model:onset"),
        Place("which_model:regime_at", (DISPLACED,)),
        Place("which_model.judged:regime_at", (DISPLACED,)),
        Place("which_model.periods:branches_of"),
        Place("which_model.periods:_periods_at", S, unjudged=("kelvin-voigt",)),  # known at an r of the full report
        Place("which_model.laws:measure_onsets", (each(part("error")),)),
        Place("which_model.laws:measure_cycle"),
        Place(
            "which_model:regime_in",
            (lambda value: value if value.words == UNTRIED else DISPLACED(value),),
            unjudged=("modal:2", "modal:1", "kelvin-voigt", "block8", "block12", "quasistatic"),
        ),
    ),
    "cost-and-error": (Place("cost_and_error:_cycle_at", S), Place("cost_and_error:_times_of")),
    "regime-map": (
        Place("regime_map:_swept_plane"),
        Place("regime_map:_mapped"),
        Place("regime_map:_critical_round_trips", (displaced(0.06), displaced(-0.06))),
        Place("regime_map:_model_regimes", (lambda found: np.roll(found, 4, axis=0),)),
    ),
    "asymmetry": (
        Place("asymmetry:state_at", S, 2),
        Place("asymmetry:_period_as_two", S),
        Place("asymmetry:motion_at", (DISPLACED,)),
        Place("asymmetry:first_point", (part("log10_r"),)),
        Place("asymmetry:relative_costs"),
    ),
    "bifurcation": (
        Place("bifurcation:branch_of", (part("onset.parameter"),)),
        Place("bifurcation:_wave_orbit", (first(scaled),)),
        Place("bifurcation:doubled", (part("last_two"), part("single.orbit"), part("double.orbit"))),
        Place("bifurcation:bubble", (lambda found: (found[0], found[1] + 3e-5, found[2]),)),
        Place("bifurcation:_folds_over_drive", (each(lambda fold: (fold[0] + 1e-6, fold[1])),)),
        Place("bifurcation:_fold_at", S),
    ),
    "snaking": (
        Place("snaking:branch_of"),
        Place("snaking:_run_at", (part("last", change=displaced(2.0)),)),
        Place("snaking:sides", (lambda value: [(*value[0][:2], scaled(value[0][2])), *value[1:]],)),
        Place("snaking:_torus_at", (lambda found: (found[0] + 1e-3, found[1]), lambda found: (found[0], scaled(found[1])))),
    ),
    "laboratory": (
        Place("laboratory:_cycles_of_samples", (lambda found: [None] * len(found),), 9, claimed=True),
        Place("laboratory:_cycle_without_tuning", (lambda one: one and scaled(one, 0.01), lambda one: None), few=True),
        Place("laboratory:_waves_in_blocks", (only("block", only("period", lambda one: 1.1 * one)),)),
        Place("laboratory:_rise_of", (lambda one: (one[0], 1.1 * one[1]),)),
        Place("laboratory:_fitted_to", (lambda one: (2e-8 + one[0], one[1]), lambda one: (one[0], scaled(one[1])))),
    ),
    "claims": (
        Place("claims:_settled_at", tuple(only(model, scaled) for model in ("delay", "kelvin-voigt", "block8", "block12")), 9),
        Place("claims:_run_deep", (first(part("stress_drop", change=beating)),), claimed=True),
        Place("claims:_measure_ripples", tuple(only(name, scaled) for name in ("ripple", "drop", "slipped"))),
    ),
}
"""By study: those whose quick run a test holds (`shown.quick`)."""


ROOMY, ROUNDING = 30.0, 1e-10
"""A limit of more than this many times the measured size lets faults pass. Below `ROUNDING` machines may differ by more."""


def too_roomy(verdicts):
    """Claims whose limit lies more than `ROOMY` times above what was measured in the worst of its cases, and above rounding."""
    limited = [v for v in by_claim("", verdicts) if v.found is not None and v.limit is not None and not none_is_nearer(v)]
    roomy = [v for v in limited if v.limit > max(ROOMY * v.found, ROUNDING)]
    return [f"{v.claim}: {v.ours} ({v.remark}), {v.expected}" for v in roomy]


def none_is_nearer(verdict):
    """Whether the limit is that none of so many is missed, half of the last digit that a paper prints, or what an order of
    convergence or a mean may be off by, which chance can put on the declared one or on the truth."""
    power = math.log10(2.0 * verdict.limit) if verdict.limit else 0.5
    printed = verdict.evidence is Evidence.PAPER and abs(power - round(power)) < 1e-9
    of_order = verdict.limit is not None and verdict.limit >= ALMOST and "order" in verdict.claim
    of_mean = "standard errors" in verdict.expected
    return printed or of_order or of_mean or (verdict.found, verdict.limit) == (0.0, 1.0)


def quick(name):
    """A study's quick run by a clock of its own: the n-th reading is n^2 ms, so that run times are the same on every machine.

    The shares of its work that it reports on the way must rise to 1 at most, its figures must draw, and a verdict must fail for
    every counterfeit of `counterfeit.PLACES`.
    """
    shares, scenes, study, tapes = list[float](), set[str](), study_called(name), tapes_of(name)
    with pytest.MonkeyPatch.context() as patch:
        readings = itertools.count()
        patch.setattr(stopwatch, "processor_seconds", lambda: 1e-3 * next(readings) ** 2)
        patch.setattr(assemble, "load_tables", watched(assemble.load_tables, scenes))
        for tape in tapes:
            tape.record(patch)
        result = study.run(Budget(quick=True, report=shares.append))
    assert all(before < after for before, after in itertools.pairwise([0.0, *shares, 1.0 + 1e-9])), shares
    assert scenes <= {path.stem for path in sources_of(study) if path.suffix == ".toml"}
    with styled():
        for figure in result.figures:
            panels = draw(figure.draw()).axes
            curves = [np.asarray(line.get_ydata(), dtype=float) for panel in panels for line in panel.get_lines()]
            assert any(panel.get_xlabel() or panel.texts for panel in panels), figure.name
            assert all(np.isfinite(curve).any() for curve in curves if curve.size), figure.name
    stays = list(green(study, tapes))
    assert stays == [], stays
    return result


def watched(read, scenes):
    """`read` (`slipwave.input.assemble.load_tables`), which notes the gallery scenes it is asked for in `scenes`."""

    def reading(name, *rest):
        scenes.update({str(name)} & set(assemble.gallery_names()))
        return read(name, *rest)

    return reading


def outcomes(found):
    return " ".join(verdict.outcome.value for verdict in ([found] if isinstance(found, Verdict) else found))


def judged(found, expected):
    """Whether verdicts are as expected: their outcomes in words, or how many fail."""
    return (outcomes(found).split().count("fail") if isinstance(expected, int) else outcomes(found)) == expected

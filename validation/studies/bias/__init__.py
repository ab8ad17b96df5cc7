"""Bias of fitted a, b and L by neglecting waves, or a machine's mass, and whether the fits' own intervals cover it."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from validation.fit.synthetic import NOISE
from validation.studies.bias.atlas import ALLOWED, Atlas
from validation.studies.bias.drawn import ATLAS, draw_atlas, table_of_coverage, table_of_rules, table_of_slips
from validation.studies.bias.measured import (
    COVERED_RECORD,
    MODELS,
    QUANTITIES,
    RECORD,
    AtlasPoint,
    all_biases,
    biases_of,
    intervals_held,
    recorded_coverage,
    scene_of_point,
    seen_record,
    stand_in,
)
from validation.study import EXACT, SELF, WITNESS, Budget, Figure, Number, Omission, StudyResult, Verdict, claim, holding

NAME = "bias"
QUESTION = "What does leaving the waves out do to the a, b and L that are fitted?"
SCENES: tuple[str, ...] = ()
FILES = (RECORD, COVERED_RECORD)
SECONDS = (5.0, 9.0)

_SAME = 2e-3  # between two computations of an error: least squares stop at relative changes of 1e-10, marches at 1e-8
_LEAST, _MOST = 0.91, 0.995
_CORNER, _WAVE, _WAVE_SAME = AtlasPoint(0.6, 5.0, None), "dg:5", 2e-2
_OWN, _OWN_MODEL, _OWN_SAME = AtlasPoint(0.24, 0.8, None), "quasidynamic", 0.02
_BETWEEN = ((0.9, 1.3, None), (0.9, 3.0, 3.0))  # of the rule's limit; kappa; mass: no points of the atlas
_PART = {"quick": 3, "full": 8}  # fits whose intervals are computed anew


def run(budget: Budget) -> StudyResult:
    """Read the stored fits, repeat a part of them, and test the rule where it was not derived."""
    if not RECORD.is_file():
        return StudyResult(
            "Not answered in this report.", omissions=(Omission("The stored fits.", "No record of them is here."),)
        )
    atlas, covered = Atlas.read(), recorded_coverage()
    verdicts = [*_anew(atlas, budget.quick)]
    budget.report(0.6)
    verdicts += [_intervals(atlas), *_slips(atlas), _by_full_wave(), *_covered(covered, budget.quick)]
    rules = {model: atlas.rule(model) for model in MODELS}
    slips = [f"{100.0 * atlas.slip_error('quasidynamic', quantity):.2g} %" for quantity in ("L", "k")]
    return StudyResult(
        answer="A quasi-dynamic fit of velocity steps errs by less than 1 % in a, b and L if the slowest free swing of sample "
        f"and machine takes less than {rules['quasidynamic']:.2g} of the time of slip by L; without radiation damping the limit "
        f"is {rules['quasistatic']:.2g}. Stick-slip gives it the stiffness (median error {slips[1]}), but not L ({slips[0]}).",
        tables=(table_of_rules(atlas), table_of_slips(atlas), table_of_coverage(covered)),
        figures=(Figure("atlas", ATLAS, lambda: draw_atlas(atlas)),),
        verdicts=tuple(verdicts),
        numbers={f"{model} swing with 1 %": Number(limit, 1e-3) for model, limit in rules.items()},
        notes=(
            f"{atlas.fits} fits by `slipwave sweep`, kept in `{RECORD.name}` (digest {atlas.digest}); "
            "`python -m validation.studies.bias.measured FOLDER` computes them again, in 5 minutes of processor time.",
        ),
    )


def _anew(atlas: Atlas, quick: bool) -> tuple[Verdict, ...]:
    """One stored point computed again, and the rule at points between those from which it was derived."""
    number = atlas.middle
    again, stored = all_biases(scene_of_point(atlas.points[number])), atlas.row(number)
    apart = max(abs(again[name] - stored[name]) for name in again if " error " in name) if atlas.is_own else math.inf
    limit = atlas.rule("quasidynamic")
    chosen = [AtlasPoint(share * limit, kappa, mass) for share, kappa, mass in _BETWEEN[: 1 if quick else 2]]
    worst = max(abs(one[f"error {q}"]) for one in map(_quasidynamic_errors, chosen) for q in ("a", "b", "L"))
    spread = max(atlas.limits("quasidynamic").max() / limit, 1.0)
    return (
        holding(
            "The stored fits are those of this program",
            SELF,
            f"scenes and measure the same, and at one point all errors within {_SAME:g}",
            f"within {apart:.1g}",
            apart < _SAME,
        ).with_margin(apart, _SAME),
        claim(
            "Below the rule's limit the quasi-dynamic fit errs by less than 1 %",
            EXACT,
            worst,
            ALLOWED,
            f"between the atlas' points, at 0.9 of the limit; at other points of the atlas the limit is up to {spread:.2g} times "
            "as large",
        ),
    )


def _quasidynamic_errors(point: AtlasPoint) -> dict[str, float]:
    scene = scene_of_point(point)
    return biases_of(scene, seen_record(scene), "quasidynamic")


def _intervals(atlas: Atlas) -> Verdict:
    """Verdict: intervals do not cover the model's error."""
    excluded = sum(int(atlas.excluded(model, steps).sum()) for model in MODELS for steps in (True, False))
    title, expected = (
        "Some fits' own intervals exclude the truth",
        "more than none: an interval knows nothing of the model's error",
    )
    remark = f"95 % intervals of a, b, L for noise {NOISE:g}"
    return holding(title, EXACT, expected, f"{excluded} of {atlas.fits}", excluded > 0, remark)


def own_errors() -> dict[str, float]:
    """Errors of a model's fit to its own stick-slip, of slabs as at one point of the atlas."""
    scene = stand_in(scene_of_point(_OWN))
    return biases_of(scene, seen_record(scene, _OWN_MODEL), _OWN_MODEL)


def _slips(atlas: Atlas) -> Iterator[Verdict]:
    """Stick-slip: fits to a model's own data recover its parameters, fits to data of the delay system do not."""
    own = max(abs(error) for name, error in own_errors().items() if name.startswith("error"))
    title = "A model's own stick-slip gives back a, b, L and stiffness"
    yield claim(title, EXACT, own, _OWN_SAME, f"{_OWN_MODEL}; with noise {NOISE:g}, so that errors are those of other fits")
    least = min(atlas.slip_error(model, "L") for model in MODELS if np.isfinite(atlas.of(model, "error", "L", False)).any())
    most = max(atlas.slip_error(model, "k") for model in MODELS if np.isfinite(atlas.of(model, "error", "L", False)).any())
    yield holding(
        "Stick-slip of slabs with waves gives the stiffness, but not L, to any fit without them",
        EXACT,
        "medians: of L more than 10 %, of the stiffness less than 2 %",
        f"{100.0 * least:.2g} % or more, {100.0 * most:.2g} % or less",
        least > 0.1 and most < 0.02,
    )


def corner_errors(model: str) -> dict[str, float]:
    """Errors of the quasi-dynamic fit to data of `model` in one corner of the atlas."""
    scene = scene_of_point(_CORNER)
    return biases_of(scene, seen_record(scene, model), "quasidynamic")


def _by_full_wave() -> Verdict:
    """One corner with data of a full wave instead of the delay system."""
    ours, theirs = corner_errors("delay"), corner_errors(_WAVE)
    apart = max(abs(ours[f"error {q}"] - theirs[f"error {q}"]) for q in QUANTITIES)
    remark = f"{_WAVE}, swing {_CORNER.swing:g}, k/k_{{c}} {_CORNER.kappa:g}"
    return claim("A full wave gives the same errors as the delay system", WITNESS, apart, _WAVE_SAME, remark)


def _covered(covered: Mapping[str, Sequence[Sequence[bool]]], quick: bool) -> Iterator[Verdict]:
    for model, rows in covered.items():
        shares = np.mean(rows, axis=0)
        part = _PART["quick" if quick else "full"] if model == "quasidynamic" else 0
        same = intervals_held(model, range(part)) == rows[:part]
        yield holding(
            "95 % intervals hold the truth in 91 to 99.5 % of fits",
            EXACT,
            f"each of a, b, L in {100 * _LEAST:g} to {100 * _MOST:g} %",
            ", ".join(f"{100 * share:.1f} %" for share in shares),
            bool(same and (shares >= _LEAST).all() and (shares <= _MOST).all()),
            f"{model} as truth and as fit, {len(rows)} fits with noise {NOISE:g}",
        ).with_margin(float(np.abs(shares - 0.5 * (_LEAST + _MOST)).max()), 0.5 * (_MOST - _LEAST))

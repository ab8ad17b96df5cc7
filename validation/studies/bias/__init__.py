"""What leaving waves out does to a, b and L fitted to velocity steps, and whether the fits' own intervals say so."""

import math
from typing import Any

import numpy as np

from slipwave.observe.pieces import Array
from validation.fit.synthetic import NOISE, stepped_problem, stepped_scene, true_friction
from validation.studies.bias.measured import (
    COVERED,
    MODELS,
    QUANTITIES,
    RECORD,
    all_biases,
    biases_of,
    grid_digest,
    intervals_held,
    recorded,
)
from validation.study import (
    EXACT,
    SELF,
    WITNESS,
    Budget,
    Figure,
    Number,
    Omission,
    StudyResult,
    Table,
    Verdict,
    claim,
    holding,
    table,
)
from validation.study.drawing import Drawing, canvas, pen, styled

NAME = "bias"
QUESTION = "What does leaving the waves out do to the a, b and L that are fitted?"
SCENES: tuple[str, ...] = ()
FILES = (RECORD,)
SECONDS = (6.0, 20.0)

ALLOWED = 0.01
_SAME = 2e-3  # between two computations of an error: least squares stop at relative changes of 1e-10, marches at 1e-8
_LEAST, _MOST = 0.91, 0.995
_CORNER, _WAVE = (0.3, 5.0), "dg:5"
_WAVE_SAME = 2e-2
_PART = {"quick": 3, "full": 8}  # fits of each model whose intervals are computed anew


def run(budget: Budget) -> StudyResult:
    """Read the stored fits, compute a part of them anew, and judge the rule where it was not made."""
    if not RECORD.is_file():
        return StudyResult(
            "Not answered in this report.", omissions=(Omission("The stored fits.", "No record of them is here."),)
        )
    record = recorded()
    atlas = Atlas(record)
    rules = {model: atlas.rule(model) for model in MODELS}
    anew = _anew(atlas, rules, budget.quick)
    budget.report(0.6)
    usual = rules["quasidynamic"]
    return StudyResult(
        answer="A quasi-dynamic fit of velocity steps errs by less than 1 % in a, b and L if a wave's round trip takes less "
        f"than {usual:.2g} of the time of slip by L; without radiation damping the limit is {rules['quasistatic']:.2g}.",
        tables=(_rules(atlas, rules), _coverage(record)),
        figures=(Figure("atlas", _ATLAS, lambda: _draw(atlas)),),
        verdicts=(*anew, _witness(), *_covered(record, budget.quick)),
        numbers={f"{model} share with 1 %": Number(share, 1e-3) for model, share in rules.items()},
        notes=(f"{atlas.fits} fits, kept in `{RECORD.name}`; `python -m validation.studies.bias.measured` computes them again.",),
    )


class Atlas:
    """The stored fits over `shares` and `kappas`."""

    def __init__(self, record: dict[str, Any]) -> None:
        points = np.array(record["points"])
        self.shares, self.kappas = np.unique(points[:, 0]), np.unique(points[:, 1])
        self._rows, self.digest = record["rows"], record["digest"]
        self.fits = len(self._rows) * len(MODELS)

    def of(self, model: str, kind: str, quantity: str) -> Array:
        """Relative errors, or half widths of intervals (shares, kappas)."""
        values = [row[f"{model} {kind} {quantity}"] for row in self._rows]
        return np.array(values, dtype=float).reshape(self.shares.size, self.kappas.size)

    def worst(self, model: str) -> Array:
        """The largest error of a, b and L (shares, kappas); infinite where there was no minimum."""
        errors = np.abs([self.of(model, "error", quantity) for quantity in ("a", "b", "L")])
        return np.asarray(np.where(np.isfinite(errors), errors, np.inf).max(axis=0))

    def excluded(self, model: str) -> "np.ndarray[tuple[int, ...], np.dtype[np.bool_]]":
        """Where the interval of a, b or L does not hold the truth."""
        outside = [np.abs(self.of(model, "error", q)) > self.of(model, "half", q) for q in ("a", "b", "L")]
        return np.asarray(np.any(outside, axis=0))

    def rule(self, model: str) -> float:
        """The largest share up to which no error is larger than allowed, whatever kappa."""
        good = np.flatnonzero(self.worst(model).max(axis=1) >= ALLOWED)
        first = int(good[0]) if good.size else self.shares.size
        return float(self.shares[first - 1]) if first else 0.0


def _anew(atlas: Atlas, rules: dict[str, float], quick: bool) -> tuple[Verdict, ...]:
    """The rule at places between those that it was made of, and one stored place computed again."""
    row, column = atlas.shares.size // 2, atlas.kappas.size // 2
    place = float(atlas.shares[row]), float(atlas.kappas[column])
    usual = rules["quasidynamic"]
    between = [(0.9 * usual, 2.0), (0.95 * usual, 9.0)][: 1 if quick else 2]
    again, *held = (all_biases(stepped_scene(*one)) for one in (place, *between))
    pairs = [(again[f"{m} error {q}"], float(atlas.of(m, "error", q)[row, column])) for m in MODELS for q in QUANTITIES]
    apart = max(abs(new - old) for new, old in pairs) if atlas.digest == grid_digest() else math.inf
    worst = max(abs(one[f"quasidynamic error {q}"]) for one in held for q in ("a", "b", "L"))
    excluded = sum(int(atlas.excluded(model).sum()) for model in MODELS)
    return (
        holding(
            "The stored fits are those of this program",
            SELF,
            f"scenes and seeds the same, and at share {place[0]:.3g} all errors within {_SAME:g}",
            f"within {apart:.1g}",
            apart < _SAME,
        ),
        claim(
            "Below the rule's share the quasi-dynamic fit errs by less than 1 %",
            EXACT,
            worst,
            ALLOWED,
            "between the grid's places",
        ),
        holding(
            "Some fits' own intervals exclude the truth",
            EXACT,
            "more than none: an interval knows nothing of the model's error",
            f"{excluded} of {atlas.fits}",
            excluded > 0,
            f"95 % intervals of a, b, L for noise {NOISE:g}",
        ),
    )


def corner_errors(model: str) -> dict[str, float]:
    """Errors of the quasi-dynamic fit of what `model` shows in one corner of the atlas."""
    scene = stepped_scene(*_CORNER)
    return biases_of(scene, true_friction(stepped_problem(scene, model)), "quasidynamic")


def _witness() -> Verdict:
    """One corner by a full wave in place of the delay system."""
    ours, theirs = corner_errors("delay"), corner_errors(_WAVE)
    apart = max(abs(ours[f"error {q}"] - theirs[f"error {q}"]) for q in QUANTITIES)
    return claim("A full wave gives the same errors as the delay system", WITNESS, apart, _WAVE_SAME, f"{_WAVE}, {_CORNER}")


def _covered(record: dict[str, Any], quick: bool) -> list[Verdict]:
    found = []
    for model, rows in record["covered"].items():
        shares = np.mean(rows, axis=0)
        part = _PART["quick" if quick else "full"] if model == "quasidynamic" else 0
        same = intervals_held(model, range(part)) == rows[:part]
        found.append(
            holding(
                "95 % intervals hold the truth in 91 to 99.5 % of fits",
                EXACT,
                f"each of a, b, L in {100 * _LEAST:g} to {100 * _MOST:g} %",
                ", ".join(f"{100 * share:.1f} %" for share in shares),
                bool(same and (shares >= _LEAST).all() and (shares <= _MOST).all()),
                f"{model} as truth and as fit, {len(rows)} fits with noise {NOISE:g}",
            )
        )
    return found


def _rules(atlas: Atlas, rules: dict[str, float]) -> Table:
    rows: list[tuple[str | float, ...]] = []
    for model in MODELS:
        ends = [float(np.nanmax(np.abs(atlas.of(model, "error", q)[-4]))) for q in QUANTITIES]
        rows.append((model, rules[model], int(atlas.excluded(model).sum()), *(100.0 * end for end in ends)))
    heading = " | ".join(
        ["model", "share with 1 % .2g", "truth excluded .0f", *(f"{q} at {atlas.shares[-4]:.2g} [%] .2g" for q in QUANTITIES)]
    )
    return table("rules", _RULES, heading, rows)


def _coverage(record: dict[str, Any]) -> Table:
    rows = ((model, len(rows), *(100.0 * np.mean(rows, axis=0)).tolist()) for model, rows in record["covered"].items())
    return table("coverage", _COVERAGE, "model | fits .0f | a [%] .1f | b [%] .1f | L [%] .1f", rows)


def _draw(atlas: Atlas) -> Drawing:
    with styled():
        figure = canvas(height=4.4)
        grid = figure.subplots(2, 3, sharex=True, sharey=True)
        for axes, model in zip(grid.flat, MODELS, strict=True):
            worst = np.log10(np.clip(atlas.worst(model), 1e-5, 1.0)).T
            picture = axes.contourf(atlas.shares, atlas.kappas, worst, np.arange(-5.0, 0.1, 0.5), cmap="viridis", extend="both")
            axes.contour(atlas.shares, atlas.kappas, worst, [-2.0], colors="white", linewidths=1.6)
            where = np.argwhere(atlas.excluded(model))
            axes.plot(atlas.shares[where[:, 0]], atlas.kappas[where[:, 1]], "x", color="#d62728", markersize=3)
            axes.set(xscale="log", yscale="log", title=pen(model).label)
        for axes in grid[1]:
            axes.set_xlabel("transit / time of slip by $L$")
        for axes in grid[:, 0]:
            axes.set_ylabel("$k/k_c$")
        figure.colorbar(picture, ax=grid, label="log$_{10}$ largest error of a, b, L")
        return figure


_STEPS = (
    "A velocity step by ten of the exact delay system (a = 0.01, b = 0.015), fitted from a, b, L and stiffness; share is the "
    "transit over the time of slip by L at the faster velocity, k_{c} = (b - a) σ/L."
)
_ATLAS = f"{_STEPS} White: 1 %. Crosses: the fit’s own 95 % interval of a, b or L excludes the truth (noise {NOISE:g})."
_RULES = (
    f"{_STEPS} Share with 1 %: the largest of the atlas up to which no error of a, b and L is larger, for k/k_{{c}} from 1.2 to "
    "32; truth excluded: places where an interval of a, b or L does not hold the truth; then the largest errors at one share."
)
_COVERAGE = (
    f"Records of a, b, L by each model, fitted by itself, at share {COVERED[0]} and k/k_{{c}} {COVERED[1]}: how often intervals "
    "hold the truth."
)

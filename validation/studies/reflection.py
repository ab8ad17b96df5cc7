"""Outer faces that reflect a part of each wave: bare coefficients, which leak the load, and grips, which keep it; on both faces
and on one. Where stick-slip begins and ends, at which reflection snake and torus end, which model may be used."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import slipwave as sw
from validation.chart import BLUE, DASHED, INK, Chart, Look, Panel, Scale, Trace
from validation.chart.colors import PAPER, REGIMES
from validation.chart.looks import NAMES
from validation.measure.in_words import command_words, motion_at, scene_of, state_at
from validation.measure.memo import critical_r
from validation.measure.on_record import MOTIONS, SPECIAL_POINTS, KnownPoint, branch_points, on_record, special_points
from validation.measure.regimes import STEADY, UNDECIDED, Regime
from validation.references import others
from validation.report import (
    EXACT,
    ROUNDING,
    SELF,
    WITNESS,
    Answers,
    Budget,
    Figure,
    StudyResult,
    Table,
    Verdicts,
    claim,
    every,
    minus,
    places,
    plain,
    stated,
    table,
)
from validation.report.compared import EXACT_MODEL, relative_costs
from validation.report.everywhere import first_good, first_in_words, motion_cells, recorded_table, repeated, summary
from validation.report.known import NO_OTHERS, OTHERS_AT, as_foreign, foreign_answer
from validation.report.model_table import ModelColumn

NAME = "reflection"
QUESTION = "What do outer faces that reflect only a part of each wave do to stick-slip, and which model may be used behind them?"
SCENES = ("paper", "reflection")
FILES = (MOTIONS, SPECIAL_POINTS, *others.FILES)
SECONDS = (40.0, 60.0)

STIFFNESS = 10.0
"""Of the grips, in epsilon a transit."""
REFLECTIONS = (0.999, 0.99, 0.95, 0.9, 0.5, 0.0, -0.5, -0.9)
OVER_ONSET = (1.05, 1.3)
"""r over the onset."""
MODELS = (EXACT_MODEL, "fitted:8", "fitted:4", "quasidynamic", "quasistatic")
RANGE = (-2.8, -2.3)
"""log10 r of the branches."""
FAR = 115.0
"""Period (transits) up to which they are followed."""
WHOLE = {"longest_period": FAR, "most_points": 6000}
UNTIL = 900.0


class _LeakyFace(NamedTuple):
    """A `kind` of outer face, "bare" or "grip", on `both` slabs or on the upper one alone, and its reflection R, of a grip that
    of high frequencies: Z_g/epsilon = (1 + R)/(1 - R)."""

    kind: str
    both: bool
    reflection: float

    def settings(self, log10_r: float = -2.68) -> str:
        """The words that give the paper's slabs with this face in a command."""
        impedance = (1.0 + self.reflection) / (1.0 - self.reflection)
        grip = {"kind": "grip", "stiffness": STIFFNESS, "impedance": impedance}
        keys = {"kind": "reflection", "coefficient": self.reflection} if self.kind == "bare" else grip
        names = ("slab",) if self.both else ("upper", "lower")
        face = {f"{names[0]}.face.{key}": value for key, value in keys.items()}
        slabs = {f"{name}.{key}": value for name in names for key, value in (("epsilon", 2.8e-5), ("log10_r", log10_r))}
        return command_words("paper", slabs | face | {"start.size": 0.5})

    @property
    def title(self) -> str:
        """Its words on the page."""
        return f"{self.kind}, {self.where}, R = {places([self.reflection])}"

    @property
    def where(self) -> str:
        """Which slabs have it."""
        return "both faces" if self.both else "one face"


def _edge(both: bool) -> float:
    """The R of bare faces, on both slabs or on one, below which their dashpot, epsilon (1 + R)/(1 - R) a slab, is weaker than
    friction's weakening, (b - a)/V: steady sliding is then unstable at every r, and the interface locks."""
    scene = sw.read("paper")
    ratio = (scene.law.b - scene.law.a) / scene.velocity / scene.upper.epsilon * (2.0 if both else 1.0)
    return float((ratio - 1.0) / (ratio + 1.0))


_Points: TypeAlias = Mapping[_LeakyFace, Sequence[KnownPoint]]
_Motions: TypeAlias = Mapping[tuple[_LeakyFace, float], Regime]
"""By face and r over the onset, or log10 r."""

_KINDS, _BOTH = {"bare": "bare faces", "grip": "grips"}, (True, False)
FACES = tuple(_LeakyFace(kind, both, R) for kind in _KINDS for both in _BOTH for R in REFLECTIONS)
_FOLLOWED = (0.999, 0.997, 0.995, 0.99, 0.98, 0.95, 0.9)
BRANCHES = tuple(_LeakyFace(kind, True, R) for kind in _KINDS for R in _FOLLOWED)
"""Faces behind which the branch was followed over RANGE."""
_ROWS = (0.999, 0.998, 0.997, 0.996, 0.995, 0.993, 0.99, 0.985, 0.98, 0.97, 0.95, 0.93, 0.9)
_COLUMNS = tuple(round(-2.8 + 0.025 * k, 3) for k in range(21))
"""R of both faces and log10 r of the map of regimes."""
_WITNESSED = (
    _LeakyFace("grip", True, 0.5),
    _LeakyFace("grip", False, -0.5),
    _LeakyFace("bare", True, 0.99),
    _LeakyFace("bare", False, 0.9),
)
_LADDER = ("fitted:4", "fitted:8")
_COSTED = _LeakyFace("grip", True, 0.5), OVER_ONSET[1]
_AGAIN = (
    (EXACT_MODEL, _LeakyFace("bare", True, 0.95), 1.3),
    ("fitted:8", _LeakyFace("grip", False, 0.5), 1.05),
    ("quasidynamic", _LeakyFace("grip", True, -0.5), 1.3),
    (EXACT_MODEL, _LeakyFace("grip", False, 0.999), 1.3),
)


_ON_THE_MAP = _LeakyFace("grip", True, 0.995), -2.5
_CELLS = 8  # of the full wave
_FIRST_TORUS = {"log10_r": (-2.72, -2.6)}
_PERIOD = 78.45  # transits: between the first torus and the next fold
_BEGIN, _ALONG = {"bare": 2.25e-3, "grip": 7.4e-4}, 8  # 1 - R at which the curve begins, and its points
_BESIDE = 0.02  # of 1 - R, from the end of the torus


def columns() -> dict[tuple[_LeakyFace, float], ModelColumn]:
    """Every face that has an onset, at every r over it."""
    built = {}
    for face in FACES:
        onset = _face_onset(face)
        for over in OVER_ONSET if onset > 0.0 else ():
            log10_r, group = round(math.log10(onset * over), 6), f"r = {over:g} r_{{c}}"
            built[face, over] = _column(face, log10_r, over, group)
    return built


def plane() -> dict[tuple[_LeakyFace, float], str]:
    """Every point of the map of regimes over the onset, and the words of its scene."""
    onsets = {face: _face_onset(face) for face in (_LeakyFace(kind, True, R) for kind in _KINDS for R in _ROWS)}
    return {(face, x): face.settings(x) for face, onset in onsets.items() for x in _COLUMNS if 10.0**x > onset}


def _column(face: _LeakyFace, log10_r: float, over: float = math.nan, group: str = "") -> ModelColumn:
    return ModelColumn(
        f"{face.title}, {group or minus(f'log_{{10}} r = {log10_r:g}')}", log10_r, over, group, face.settings(log10_r)
    )


def _face_onset(face: _LeakyFace) -> float:
    """The r at which steady sliding loses its stability by a Hopf point; NaN if there is none."""
    return critical_r(EXACT_MODEL, scene_of(face.settings()))


TorusEnd: TypeAlias = tuple[float, float, float, bool]
"""Where the first torus ends: log10 r and the largest 1 - R of the curve through both of its ends; the distance to the next
largest of the curve's points, its error; and whether the curve goes on to smaller ones on both sides."""


def _torus_end(kind: str) -> TorusEnd:
    setting = {"slab.face.coefficient": "1 - leak"} if kind == "bare" else {"slab.face.impedance": "2/leak - 1"}
    scene, along = scene_of(_LeakyFace(kind, True, 0.99).settings()), {"leak": (_BEGIN[kind], 0.01)}
    curve = sw.curve(scene, "NS", _FIRST_TORUS, along, set=setting, model=EXACT_MODEL, most_points=_ALONG)
    points = sorted(curve.summary["points"], key=lambda point: point["log10_r"])
    best, second = sorted(points, key=lambda point: point["leak"], reverse=True)[:2]
    return best["log10_r"], best["leak"], best["leak"] - second["leak"], best not in (points[0], points[-1])


def run(budget: Budget) -> StudyResult:
    """Onsets of all faces; full waves; a few motions and a branch on record again."""
    shown = columns()
    exact = {key: on_record(EXACT_MODEL, column.settings) or Regime(UNDECIDED) for key, column in shown.items()}
    budget.report(0.2)
    words = {face: face.settings(-2.6) for face in budget.plan(_WITNESSED[::2], _WITNESSED)}
    delay = {face: state_at(scene, UNTIL, tol=1e-11) for face, scene in words.items()}
    waves = {face: state_at(scene, UNTIL, "dg:7", cells=_CELLS, time="explicit") for face, scene in words.items()}
    budget.report(0.5)
    costs = relative_costs(MODELS[:-1], {}, scene_of(shown[_COSTED].settings), budget.plan(quick=3, full=5))
    compared = recorded_table(NAME, [*shown.values()], MODELS, shown[_COSTED].title, costs)
    again = [(model, shown[face, over]) for model, face, over in budget.plan(_AGAIN[::2], _AGAIN)]
    again.append((EXACT_MODEL, _column(*_ON_THE_MAP)))
    known = {face: special_points().get(face.settings(), ()) for face in BRANCHES}
    regimes = {key: on_record(EXACT_MODEL, words) or Regime(UNDECIDED) for key, words in plane().items()}
    budget.report(0.7)
    torus = {kind: _torus_end(kind) for kind in budget.plan(["bare"], [*_KINDS])}
    return StudyResult(
        answers=_answers(known, regimes, torus, first_in_words(compared, _LADDER, "behind every face")),
        figures=(Figure("plane", _PLANE, lambda: _plane(known, regimes, torus)),),
        tables=(_motions(exact), summary(compared, "behind all faces of the table of motions")),
        verdicts=(
            *_of_faces(delay, waves),
            first_good(compared, _LADDER, f"{_FIRST} has the exact regimes, and T and Δμ to 1 %"),
            repeated("Motions behind faces on record are found again", again, motion_at),
            *_of_points(known, torus),
        ),
        notes=(
            "A locked interface returns each wave whole, the outer face returns the share R of it. Behind bare faces the load "
            "therefore falls by the factor R every transit, to 1/e in about 1/(1 − R) transits. A grip keeps it in its spring.",
        ),
        numbers={
            f"T, {shown[face, over].title}": stated(motion.figures["T"].value, max(motion.figures["T"].error, 1e-9))
            for (face, over), motion in exact.items()
            if motion.words == "periodic" and over == OVER_ONSET[0] and face.both
        },
        omissions=NO_OTHERS,
    )


_FIRST = "The first rational fit that is good behind every face"


def _answers(
    known: _Points,
    regimes: _Motions,
    torus: Mapping[str, TorusEnd],
    of_models: str,
) -> Answers:
    bare, single = map(_edge, _BOTH)
    ends = [f"R = {1.0 - leak:.6f} ± {plain(error, '.0e')} behind {_KINDS[kind]}" for kind, (_, leak, error, _) in torus.items()]
    wild = [(face.kind, face.reflection) for (face, _), motion in regimes.items() if motion.words == "irregular"]
    seen = [
        f"{name} have torus points down to {_last(known, kind, 'NS')}, folds of the snake down to {_last(known, kind, 'LP')}, "
        f"irregular motion down to {_down_to([R for other, R in wild if other == kind], _ROWS)}"
        for kind, name in _KINDS.items()
    ]
    return {
        (
            "What faces lose ends the torus early and stick-slip late: the first torus of the branch ends at "
            f"{', at '.join(ends)}. "
            f"Up to log_{{10}} r = {places(RANGE[1:])} and T = {FAR:g}, {'; '.join(seen)}."
        ): (
            "The first torus",
            "Special points",
            "Motions behind faces",
        ),
        (
            "Grips, which keep the load, keep stick-slip at every R tried; bare faces, which leak it, move its onset to larger r "
            f"and end it at R = {bare:.3f} (on one slab {single:.3f}), where steady sliding is unstable at every r and the "
            "interface locks."
        ): ("Stick-slip behind bare faces",),
        of_models: (_FIRST, "Motions behind faces"),
        **foreign_answer("the full wave", "Slabs behind"),
    }


def _last(known: _Points, kind: str, point: str) -> str:
    """The least R of the branches that has special points of one kind, and the next one without."""
    own = [face for face, points in known.items() if face.kind == kind and any(special.kind == point for special in points)]
    return _down_to([face.reflection for face in own], _FOLLOWED)


def _down_to(have: Sequence[float], tried: Sequence[float]) -> str:
    """The least R of those that have something, and the next one that was tried."""
    least = min(have, default=2.0)
    without = [R for R in tried if least > R]
    return f"R = {least:g} (not {max(without):g})" if have and without else "none of the R tried"


_ASIDE = 1e-3


def _of_faces(delay: Mapping[_LeakyFace, float], waves: Mapping[_LeakyFace, float]) -> Verdicts:
    """The delay system against the full wave and another program; whether bare faces have an onset just above their edge and none
    just below."""
    off = {face: abs(wave - delay[face]) for face, wave in waves.items()}
    worst = max(off, key=off.__getitem__)
    title = f"Slabs behind partly reflecting faces: ψ({UNTIL:.0f}) of the delay system and of the full wave, `dg:7`, agree"
    yield claim(title, WITNESS, off[worst], ROUNDING, f"worst of {len(off)}: {worst.title}")
    title = f"Another program, {others.SEM2DPACK}, has the exact solution’s ψ behind bare faces"
    words = {f"reflection-{R:g}": command_words("reflection", {"slab.face.coefficient": R}) for R in (0.5, 0.9)}
    if others.FILES:
        yield as_foreign(title, {name: {t: state_at(scene, t, tol=1e-12) for t in OTHERS_AT} for name, scene in words.items()})
    title, edges = (
        "Stick-slip behind bare faces ends where their dashpot is as strong as friction’s weakening",
        [*map(_edge, _BOTH)],
    )
    right = [
        (_face_onset(_LeakyFace("bare", both, edge + aside)) > 0.0) == (aside > 0.0)
        for both, edge in zip(_BOTH, edges, strict=True)
        for aside in (_ASIDE, -_ASIDE)
    ]
    remark = f"R {_ASIDE:g} above and below {edges[0]:.6f} on both slabs and {edges[1]:.6f} on one"
    yield every(title, EXACT, sum(right), 4, remark)


def _of_points(known: _Points, torus: Mapping[str, TorusEnd]) -> Verdicts:
    """Special points on record again; whether the curve of torus points turns back at its extreme, and the branch beyond has
    none."""
    face = _LeakyFace("bare", True, 0.95)
    pairs = zip(branch_points(face.settings(), RANGE, **WHOLE), known[face], strict=True)
    off = max((abs(ours.log10_r - old.log10_r) for ours, old in pairs), default=math.nan)
    title, where = (
        "Special points on record behind a face are found again",
        f"{face.title}: log_{{10}} r of {len(known[face])} points",
    )
    yield claim(title, SELF, off, ROUNDING, where)
    title = "The first torus has two ends before the extreme of their curve, and none beyond"
    held = [turns for *_, turns in torus.values()]
    for kind, (_, leak, *_) in torus.items():
        scene = scene_of(_LeakyFace(kind, True, 1.0 - leak * (1.0 + _BESIDE)).settings())
        beyond = sw.branch(scene, _FIRST_TORUS, model=EXACT_MODEL, longest_period=_PERIOD).summary["special"]
        held.append(all(point["type"] != "NS" for point in beyond))
    remark = f"{', '.join(_KINDS[kind] for kind in torus)}: the curve turns; torus points at 1 − R {100 * _BESIDE:g} % above"
    yield every(title, WITNESS, sum(held), len(held), remark, "sides")


def _motions(exact: _Motions) -> Table:
    rows = []
    for face in dict.fromkeys(face for face, _ in exact):
        cells = [cell for over in OVER_ONSET for cell in motion_cells(exact[face, over])]
        slabs = "both" if face.both else "one"
        rows.append([face.kind, slabs, face.reflection, math.log10(_face_onset(face)), *cells])
    each = " | ".join(f"at {over:g} r_{{c}} | T [transits] | Δμ [σ]" for over in OVER_ONSET)
    return table("motions", _MOTIONS, f"face | slabs | R .3g | onset, log_{{10}} r .6f | {each}", rows)


_MOTIONS = (
    f"The exact motion behind faces that reflect the share R of high-frequency waves: bare ones, and grips of stiffness "
    f"{STIFFNESS:g} ε a transit; onset r_{{c}} of stick-slip, and at two r over it regime, period and stress drop, where motions "
    "do not repeat means with two standard errors. Bare faces of smaller R have no onset: the interface locks."
)
_PLANE = (
    "Regimes of the exact motion over r and the reflection R of both faces: bare faces, and grips of the same high-frequency "
    "reflection. A cell is a run of 20,000 transits. Line: onset, below which sliding is steady. Marks: special points of the "
    f"branch up to T = {FAR:g} transits at seven R, the first of each kind joined (dashed), and where the first torus ends."
)
_NEAR_ONSET = 0.01  # in log10 r: a fold there ends the cycles, those beyond are the snake's
_SEVERAL = "periodic, several events"
_CELLS_OF = {STEADY: REGIMES["steady"], **{word: REGIMES[word] for word in ("periodic", "torus", "irregular")}}
_CELL = Look(
    kind="cells",
    colors=_CELLS_OF | {_SEVERAL: REGIMES["periodic"], UNDECIDED: PAPER},
    hatches={_SEVERAL: "////", UNDECIDED: "xxx"},
)
_MARKS = {"LP": ("o", INK, 2.6), "NS": ("s", BLUE, 4.0), "PD": ("^", "#8a3a00", 4.6)}


def _plane(
    known: _Points,
    regimes: _Motions,
    torus: Mapping[str, TorusEnd],
) -> Chart:
    """Regimes over r and 1 - R, with the onset, special points, and where the first torus ends."""
    panels, leaks, words = [], [1.0 - R for R in _ROWS], list(_CELL.colors)
    for kind, title in _KINDS.items():
        faces = [_LeakyFace(kind, True, R) for R in _ROWS]
        rows = [[_word(regimes.get((face, x))) for x in _COLUMNS] for face in faces]
        traces = [Trace("regime", _COLUMNS, leaks, _CELL, value=[[words.index(word) for word in row] for row in rows])]
        onset = [math.log10(_face_onset(face)) for face in faces]
        traces += [
            Trace("", onset, leaks, Look(PAPER, width=3.6)),
            Trace("onset (Hopf point)", onset, leaks, Look(INK, width=1.8)),
        ]
        for point, (marker, color, size) in _MARKS.items():
            own = [
                (face, special)
                for face, points in known.items()
                for special in points
                if (face.kind, special.kind) == (kind, point)
            ]
            places_of = [special.log10_r for _, special in own], [1.0 - face.reflection for face, _ in own]
            first = _first_beyond(own)
            traces += [Trace("", *first, Look(PAPER, width=3.0)), Trace("", *first, Look(color, DASHED))]
            traces.append(Trace(NAMES[point], *places_of, Look(color, "", marker, size=size, hollow=True)))
        if kind in torus:
            place = torus[kind][:1], torus[kind][1:2]
            traces += [
                Trace("", *place, Look(PAPER, "", "D", size=8.0)),
                Trace("end of the first torus", *place, Look(BLUE, "", "D")),
            ]
        panels.append(Panel(title, Scale(r"$\log_{10} r$", limits=(_COLUMNS[0], _COLUMNS[-1])), Scale("$1 - R$", "log"), traces))
    return Chart(panels, 4.6, 2, legend="outside upper left", legend_columns=4)


def _first_beyond(own: Sequence[tuple[_LeakyFace, KnownPoint]]) -> tuple[list[float], list[float]]:
    """log10 r of the first of special points of one kind that lies beyond the neighbourhood of the onset, and 1 - R, by faces."""
    beyond = [(face, special.log10_r) for face, special in own if special.log10_r > math.log10(_face_onset(face)) + _NEAR_ONSET]
    faces = list(dict.fromkeys(face for face, _ in beyond))
    return [min(x for other, x in beyond if other == face) for face in faces], [1.0 - face.reflection for face in faces]


def _word(motion: Regime | None) -> str:
    """The word of a cell of the map; of none steady sliding, which is stable below the onset."""
    word = motion.words if motion else STEADY
    return _SEVERAL if word.startswith("periodic,") else word if word in _CELL.colors else UNDECIDED

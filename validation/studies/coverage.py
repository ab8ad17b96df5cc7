"""Coverage of the errors that this program states."""

from collections.abc import Iterator

import numpy as np

from slipwave.sources import source_digest
from validation.coverage.held import Coverage, Held, coverage_of
from validation.coverage.record import KINDS, RECORD, Record, computation, known_computations
from validation.study import SELF, Budget, Cell, Figure, Number, Omission, StudyResult, Table, Verdict, every, holding, table
from validation.study.drawing import WIDTH, Drawing, canvas

NAME = "coverage"
QUESTION = "How often do the stated errors hold the truth?"
SCENES: tuple[str, ...] = ()
FILES = (RECORD,)
SECONDS = (2.0, 20.0)

ENOUGH = 0.95
# how closely a computation is repeated: share of what is compared, share of the bar, and what is left of rounding
_NEAR, _LITTLE, _ROUNDING = 0.05, 1e-3, 3e-12
_ALIKE = 3.0  # ratio of two bars over one irregular motion, and of an error to them
_LEAST, _MOST = 1e-5, 10.0  # error over bar, in the figure


def run(budget: Budget) -> StudyResult:
    """Show the record of `python -m validation.coverage --record`, and repeat a part of it, selected by the text of the
    solvers."""
    record = known_computations()
    if not record:
        why = "No record by the present definition is here: python -m validation.coverage --record makes one."
        return StudyResult("Not answered in this report.", omissions=(Omission("Coverage of stated errors.", why),))
    found = {kind: coverage_of(record[kind]) for kind in KINDS}
    worst = {kind: min(some, key=lambda one: one.share) for kind, some in found.items()}
    least = min(worst, key=lambda kind: worst[kind].share)
    return StudyResult(
        answer=f"Stated errors hold the truth in at least {100.0 * worst[least].share:.1f} of 100 computations of known truth, "
        f"in each of {len(KINDS)} kinds (the least: {least}).",
        tables=(_table(found),),
        figures=(Figure("shares", _CAPTION, lambda: _histograms(record)),),
        verdicts=(*(holds(kind, one) for kind, one in worst.items()), *_repeated(record, budget)),
        notes=("`python -m validation.coverage --record` computes what it lacks; it may be interrupted.",),
        numbers={f"held, {kind}": Number(one.share, 0.02) for kind, one in worst.items()},
    )


def _table(found: dict[str, list[Coverage]]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (
            kind,
            KINDS[kind].bar,
            KINDS[kind].truth,
            one.figure,
            one.many,
            100.0 * one.share,
            100.0 * one.low,
            100.0 * one.high,
            one.width,
        )
        for kind, some in found.items()
        for one in some
    ]
    heading = (
        "kind | stated error | truth | figure | number .0f | held [%] .1f | at least [%] .1f | at most [%] .1f "
        "| bar/error [median] .3g"
    )
    caption = (
        "How often an error that the program states is at least as large as the true one: computations of random scenes, alike, "
        "unlike, layered, held by grips or machines, viscous. Share with its 95 % interval (Wilson). Last: how many times larger "
        "than the error a bar is; a large number means a bar that tells little."
    )
    return table("coverage", caption, heading, rows)


def holds(kind: str, one: Coverage) -> Verdict:
    """The verdict on the figure with the lowest coverage, with its interval."""
    title = "Stated errors hold the truth in at least 95 of 100 computations"
    remark = f"{kind}: {one.figure}; {one.many} computations, 95 % interval {100.0 * one.low:.1f} to {100.0 * one.high:.1f}"
    ours = f"{100.0 * one.share:.1f} of 100"
    found = holding(title, KINDS[kind].evidence, "95.0 of 100 or more", ours, one.share >= ENOUGH, remark)
    return found.with_margin(1.0 - one.share, 1.0 - ENOUGH)


def chosen(record: Record, kind: str, quick: bool) -> list[int]:
    """Numbers of the computations to be repeated, which depend on the text of the solvers."""
    count = KINDS[kind].repeated // 4 if quick else KINDS[kind].repeated
    able = [number for number, held in enumerate(record[kind]) if held]
    random = np.random.default_rng(int(source_digest(), 16))
    return sorted(random.choice(able, min(count, len(able)), replace=False).tolist())


def _repeated(record: Record, budget: Budget) -> Iterator[Verdict]:
    title = "Computations of the record, repeated, are what is recorded"
    for kind in budget.each(list(KINDS)):
        numbers = chosen(record, kind, budget.quick)
        same = sum(agree(kind, computation(kind, number), record[kind][number]) for number in numbers)
        if numbers:
            remark = f"{kind}: number {', '.join(map(str, numbers))}"
            yield every(title, SELF, same, len(numbers), remark)


def agree(kind: str, ours: list[Held], known: list[Held]) -> bool:
    """Whether a repeated computation agrees with the recorded one in each bar and each error; for a motion that never repeats,
    which rounding changes between machines, in their sizes."""
    near = _near if KINDS[kind].exact else _alike
    return [one.figure for one in ours] == [one.figure for one in known] and all(map(near, ours, known))


def _near(one: Held, other: Held) -> bool:
    bar, error = max(one.bar, other.bar), max(one.error, other.error)
    same = abs(one.bar - other.bar) < _NEAR * bar + _ROUNDING
    return same and abs(one.error - other.error) < _NEAR * error + _LITTLE * bar + _ROUNDING


def _alike(one: Held, other: Held) -> bool:
    bar = max(one.bar, other.bar)
    return bar < _ALIKE * min(one.bar, other.bar) and max(one.error, other.error) < _ALIKE * bar


_CAPTION = (
    "True error over stated error, by kind of stated error, in decades; the line is 1, and what lies right of it is not held. "
    f"Ratios below {_LEAST:g} are counted in the first bar."
)


def _histograms(record: Record) -> Drawing:
    figure = canvas(WIDTH, 4.6)
    panels = figure.subplots(2, 4, sharex=True)
    edges = np.arange(np.log10(_LEAST), np.log10(_MOST) + 0.1, 0.25)
    for axes, kind in zip(panels.flat, KINDS, strict=False):
        held = [one for some in record[kind] for one in some]
        ratios = np.clip([one.error / one.bar for one in held], _LEAST, _MOST)
        axes.hist(np.log10(ratios), edges, color="#0072b2")
        axes.axvline(0.0, color="#d55e00", linewidth=1.0)
        axes.set_title(f"{kind}, {len(held)}", fontsize=10)
        axes.set_xticks([-4, -2, 0], ["$10^{-4}$", "$10^{-2}$", "1"])
    for axes in panels.flat[len(KINDS) :]:
        axes.set_axis_off()
    for axes in panels[1]:
        axes.set_xlabel("error / bar")
    return figure

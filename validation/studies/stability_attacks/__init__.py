"""Attacks on the full wave: steps past the limit, stiff friction, extreme scenes, noise at the grid scale."""

from collections.abc import Iterable, Iterator
from itertools import count

from validation.studies.stability_attacks import shown, verdicts
from validation.studies.stability_attacks.limits import BEYOND, MEDIA, around_the_limit, limit_at, state_reach, stops_beyond
from validation.studies.stability_attacks.runs import ATTACKS, CELLS, advised, attack, locked_noise
from validation.studies.stability_attacks.verdicts import Found
from validation.study import Budget, Number, StudyResult

NAME = "stability-attacks"
QUESTION = "Can extreme inputs make the full-wave solvers fail without a message?"
SCENES = ("paper", "unlike")
SECONDS = (8.0, 32.0)

_QUICK_DECADES, _FULL_DECADES = (-4, 0, 2, 4, 8), (-4, -2, *range(9))
_QUICK_MEDIA = ("alike slabs", "impedances 1 : 1000", "layers 1 : 100", "Kelvin-Voigt, 0.02 transits")
_ADVISED = ("sbp:4", "fem:4", "dg:3")


def run(budget: Budget) -> StudyResult:
    """Step limits over eight decades of stiffness and over media, extreme scenes, and noise in a locked slab."""
    found = _measure(budget)
    return StudyResult(
        answer=verdicts.answer(found),
        tables=(
            shown.limit_table(found.decades, found.limits, found.reach),
            shown.medium_table(found.media),
            shown.attack_table(found.attacks, found.late),
            *shown.message_table(found.attacks),
            shown.advice_table(found.advice),
            shown.noise_table(found.noise, found.transits),
        ),
        verdicts=(
            verdicts.limit_verdict(found),
            verdicts.medium_verdict(found.media),
            verdicts.state_verdict(found.reach),
            verdicts.stop_verdict(found.stopped),
            *(verdicts.attack_verdict(name, outcomes, found.late) for name, outcomes in found.attacks.items()),
            verdicts.advice_verdict(found.advice),
            verdicts.noise_verdict(found.noise, found.transits),
        ),
        notes=(
            "Users cannot pass the limit: cfl beyond 1 is refused before a run begins. The runs of the first two tables "
            "set their steps inside the solvers.",
        ),
        numbers={f"limit of {model}": Number(shares[-1], verdicts.SHARP) for model, shares in found.limits.items()},
    )


def _measure(budget: Budget) -> Found:
    decades = _QUICK_DECADES if budget.quick else _FULL_DECADES
    transits = 1e3 if budget.quick else 2e4
    done, total = count(1), 4 * len(CELLS) + len(ATTACKS)

    def each(names: Iterable[str]) -> Iterator[str]:
        """The names; the share of all parts that are done is reported after each."""
        for name in names:
            yield name
            budget.report(next(done) / total)

    limits = {model: [limit_at(model, decade) for decade in decades] for model in each(CELLS)}
    media = {
        medium: {model: around_the_limit(model, medium) for model in CELLS}
        for medium in (_QUICK_MEDIA if budget.quick else MEDIA)
    }
    return Found(
        decades,
        limits,
        {model: state_reach(model) for model in each(CELLS)},
        media,
        {model: stops_beyond(model, BEYOND) for model in each(CELLS)},
        not budget.quick,
        {name: attack(name, not budget.quick) for name in each(ATTACKS)},
        {model: advised(model) for model in (_ADVISED if budget.quick else CELLS)},
        transits,
        {model: locked_noise(model, transits) for model in each(CELLS)},
    )

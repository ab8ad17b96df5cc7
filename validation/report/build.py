"""Runs the studies one after the other (they measure times, so never side by side) and hands their results to the page."""

import time
import traceback
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from scene.errors import NumericsError
from validation.report import store
from validation.report.page import write_page
from validation.report.provenance import provenance
from validation.studies import choose, load
from validation.study import Budget, Study


def build_report(out: Path, quick: bool, only: list[str] | None) -> Path:
    """See `validation.report.make_report`."""
    fresh = _run([load(name) for name in choose(only)], out / "data", quick)
    results = [result for name in choose(None) if (result := fresh.get(name) or _known(name, out / "data", quick))]
    page = write_page(out, results, provenance(), quick)
    broken = [result.name for result in results if result.error]
    if broken:
        raise NumericsError(f"{', '.join(broken)}: failed, the rest of the report is whole; {page} tells why")
    return page


def _run(studies: list[Study], folder: Path, quick: bool) -> dict[str, store.Stored]:
    """Obtain each study's result, telling on stderr how far it is and what time is left."""
    results: dict[str, store.Stored] = {}
    with _bar(Console(stderr=True)) as bar:
        task = bar.add_task("", total=sum(_seconds(study, quick) for study in studies))
        for study in studies:
            start = bar.tasks[task].completed

            def report(share: float, start: float = start, study: Study = study) -> None:
                """Move the bar to this share of the study."""
                bar.update(task, completed=start + share * _seconds(study, quick))

            bar.update(task, description=study.NAME)
            results[study.NAME] = _obtain(folder, study, Budget(quick, report))
            report(1.0)
            _say(bar.console, results[study.NAME])
    return results


def _known(name: str, folder: Path, quick: bool) -> store.Stored | None:
    """A study that was not asked for this time is still shown if its stored result holds."""
    study = load(name)
    return store.load(folder, study, store.study_key(study, quick))


def _seconds(study: Study, quick: bool) -> float:
    return study.SECONDS[0 if quick else 1]


def _bar(console: Console) -> Progress:
    columns = (TextColumn("{task.description:24}"), BarColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    return Progress(*columns, console=console, transient=True)


def _obtain(folder: Path, study: Study, budget: Budget) -> store.Stored:
    """The study's stored result if nothing changed, else a fresh one, stored; an exception becomes a result that says so."""
    key = store.study_key(study, budget.quick)
    known = store.load(folder, study, key)
    return known or attempt(study, lambda seconds: store.save(folder, study, key, study.run(budget), seconds()))


def attempt(study: Study, work: Callable[[Callable[[], float]], store.Stored]) -> store.Stored:
    """Run `work`, giving it a stop-watch; any exception ends this study only."""
    began = time.perf_counter()

    def seconds() -> float:
        """Wall time since the work began."""
        return time.perf_counter() - began

    try:
        return work(seconds)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        message = f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno}, in {where.name})"
        return store.Stored(study.NAME, study.QUESTION, seconds(), True, error=message)


def _say(console: Console, stored: store.Stored) -> None:
    state = "failed" if stored.error else f"{stored.wall_seconds:6.1f} s" if stored.fresh else "  stored"
    console.print(f"{stored.name:24} {state}", highlight=False)
    if stored.error:
        console.print(f"    {stored.error}", highlight=False, markup=False)

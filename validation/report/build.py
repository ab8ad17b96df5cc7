"""Runs the studies, several at a time, and passes their results to the page."""

import sys
import time
import traceback
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, cast

from slipwave.files import alone_in
from slipwave.sources import commit
from validation.models.progress import progress
from validation.models.stopwatch import cores
from validation.report import Budget, Study, baseline, store
from validation.report.baseline import RedReport, red_lines
from validation.report.changes import changes_since
from validation.report.files import write_files
from validation.report.page import write_page
from validation.report.provenance import machine_facts
from validation.report.record import Record, Word, record_of
from validation.report.registered import choose, study_called
from validation.report.side_by_side import share_out

_DIED = "a process of the report died, killed or short of memory, before this study was done"


class Task(NamedTuple):
    """A study to be run: name, module, and the folder and key of its stored result."""

    name: str
    module: str
    folder: Path
    key: str
    quick: bool


def make_report(
    out: Path = Path("reports"),
    quick: bool = False,
    only: list[str] | None = None,
    processes: int | None = None,
    against: Record | None = None,
) -> Path:
    """Write out/index.html and its accompanying files, computing only what is not stored under out/data; returns the page's path.

    Studies run in parallel in `processes` (default: one per core); those that measure run time (`TIMED`) run alone at the end. A
    failed study is shown as failed and the others continue. After writing, RedReport (a NumericsError) is raised if a study or a
    verdict fails, or a number left its baseline; with `against`, an earlier report that replaces the baseline, if a number or a
    verdict is worse than there. An interrupted report resumes: finished studies are stored whole. Raises SceneError for an
    unknown name in `only`, and while another process writes a report to `out`.
    """
    asked = choose(only)
    studies = [study_called(name) for name in choose(None)]
    tasks = {study.NAME: _task(study, out / "data", quick) for study in studies}
    with alone_in(out, f"--out = {str(out)!r}"):
        stored = {study.NAME: store.stored_result(out / "data", study, tasks[study.NAME].key) for study in studies}
        wanted = [study for study in studies if study.NAME in asked and stored[study.NAME] is None]
        for known in (result for name in asked if (result := stored[name])):
            _say(known)
        seconds = {study.NAME: _seconds(study, quick) for study in wanted}
        spent = dict.fromkeys(seconds, 0.0)
        with progress("report", sum(seconds.values())) as report:

            def tell(name: str, share: float) -> None:
                """Report how far the study `name` is."""
                spent[name] = share * seconds[name]
                report(sum(spent.values()))

            for result in _run(wanted, tasks, processes or cores(), tell):
                stored[result.name] = result
                tell(result.name, 1.0)
                _say(result)
        return _write(out, [result for result in stored.values() if result], quick, against)


def _write(out: Path, results: list[store.Stored], quick: bool, against: Record | None) -> Path:
    """Write the page and its files; raises RedReport at the end."""
    facts = machine_facts()
    bare = record_of(results, facts, quick, datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"))
    kept = baseline.as_report(bare)
    left = changes_since(kept, bare, f"the baseline of commit {commit(baseline.FOLDER)}")
    report = bare.model_copy(update={"changes": left})
    patch = baseline.patch_of(report)
    red: tuple[Word, ...] = baseline.LEFT
    if against:
        red, times = (Word.WORSE,), bare.times.model_copy(update={"before": against.times.seconds})
        report = bare.model_copy(update={"changes": changes_since(against, bare, _called(against)), "times": times})
    out.mkdir(parents=True, exist_ok=True)
    write_files(out, report, red, patch)
    page = write_page(out, results, facts, report)
    lines = red_lines(report, red)
    if lines:
        raise RedReport(lines, page)
    return page


def _called(report: Record) -> str:
    """Text that identifies a report by version, commit and time."""
    return f"slipwave {report.versions.get('slipwave', '?')}, {report.digests.get('commit', '?')}, of {report.times.written}"


def _task(study: Study, folder: Path, quick: bool) -> Task:
    return Task(study.NAME, str(getattr(study, "__name__", "")), folder, store.study_key(study, quick), quick)


def _run(
    studies: list[Study], tasks: dict[str, Task], processes: int, tell: Callable[[str, float], None]
) -> Iterator[store.Stored]:
    """Yield results as studies end. The longest studies begin first, several at a time; those that measure run time run alone at
    the end."""
    longest_first = sorted(studies, key=lambda study: -_seconds(study, tasks[study.NAME].quick))
    timed = [tasks[study.NAME] for study in longest_first if getattr(study, "TIMED", False)]
    shared = [task for study in longest_first if (task := tasks[study.NAME]) not in timed]
    if processes > 1 and len(shared) > 1:
        for task, result in share_out(_perform, shared, processes, lambda task, share: tell(task.name, share)):
            yield result or store.Stored(task.name, study_called(task.name).QUESTION, 0.0, True, error=_DIED)
    else:
        timed = shared + timed
    yield from (_perform(task, partial(tell, task.name)) for task in timed)


def _perform(task: Task, tell: Callable[[float], None]) -> store.Stored:
    """Run a study and store its result; any exception becomes the result of this study."""
    study = cast(Study, import_module(task.module))
    began = time.perf_counter()
    try:
        result = study.run(Budget(task.quick, tell))
        return store.store_result(task.folder, study, task.key, result, time.perf_counter() - began)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        message = f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno}, in {where.name})"
        return store.Stored(study.NAME, study.QUESTION, time.perf_counter() - began, True, error=message)


def _seconds(study: Study, quick: bool) -> float:
    return study.SECONDS[0 if quick else 1]


def _say(stored: store.Stored) -> None:
    """Log one line for a finished study."""
    state = "failed" if stored.error else f"{stored.wall_seconds:6.1f} s" if stored.fresh else "  stored"
    print(f"{stored.name:24} {state}", file=sys.stderr, flush=True)

"""Runs the studies, several at a time, and passes their results to the page."""

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from datetime import UTC, datetime
from functools import partial
from importlib import import_module
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias, cast

from slipwave.files import alone_in
from slipwave.friction.own import LAW_FILES
from slipwave.sources import commit
from validation.models.own import load_own
from validation.models.progress import progress
from validation.models.stopwatch import cores
from validation.report import Budget, Study, baseline, store
from validation.report.baseline import RedReport, changes_since, red_lines
from validation.report.files import write_files
from validation.report.page import write_page
from validation.report.record import Record, Word, record_of
from validation.report.registered import choose, placed, study_called
from validation.sweep import executors

Tell: TypeAlias = Callable[[float], None]
"""Is called with the share of a study that is done, 0 to 1."""
_LOOK = 0.2  # seconds between two looks at how far the studies are
_DIED = "a process of the report died, killed or short of memory, before this study was done"


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
    keys = {study.NAME: store.study_key(study, quick) for study in studies}
    with alone_in(out, f"--out = {str(out)!r}"):
        stored = {study.NAME: store.stored_result(out / "data", study, keys[study.NAME]) for study in studies}
        wanted = [study for study in studies if study.NAME in asked and stored[study.NAME] is None]
        for known in (result for name in asked if (result := stored[name])):
            _say(known)
        seconds = {study.NAME: study.SECONDS[0 if quick else 1] for study in wanted}
        works = {
            study.NAME: partial(_perform, study.__name__, out / "data", keys[study.NAME], quick, [*LAW_FILES])
            for study in sorted(wanted, key=lambda study: -seconds[study.NAME])
        }
        timed = [study.NAME for study in wanted if getattr(study, "TIMED", False)]
        shared = {name: work for name, work in works.items() if name not in timed}
        workers = min(processes or cores(), len(shared))
        spent = dict.fromkeys(seconds, 0.0)
        with progress("report", sum(seconds.values())) as report:

            def tell(name: str, share: float) -> None:
                """Report how far the study `name` is."""
                spent[name] = share * seconds[name]
                report(sum(spent.values()))

            together = _side_by_side(shared, workers, tell) if workers > 1 else ()
            alone = [*(shared if workers < 2 else ()), *(name for name in works if name in timed)]
            for result in chain(together, (works[name](partial(tell, name)) for name in alone)):
                stored[result.name] = result
                tell(result.name, 1.0)
                _say(result)
        return _write(out, [result for result in stored.values() if result], quick, against)


def _write(out: Path, results: list[store.StoredStudy], quick: bool, against: Record | None) -> Path:
    """Write the page and its files; raises RedReport at the end."""
    bare = record_of(results, quick, datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"))
    kept = baseline.as_report(bare)
    left = changes_since(kept, bare, f"the baseline of commit {commit(baseline.FOLDER)}")
    report = bare.model_copy(update={"changes": left})
    patch = baseline.patch_of(report)
    red: tuple[Word, ...] = baseline.LEFT
    if against:
        red, times = (Word.WORSE,), bare.times.model_copy(update={"before": against.times.seconds})
        version, revision = against.versions.get("slipwave", "?"), against.digests.get("commit", "?")
        left = changes_since(against, bare, f"slipwave {version}, {revision}, of {against.times.written}")
        report = bare.model_copy(update={"changes": left, "times": times})
    out.mkdir(parents=True, exist_ok=True)
    write_files(out, report, red, patch)
    page = write_page(out, results, report)
    lines = red_lines(report, red)
    if lines:
        raise RedReport(lines, page)
    return page


def _side_by_side(
    works: Mapping[str, Callable[[Tell], store.StoredStudy]], workers: int, tell: Callable[[str, float], None]
) -> Iterator[store.StoredStudy]:
    """Yield results as studies end, which processes of their own begin in this order; those that were running or waiting when a
    process died have failed. How far each is stands in a file."""
    with TemporaryDirectory() as folder, executors.processes(workers) as start:
        pool, notes, names = start(), {name: Path(folder, name) for name in works}, dict[Future[store.StoredStudy], str]()
        for name, work in works.items():
            try:
                names[pool.submit(work, partial(_note, notes[name]))] = name
            except BrokenExecutor as error:  # a process died while others were started
                broken = Future[store.StoredStudy]()
                broken.set_exception(error)
                names[broken] = name
        while names:
            done, running = wait(names, _LOOK, FIRST_COMPLETED)
            for name in (names[future] for future in running):
                tell(name, float(notes[name].read_text() or 0.0) if notes[name].exists() else 0.0)
            for name, future in ((names.pop(future), future) for future in done):
                died = store.StoredStudy(name, study_called(name).QUESTION, 0.0, True, error=_DIED)
                yield died if future.exception() else future.result()


def _note(file: Path, share: float) -> None:
    file.write_text(f"{share}")


def _perform(module: str, folder: Path, key: str, quick: bool, laws: list[Path], tell: Tell) -> store.StoredStudy:
    """Run a study, with the user's files of `laws`, and store its result under a key; any exception, or sys.exit, becomes the
    result of this study."""
    load_own(laws)
    study = cast(Study, import_module(module))
    began = time.perf_counter()
    try:
        result = study.run(Budget(quick, tell))
        if not result.answers:
            raise ValueError("the study answers nothing")
        return store.store_result(folder, study, key, result, time.perf_counter() - began)
    except (Exception, SystemExit) as error:
        return store.StoredStudy(study.NAME, study.QUESTION, time.perf_counter() - began, True, error=placed(error))


def _say(stored: store.StoredStudy) -> None:
    """Log one line for a finished study."""
    state = "failed" if stored.error else f"{stored.wall_seconds:6.1f} s" if stored.fresh else "  stored"
    print(f"{stored.name:24} {state}", file=sys.stderr, flush=True)

"""The race of full waves: processor time and error of psi(600), after a nudge at log10 r = -2.6; nothing is judged.

python -m validation.wave_race                           # half a minute
python -m validation.wave_race --yardstick PROGRAM.py    # against another program, timed in the same run

PROGRAM prints one JSON object a line, with the `error` of its psi(600) and the time in `ms` by `time.perf_counter`.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import NamedTuple

import slipwave
from slipwave.solve import Final, follow
from validation.output import print_table
from validation.run.timing import in_turn
from validation.work_precision import Setting, solver_of, warm_up

PSI = -2.8174018894888
"""psi(600) by the delay system at three resolutions, and by another program."""

SETTINGS = (
    *(Setting("delay", tolerance=tolerance) for tolerance in (1e-8, 1e-9, 1e-11)),
    *(Setting(f"dg:{degree}", tolerance, cells, time="exact") for degree, cells, tolerance in ((8, 4, 1e-9), (24, 1, 3e-9))),
    *(Setting(f"dg:{degree}", 1e-10, cells, time="exact") for degree, cells in ((16, 2), (20, 2))),
    Setting("dg:8", cells=4, time="exact"),
    *(Setting(f"dg:{degree}", cells=cells, time="explicit") for degree, cells in ((8, 4), (16, 2))),
    *(Setting("fd", cells=cells) for cells in (64, 256)),
)
"""The delay system; exact marches with errors of 1e-9 and of 1e-11, and with the steps of the default; explicit; leapfrog."""

_BY_PROCESSOR = (
    "import runpy, sys, time; time.perf_counter = time.process_time; sys.path.insert(0, sys.argv[2]); "
    "runpy.run_path(sys.argv[1], run_name='__main__')"
)
_UNTIL = 600.0
_ROUNDS = 3
_EACH = 2  # runs of each setting in a round


class Entrant(NamedTuple):
    """A program at a setting: its `kind` (delay, exact, explicit, fd or the other program's name), what it is in words, its error
    and its time in ms."""

    kind: str
    what: str
    error: float
    ms: float


def timed_in_turn(yardstick: Path | None) -> list[Entrant]:
    """The other program and every setting, in turn, so that a machine that slows down slows all; medians."""
    scene = slipwave.read("paper-2.6")
    ends: dict[str, Final] = {}

    def march(name: str, setting: Setting) -> None:
        ends[name] = follow(solver_of(setting, scene), _UNTIL)

    for setting in SETTINGS:
        warm_up(setting, scene)
    settings = {_in_words(setting): setting for setting in SETTINGS}
    works = {name: partial(partial, march, name, setting) for name, setting in settings.items()}
    theirs: list[list[Entrant]] = []
    ours: list[dict[str, float]] = []
    for _ in range(_ROUNDS):
        theirs += [_rival(yardstick)] if yardstick else []
        ours += in_turn(works, _EACH)
    rivals = [case[0]._replace(ms=median(run.ms for run in case)) for case in zip(*theirs, strict=True)]
    return rivals + [
        Entrant(setting.time or setting.model, name, abs(ends[name].psi - PSI), 1e3 * median(times[name] for times in ours))
        for name, setting in settings.items()
    ]


def _in_words(setting: Setting) -> str:
    return f"{setting.model}, {setting.words}".replace("10^{", "1e").replace("}", "")


def _rival(program: Path) -> list[Entrant]:
    """The lines of another program, which sees processor time on its clock."""
    command = [sys.executable, "-c", _BY_PROCESSOR, str(program), str(program.parent)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    cases = [json.loads(line) for line in printed.splitlines()]
    words = [", ".join(f"{name} {value:g}" for name, value in case.items() if name not in ("error", "ms")) for case in cases]
    return [Entrant(program.stem, name, case["error"], case["ms"]) for name, case in zip(words, cases, strict=True)]


def ratios(found: Sequence[Entrant], rivals: str) -> Iterator[tuple[str, str]]:
    """Which times are compared, and their ratio."""
    exact = {error: fastest(found, "exact", error) for error in (1e-9, 1e-11)}
    for kind, error in ((rivals, 1e-9), ("explicit", 1e-9), ("fd", 1e-5)):
        yield f"{kind} to {error:g} over exact to 1e-9", _over(fastest(found, kind, error), exact[1e-9])
    yield "exact to 1e-11 over exact to 1e-9", _over(exact[1e-11], exact[1e-9])
    for error, march in exact.items():
        yield f"exact over delay, both to {error:g}", _over(march, fastest(found, "delay", error))


def fastest(found: Sequence[Entrant], kind: str, error: float) -> Entrant | None:
    """The fastest of its kind with an error of psi(600) of at most `error`."""
    able = [entrant for entrant in found if entrant.kind == kind and entrant.error <= error]
    return min(able, key=lambda entrant: entrant.ms, default=None)


def _over(first: Entrant | None, second: Entrant | None) -> str:
    return f"{first.ms / second.ms:.2f}" if first and second else "-"


def main(yardstick: Path | None) -> None:
    """Run all, print the table and the ratios."""
    found = timed_in_turn(yardstick)
    rows = [[f"{entrant.kind}: {entrant.what}", f"{entrant.error:.1e}", f"{entrant.ms:.1f}"] for entrant in found]
    print_table(["march", "error of psi(600)", "ms"], rows)
    print()
    compared = ratios(found, yardstick.stem if yardstick else "another program")
    print_table(["ratio of times", "measured"], [list(row) for row in compared])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--yardstick", type=Path, metavar="PROGRAM.py")
    main(parser.parse_args().yardstick)

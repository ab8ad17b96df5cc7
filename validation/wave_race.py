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
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import slipwave
from validation.results.result import aligned
from validation.timing import Setting, time_final

PSI = -2.8174018894888
"""psi(600) by the delay system at three resolutions, and by another program."""

_EXACT, _EXPLICIT = Setting("dg:8", cells=4, time="exact"), Setting("dg:8", cells=4, time="explicit")
SETTINGS = (
    *(Setting("delay", tolerance=tolerance) for tolerance in (1e-8, 1e-9, 1e-11)),
    *(replace(_EXACT, tolerance=1e-9), replace(_EXACT, model="dg:24", cells=1, tolerance=3e-9)),
    *(replace(_EXACT, model=model, cells=2, tolerance=1e-10) for model in ("dg:16", "dg:20")),
    *(_EXACT, _EXPLICIT, replace(_EXPLICIT, model="dg:16", cells=2)),
    *(Setting("fd", cells=cells) for cells in (64, 256)),
)
"""The delay system; exact marches with errors of 1e-9 and of 1e-11, and with the steps of the default; explicit; leapfrog."""

_COMPARED = (
    ("rival", 1e-9, "exact", 1e-9),
    ("explicit", 1e-9, "exact", 1e-9),
    ("fd", 1e-5, "exact", 1e-9),
    ("exact", 1e-11, "exact", 1e-9),
    ("exact", 1e-9, "delay", 1e-9),
    ("exact", 1e-11, "delay", 1e-11),
)
"""Ratios of times: kind and largest error of the one, kind and largest error of the other."""

_BY_PROCESSOR = (
    "import runpy, sys, time; time.perf_counter = time.process_time; sys.path.insert(0, sys.argv[2]); "
    "runpy.run_path(sys.argv[1], run_name='__main__')"
)
_UNTIL = 600.0
_REPEATS = 5


class Entrant(NamedTuple):
    """A program at a setting: its `kind` (delay, exact, explicit, fd or rival), its description, its error and its time in ms."""

    kind: str
    what: str
    error: float
    ms: float


def raced(yardstick: Path | None, settings: Sequence[Setting] = SETTINGS, repeats: int = _REPEATS) -> list[Entrant]:
    """The other program and every setting, each the fastest of its runs."""
    scene = slipwave.read("paper-2.6")
    runs = [run_program(yardstick) for _ in range(repeats)] if yardstick else []
    rivals = [min(case, key=lambda one: one.ms) for case in zip(*runs, strict=True)]
    ours = [(one, *time_final(one, scene, _UNTIL, repeats)) for one in settings]
    return rivals + [Entrant(one.time or one.model, _in_words(one), abs(psi - PSI), 1e3 * spent) for one, spent, psi in ours]


def _in_words(setting: Setting) -> str:
    name = setting.time or setting.model
    return f"{name}: {setting.model}, {setting.words}".replace("10^{", "1e").replace("}", "")


def run_program(program: Path) -> list[Entrant]:
    """The lines of another program, which sees processor time on its clock."""
    command = [sys.executable, "-c", _BY_PROCESSOR, str(program), str(program.parent)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    cases = [json.loads(line) for line in printed.splitlines()]
    words = [", ".join(f"{name} {value:g}" for name, value in case.items() if name not in ("error", "ms")) for case in cases]
    return [
        Entrant("rival", f"{program.stem}: {name}", case["error"], case["ms"]) for name, case in zip(words, cases, strict=True)
    ]


def race_ratios(found: Sequence[Entrant]) -> Iterator[tuple[str, str]]:
    """The ratios of times of `_COMPARED`; a dash where nothing reached the error."""
    for kind, error, other, its_error in _COMPARED:
        first, second = fastest(found, kind, error), fastest(found, other, its_error)
        yield f"{kind} to {error:g} over {other} to {its_error:g}", f"{first.ms / second.ms:.2f}" if first and second else "-"


def fastest(found: Sequence[Entrant], kind: str, error: float) -> Entrant | None:
    """The fastest of its kind with an error of psi(600) of at most `error`."""
    able = [entrant for entrant in found if entrant.kind == kind and entrant.error <= error]
    return min(able, key=lambda entrant: entrant.ms, default=None)


def main(found: Sequence[Entrant]) -> None:
    """Print the table and the ratios."""
    print(
        "\n".join(
            aligned(["march", "error of psi(600)", "ms"], [[one.what, f"{one.error:.1e}", f"{one.ms:.1f}"] for one in found])
        )
    )
    print()
    print("\n".join(aligned(["ratio of times", "measured"], [list(row) for row in race_ratios(found)])))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--yardstick", type=Path, metavar="PROGRAM.py")
    main(raced(parser.parse_args().yardstick))

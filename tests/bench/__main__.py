"""`make bench`: processor times, all in turn; medians over rounds with quartiles. Nothing is judged.

python -m tests.bench                           # some minutes
python -m tests.bench --yardstick PROGRAM.py    # full waves against another program, timed in the same rounds

First the error of psi(600) and the time of full waves and the delay system, after a nudge at log10 r = -2.6. PROGRAM prints one
JSON object a line, with the `error` of its psi(600) and the time in `ms` by `time.perf_counter`. Then ratios of two times each,
times of whole commands, and the reductions beside general integrators (`tests.bench.peers`).
"""

import argparse
import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import slipwave as sw
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.envelope import Envelope
from slipwave.observe.protocol import ProtocolObserver
from slipwave.scene import Scene
from slipwave.scene.drive import Start, StartKind
from slipwave.scene.slab import KelvinVoigtViscosity
from slipwave.solve import follow
from tests.bench.peers import LABORATORY, PEER_HEADS, table_of_peers
from tests.granite import GRANITE, SAMPLE
from validation.commands.result import aligned
from validation.models.build import build
from validation.models.by_name import Options
from validation.models.timing import Work, alternating, in_turn, marching, quartiles

PSI = -2.8174018894888
"""psi(600) by the delay system at three resolutions, and by another program."""


class Setting(NamedTuple):
    """A model with its numerical options; `None` leaves one to the model."""

    model: str
    tolerance: float | None = None
    cells: int | None = None
    time: str | None = None

    @property
    def options(self) -> Options:
        return Options(tolerance=self.tolerance, cells=self.cells, time=self.time)

    @property
    def words(self) -> str:
        """The model and its options, as a table names them."""
        words = [f"{self.cells} cells"] if self.cells else []
        words += [f"{self.time} in time"] if self.time else []
        words += [f"tolerance 1e{math.log10(self.tolerance):.2g}"] if self.tolerance else []
        return ", ".join([self.model, *words])


_EXACT, _EXPLICIT = Setting("dg:8", cells=4, time="exact"), Setting("dg:8", cells=4, time="explicit")
SETTINGS = (
    *(Setting("delay", tolerance=tolerance) for tolerance in (1e-8, 1e-9, 1e-11)),
    *(_EXACT._replace(tolerance=1e-9), _EXACT._replace(model="dg:24", cells=1, tolerance=3e-9)),
    *(_EXACT._replace(model=model, cells=2, tolerance=1e-10) for model in ("dg:16", "dg:20")),
    *(_EXACT, _EXPLICIT, _EXPLICIT._replace(model="dg:16", cells=2)),
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


class Entrant(NamedTuple):
    """A program at a setting: its `kind` (delay, exact, explicit, fd or rival), description, error, and times (ms) by rounds."""

    kind: str
    what: str
    error: float
    ms: tuple[float, ...]


def full_waves(yardstick: Path | None, rounds: int, settings: Sequence[Setting] = SETTINGS) -> list[Entrant]:
    """The other program and every setting, in turn; a round before that loads the compiled code."""
    scene = sw.read("paper-2.6")
    works = {one: _whole(lambda one=one: follow(build(one.model, scene, **one.options), 600.0)) for one in settings}
    found: dict[Any, list[Entrant]] = {}
    for number in range(rounds + 1):
        done = [(one, _entrant(one, final.psi, seconds)) for one, seconds, final in alternating(works, 1)]
        rivals = run_program(yardstick) if yardstick and number else []
        for name, entrant in (*((one.what, one) for one in rivals), *(done if number else ())):
            found.setdefault(name, []).append(entrant)
    return [each[0]._replace(ms=tuple(one.ms[0] for one in each)) for each in found.values()]


def _entrant(setting: Setting, psi: float, seconds: float) -> Entrant:
    kind = setting.time or setting.model
    return Entrant(kind, f"{kind}: {setting.words}", abs(psi - PSI), (1e3 * seconds,))


def run_program(program: Path) -> list[Entrant]:
    """The lines of another program, which sees processor time on its clock."""
    command = [sys.executable, "-c", _BY_PROCESSOR, str(program), str(program.parent)]
    cases = map(json.loads, subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines())
    facts = [(case.pop("error"), case.pop("ms"), case) for case in cases]
    words = (", ".join(f"{name} {value:g}" for name, value in case.items()) for _, _, case in facts)
    return [Entrant("rival", f"{program.stem}: {text}", error, (ms,)) for text, (error, ms, _) in zip(words, facts, strict=True)]


def wave_ratios(found: Sequence[Entrant]) -> Iterator[tuple[str, str]]:
    """The ratios of times of `_COMPARED`; a dash where nothing reached the error."""
    for kind, error, other, its_error in _COMPARED:
        first, second = fastest(found, kind, error), fastest(found, other, its_error)
        yield f"{kind} to {error:g} over {other} to {its_error:g}", _ratio(first.ms, second.ms) if first and second else "-"


def fastest(found: Sequence[Entrant], kind: str, error: float) -> Entrant | None:
    """The fastest of its kind with an error of psi(600) of at most `error`."""
    able = [entrant for entrant in found if entrant.kind == kind and entrant.error <= error]
    return min(able, key=lambda entrant: quartiles(entrant.ms)[1], default=None)


def _ratio(first: Sequence[float], second: Sequence[float]) -> str:
    low, median, high = quartiles(one / other for one, other in zip(first, second, strict=True))
    return f"{median:.2f} ({low:.2f} to {high:.2f})"


def pairs() -> Mapping[str, tuple[Work[Any], Work[Any]]]:
    """Two works whose times are compared, by what their ratio is called."""
    paper = sw.read("paper")
    upper, lower = (replace(paper.upper, epsilon=share * paper.upper.epsilon) for share in (2.0 / 3.0, 2.0))
    pair, unlike = (replace(paper, upper=upper, lower=replace(lower, round_trip=r * paper.transit)) for r in (1.0, 2.0))
    irrational = replace(paper, lower=replace(paper.lower, round_trip=math.sqrt(2.0) * paper.lower.round_trip))
    slab = replace(paper.upper, viscosity=KelvinVoigtViscosity(0.05 * paper.upper.round_trip))
    delay = Setting("delay", tolerance=1e-9)

    def run(setting: Setting, scene: Scene, transits: float) -> Work[Any]:
        return marching(setting.model, scene, transits, 1.0, **setting.options)

    alike, once = run(delay, paper, 200.0), run(_EXACT, paper, 200.0)
    found: dict[str, tuple[Work[Any], Work[Any]]] = {
        "delay: slabs of one pair over alike": (run(delay, pair, 200.0), alike),
        "delay: round trips 1 : 2 over alike": (run(delay, unlike, 200.0), alike),
        "delay: irrational round trips over alike": (run(delay, irrational, 200.0), alike),
        "delay: irrational round trips over alike, after a jump": (
            run(delay, _jumped(irrational), 200.0),
            run(delay, _jumped(paper), 200.0),
        ),
        "delay: every transit of granite over leaps": (partial(_granite, True), partial(_granite, False)),
        "dg:8: time of the delay system": (once, alike),
        "dg:8: unlike slabs over alike": (run(_EXACT, pair, 200.0), once),
        "dg:8: Kelvin-Voigt over elastic": (run(_EXACT, replace(paper, upper=slab, lower=slab), 200.0), once),
        "slipwave --help over bare Python": (_process("-m", "slipwave", "--help"), _process("-c", "")),
    }
    for model in ("block12", "kelvin-voigt", "modal:8"):
        reduced = run(Setting(model, tolerance=1e-9), paper, 1000.0)
        found[f"{model}: time of the delay system"] = reduced, run(delay, paper, 1000.0)
    for model in ("delay", "kelvin-voigt"):
        orbit, coarse = (_whole(sw.orbit, paper, model, tol=tol) for tol in (1e-10, 1e-6))
        branch = _whole(sw.branch, paper, "log10_r=-2.72:-2.3", model, most_points=10)
        found[f"{model}: orbit to 1e-10 over a run of 1000 transits"] = orbit, run(Setting(model), paper, 1000.0)
        found[f"{model}: branch of ten points over an orbit"] = branch, coarse
    return found


def _jumped(scene: Scene) -> Scene:
    return replace(scene, start=Start(StartKind.JUMP))


def _whole(function: Any, *given: Any, **named: Any) -> Work[Any]:
    """The work of one call, timed as a whole."""
    return lambda: partial(function, *given, **named)


def _process(*words: str) -> Work[Any]:
    return _whole(subprocess.run, [sys.executable, *words], check=True, capture_output=True)


def _granite(every: bool) -> Any:
    """Two cycles of granite slabs of 10 m at 1 um/s, 1.6e5 transits; `every` one of them marched, or sticks leapt over."""
    scene = sw.read(GRANITE)
    solver = build("delay", scene, tolerance=1e-6)
    follow(solver, 1.0)
    needs_all = [HistoryObserver(scene.law, solver.nodes, start=math.inf)] if every else []
    return partial(follow, solver, 1.6e5, [EventObserver(scene, solver.nodes), *needs_all])


def measured(works: tuple[Work[Any], Work[Any]], rounds: int) -> str:
    """The ratio of the times of two works, after a round that loads the compiled code."""
    times = in_turn(dict(enumerate(works)), rounds + 1)[1:]
    return _ratio([each[0] for each in times], [each[1] for each in times])


_POINTS = 50


class Timed(NamedTuple):
    """A work, and the factor from its seconds to the unit in its name."""

    work: Work[Any]
    scale: float


class _Here(Executor):
    def submit(self, work: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result(work(*given, **named))
        return done


def works() -> Mapping[str, Timed]:
    """What is timed, by its name with a unit."""
    laboratory = {name: sw.read(scene) for name, scene in LABORATORY.items()}
    found = {f"run {name}, quasidynamic (ms)": _call(sw.run, one, model="quasidynamic") for name, one in laboratory.items()}
    steps, sample = laboratory["velocity-steps"], sw.read(SAMPLE)
    found["compare velocity-steps, quasidynamic with quasistatic (ms)"] = _call(sw.compare, steps, "quasidynamic,quasistatic")
    found["compare steel-on-pmma with a record, quasidynamic (ms)"] = Timed(_beside_a_record, 1e3)
    found["bench paper, 2600 transits (s)"] = _call(sw.bench, "paper", until=2600.0)._replace(scale=1.0)
    found["a point of a sweep, block12, 1000 transits (ms)"] = Timed(lambda: _sweep, 1e3 / _POINTS)
    found["its march (ms)"] = Timed(marching("block12", sw.read("paper"), 1000.0), 1e3)
    found["slipwave run paper, a process (ms)"] = Timed(_process("-m", "slipwave", "run", "paper", "--json"), 1e3)
    second = sample.until / 50.0 if sample.until else 0.0
    found["delay, lab-1mm, a second of motion (s)"] = Timed(marching("delay", sample, second), 1.0)
    return found | dict(_observers(sw.read("paper"), 20_000.0)) | dict(_observers(sw.read("velocity-steps"), 60_000.0))


def _call(function: Any, *given: Any, **named: Any) -> Timed:
    return Timed(_whole(function, *given, **named), 1e3)


def _beside_a_record() -> Callable[[], Any]:
    """A comparison with the record of a run, which is written before."""
    scene, until, folder = "steel-on-pmma", 90_000.0, TemporaryDirectory()
    record = Path(folder.name) / "record.csv"
    sw.run(scene, "quasidynamic", until=until, rate="10kHz").write_series(record)

    def compared() -> None:
        with folder:
            sw.compare(scene, "quasidynamic", data=record, until=until)

    return compared


def _sweep() -> None:
    with TemporaryDirectory() as folder:
        vary = {"log10_r": (-2.72, -2.6, _POINTS)}
        sw.sweep("paper", vary=vary, models="block12", until=1000.0, out=Path(folder) / "sweep", executor=_Here())


def _observers(scene: Scene, until: float) -> Iterator[tuple[str, Timed]]:
    """The march by the delay system and what watches it, for each of its pieces."""
    solver = build("delay", scene)
    kept = HistoryObserver(scene.law, solver.nodes)
    follow(solver, until, [kept])
    pieces, each = kept.pieces(), 1e9 / kept.pieces().time.size
    march = partial(partial, follow, leaps=False)
    yield f"{scene.name}, delay: the march, a piece (ns)", Timed(lambda: march(build("delay", scene), until), each)
    observers: dict[str, Callable[[], Any]] = {
        "events": lambda: EventObserver(scene, solver.nodes),
        "envelope": lambda: Envelope(scene, solver.nodes),
    }
    if not scene.drive.is_constant:
        observers["protocol"] = lambda: ProtocolObserver(scene, solver.nodes, until)
    for name, made in observers.items():
        yield f"{scene.name}, delay: {name}, a piece (ns)", Timed(lambda made=made: partial(made().scan, pieces), each)  # type: ignore[misc]


def table_of_times(rounds: int, wanted: Mapping[str, Timed] | None = None) -> list[list[str]]:
    """Name, median and quartiles of each work, after a round that loads the compiled code."""
    named = works() if wanted is None else wanted
    taken = in_turn({name: timed.work for name, timed in named.items()}, rounds + 1)[1:]
    found = {name: quartiles(timed.scale * each[name] for each in taken) for name, timed in named.items()}
    return [[name, f"{median:.3g}", f"{low:.3g} to {high:.3g}"] for name, (low, median, high) in found.items()]


def main(found: Sequence[Entrant], named: Mapping[str, tuple[Work[Any], Work[Any]]], rounds: int) -> None:
    """Print the full waves, their ratios and those of the `named` pairs."""
    rows = [(one, quartiles(one.ms)) for one in found]
    table = [[one.what, f"{one.error:.1e}", f"{median:.1f}", f"{low:.1f} to {high:.1f}"] for one, (low, median, high) in rows]
    print("\n".join(aligned(["march", "error of psi(600)", "ms", "quartiles"], table)))
    print()
    ratios = [*wave_ratios(found), *((name, measured(works, rounds)) for name, works in named.items())]
    print("\n".join(aligned(["ratio of times", "measured"], [list(row) for row in ratios])))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description="Run times; nothing is judged.")
    parser.add_argument("--yardstick", type=Path, metavar="PROGRAM.py")
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="default: 5")
    options = parser.parse_args()
    main(full_waves(options.yardstick, options.rounds), pairs(), options.rounds)
    print("\n" + "\n".join(aligned(["work", "median", "quartiles"], table_of_times(options.rounds))))
    print("\n" + "\n".join(aligned(PEER_HEADS, table_of_peers(options.rounds))))

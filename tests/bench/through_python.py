"""Times of whole commands and of their parts, in a warm process: what a user waits for beside the march."""

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import slipwave as sw
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.envelope import Envelope
from slipwave.observe.protocol import ProtocolObserver
from slipwave.scene import Scene
from slipwave.solve import follow
from tests.bench.peers import LABORATORY
from tests.granite import SAMPLE
from validation.models.build import build
from validation.models.timing import March, Work, in_turn, quartiles

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
    found["its march (ms)"] = Timed(March("block12", sw.read("paper"), 1000.0), 1e3)
    command = [sys.executable, "-m", "slipwave", "run", "paper", "--json"]
    found["slipwave run paper, a process (ms)"] = _call(subprocess.run, command, check=True, capture_output=True)
    second = sample.until / 50.0 if sample.until else 0.0
    found["delay, lab-1mm, a second of motion (s)"] = Timed(March("delay", sample, second), 1.0)
    return found | dict(_observers(sw.read("paper"), 20_000.0)) | dict(_observers(sw.read("velocity-steps"), 60_000.0))


def _call(function: Any, *given: Any, **named: Any) -> Timed:
    return Timed(lambda: partial(function, *given, **named), 1e3)


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
    found = {name: [timed.scale * one for one in quartiles(each[name] for each in taken)] for name, timed in named.items()}
    return [[name, f"{median:.3g}", f"{low:.3g} to {high:.3g}"] for name, (low, median, high) in found.items()]

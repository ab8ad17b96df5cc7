"""Chunks of compiled work that end soon and leave no trace in the numbers; grids too big for the memory, refused before any is
taken."""

import dataclasses
import resource
import signal
import subprocess
import sys
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from leapfrog_scenes import PAPER, SCENES
from march_scenes import FAMILIES

import fullwave.lines.explicit
import fullwave.lines.march
import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.lines import budget
from fullwave.summation_by_parts import SummationByParts
from slipwave.errors import SceneError
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.solve import follow
from slipwave.step.port_march import CHUNK
from tests.compiled_work import count_calls

ENDLESS = """
import sys
import fullwave.lines.explicit
import fullwave.lines.march
from validation.cli import main

march = fullwave.lines.explicit.march


def telling(*arguments):
    print("begun", flush=True)
    return march(*arguments)


fullwave.lines.explicit.march = telling
sys.exit(main(["run", "paper", "--model", "dg:24", "--cells", "10000", "--until", "1e9", "--yes"]))
"""
SMALL = {**FAMILIES, "fd": partial(Leapfrog, cells=16, cfl=0.9)}


def outcome(solver, until):
    events, history = EventObserver(solver.scene, solver.nodes), HistoryObserver(solver.scene.law, solver.nodes)
    final = follow(solver, until, [events, history])
    parts = [*solver.state().values(), *events.state().values(), *history.columns().values()]
    return [array.tobytes() for array in parts], final, solver.failures, solver.time


def allow_at_once(steps, monkeypatch):
    """Solvers built from here on leave compiled code after so many steps."""
    for march in (fullwave.lines.explicit, fullwave.finite_difference):
        monkeypatch.setattr(march, "steps_at_once", lambda work: steps)


@pytest.mark.parametrize("name", ["grip", "unlike", "standard-linear"])
@pytest.mark.parametrize("family", SMALL)
def test_no_bit_depends_on_the_length_of_a_chunk(family, name, monkeypatch):
    whole = outcome(SMALL[family](SCENES[name]), 30.0)
    for stride in (1, 3, 8, 29, 80):
        allow_at_once(stride, monkeypatch)
        assert outcome(SMALL[family](SCENES[name]), 30.0) == whole, stride


def test_failures_are_counted_once_whatever_the_chunks(monkeypatch):
    """A solve that fails at the sample two chunks share is one failure."""
    counts = []
    for stride in (10**6, 5):
        allow_at_once(stride, monkeypatch)
        solver = DiscontinuousGalerkin(PAPER, number=3, cells=2, time="explicit")
        solver.impose(0, lambda x: np.nan * x, lambda x: 0.0 * x)  # nothing converges from here on
        with np.errstate(all="ignore"):
            while solver.time < 5.0:
                solver.advance(5.0)
        counts.append(solver.failures)
    assert counts[0] == counts[1] > 0


@pytest.mark.parametrize(
    ("kind", "options", "products"),
    [
        (DiscontinuousGalerkin, {"number": 24, "cells": 20_000}, 12 * (25 + 6)),
        (SummationByParts, {"number": 6, "cells": 200_000}, 12 * (7 + 6)),
        (FiniteElement, {"number": 4, "cells": 20_000}, 12 * (5 + 6)),
        (Leapfrog, {"cells": 1_000_000}, 10),
    ],
)
def test_a_big_grid_leaves_compiled_code_soon(kind, options, products, monkeypatch):
    """`products` a value and step: in each of 12 stages, the operator's row and half of the stages before. 4e8 of them take less
    than a second on the slowest of the machines measured."""
    calls = count_calls(monkeypatch)
    solver = kind(PAPER, **options)
    solver.advance(1e6)
    assert sum(call.steps for call in calls) >= 4
    assert max(call.steps * call.values * products for call in calls) < 4.3e8


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (DiscontinuousGalerkin, {"number": 24}),
        (FiniteElement, {"number": 16}),
        (FiniteElement, {"number": 16, "mass": "consistent"}),
    ],
)
def test_a_grid_beyond_the_memory_is_refused_at_once(kind, options, monkeypatch):
    """Before more of it is built than the few cells by which it is judged."""
    built = []
    grid_of = kind.grid_of

    def counted(solver, some):
        built.append(sum(section.cells for section in some))
        return grid_of(solver, some)

    monkeypatch.setattr(kind, "grid_of", counted)
    monkeypatch.setattr(fullwave.lines.march, "assemble", lambda *arguments: pytest.fail("was assembled"))
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(SceneError, match=r"cells = 1000000: would take .* GB of memory, .* at most some \d+ fit"):
        kind(PAPER, cells=1_000_000, **options)
    assert 0 < max(built) <= 32
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - used < 100_000


@pytest.mark.parametrize(("kind", "options"), [(DiscontinuousGalerkin, {"number": 6}), (FiniteElement, {"number": 3})])
def test_memory_told_is_that_of_so_many_cells(kind, options, monkeypatch):
    """Of the cells that are not probed too: what 5000 take is what 3000 take and, in proportion, the 2000 between."""
    told = {}
    monkeypatch.setattr(budget, "require_bytes", lambda cells, needed: told.update({cells: needed}))
    monkeypatch.setattr(fullwave.lines.march, "assemble", lambda *arguments: pytest.fail("was assembled"))
    built = {}
    bytes_of = budget._bytes
    monkeypatch.setattr(
        budget, "_bytes", lambda grid, *rest: built.setdefault(grid.blocks[0].section.cells, bytes_of(grid, *rest))
    )
    with pytest.raises(pytest.fail.Exception):
        kind(PAPER, cells=5000, **options)
    few, more = sorted(built)
    assert told[5000] == pytest.approx(5000.0 * (built[more] - built[few]) / (more - few), rel=1e-12)


def test_the_other_slab_counts_too():
    """Cells are those of the faster slab; a slower one takes many more."""
    slow = dataclasses.replace(PAPER.upper, round_trip=3000.0 * PAPER.upper.round_trip)
    unlike = dataclasses.replace(PAPER, lower=slow)
    for kind in (SummationByParts, DiscontinuousGalerkin):
        with pytest.raises(SceneError, match=r"cells = 10000: would take .* GB"):
            kind(unlike, cells=10_000)


def test_memory_that_is_not_there_is_one_line(monkeypatch):
    def full(*arguments):
        raise MemoryError

    monkeypatch.setattr(fullwave.lines.march, "assemble", full)
    with pytest.raises(SceneError, match="cells = 9: not enough memory on this machine"):
        DiscontinuousGalerkin(PAPER, cells=9)
    monkeypatch.setattr(fullwave.finite_difference, "steady_side", full)
    with pytest.raises(SceneError, match="cells = 9: not enough memory on this machine"):
        Leapfrog(PAPER, cells=9)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (DiscontinuousGalerkin, {"number": 7, "cells": 5000}),
        (FiniteElement, {"number": 8, "cells": 3000}),
        (SummationByParts, {"number": 6, "cells": 100_000}),
    ],
)
def test_the_count_is_about_what_is_taken(kind, options, monkeypatch):
    """tracemalloc would not see what scipy's C++ takes for itself; what it sees must be covered."""
    import tracemalloc

    counted = []
    kind(PAPER)
    monkeypatch.setattr("fullwave.lines.budget.require_bytes", lambda cells, needed: counted.append(needed))
    tracemalloc.start()
    kind(PAPER, **options)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 0.6 * peak < counted[0] < 2.0 * peak


@pytest.mark.parametrize(("viscous", "copies", "blocks"), [(False, 12 + 2, 1), (True, 2 * (12 + 2) + 6, 2)])
def test_what_a_march_takes_is_counted(viscous, copies, blocks):
    """State of 1000 values: 12 stages and two more, twice over with memory variables and six arrays of the medium's own."""
    operator = np.zeros(50)
    grid = SimpleNamespace(size=1000, blocks=[(np.zeros(7), "rigid")] * 3, operator=(operator,))
    assert budget._bytes(grid, 12, viscous) == 8 * 1000 * copies + blocks * 3 * (1200 + 8 * 7) + 4 * 8 * 50


def test_interrupt_ends_a_big_run():
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # whoever runs the tests may have it ignored
    with subprocess.Popen(
        [sys.executable, "-c", ENDLESS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heard
    ) as process:
        assert process.stdout.readline() == "begun\n"
        process.send_signal(signal.SIGINT)
        said = process.communicate()[1]
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith("slipwave: interrupted")


def test_paper_is_far_below_every_limit():
    paper = slipwave.read("paper")
    assert DiscontinuousGalerkin(paper)._march._most_steps == CHUNK
    assert DiscontinuousGalerkin(paper, time="explicit")._march._stride > 4096
    assert Leapfrog(slipwave.read("paper"))._stride > 4096

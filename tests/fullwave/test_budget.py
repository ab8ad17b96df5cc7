"""Chunks of compiled work that end soon; grids too big for the memory, refused before any is taken."""

import dataclasses
import resource

import pytest
from grid_scenes import PAPER

import fullwave.lines.explicit
import fullwave.lines.march
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from slipwave.errors import SceneError
from tests.compiled_work import count_calls


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
    """`products` a value and step, of 12 stages each; 4e8 of them take less than a second."""
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

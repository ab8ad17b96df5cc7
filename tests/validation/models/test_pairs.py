"""Any two abilities together: a pairwise table of scenes, each held to what must be true of every run (`pairs`)."""

from functools import cache

import pytest

from slipwave.solve import follow
from tests.reduced.test_delay import assert_same_bits
from tests.validation.pairs import KNOTS, NAMES, built, pairwise_rows, play, rows_allowed, scene_of
from validation.models.build import build

UNTIL = 40.0
CHUNK = 0.37
KINDS = {
    "constant": [],
    "ramp": ["start", "ramp", "level"],
    "hold": ["start", "hold", "slide"],
    "step after ramp": ["start", "ramp", "step"],
}
ALLOWED = rows_allowed()
ROWS = pairwise_rows(ALLOWED, 1)
WAVES = [row for row in ROWS if (":" in row[0] and row[0][:2] not in ("fi", "mo")) or row[0].startswith("fd")]
EXACT = [row for row in (*WAVES, *(row for row in ROWS if row[0] == "delay")) if "orbit" not in row]


def named(row):
    return ", ".join(row)


def each(rows, every=1):
    """A test for each row; those with an orbit that takes seconds to find are slow, and all but each `every`-th."""
    seconds = ("fitted", "dg", "sbp", "quasidynamic", "kelvin", "modal", "fd")
    slow = {row: [pytest.mark.slow] for row in rows if "orbit" in row and row[0].startswith(seconds)}
    slow |= {row: [pytest.mark.slow] for k, row in enumerate(rows) if k % every}
    return pytest.mark.parametrize("row", [pytest.param(row, id=named(row), marks=slow.get(row, [])) for row in rows])


@cache
def whole(row):
    return play(built(row), UNTIL)


def checkpoints_of(row):
    """Right at the last knot of V or, without one, anywhere; and somewhere behind it."""
    last = KNOTS[row[NAMES.index("drive")]][-1][0] or 11.0
    return [last, last + 16.1234]


def assert_same(ours, theirs):
    """To the bit, but for the number of iterations of a network, which counts steps that were tried and not taken too."""
    assert ours.text == theirs.text
    states = [one.state | {"counts": one.state["counts"][: -1 if "waves" in one.state else None]} for one in (ours, theirs)]
    assert_same_bits(*states)


@each(ROWS)
def test_chunks_and_checkpoints_change_nothing(tmp_path, row):
    straight = whole(row)
    chunked = play(built(row, straight.begun), UNTIL, tmp_path, checkpoints_of(row), chunk=CHUNK)
    assert_same(chunked, straight)
    assert [stage["kind"] for stage in straight.facts.get("protocol", [])] == KINDS[row[NAMES.index("drive")]]
    files = sorted(tmp_path.glob("*.npz"))
    assert len(files) == len(checkpoints_of(row))
    for file in files:
        assert_same(play(built(row, straight.begun), UNTIL, resume=file), straight)


@each(WAVES)
def test_the_ledger_closes(row):
    """Within rounding for the leapfrog, within what steps resolve for an exact march; measured: up to 1.2e-4 on orbits and 1e-3
    for explicit steps. Viscosity takes a little, never more than the work that is done."""
    energy, limit = whole(row).facts["energy"], 1e-12 if row[0].startswith("fd") else 3e-3 if "explicit" in row[0] else 6e-4
    assert abs(energy["residual"]) < limit
    largest = max(abs(energy[name]) for name in ("input", "friction", "stored"))
    assert ("viscous" in energy) == (row[NAMES.index("viscosity")] != "none")
    assert 0.0 <= energy.get("viscous", 0.0) < 0.1 * largest
    assert (energy["radiated"] > 0.0) == ("rigid" not in row)


@each(EXACT, every=2)
def test_two_exact_models_agree(row):
    """Friction at the end, against elements of degree 7. Measured: 1.2e-4 for the delay system where V jumps, else 2e-8;
    1.6e-4 for coarse exact grids; 5e-3 for coarse explicit ones, where an event is near."""
    witness = follow(build("dg:7", scene_of(row), cells=3, time="exact"), UNTIL)
    smooth = row[0] == "delay" and row[NAMES.index("drive")] in ("constant", "ramp")
    limit = 1e-7 if smooth else 1e-2 if "exact" not in row[0] and row[0] != "delay" else 4e-4
    assert whole(row).facts["final"]["mu"] == pytest.approx(witness.mu, abs=limit)

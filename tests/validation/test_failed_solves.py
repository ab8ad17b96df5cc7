"""A solve that did not converge ends the run with exit status 3: what came before is kept, what came after is not used."""

import json

import numpy as np
import pytest

import slipwave
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array, Pieces
from slipwave.solve import follow
from validation.cli import NUMERICS_FAILED, main
from validation.measure.settle import settle
from validation.registry.build import build

COARSE = ["--set", "slab.r=1", "--until", "40"]
"""64 cells of a leapfrog cannot follow psi through the first event of a transit of a hundred state relaxations."""

STOPPED = [
    'interface.law="slip-regularised"',
    "interface.a=0.0653",
    "interface.b=0.288",
    "drive.velocity=[[0, 4.934e4], [14.9, 4.934e4], [15, 0]]",
    'slab.face={kind="reflection", coefficient=0}',
    "slab.r=0.0104",
    "slab.epsilon=0.000412",
]
"""The drive stops, the waves are swallowed, and v goes through 0 by rounding: z = asinh(v/2e-20) leaps from 20 to -17."""


class Failing:
    """Steady sliding in pieces of one transit; the solve at t = 7.25 fails."""

    def __init__(self):
        self.scene, self.model, self.nodes = slipwave.read("paper"), "failing", np.linspace(0.0, 1.0, 5)
        self.time, self.failures, self.failed_at = 0.0, 0, np.nan
        self.seconds_per_piece, self.transits_per_piece = 0.0, np.nan

    def advance(self, until):
        begin, self.time = self.time, self.time + 5.0
        if self.time > 7.25:
            self.failures, self.failed_at = 3, 7.25
        steady = np.full((5, self.nodes.size), np.log(100.0))
        return Pieces(begin + np.arange(5.0), np.ones(5), steady, -steady, steady, steady)

    def energy(self):
        return None


class Reach:
    """Remembers how far it was fed."""

    def __init__(self):
        self.ends: Array = np.empty(0)

    def scan(self, pieces):
        self.ends = np.append(self.ends, pieces.time + pieces.length)


def test_observers_see_what_came_before_the_first_failed_solve():
    reach, solver = Reach(), Failing()
    with pytest.raises(NumericsError, match=r"failing: 3 solves .* by t = 10 transits, the first at t = 7.25.*digest"):
        follow(solver, 100.0, [reach])
    assert reach.ends.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    assert solver.time == 10.0


def test_run_prints_what_it_has_and_ends_with_status_3(tmp_path, capsys):
    assert main(["run", "paper", *COARSE, "--model", "fd", "--cells", "64", "--json"]) == NUMERICS_FAILED
    text, err = capsys.readouterr()
    result = json.loads(text)
    assert result["failures"] > 0
    assert result["final"] is None
    assert "fd: " in err
    assert err.strip().endswith(result["failed"])
    first = float(result["failed"].split("the first at t = ")[1].split(":")[0])
    assert 0.5 < first < 2.0  # rounding grows by 35 nepers a transit: the first event comes at ln(10^16)/35


def test_compare_prints_every_row_and_ends_with_status_3(tmp_path, capsys):
    out = tmp_path / "both.png"
    words = ["compare", "paper", *COARSE, "--models", "sbp:2,fd", "--cells", "64", "--out", str(out), "--json"]
    assert main(words) == NUMERICS_FAILED
    text, err = capsys.readouterr()
    rows = {row["model"]: row for row in json.loads(text)["models"]}
    assert rows["fd"]["failures"] > 0
    assert rows["fd"]["error"] == {"period": None, "stress_drop": None}
    assert "the first at t = " in rows["fd"]["failed"]
    assert rows["fd"]["failed"] in err


def test_no_orbit_is_made_of_failed_solves():
    solver = build("fd", slipwave.read("paper", ["slab.r=1"]), cells=64)
    with pytest.raises(NumericsError, match="did not converge"):
        settle(solver)


def test_the_leapfrog_comes_to_rest_with_the_others():
    """It ended at psi = -121 with two failed solves: the extrapolated start of a solve lay hundreds away from the root."""
    scene = slipwave.read("paper", STOPPED)
    ours = follow(build("fd", scene), 40.0).psi
    witness = follow(build("dg:4", scene, cells=24, time="explicit"), 20.0).psi
    assert ours == pytest.approx(witness, abs=0.3)  # both stop short of what 256 cells say by 0.08 and 0.2

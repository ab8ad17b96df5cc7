"""`slipwave verify`: a right scheme, law and scene keep every row; schemes and laws with one mistake are red where it shows."""

import json
import xml.etree.ElementTree as xml

import pytest

import slipwave as sw
from slipwave.errors import NumericsError, SceneError
from slipwave.sources import ROOT
from validation.commands.cli import NUMERICS_FAILED, main

RIGHT = """
from dataclasses import replace
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import AttackCells, FullWave, Rungs

MINE = FullWave(
    "mine:P", f"{__name__}:Mine", "my elements", numbers=range(1, 8), default=7, order_bulk=lambda p: p + 1,
    order_interface=lambda p: p + 1, cfl=0.75, cells=4, attacks={7: AttackCells(2, 4)}, ladder={7: Rungs(2, 24, 1e-9)},
)


class Mine(DiscontinuousGalerkin):
    family = MINE
"""
COEFFICIENT = """
    def grid_of(self, sections):
        grid = super().grid_of(sections)
        return replace(grid, operator=grid.operator._replace(scale=1.0001 * grid.operator.scale))
"""
STEP = """
    def elastic_limit(self):
        return 1.1 * super().elastic_limit()
"""
LAW = """
from slipwave.friction import ageing, register
from slipwave.friction.law import steady_psi


class Mine(ageing.Ageing):
    pass


def respond(law, z, psi):
    v, v_z, F, F_z, F_psi, G, G_z, G_psi = ageing.respond_ageing(law, z, psi)
    return v, v_z, F, F_z, {slope} * F_psi, G, G_z, G_psi


register("mine", Mine, respond, steady_psi)
"""


@pytest.fixture
def file(tmp_path):
    return tmp_path / "mine.py"


def missed(words, capsys):
    """Exit status and the claims that a command misses, each once."""
    status = main([*words, "--json"])
    found = json.loads(capsys.readouterr().out)
    red = [row["claim"] for row in found["rows"] if row["outcome"] == "fail"]
    assert found["missed"] == len(red)
    return status, list(dict.fromkeys(red))


ORDER = "Every full-wave family reaches its order in space in every output, from the smooth start"
AGREES = "psi converges to that of the delay system"
LIMIT = "The step limit does not move with the stiffness of friction"
CALM = "Noise stays at 0.99 of the limit, for all slabs and faces"


@pytest.mark.parametrize(
    ("mistake", "red"),
    [(COEFFICIENT, {ORDER, AGREES}), (STEP, {LIMIT, CALM})],
    ids=["a coefficient off by 1e-4", "a step limit off by 10 %"],
)
def test_a_scheme_with_one_mistake_is_red_where_it_shows(file, capsys, tmp_path, mistake, red):
    """The same scheme without one keeps all of them: `test_documented_pages`. JUnit has a case for each row."""
    file.write_text(RIGHT + mistake)
    status, found = missed(["verify", "--family", str(file), "--junit", str(tmp_path / "v.xml")], capsys)
    assert status == NUMERICS_FAILED
    assert red <= set(found)
    suite = xml.parse(tmp_path / "v.xml").getroot()
    cases = suite.findall("testcase")
    assert (suite.get("tests"), len(cases), len({case.get("name") for case in cases})) == ("17", 17, 17)
    assert int(suite.get("failures")) == len([case for case in cases if case.find("failure") is not None]) >= len(red)


def test_in_python_the_rows_come_with_the_error(file):
    file.write_text(RIGHT + COEFFICIENT)
    with pytest.raises(
        NumericsError, match=r"2 of 2 rows are missed: The energy balance closes \(mine:7, scene paper\)"
    ) as caught:
        sw.verify("paper", "mine:7", family=file)
    assert [row.outcome for row in caught.value.result.rows] == ["fail", "fail"]


def test_of_a_scene_that_jumps_the_ledger_alone_is_judged(printed):
    assert "note: its start or its drive jumps: only the ledger is judged, no order is promised" in printed("verify", "jump")


@pytest.mark.parametrize(("slope", "told"), [(1.01, "F_psi at z = "), (0.0, "F_psi at z = ")])
def test_a_law_that_registration_refuses_is_a_row(file, capsys, slope, told):
    file.write_text(LAW.format(slope=slope))
    assert main(["verify", "--law", str(file)]) == NUMERICS_FAILED
    assert told in capsys.readouterr().out


@pytest.mark.slow
def test_a_right_law_keeps_every_row(capsys):
    assert missed(["verify", "--law", str(ROOT / "examples" / "own_law.py")], capsys) == (0, [])


def test_a_law_that_the_compiler_refuses_is_a_row(file, capsys):
    """It calls a function of another module, which is not compiled."""
    file.write_text(LAW.format(slope=1.0))
    assert missed(["verify", "--law", str(file)], capsys) == (NUMERICS_FAILED, ["It compiles into the solvers"])


def test_a_file_of_reductions_alone(file):
    file.write_text('from slipwave.family import Family\nA = Family("a", f"{__name__}:a", "a")\ndef a(scene, name): pass\n')
    with pytest.raises(SceneError, match="declares no full wave"):
        sw.verify(family=file)

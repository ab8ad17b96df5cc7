"""`slipwave verify`: right schemes, laws and scenes keep every row; one mistake is red where it shows."""

import json
import math
import xml.etree.ElementTree as xml
from pathlib import Path

import pytest
import vertex_volumes

import slipwave as sw
from slipwave.errors import NumericsError, SceneError
from slipwave.friction import LAWS
from slipwave.sources import ROOT
from validation.commands.cli import NUMERICS_FAILED, main
from validation.measure.grid_ladders import LADDERS
from validation.verification.of_family import _require_day, rows_on_scene
from validation.verification.of_law import _left_after_a_step

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
HALF_AS_VISCOUS = """
    def __init__(self, scene, *rest, **more):
        slab = replace(scene.upper, viscosity=replace(scene.upper.viscosity, time=0.5 * scene.upper.viscosity.time))
        super().__init__(replace(scene, upper=slab, lower=slab), *rest, **more)
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
    assert (suite.get("tests"), len(cases), len({case.get("name") for case in cases})) == ("19", 19, 19)
    assert int(suite.get("failures")) == len([case for case in cases if case.find("failure") is not None]) >= len(red)


def test_in_python_the_rows_come_with_the_error(file):
    file.write_text(RIGHT + COEFFICIENT)
    with pytest.raises(
        NumericsError, match=r"2 of 2 rows are missed: The energy balance closes \(mine:7, scene paper\)"
    ) as caught:
        sw.verify("paper", "mine:7", family=file)
    assert [row.outcome for row in caught.value.result.rows] == ["fail", "fail"]


def test_the_heat_of_viscosity_may_have_an_error_of_either_sign():
    """On 8 cells it is 2.2e-9 of the work too small; that falls with the grid, and was taken for a gain."""
    balance, _ = sw.verify("viscous", "fem:1").rows
    assert (balance.outcome, balance.found) == ("pass", None)


def test_of_a_scene_that_no_grid_can_start_nothing_is_said_to_be_missed():
    with pytest.raises(SceneError, match=r"^start.kind = 'orbit': needs a constant drive.velocity"):
        sw.verify("ramp", set={"start.kind": "orbit"})


def test_a_scene_whose_rows_take_days_is_refused_before_they_begin(caplog):
    """Steps as short as a stiff face needs; before, nothing was said."""
    face = {"kind": "machine", "impedance": 0.0, "mass": 0.0}
    with pytest.raises(
        SceneError, match=r"scene 'paper': explicit steps as short as 4.8e-09 transits .* take about 14.2 days: use"
    ):
        next(rows_on_scene("dg:7", sw.read("paper", {"slab.face": face | {"stiffness": 1e9}})))
    with caplog.at_level("INFO", "slipwave"):
        _require_day("dg:7", sw.read("paper", {"slab.face": face | {"stiffness": 1e6}}), [2, 3, 4, 6, 9, 14])
    assert caplog.messages[-1].endswith("explicit steps as short as 4.8e-06 transits make its rows take about 20 minutes")


def test_where_runs_fail_an_order_is_not_decided():
    """Slabs of 380 critical thicknesses: explicit steps resolve no slip event on any grid but the coarsest, which has none."""
    rows = sw.verify("layered", r=1.0).summary["rows"]
    assert [row["outcome"] for row in rows] == ["not decided", "not decided"]
    assert all("the run fails on 5 of 6 grids: dg:7: before t = " in row["remark"] for row in rows)


def test_a_row_says_what_holds():
    """From two errors above 1e-8 the order was 6.0 +- 5.4; that the finest is below is why the row holds."""
    assert sw.verify("unlike", "fem:2").summary["rows"][1]["found"].startswith("3.8e-10")


def test_of_a_scene_that_jumps_the_ledger_alone_is_judged(printed):
    assert "note: psi is compared after a nudge at constant V only: here the ledger alone is judged" in printed("verify", "jump")


@pytest.mark.parametrize("slope", [1.01, 0.0])
def test_a_law_that_registration_refuses_is_a_row(file, capsys, slope):
    file.write_text(LAW.format(slope=slope))
    assert main(["verify", "--law", str(file)]) == NUMERICS_FAILED
    assert "F_psi at z = " in capsys.readouterr().out


def test_a_viscosity_of_half_the_time_is_red(file, capsys):
    """Before, the reference in viscous slabs was a finer grid of the same family, with the same mistake."""
    file.write_text(RIGHT + HALF_AS_VISCOUS)
    words = ["verify", "viscous", "--family", str(file), "--model", "mine:7"]
    assert missed(words, capsys) == (NUMERICS_FAILED, ["psi converges to that of dg:7"])


def test_a_mistake_that_shows_at_the_scene_is_a_row(file, capsys):
    """Registration takes b = 0.03; nothing is marched with it."""
    file.write_text(LAW.format(slope="(0.97 + law.b)"))
    rows = ["Its derivatives are those of differences", "It passes the check of registration at the scene’s V"]
    assert missed(["verify", "--law", str(file)], capsys) == (NUMERICS_FAILED, rows)


def test_the_state_of_a_law_without_one_stays():
    """Before, a division by zero: its steady state is the same at all rates."""

    def back(law, z, psi):
        v = math.exp(z)
        return v, v, 0.5 + 0.02 * z, 0.02, 0.0, -psi, 0.0, -1.0

    law = LAWS["ageing"]._replace(respond=back, steady_state=lambda law, v: 0.0)
    assert _left_after_a_step(law, None) == 0.0


@pytest.mark.slow
def test_a_right_law_keeps_every_row(capsys):
    assert missed(["verify", "--law", str(ROOT / "examples" / "own_law.py")], capsys) == (0, [])


def test_a_law_that_the_compiler_refuses_is_a_row(file, capsys):
    """It calls a function of another module, which is not compiled."""
    file.write_text(LAW.format(slope=1.0))
    assert missed(["verify", "--law", str(file)], capsys) == (NUMERICS_FAILED, ["It compiles into the solvers"])


def test_a_law_with_other_parameters_than_those_of_the_scene_is_judged(file, capsys):
    """Before, it was refused: `interface.a_star` of the scene paper was an unknown key. It is not compiled, as above."""
    fields = "NamedTuple):\n    mu: float\n    direct: float\n    own: float"
    text = LAW.format(slope=1.0).replace("ageing.Ageing):\n    pass", fields)
    file.write_text("from typing import NamedTuple" + text.replace("respond_ageing(law,", "respond_ageing(ageing.Ageing(*law),"))
    values = ["--set", "interface.mu=0.4", "--set", "interface.direct=0.03", "--set", "interface.own=0.05"]
    assert missed(["verify", "--law", str(file), *values], capsys) == (NUMERICS_FAILED, ["It compiles into the solvers"])


def test_what_no_row_would_use_is_refused(file):
    with pytest.raises(SceneError, match="V = 50: leave it out; without SCENE a scheme is judged"):
        sw.verify(model="sbp:6", V=50)
    with pytest.raises(SceneError, match=r"^model: leave it out; the rows of a law"):
        sw.verify(law=ROOT / "examples" / "own_law.py", model="sbp:6")
    file.write_text(RIGHT)
    with pytest.raises(SceneError, match=r"^model: missing; must name the member of family"):
        sw.verify("paper", family=file)


def test_a_file_of_reductions_alone(file):
    file.write_text('from slipwave.family import Family\nA = Family("a", f"{__name__}:a", "a")\ndef a(scene, name): pass\n')
    with pytest.raises(SceneError, match="declares no full wave"):
        sw.verify(family=file)


SOURCE = Path(vertex_volumes.__file__).read_text(encoding="utf-8")
MISTAKES = {
    "a derivative 1 % off": ("0.5 * scale", "0.505 * scale", "psi"),
    "a derivative 1e-4 off": ("0.5 * scale", "0.50005 * scale", "psi"),
    "half a penalty": ("(2 / h, 2 / h)", "(1 / h, 1 / h)", "Noise at the grid scale"),
    "a lift of 1.01": ("(2 / h, 2 / h)", "(2.02 / h, 2 / h)", "The energy balance"),
    "the wrong sign of damping": ("half, 0.0)", "half, -0.001)", "The energy balance"),
    "dissipation of first order": ("half, 0.0)", "half, 0.01)", "The energy balance"),
    "one end row of order 0": ("rates[to + begin] = scale", "rates[to + begin] = 0.9 * scale", "psi"),
    "an order one too high": ("order_interface=lambda p: 2", "order_interface=lambda p: 3", "psi"),
    "a step limit 10 % long": ("return longest", "return 1.1 * longest", "The step limit"),
    "energy that is not conserved": ("conserves=False", "conserves=True", "The energy balance"),
    "a wrong norm": ("= h / 2", "= h", "The energy balance"),
}


def missed_by(tmp_path, old="", new=""):
    """The claims that a copy with a mistake misses, and what is said."""
    assert old in SOURCE
    (tmp_path / "mine.py").write_text(SOURCE.replace(old, new) if old else SOURCE)
    try:
        rows, said = sw.verify(family=tmp_path / "mine.py").rows, ""
    except NumericsError as error:
        rows, said = error.result.rows, str(error)
    assert bool(said) == any(row.outcome == "fail" for row in rows)
    return [row.claim for row in rows if row.outcome == "fail"], said


@pytest.mark.slow
@pytest.mark.parametrize("limit", ["n = 40", "n = 120"])
def test_a_correct_scheme_of_somebody_else_keeps_every_row(tmp_path, limit):
    assert missed_by(tmp_path, "n = 40", limit) == ([], "")


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_one_mistake_is_red_where_it_shows_and_is_named(tmp_path, mistake):
    old, new, claim = MISTAKES[mistake]
    red, said = missed_by(tmp_path, old, new)
    assert any(one.startswith(claim) for one in red)
    assert "(vertex" in said


SHIPPED_FAST = ("fd", "sbp:2", "dg:1")


@pytest.mark.parametrize(
    "model", [pytest.param(model, marks=[pytest.mark.slow] * (model not in SHIPPED_FAST)) for model in LADDERS]
)
def test_every_member_that_is_shipped_keeps_every_row(model):
    assert {row.outcome for row in sw.verify(model=model).rows} == {"pass"}


@pytest.mark.slow
@pytest.mark.parametrize("model", ["fem:10", "dg:12"])
def test_members_that_are_at_rounding_on_too_few_grids_are_not_judged_by_their_order(model):
    found = sw.verify(model=model)
    assert found.summary["missed"] == 0
    assert (found.summary["not_decided"] == 1) == (found.rows[0].outcome == "not decided")

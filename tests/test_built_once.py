"""Objects are finished when they are built: no program sets an attribute of another one from outside, least of all a solver's."""

import ast
from pathlib import Path

from slipwave.sources import ROOT, SOLVER_ROOMS

OF_LIBRARIES = {
    "dispatcher._cache", "dispatcher.get_call_template", "dispatcher.get_overload",
    "_brief.maxstring", "_brief.maxother", "_brief.maxlevel", "_brief.maxlist", "_brief.maxdict", "_brief.maxtuple",
    "node.body",
    "sys.stdout", "sys.stderr",
    "crossing.direction",
    "environment.filters", "environment.globals", "os.environ", "xml.SubElement(case, 'system-out').text",
    "call.__doc__", "call.__signature__", "self.call.__signature__", "self.call.__annotations__",
    "mark.until", "work.until", "engine.report",
    "found[name].attrs", "found['other_regime'].attrs",
}  # fmt: skip
"""Attributes that numba, reprlib, ast, jinja2, Python and scipy expect their users to set, or for which they have no option; and
`until` of a mark and of the progress, the end of the stretch of a run that has just begun, and a sweep's `report`."""


def attributes_set(path: Path) -> set[str]:
    """Attributes that a program sets of anything but `self`, as `solver.step`."""
    found = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del):
            found.add(ast.unparse(node))
    return {name for name in found if not name.startswith("self.") or name.count(".") > 1}


def test_no_program_edits_what_it_did_not_make() -> None:
    files = [path for room in (*SOLVER_ROOMS, "validation") for path in (ROOT / room).rglob("*.py")]
    assert set().union(*map(attributes_set, files)) == OF_LIBRARIES


def test_an_edit_is_seen(tmp_path: Path) -> None:
    file = tmp_path / "edit.py"
    file.write_text("def march(self, solver):\n    self.time = 1\n    solver.step *= 2\n    self.solver.step, other = 1, 2\n")
    assert attributes_set(file) == {"solver.step", "self.solver.step"}

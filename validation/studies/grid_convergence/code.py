"""The code that the exact system and the full-wave families share, read from what their modules import."""

from collections.abc import Collection
from itertools import combinations

from slipwave.family import Exact
from slipwave.sources import ROOT, import_closure
from validation.registry.families import FAMILIES
from validation.study import Table, table

_MARCH = {"fullwave.lines.motion": "the right-hand side with its faces", "fullwave.lines.kernel": "the time stepper"}
COMPARED = tuple(family.name for family in FAMILIES if family.exact is not Exact.NEVER)


def modules_of(family: str) -> frozenset[str]:
    """Modules of this package that a family's solver is made of, as `fullwave.lines.march`."""
    module = next(facts.module for facts in FAMILIES if facts.name == family)
    start = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    files = (path.relative_to(ROOT).with_suffix("") for path in import_closure([start], packages=False))
    return frozenset(".".join(path.parts).removesuffix(".__init__") for path in files)


def shared(one: str, other: str) -> tuple[str, ...]:
    """Modules beyond `slipwave` that two families have in common; the tables of facts, which compute nothing, left out."""
    common = modules_of(one) & modules_of(other)
    return tuple(sorted(name for name in common if not name.startswith("slipwave") and not name.endswith(".families")))


def code_table() -> Table:
    """One row per pair of families."""
    rows = (
        (f"`{one}`, `{other}`", len(common), ", ".join(name.removeprefix("fullwave.") for name in common) or "none")
        for one, other in combinations(COMPARED, 2)
        for common in [shared(one, other)]
    )
    caption = (
        "Modules of the solvers that two families share, read from their imports; all share `slipwave` (the scene, friction, the "
        "interface condition, the event detection). Comparing two families cannot reveal a mistake in what they share."
    )
    return table("code", caption, "pair | modules .0f | in common", rows)


def code_note() -> str:
    """What the pairs are worth as witnesses."""
    alike = set(shared("sbp", "fem")) & set(shared("sbp", "dg"))
    leapfrog = shared("fd", "sbp")
    exact = max(len(shared("delay", family)) for family in COMPARED[1:])
    return (
        f"`sbp`, `fem` and `dg` have {len(alike)} modules in common, {_march_in(alike)}: they are witnesses of each other’s "
        f"operators in space only. The leapfrog has {len(leapfrog)} modules in common with them, {_march_in(leapfrog)}. "
        f"The delay system, which every error is measured against, has no grid and {exact or 'no'} solver modules in common "
        "with any of them."
    )


def _march_in(modules: Collection[str]) -> str:
    parts = [words for module, words in _MARCH.items() if module in modules]
    return f"among them {' and '.join(parts)}" if parts else f"but not {' nor '.join(_MARCH.values())}"

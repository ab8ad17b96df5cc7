"""The order in space of every full wave, in every output, against the delay system: from a smooth start, and from a jump."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations

import numpy as np

from slipwave.sources import ROOT, import_closure
from validation.measure.grid_ladders import LADDERS, in_space
from validation.measure.grids.in_space import delay_reference, without_error_in_time
from validation.measure.in_words import state_at
from validation.measure.order_fit import fit_order
from validation.measure.orders import Climb, climb
from validation.models.by_name import FAMILIES, GRIDS, grid_of
from validation.report import EXACT, SELF, WITNESS, Evidence, Verdict, every
from validation.report.known import of_order

JUMP = "From a jump, which returns every transit, the leapfrog is of order 1"
INDEPENDENT = "The delay system shares no module of a solver with any full wave"
CFLS = (0.5, 0.9, 1.0)
_QUICK = ("fd", "sbp:2", "sbp:4", "sbp:6", "fem:7", "dg:2", "dg:7")
_UNTIL = 400.0  # transits


def judged_models(quick: bool) -> tuple[str, ...]:
    """The members whose order is fitted: in a quick report some of those with a ladder, one of every family at least."""
    seen = {model.partition(":")[0] for model in _QUICK}
    others = (family.called(next(iter(family.ladder))) for family in GRIDS if family.ladder and family.name not in seen)
    return (*_QUICK, *others) if quick else tuple(LADDERS)


def leapfrog_at(cfl: float) -> Climb:
    """The leapfrog at another Courant number; at 1 it is the delay system under the midpoint rule."""
    ladder = in_space(replace(LADDERS["fd"], cfl=cfl))
    return climb(ladder, delay_reference(ladder.run), without_error_in_time)


def space_errors(climbs: Iterable[Climb]) -> dict[str, dict[str, tuple[np.ndarray, np.ndarray]]]:
    """Geometric mean of all errors over points per slab, by kind of scheme and model."""
    found: dict[str, dict[str, tuple[np.ndarray, np.ndarray]]] = {}
    for one in climbs:
        family, number = grid_of(one.ladder.model)
        kind = {"fem": "finite elements", "dg": "discontinuous Galerkin"}.get(family.name, "differences")
        errors = np.exp(np.mean(np.log([*one.errors.values()]), axis=0))
        found.setdefault(kind, {})[one.ladder.model] = one.cells * family.points(number), errors
    return found


def evidence_at(cfl: float) -> Evidence:
    """At CFL 1 the leapfrog carries waves without error: it is no independent witness of the delay system."""
    return SELF if cfl == 1.0 else WITNESS


def jump_errors(cfl: float, cells: Iterable[int]) -> np.ndarray:
    """Errors of psi after `_UNTIL` transits."""
    known = state_at("yardstick", _UNTIL, tol=1e-11)
    return np.array([abs(state_at("yardstick", _UNTIL, "fd", cells=n, cfl=cfl) - known) for n in cells])


def jump_verdict(cfl: float, cells: Iterable[int], errors: np.ndarray) -> Verdict:
    """The order of psi from a jump."""
    return of_order(JUMP, evidence_at(cfl), fit_order(np.array(cells), errors), 1.0, f"CFL {cfl}")


def _modules_of(family: str) -> frozenset[str]:
    """Modules of the project that a family's solver uses, as `fullwave.lines.march`."""
    module = next(facts.module for facts in FAMILIES if facts.name == family)
    start = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    files = (path.relative_to(ROOT).with_suffix("") for path in import_closure([start], packages=False))
    return frozenset(".".join(path.parts).removesuffix(".__init__") for path in files)


def shared(one: str, other: str) -> tuple[str, ...]:
    """Modules outside `slipwave` that two families share, without the tables of facts, which compute nothing."""
    common = _modules_of(one) & _modules_of(other)
    return tuple(sorted(name for name in common if not name.startswith("slipwave") and not name.endswith(".families")))


def independence() -> Verdict:
    """What the imports say."""
    waves = [family.name for family in GRIDS]
    apart = sum(not shared("delay", name) for name in waves)
    among = ", ".join(f"`{one}` and `{other}` {len(shared(one, other))}" for one, other in combinations(waves, 2))
    return every(INDEPENDENT, EXACT, apart, len(waves), f"by their imports; all share `slipwave`; modules in common: {among}")

"""A sweep from its plan to its finished points."""

import json
import shutil
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from pydantic import BaseModel

import slipwave
from slipwave.errors import SceneError
from slipwave.friction.law import LAWS
from slipwave.input.assemble import to_toml
from slipwave.input.overrides import parse_toml
from slipwave.solve.follow import DAY
from slipwave.sources import source_digest
from validation.models.by_name import parse, resolve
from validation.models.own import digests, require_files
from validation.models.parameter import Variation, scenes_with
from validation.models.progress import progress
from validation.models.stopwatch import cores
from validation.sweep.engine import Engine, compute
from validation.sweep.executors import Workers
from validation.sweep.gather import arrays_of
from validation.sweep.measures import MEASURES, measure_of, own_measure
from validation.sweep.plan import Axis, Indices, Plan, axis_of, require_plan
from validation.sweep.refine import refine, regime_numbers
from validation.sweep.store import MANIFEST, Store

_BYTES = 40  # per figure of a point: its value in the parts, and in the netCDF file
_PROBES = 8
_PROBE_SECONDS = 5.0


def plan_of(scenes: Variation, axes: Sequence[Axis], models: Sequence[str], measure: str, **options: Any) -> Plan:
    """A validated plan. Raises SceneError if it is invalid."""
    names = tuple(dict.fromkeys(resolve(name.strip(), scenes.base)[0] for name in models))
    for name in names:
        parse(name)
    given = {name: value for name, value in options.items() if value}
    rows = tuple(given.pop("rows", ()))
    plan = Plan(scenes, tuple(replace(axis, name=scenes.key_of(axis.name)) for axis in axes), names, measure, given, rows)
    if measure not in MEASURES:
        own_measure(measure)
    require_plan(plan)
    return plan


def require_laws_in_files(plan: Plan) -> None:
    """Raises SceneError for a law that the processes of a sweep do not find: their main part is not the user's."""
    for name in sorted(plan.laws & LAWS.keys()):
        if LAWS[name].parameters.__module__ == "__main__":
            where = "in the main part of a script or in a notebook, where the processes of a sweep do not find it"
            raise SceneError(f'friction law {name!r}: is registered {where}: write it to a file, and give law="FILE.py"')


def _manifest_of(plan: Plan) -> dict[str, Any]:
    """The plan and the programs, ours and the user's, with which a folder must agree to be continued."""
    program = _versions() | {"code": source_digest()}
    source = {"scene_toml": to_toml(plan.base)}
    files = digests(plan.laws, plan.models, None if plan.measure in MEASURES else own_measure(plan.measure))
    return dict(json.loads(json.dumps(plan.manifest | source | {"program": program, "files": files})))


@cache
def _versions() -> dict[str, str]:
    return {name: version(name) for name in ("slipwave", "numpy", "scipy", "numba")}


class _StoredAxis(BaseModel):
    key: str
    values: tuple[float, ...] | tuple[str, ...]
    unit: str


class _Stored(BaseModel):
    """What a manifest says of its plan."""

    scene_toml: str
    axes: list[_StoredAxis]
    models: tuple[str, ...]
    measure: str
    options: dict[str, int | float]
    rows: tuple[dict[str, float | str], ...]
    set: dict[str, Any] = {}
    files: dict[str, str] = {}


def stored_plan(folder: Path, to_go_on: bool = False) -> Plan:
    """The plan of a folder, checked as one that is made; nothing is imported for its measure. Raises SceneError if it holds no
    sweep, or none that may be planned, or needs a user's file that is not loaded as it was, unless `to_go_on`, which says so
    later."""
    label, manifest = f"SCENE = {str(folder)!r}", Store(folder).manifest
    if manifest is None:
        raise SceneError(f"{label}: a folder without a sweep (no manifest.json)")
    files = dict[str, str]()
    try:
        said = _Stored(**manifest)
        files = said.files
        axes = tuple(replace(axis_of(axis.key, [*axis.values]), unit=axis.unit) for axis in said.axes)
        scene = slipwave.read_scene(parse_toml(said.scene_toml))
        names = [axis.name for axis in axes] + [key for row in said.rows for key in row]
        plan = Plan(scenes_with(scene, names, said.set), axes, said.models, said.measure, said.options, said.rows)
        require_plan(plan)
    except (ValueError, RecursionError) as error:
        require_files(label, files)
        reason = error if isinstance(error, SceneError) else "it is damaged, or of another version"
        raise SceneError(f"{str(folder / MANIFEST)!r}: holds no plan of a sweep: {reason}") from None
    if not to_go_on:
        require_files(label, files)
    return plan


def forecast(plan: Plan, workers: int) -> dict[str, Any]:
    """Predicted cost of a sweep: points, seconds per point and in all with so many `workers` (0: one per core), bytes on disk;
    from a few points all over the plan, computed in this process; for a refined plan that of the whole lattice."""
    chosen = plan.order[np.linspace(0, plan.size - 1, min(_PROBES, plan.size)).astype(int)]
    compute(plan, chosen[:1])  # compiled code is loaded
    spent: list[float] = []
    for point in chosen:
        spent.append(compute(plan, np.array([point]))[1])
        if sum(spent) > _PROBE_SECONDS:
            break
    each, workers = float(np.mean(spent)), workers or cores()
    cost = {"points": plan.size, "seconds_per_point": each, "seconds": plan.size * each / workers}
    return cost | {"size": _size(plan), "workers": workers}


def _size(plan: Plan) -> int:
    return plan.size * _BYTES * (len(measure_of(plan.measure).columns) * (2 if plan.base.units else 1) + 2)


Done: TypeAlias = tuple[tuple[int, int] | None, int]
"""The audit of a refined sweep (`refine`), and the number of points computed now."""


def perform_sweep(
    plan: Plan,
    store: Store,
    workers: AbstractContextManager[Workers],
    part: tuple[int, int] = (1, 1),
    most_seconds: float = DAY,
    anew: bool = False,
) -> Done:
    """Compute the missing points, or all `anew`; `part` (i, n): as the i-th of n jobs that share the folder. Raises SceneError
    for more than the disk or `most_seconds`; NumericsError if the scheduler disappears. Finished parts stay in the store in any
    case."""
    for name in plan.models:
        parse(name)
    with workers as (start, count, alive):
        store.begin(_manifest_of(plan), anew)
        free = shutil.disk_usage(store.folder).free
        if _size(plan) > free:
            raise SceneError(f"--out = {str(store.folder)!r}: needs about {_size(plan):.1e} bytes, and {free:.1e} are free")
        done = store.done(plan)
        before, order, levels = int(done.sum()), plan.order, int(plan.options.get("refine", 0))
        order = order[len(order) * (part[0] - 1) // part[1] : len(order) * part[0] // part[1]]
        with progress(f"{plan.base.name}, points", len(order)) as report:

            def checked(points: int) -> None:
                """Show progress and refuse a sweep that would take too long."""
                done_now[0] += points
                report(done_now[0])
                rest = (len(order) - done_now[0]) * engine.seconds_per_point / count
                if rest > most_seconds and not levels:
                    raise SceneError(f"the sweep would take about {rest / 3600.0:.0f} hours more; --yes computes it all the same")

            done_now = [before]
            engine = Engine(plan, store, start, count, checked, alive)

            def missing(wanted: Indices) -> None:
                """Compute the missing points among `wanted`, in their order."""
                chosen = np.zeros(plan.size, dtype=bool)
                chosen[wanted] = True
                engine.run(order[(chosen & ~store.done(plan))[order]])

            if levels:
                measure = measure_of(plan.measure)
                audit = refine(plan, levels, missing, lambda: regime_numbers(measure, arrays_of(plan, store)))
            else:
                audit = None
                engine.run(order[~done[order]])
    return audit, done_now[0] - before

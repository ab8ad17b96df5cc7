"""The finished points of a sweep as one `xarray.Dataset`, at any time."""

import json
from typing import Any

import numpy as np
import numpy.typing as npt

from slipwave.errors import SceneError
from slipwave.scene.units import IN_SI
from validation.data.datasets import Dataset, new_dataset, words_of_flags
from validation.data.variables import Meaning, attributes
from validation.models.own import digests
from validation.models.provenance import provenance
from validation.sweep.measures import VERDICTS, Measure, measure_of
from validation.sweep.plan import Plan
from validation.sweep.refine import fill, regime_numbers
from validation.sweep.store import STATUS, Store

Array = npt.NDArray[Any]

_ROUNDING = 1e-12  # relative, of a unit in SI


def arrays_of(plan: Plan, store: Store) -> dict[str, Array]:
    """Every column over all points of the plan: NaN, -1 and "" where a point is missing. Duplicates by two processes have the
    same figures."""
    arrays: dict[str, Array] = {"status": np.full(plan.size, -1, dtype=np.int8), "reason": np.full(plan.size, "", dtype=object)}
    arrays |= {name: np.full(plan.size, -1, dtype=np.int8) for name in measure_of(plan.measure).words}
    for points, columns in store.parts(plan):
        for name, values in columns.items():
            if name not in arrays:
                empty: Any = np.nan if values.dtype.kind == "f" else -1
                arrays[name] = np.full((plan.size, *values.shape[1:]), empty, dtype=values.dtype)
            arrays[name][points] = values
    return arrays


def filled_arrays(plan: Plan, store: Store) -> dict[str, Array]:
    """Every column over all points of the plan. In a refined sweep, points between the computed ones have the verdict of their
    cell and the status "not computed"."""
    arrays, levels = arrays_of(plan, store), int(plan.options.get("refine", 0))
    if levels:
        shown = {name: values for name, values in arrays.items() if name not in ("status", "reason") and values.ndim == 1}
        fill(plan, levels, regime_numbers(measure_of(plan.measure), arrays), shown)
    return arrays


def dataset_of(plan: Plan, arrays: dict[str, Array]) -> Dataset:
    """The columns `filled_arrays` over (model, axes); verdicts are words, which files hold as CF flags. `status`: how each point
    ended. The reason of a point that is too short says how long it would take."""
    measure = measure_of(plan.measure)
    names = ["scene"] if plan.rows else [axis.column for axis in plan.axes]
    dimensions = ("model", *names)
    if twice := arrays.keys() & {*dimensions}:
        raise SceneError(f"--vary {', '.join(twice)}: the measure returns a figure of the same name")
    if "needed" in arrays:
        arrays = arrays | {"reason": _lengths(arrays, plan)}
    variables = {
        name: (
            (*dimensions, *["cycle"] * (values.ndim - 1)),
            values.reshape(plan.shape + values.shape[1:]),
            _notes(name, measure, plan, arrays),
        )
        for name, values in arrays.items()
    }
    facts = provenance("sweep", plan.base, ", ".join(plan.models), {**plan.options, "measure": plan.measure})
    manifest = plan.manifest | {"files": digests(plan.laws, plan.models)}
    data = new_dataset(variables, coords=_coordinates(plan), attrs=facts | {"manifest": json.dumps(manifest)})
    data = words_of_flags(data, measure.words)
    return data if len(plan.models) > 1 else data.isel(model=0)


def _lengths(arrays: dict[str, Array], plan: Plan) -> Array:
    """The reasons, with those of points that are too short."""
    reasons = arrays["reason"].copy()
    for point in np.flatnonzero((arrays["verdict"] == VERDICTS.index("too short")) & (arrays["status"] == 0)).tolist():
        needed, seconds = arrays["needed"][point], arrays.get("needed_s")
        unit = f" ({seconds[point]:.2g} s)" if plan.base.units and seconds is not None else ""
        told = f"about {needed:.2g} transits{unit} would do" if np.isfinite(needed) else "one takes longer than a run can be"
        reasons[point] = f"too short: {told}"
    return reasons


def _coordinates(plan: Plan) -> dict[str, Any]:
    models: dict[str, Any] = {"model": ("model", list(plan.models))}
    if plan.rows:
        keys = dict.fromkeys(key for row in plan.rows for key in row)
        return models | {key.replace(".", "_"): ("scene", [row.get(key, np.nan) for row in plan.rows]) for key in keys}
    return models | {
        axis.column: (
            axis.column,
            list(axis.values),
            {"long_name": axis.name} | ({} if axis.is_of_words else {"units": axis.unit or "1"}),
        )
        for axis in plan.axes
    }


def _notes(name: str, measure: Measure, plan: Plan, arrays: dict[str, Array]) -> dict[str, Any]:
    """CF attributes of a column; `si_factor` where it is the same at all points."""
    if name == "reason":
        return {"long_name": "why there are no figures"}
    words = (*STATUS,) if name == "status" else measure.words.get(name)
    if words:
        meanings = " ".join(word.replace(" ", "_") for word in words)
        meaning = "how the point ended; -1: not computed" if name == "status" else measure.columns[name].meaning
        return {"long_name": meaning, "flag_values": np.arange(len(words), dtype=np.int8), "flag_meanings": meanings}
    if name in measure.columns:
        notes = attributes(measure.columns[name], plan.base)
        twin = arrays.get(f"{name}_{IN_SI[measure.columns[name].unit][1]}") if "si_factor" in notes else None
        if twin is not None and not _is_multiple(twin, arrays[name], notes["si_factor"], arrays["status"]):
            del notes["si_factor"]
        return notes
    for column, known in measure.columns.items():
        unit, ending = IN_SI.get(known.unit, ("", ""))
        if name == f"{column}_{ending}":  # the twin in SI
            return {"long_name": known.meaning, "units": unit}
    return attributes(Meaning(name), plan.base)


def _is_multiple(twin: Array, values: Array, factor: float, status: Array) -> bool:
    """Whether `twin` is the `factor` times the `values` at every computed point: what is varied may change the unit."""
    done = status == STATUS.index("done")
    return np.allclose(twin[done], factor * values[done], rtol=_ROUNDING, atol=0.0, equal_nan=True)

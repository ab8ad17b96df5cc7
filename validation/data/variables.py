"""The quantities of results as variables of a Dataset (CF conventions): meaning, unit, size in SI.

Values are dimensionless, as everywhere: `units` is "1" and `in_units_of` names the unit. For a scene in SI each variable also
states `si_factor` and `si_units`, and all but histories have a twin in SI, named as in the JSON (`period_s`, `stress_drop_Pa`).
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from slipwave.files import TIME
from slipwave.scene import Scene
from slipwave.scene.units import IN_SI
from validation.data.datasets import Dataset, new_dataset


class Meaning(NamedTuple):
    """Meaning of a quantity, and its unit: "transit", "normal stress", "V*", "L"; empty for a pure number."""

    meaning: str
    unit: str = ""


EVENTS = {
    "event_time": Meaning("date of the slip event: v passes half its largest value", "transit"),
    "period": Meaning("time to the next event", "transit"),
    "stress_drop": Meaning("max - min of the friction stress over the cycle", "normal stress"),
    "elastic_stress_drop": Meaning("max - min of the elastic stress y over the cycle", "normal stress"),
    "v_max": Meaning("largest slip rate of the cycle", "V*"),
    "v_min": Meaning("smallest slip rate of the cycle", "V*"),
}
_MARGIN = "half the width of the 95 % interval of the mean over the second half: "
MARGINS = {
    f"{name}_margin": Meaning(_MARGIN + name, EVENTS[name].unit) for name in ("period", "stress_drop", "elastic_stress_drop")
} | {"v_max_median_margin": Meaning("the same of the median of v_max", "V*")}
STAGE_QUANTITIES = {
    "start": Meaning("beginning of the stage", "transit"),
    "end": Meaning("end of the stage", "transit"),
    "velocity": Meaning("V of the drive", "V*"),
    "steady_stress": Meaning("friction stress at the end of a settled stage", "normal stress"),
    "direct_effect": Meaning("peak minus the friction stress before the step", "normal stress"),
    "evolution": Meaning("peak minus the new steady stress", "normal stress"),
    "slip_to_recovery": Meaning("slip from the peak to where 1/e of its distance from the steady stress is left", "L"),
    "relaxation": Meaning("friction stress before the hold minus that at its end", "normal stress"),
    "healing": Meaning("peak after the hold minus the friction stress before it", "normal stress"),
}
INTERFACE = {
    TIME: Meaning("time since the start of the run, of an orbit since the start of its period", "transit"),
    "interface_slip_rate": Meaning("slip rate v", "V*"),
    "interface_psi": Meaning("state ln phi"),
    "interface_stress": Meaning("friction stress mu", "normal stress"),
    "interface_elastic_stress": Meaning("elastic stress y", "normal stress"),
}
_ADVANCE = "time by which all later events come earlier, over "
PHASE = {
    "phase_response_stress": Meaning(f"{_ADVANCE}the impulse of a short shear stress on the interface", "1/normal stress"),
    "phase_response_drive": Meaning(f"{_ADVANCE}the displacement of a short change of the drive's velocity", "1/V*"),
}


_SHOWN = {"transit": ("transits", "s"), "normal stress": ("normal stress", "Pa"), "V*": ("V*", "m/s"), "L": ("L", "m")}
_SHOWN |= {"1/normal stress": ("1/normal stress", "1/Pa"), "1/V*": ("1/V*", "s/m")}


def leaves(facts: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every single value in `facts` with its dotted key."""
    for key, value in facts.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{above}{key}.")
        elif not isinstance(value, list):
            yield f"{above}{key}", value


def stored_name(column: str) -> str:
    """Name in files and datasets of a column of the interface's history (`slipwave.observe.history`)."""
    return TIME if column == "time" else f"interface_{column}"


_IN_WORDS = {"re": "real part", "im": "imaginary part", "std": "standard deviation", "wall": "run time", "s": "in seconds"}
_IN_WORDS |= {"low": "lower quartile", "high": "upper quartile"}
_IN_WORDS |= {"error": "relative error of", "difference": "difference of", "margin": "margin of"}


def si_factor(quantity: Meaning, scene: Scene) -> float | None:
    """SI size of the unit; None for a pure number and for scenes without units."""
    return scene.units.size(quantity.unit, scene.transit) if scene.units and quantity.unit else None


def shown_in(unit: str, scene: Scene) -> tuple[float, str]:
    """The size of a unit as tables show it, and its name there: in SI for a scene with units."""
    plain, physical = _SHOWN[unit]
    return (scene.units.size(unit, scene.transit), physical) if scene.units else (1.0, plain)


def attributes(quantity: Meaning, scene: Scene) -> dict[str, Any]:
    """Attributes of a variable."""
    notes: dict[str, Any] = {"long_name": quantity.meaning, "units": "1"}
    if quantity.unit:
        notes["in_units_of"] = quantity.unit
    factor = si_factor(quantity, scene)
    return notes if factor is None else notes | {"si_factor": factor, "si_units": IN_SI[quantity.unit][0]}


def _column_meaning(key: str) -> Meaning:
    """Meaning of a column of a table of results, by its key: `period.mean`, `error.period`, `margins.period`."""
    words, (first, _, rest) = " ".join(_IN_WORDS.get(part, part) for part in re.split(r"[._]", key)), key.partition(".")
    figure = MARGINS.get(f"{rest}_margin") if first == "margins" else EVENTS.get(first)
    return Meaning(f"{words}; {figure.meaning}", figure.unit) if figure else Meaning(words)


def twins_in_si(name: str, values: ArrayLike, quantity: Meaning, scene: Scene) -> dict[str, tuple[Any, dict[str, str]]]:
    """Name -> values and attributes of the twin in SI; empty for a pure number and for scenes without units."""
    factor = si_factor(quantity, scene)
    if factor is None:
        return {}
    unit, ending = IN_SI[quantity.unit]
    return {f"{name}_{ending}": (np.asarray(values, dtype=float) * factor, {"long_name": quantity.meaning, "units": unit})}


def in_si(values: Mapping[str, Any], quantities: Mapping[str, Meaning], scene: Scene) -> dict[str, Any]:
    """Name -> value in SI, as `twins_in_si`, of each of the `quantities`; None where there is none."""
    every: dict[str, Any] = {}
    for name, quantity in quantities.items():
        value = values.get(name)
        for twin, (size, _) in twins_in_si(name, math.nan if value is None else value, quantity, scene).items():
            every[twin] = None if value is None else size if np.ndim(size) else float(size)
    return every


def cycle_in_si(values: Mapping[str, float], scene: Scene) -> dict[str, dict[str, float]]:
    """{"si": the figures of a cycle in SI}, for the JSON of a scene with units; else nothing. `period_std` and `period_margin`
    are in the unit of `period`, `v_max_median` in that of `v_max`."""
    if scene.units is None:
        return {}
    kinds = {name: EVENTS[re.sub("(_median)?(_std|_margin)?$", "", name)] for name in values}
    return {"si": in_si(values, kinds, scene) | {"transit_s": scene.units.size("transit", scene.transit)}}


def variables(
    dimension: str | tuple[str, ...],
    columns: Mapping[str, ArrayLike],
    quantities: Mapping[str, Meaning],
    scene: Scene,
    twins: bool = True,
) -> dict[str, Any]:
    """Variables over `dimension` for `xarray.Dataset`; with `twins` each is followed by that in SI if the scene has units."""
    every: dict[str, Any] = {}
    for name, values in columns.items():
        every[name] = (dimension, values, attributes(quantities[name], scene))
        if twins:
            every |= {twin: (dimension, *rest) for twin, rest in twins_in_si(name, values, quantities[name], scene).items()}
    return every


def figures_at(
    dimension: str, columns: Mapping[str, Sequence[float]], base: Scene, scenes: Callable[[], Sequence[Scene]]
) -> dict[str, Any]:
    """Figures of cycles as `variables`, each value in SI by the units of its own one of the `scenes`, which what is varied may
    change: `si_factor` is stated where it is the same for all."""
    stored = variables(dimension, columns, EVENTS, base)
    every = scenes() if base.units else []
    for name, values in columns.items() if base.units else ():
        sizes = [si_factor(EVENTS[name], scene) or math.nan for scene in every]
        twin = f"{name}_{IN_SI[EVENTS[name].unit][1]}"
        stored[twin] = (dimension, np.multiply(values, sizes), stored[twin][2])
        if len({*sizes}) > 1:
            del stored[name][2]["si_factor"]
    return stored


def table_of(rows: Sequence[Mapping[str, Any]], dimension: str, scene: Scene) -> Dataset:
    """The rows of a summary on `scene` as variables over `dimension`: numbers and words by their dotted keys, NaN where
    missing."""
    flat = [dict(leaves(row)) for row in rows]
    names = dict.fromkeys(name for row in flat for name in row)
    every: dict[str, Any] = {}
    for key in names:
        name, values, meaning = key.replace(".", "_"), _column([row.get(key) for row in flat]), _column_meaning(key)
        if values.dtype == float:
            every |= variables(dimension, {name: values}, {name: meaning}, scene)
            every[name][2].update({"units": "s"} if key.startswith("wall_") else {})
        else:
            every[name] = (dimension, values, {"long_name": meaning.meaning})
    table = new_dataset(every)
    return table.set_coords("model") if "model" in table else table


def _column(values: Sequence[Any]) -> "np.ndarray[Any, Any]":
    words = any(isinstance(value, str) for value in values)
    empty = "" if words else math.nan
    return np.array([empty if value is None else value for value in values], dtype=object if words else float)

"""What moves an orbit: derivatives of its figures by every physical key of its scene, for `slipwave orbit --response`."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import slipwave
from reduced.orbit.closing import Closed
from reduced.orbit.periodic import figures_of
from reduced.orbit.response import Beside, Responding
from slipwave.errors import NumericsError, SceneError
from slipwave.input.assemble import validate
from slipwave.input.quantity import Quantity
from slipwave.input.schema import KeyTable
from slipwave.input.source import tables_of
from slipwave.scene import Scene
from validation.commands.phase_response import phase_facts
from validation.commands.result import aligned, rounded
from validation.data.variables import cycle_in_si
from validation.models.orbits import OrbitFound
from validation.models.parameter import Parameter, number_in

_STEP = 1e-6  # of differences, relative: the paper's derivatives have errors of 2e-7 then, of 1.4e-5 at 1e-5
_WEAK, _WIDER = 0.03, 100.0  # d ln(figure)/d ln(key), below which rounding counts for more, and the factor of the step then
_CENTRAL, _ONE_SIDED = {1: 0.5, -1: -0.5}, {0: -1.5, 1: 2.0, 2: -0.5}  # steps -> weights
_SI = "si."
_WITHOUT_EFFECT = 1e-7  # per cent, of figures by 1 % of a key
_SHOWN = {"T": "period_time", "stress drop": "stress_drop", "v_max": "v_max", "v_min": "v_min"}
_IN_SI = {"T": "period_s", "stress drop": "stress_drop_Pa", "v_max": "v_max_m_per_s", "v_min": "v_min_m_per_s"}

Response: TypeAlias = dict[str, dict[str, Any]]
"""Figure -> key of the scene -> derivative; those of figures in SI under `si`. `keys`: the `value` and `unit` of each key, and
the `reason` where its derivatives are None. `phase`: the response to short pulses."""


@dataclass(frozen=True)
class _Number(Parameter):
    """A number of the scene: its `value`, in the `shown` unit; a 0 has none. `layers`: key of the list of tables that it is
    in, its place there, and its key in that table."""

    value: float = 0.0
    shown: str = ""
    layers: tuple[str, int, str] | None = None

    def scene(self, base: Scene, offset: float) -> Scene:
        """The scene with the value moved by `offset`. Raises SceneError if there is none."""
        written = self.written(self.value + offset)
        if self.layers is None:
            return slipwave.read(base, {self.name: written})
        key, k, field = self.layers
        table: Any = tables_of(base)[1]
        for part in key.split("."):
            table = table[part]
        return slipwave.read(base, {key: [{**one, field: written} if i == k else one for i, one in enumerate(table)]})

    def beside(self, base: Scene, wider: float = 1.0) -> list[Beside]:
        """Scenes on both sides; at an end of the range this one and those on one side. Raises SceneError if there are none."""
        step = wider * _STEP * (1.0 / math.log(10.0) if self.name.endswith("log10_r") else abs(self.value) or 1.0)
        failed = SceneError("")
        for sign, weights in ((1.0, _CENTRAL), (1.0, _ONE_SIDED), (-1.0, _ONE_SIDED)):
            try:
                offsets = {sign * count * step: sign * weight / step for count, weight in weights.items()}
                return [Beside(self.scene(base, offset), offset, weight) for offset, weight in offsets.items()]
            except SceneError as error:
                failed = error
        raise failed


def response_of(found: OrbitFound, responding: Responding) -> Response:
    """The derivatives of an orbit's figures by every key that is a number, but those of start and run; with units also those of
    the figures in SI; and the phase response. Raises SceneError if the scene was not read."""
    closed, scene = found.found.closed, found.scene
    keys = dict[str, dict[str, Any]]()
    figures = _figures(closed)
    slopes: Response = {name: {} for name in figures}
    for number in _numbers(scene):
        keys[number.name] = {"value": number.value, "unit": number.shown}
        by: Mapping[str, float] = {}
        try:
            by = responding.by(number.beside(scene), _figures)
            if number.value and all(abs(by[name] * number.value / figure) < _WEAK for name, figure in figures.items()):
                by = responding.by(number.beside(scene, _WIDER), _figures)
        except (SceneError, NumericsError) as error:
            keys[number.name]["reason"] = str(error)
        for name, known in slopes.items():
            known[number.name] = by.get(name)
    in_si = {name: slopes.pop(name) for name in [*slopes] if name.startswith(_SI)}
    twins = {"si": {name.removeprefix(_SI): known for name, known in in_si.items()}} if in_si else {}
    return slopes | twins | {"keys": keys, "phase": phase_facts(found, responding)}


def response_rows(response: Response, facts: Mapping[str, Any]) -> Iterator[str]:
    """The table: the effect in per cent of 1 % of each key, or, of a key that is 0, of 1, on the figures among the `facts`, in SI
    where the scene is; the largest on the period first."""
    names = _IN_SI if "si" in facts else _SHOWN
    slopes, figures = response.get("si", response), facts.get("si", facts)
    rows = list[tuple[float, list[str]]]()
    for key, known in response["keys"].items():
        is_log, value = key.endswith("log10_r"), known["value"]
        change = 1.0 / math.log(10.0) if is_log else value or 100.0
        effects = [_effect(slopes[name][key], change / figures[name]) for name in names.values()]
        shown = [f"r ({key})" if is_log else key, f"{value:.6g} {known['unit']}".rstrip(), "1 %" if value else "1"]
        rows.append((abs(effects[0] or 0.0), [*shown, *(rounded(one, 4) for one in effects)]))
    rows.sort(key=lambda row: -row[0])
    yield from aligned(["effect in % of", "value", "change", *names], [row for _, row in rows])
    yield from (f"{key}: {known['reason']}" for key, known in response["keys"].items() if "reason" in known)


def _effect(slope: float | None, change: float) -> float | None:
    if slope is None:
        return None
    return slope * change if abs(slope * change) > _WITHOUT_EFFECT else 0.0


def _figures(closed: Closed) -> dict[str, float]:
    """The figures of the JSON of orbits; those in SI under `si.`NAME."""
    scene, values = closed.flow.scene, figures_of(closed)
    in_si = cycle_in_si(values, scene).get("si", {})
    in_si.pop("transit_s", None)
    return values | {"period_time": values["period"] * scene.transit} | {_SI + name: value for name, value in in_si.items()}


def _numbers(scene: Scene) -> Iterator[_Number]:
    known = validate(tables_of(scene)[1])
    for name in ("interface", "slab", "upper", "lower", "machine"):
        if (table := getattr(known, name)) is not None:
            yield from _numbers_in(table, name)
    [(_, velocity)] = known.drive.velocity
    yield _number(known.drive, "velocity", velocity, "drive.velocity")


def _numbers_in(table: KeyTable, path: str) -> Iterator[_Number]:
    for field, value in table:
        key = f"{path}.{field}"
        if key.endswith("].fraction"):  # shares add up to 1, so that none changes alone
            continue
        if isinstance(value, KeyTable):
            yield from _numbers_in(value, key)
        elif isinstance(value, list):
            for k, layer in enumerate(value):
                for one in _numbers_in(layer, f"{key}[{k}]"):
                    yield replace(one, layers=(key, k, one.name.rpartition(".")[2]))
        elif isinstance(value, int | float | Quantity) and not isinstance(value, bool):
            yield _number(table, field, value, key)


def _number(table: KeyTable, field: str, value: float | Quantity, key: str) -> _Number:
    number, written, shown = number_in(table, field, value)
    return _Number(key, written, number, shown) if number else _Number(key)

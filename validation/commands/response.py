"""What moves an orbit, for `slipwave orbit --response`: derivatives of its figures by every physical key of its scene, and its
phase response."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

import slipwave
from reduced.orbit.closing import Closed
from reduced.orbit.periodic import figures_of
from reduced.orbit.phase import PhaseResponse
from reduced.orbit.response import Responding
from slipwave.errors import NumericsError, SceneError
from slipwave.files import TIME
from slipwave.input.assemble import tables_of, validate
from slipwave.input.quantity import Quantity
from slipwave.input.schema import KeyTable, LayerTable
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.chart import GUIDE, Chart, Look, Panel, Scale, SecondScale, Trace
from validation.chart.thin import staying
from validation.commands.reasons import PREFIXES, power_of
from validation.commands.result import aligned, rounded
from validation.data.variables import INTERFACE, PHASE, cycle_in_si, in_si, shown_in, si_factor
from validation.models.orbit_start import first_event
from validation.models.orbits import SceneOrbit
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

PhaseFacts: TypeAlias = dict[str, Any]
"""At `phase`s of the cycle, 0 at its first slip event, and `time`s since then: the advance of later events by impulses of
`stress` and of `drive`, in the `unit`s; in SI under `si`."""

_MOST = 400  # points of each curve in the JSON
_NAMES = {"stress": "phase_response_stress", "drive": "phase_response_drive"}
_LISTED, _HARMONICS = 5, 20  # in the table and in the JSON
_AMPLITUDES = (("normal stress", "V*"), ("Pa", "m/s"))
_DENSITIES = ("normal stress^2 transit", "Pa^2 s")
_PULSES = {"stress": "shear stress", "drive": "drive velocity"}


@dataclass(frozen=True)
class _Number(Parameter):
    """A number of the scene: its `value`, in the `shown` unit; a 0 has none."""

    value: float = 0.0
    shown: str = ""

    def scene(self, base: Scene, offset: float) -> Scene:
        """The scene with the value moved by `offset`. Raises SceneError if there is none."""
        return slipwave.read(base, {self.name: self.written(self.value + offset)})

    def beside(self, base: Scene, wider: float = 1.0) -> tuple[list[Scene], dict[float, float]]:
        """Scenes on both sides, and offset -> weight of each (`Responding.by`); at an end of the range this one and those on one
        side. Raises SceneError if there are none."""
        step = wider * _STEP * (1.0 / math.log(10.0) if self.name.endswith("log10_r") else abs(self.value) or 1.0)
        failed = SceneError("")
        for sign, weights in ((1.0, _CENTRAL), (1.0, _ONE_SIDED), (-1.0, _ONE_SIDED)):
            try:
                offsets = {sign * count * step: sign * weight / step for count, weight in weights.items()}
                return [self.scene(base, offset) for offset in offsets], offsets
            except SceneError as error:
                failed = error
        raise failed


def response_of(scene_orbit: SceneOrbit, responding: Responding) -> Response:
    """The derivatives of an orbit's figures by every key that is a number, but those of start and run; with units also those of
    the figures in SI; and the phase response. Raises SceneError if the scene was not read."""
    closed, scene = scene_orbit.periodic.closed, scene_orbit.scene
    keys = dict[str, dict[str, Any]]()
    figures = _figures(closed)
    slopes: Response = {name: {} for name in figures}
    for number in _numbers(scene):
        keys[number.name] = {"value": number.value, "unit": number.shown}
        by: Mapping[str, float] = {}
        try:
            by = responding.by(*number.beside(scene), _figures)
            if number.value and all(abs(by[name] * number.value / figure) < _WEAK for name, figure in figures.items()):
                by = responding.by(*number.beside(scene, _WIDER), _figures)
        except (SceneError, NumericsError) as error:
            keys[number.name]["reason"] = str(error)
        for name, known in slopes.items():
            known[number.name] = by.get(name)
    in_si = {name: slopes.pop(name) for name in [*slopes] if name.startswith(_SI)}
    twins = {"si": {name.removeprefix(_SI): known for name, known in in_si.items()}} if in_si else {}
    return slopes | twins | {"keys": keys, "phase": _phase_facts(scene_orbit, responding)}


def response_lines(response: Response, facts: Mapping[str, Any], scene: Scene) -> Iterator[str]:
    """The tables, each after a blank line: the effect in per cent of 1 % of each key, or, of a key that is 0, of 1, on the
    figures among the `facts`, in SI where the scene is, the largest on the period first; and the phase response."""
    names = _IN_SI if "si" in facts else _SHOWN
    slopes, figures = response.get("si", response), facts.get("si", facts)
    rows = list[tuple[float, list[str]]]()
    for key, known in response["keys"].items():
        is_log, value = key.endswith("log10_r"), known["value"]
        change = 1.0 / math.log(10.0) if is_log else value or 100.0
        slope_of = {name: slopes[name][key] for name in names.values()}
        effects = [None if slope is None else slope * change / figures[name] for name, slope in slope_of.items()]
        effects = [0.0 if effect is not None and abs(effect) <= _WITHOUT_EFFECT else effect for effect in effects]
        shown = [f"r ({key})" if is_log else key, f"{value:.6g} {known['unit']}".rstrip(), "1 %" if value else "1"]
        rows.append((abs(effects[0] or 0.0), [*shown, *(rounded(effect, 4) for effect in effects)]))
    rows.sort(key=lambda row: -row[0])
    yield ""
    yield from aligned(["effect in % of", "value", "change", *names], [row for _, row in rows])
    yield from (f"{key}: {known['reason']}" for key, known in response["keys"].items() if "reason" in known)
    yield ""
    yield from _phase_lines(response["phase"], scene)


def _figures(closed: Closed) -> dict[str, float]:
    """The figures of the JSON of orbits; those in SI under `si.`NAME."""
    scene, values = closed.flow.scene, figures_of(closed)
    physical = cycle_in_si(values, scene).get("si", {})
    physical.pop("transit_s", None)
    return values | {"period_time": values["period"] * scene.transit} | {_SI + name: value for name, value in physical.items()}


def _numbers(scene: Scene) -> Iterator[_Number]:
    known = validate(tables_of(scene)[1])
    for name in ("interface", "slab", "upper", "lower", "machine"):
        if (table := getattr(known, name)) is not None:
            yield from _numbers_in(table, name, scene)
    [(_, velocity)] = known.drive.velocity
    yield _number(known.drive, velocity, "drive.velocity", scene)


def _numbers_in(table: KeyTable, path: str, scene: Scene) -> Iterator[_Number]:
    for field, value in table:
        key = f"{path}.{field}"
        if isinstance(table, LayerTable) and field == "fraction":  # shares add up to 1, so that none changes alone
            continue
        if isinstance(value, KeyTable):
            yield from _numbers_in(value, key, scene)
        elif isinstance(value, list):
            for k, layer in enumerate(value):
                yield from _numbers_in(layer, f"{key}.{k}", scene)
        elif isinstance(value, int | float | Quantity) and not isinstance(value, bool):
            yield _number(table, value, key, scene)


def _number(table: KeyTable, value: float | Quantity, key: str, scene: Scene) -> _Number:
    number, written, shown = number_in(table, key, value, scene)
    return _Number(key, written, number, shown) if number else _Number(key)


def _phase_facts(scene_orbit: SceneOrbit, responding: Responding) -> PhaseFacts:
    """The JSON; the curves thinned so that every extremum stays."""
    response = responding.phase
    scene, (times, _, values) = scene_orbit.scene, response.samples
    since = ((times - first_event(scene_orbit.periodic.closed)) % response.period).ravel()
    order = np.argsort(since)
    since, values = since[order], values.reshape(2, -1)[:, order]
    kept = np.unique(np.concatenate([staying(since, column, _MOST) for column in values if not np.isnan(column).any()]))
    columns = {"time": since[kept], **dict(zip(_NAMES, values[:, kept], strict=True))}
    meanings = {"time": INTERFACE[TIME]} | {name: PHASE[stored] for name, stored in _NAMES.items()}
    facts: PhaseFacts = {"phase": (since[kept] / response.period).tolist()}
    facts |= {name: column.tolist() for name, column in columns.items()}
    facts["unit"] = {name: meaning.unit for name, meaning in meanings.items()}
    facts["first_order_up_to"] = dict(zip(_NAMES, responding.first_order_up_to().tolist(), strict=True))
    facts["harmonics"] = dict(zip(_NAMES, response.harmonics(_HARMONICS).tolist(), strict=True))
    facts["diffusion"] = dict(zip(_NAMES, response.diffusion.tolist(), strict=True))
    if scene.units is None:
        return facts
    facts["si"] = {twin: column.tolist() for twin, column in in_si(columns, meanings, scene).items()}
    for key, power in (("first_order_up_to", -1.0), ("harmonics", 1.0), ("diffusion", 2.0)):
        sizes = {name: scene.units.size(meanings[name].unit, scene.transit) ** power for name in _NAMES}
        facts["si"][key] = {name: (size * np.array(facts[key][name])).tolist() for name, size in sizes.items()}
    return facts


def _phase_lines(facts: Mapping[str, Any], scene: Scene) -> Iterator[str]:
    """The table: the largest advance and delay, and when in the cycle a pulse has it."""
    rows = list[list[str]]()
    for name, words in _PULSES.items():
        size, unit = shown_in(PHASE[_NAMES[name]].unit, scene)
        values = size * np.array(facts[name], dtype=float)
        if np.isnan(values).any():
            continue
        most = (int(values.argmax()), int(values.argmin()))
        rows.append([words, unit, *(text for k in most for text in (rounded(values[k], 3), f"{facts['phase'][k]:.3f}"))])
    yield from aligned(["a short pulse of", "advance in", "largest", "at phase", "least", "at phase"], rows)
    yield "the time by which all later events come earlier, over the pulse's size times its length; phase 0: the slip event"
    yield ""
    known, place = facts.get("si", facts), int("si" in facts)
    rows = [
        [
            words,
            *(rounded(size, 4) for size in known["harmonics"][name][:_LISTED]),
            "unknown" if (limit := known["first_order_up_to"][name]) is None else f"{rounded(limit, 2)} {unit}",
        ]
        for (name, words), unit in zip(_PULSES.items(), _AMPLITUDES[place], strict=True)
    ]
    yield from aligned(["a sine of amplitude A of", *(f"n = {n}" for n in range(1, _LISTED + 1)), "first order up to"], rows)
    yield "a cycle is locked to n periods P of the sine while |n P/T - 1| < A times this, in 1/(the unit of A)"
    spread = rounded(known["diffusion"]["stress"], 4)
    yield f"white shear stress of two-sided density S ({_DENSITIES[place]}): dates of events diffuse with D = {spread} S"


def with_phase_response(chart: Chart, scene: Scene, time: Array, response: PhaseResponse) -> Chart:
    """The motion's chart over `time` (transits) with the phase response below."""
    panels: Sequence[Panel] = [
        Panel(
            f"a short pulse of {_PULSES[name]}: by how much all later events come earlier (below 0: later)",
            chart.panels[-1].x,
            _scale(name, scene, float(np.abs(values).max())),
            [Trace("", [-np.inf, np.inf], [0.0, 0.0], GUIDE), Trace("advance", time, values, Look(width=0.9))],
        )
        for name, values in zip(_NAMES, response.at(time), strict=True)
        if not np.isnan(values).any()
    ]
    return replace(chart, panels=[*chart.panels, *panels], height=0.5 * chart.height * (2 + len(panels)))


def _scale(name: str, scene: Scene, largest: float) -> Scale:
    """With an SI scale in a unit in which the `largest` value is between 1 and 1000."""
    meaning = PHASE[_NAMES[name]]
    size, label = si_factor(meaning, scene), "advance / ({})"
    if size is None:
        return Scale(label.format(meaning.unit))
    power = min(9, 3 + power_of(1.0 / (size * largest)))
    unit = shown_in(meaning.unit, scene)[1].replace("/", f"/{PREFIXES[power]}")
    return Scale(label.format(meaning.unit), second=SecondScale(label.format(unit), size * 10.0**power))

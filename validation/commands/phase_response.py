"""The phase response of an orbit, as `slipwave orbit --response` says and draws it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from reduced.orbit.phase import PhaseResponse
from reduced.orbit.response import Responding
from slipwave.files import TIME
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.chart import GUIDE, Chart, Look, Panel, Scale, Second, Trace
from validation.chart.thin import staying
from validation.commands.reasons import PREFIXES, power_of
from validation.commands.result import aligned, rounded
from validation.data.variables import INTERFACE, PHASE, shown_in, si_factor, twins_in_si
from validation.models.orbit_start import first_event
from validation.models.orbits import OrbitFound

PhaseFacts: TypeAlias = dict[str, Any]
"""At `phase`s of the cycle, 0 at its first slip event, and `time`s since then: the advance of later events by impulses of
`stress` and of `drive`, in the `unit`s; in SI under `si`."""

_MOST = 400  # points of each curve in the JSON
_NAMES = {"stress": "phase_response_stress", "drive": "phase_response_drive"}
_SHOWN, _HARMONICS = 5, 20  # in the table and in the JSON
_AMPLITUDES = (("normal stress", "V*"), ("Pa", "m/s"))
_DENSITIES = ("normal stress^2 transit", "Pa^2 s")
_PULSES = {"stress": "shear stress", "drive": "drive velocity"}


def phase_facts(found: OrbitFound, responding: Responding) -> PhaseFacts:
    """The JSON; the curves thinned so that every extremum stays."""
    response = responding.phase
    scene, (times, _, values) = found.scene, response.samples
    since = ((times - first_event(found.found.closed)) % response.period).ravel()
    order = np.argsort(since)
    since, values = since[order], values.reshape(2, -1)[:, order]
    kept = np.unique(np.concatenate([staying(since, one, _MOST) for one in values if not np.isnan(one).any()]))
    columns = {"time": since[kept], **dict(zip(_NAMES, values[:, kept], strict=True))}
    meanings = {"time": INTERFACE[TIME]} | {name: PHASE[stored] for name, stored in _NAMES.items()}
    facts: PhaseFacts = {"phase": (since[kept] / response.period).tolist()}
    facts |= {name: one.tolist() for name, one in columns.items()}
    facts["unit"] = {name: meaning.unit for name, meaning in meanings.items()}
    facts["first_order_up_to"] = dict(zip(_NAMES, responding.first_order_up_to().tolist(), strict=True))
    facts["harmonics"] = dict(zip(_NAMES, response.harmonics(_HARMONICS).tolist(), strict=True))
    facts["diffusion"] = dict(zip(_NAMES, response.diffusion.tolist(), strict=True))
    if scene.units is None:
        return facts
    in_si = {twin: one for name in columns for twin, (one, _) in twins_in_si(name, columns[name], meanings[name], scene).items()}
    facts["si"] = {twin: one.tolist() for twin, one in in_si.items()}
    for key, power in (("first_order_up_to", -1.0), ("harmonics", 1.0), ("diffusion", 2.0)):
        sizes = {name: scene.units.size(meanings[name].unit, scene.transit) ** power for name in _NAMES}
        facts["si"][key] = {name: (size * np.array(facts[key][name])).tolist() for name, size in sizes.items()}
    return facts


def phase_rows(facts: Mapping[str, Any], scene: Scene) -> Iterator[str]:
    """The table: the largest advance and delay, and when in the cycle a pulse has it."""
    rows = list[list[str]]()
    for name, words in _PULSES.items():
        size, unit = shown_in(PHASE[_NAMES[name]].unit, scene)
        values = size * np.array(facts[name], dtype=float)
        if np.isnan(values).any():
            continue
        most = (int(values.argmax()), int(values.argmin()))
        rows.append([words, unit, *(text for k in most for text in (rounded(values[k], 4), rounded(facts["phase"][k], 3)))])
    yield from aligned(["a short pulse of", "advance in", "largest", "at phase", "least", "at phase"], rows)
    yield "the time by which all later events come earlier, over the pulse's size times its length; phase 0: the slip event"
    yield ""
    known, place = facts.get("si", facts), int("si" in facts)
    rows = [
        [
            words,
            *(rounded(one, 4) for one in known["harmonics"][name][:_SHOWN]),
            "unknown" if (limit := known["first_order_up_to"][name]) is None else f"{rounded(limit, 2)} {unit}",
        ]
        for (name, words), unit in zip(_PULSES.items(), _AMPLITUDES[place], strict=True)
    ]
    yield from aligned(["a sine of amplitude A of", *(f"n = {n}" for n in range(1, _SHOWN + 1)), "first order up to"], rows)
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
    return Scale(label.format(meaning.unit), second=Second(label.format(unit), size * 10.0**power))

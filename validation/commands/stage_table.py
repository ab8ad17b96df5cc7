"""The stages of a protocol as results: dictionaries for the JSON, with SI where the scene has units, and rows for a table."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import pairwise
from typing import Any

from slipwave.observe.protocol import StageFigures
from slipwave.scene import Scene
from validation.commands.result import aligned, rounded
from validation.data.variables import STAGE_QUANTITIES, in_si, shown_in


def stage_results(stages: Sequence[StageFigures], scene: Scene) -> list[dict[str, Any]]:
    """One dictionary for each stage, times in transits, stresses in units of the normal stress, slip in L; `si` exists only for
    scenes with units."""
    rows = [asdict(stage) for stage in stages]
    return [row | {"si": in_si(row, STAGE_QUANTITIES, scene)} for row in rows] if scene.units else rows


def stages_in_words(stages: Sequence[StageFigures]) -> str:
    """Text on the number and state of the stages: "3 stages, all settled"."""
    states = [_state(stage) for stage in stages]
    counts = [f"{states.count(state)} {state}" for state in dict.fromkeys(states)]
    words = f"all {states[0]}" if len(counts) == 1 and len(states) > 1 else ", ".join(counts)
    return f"{len(stages)} stage{'s' * (len(stages) != 1)}, {words}"


def _state(stage: StageFigures) -> str:
    if stage.kind in ("hold", "ramp"):
        return stage.kind
    return "settled" if stage.steady_stress is not None else "in stick-slip" if stage.stick_slips else "not settled"


def _why(before: StageFigures, stage: StageFigures) -> str:
    if stage.stick_slips:
        return "it is in stick-slip"
    if before.relaxation is not None:
        return "friction has not reached its peak in it"
    if before.steady_stress is not None:
        return "no time step of the model lies within it"
    if before.kind == "hold":
        return "its hold has no relaxation"
    return f"the {before.kind} before it is {_state(before)}, so there is no steady stress to compare with"


def stage_lines(stages: Sequence[StageFigures], scene: Scene) -> Iterator[str]:
    """A table, in seconds and metres if the scene has units, stresses always over the normal stress; and a line for each hold
    without relaxation, or slide after it without healing, with the reason."""
    (second, clock), (metre, length), (rate, speed) = (shown_in(unit, scene) for unit in ("transit", "L", "V*"))
    heading = ["stage", f"from [{clock}]", f"V [{speed}]", "steady", "direct", "evolution", f"slip to 1/e [{length}]"]
    rows = [
        [
            f"{stage.kind}, stick-slip" if stage.stick_slips else stage.kind,
            rounded(stage.start * second, 6),
            rounded(stage.velocity * rate, 6),
            *(rounded(value, 6) for value in (stage.steady_stress, stage.direct_effect, stage.evolution)),
            rounded(None if stage.slip_to_recovery is None else stage.slip_to_recovery * metre, 6),
            *(rounded(value, 6) for value in (stage.relaxation, stage.healing)),
        ]
        for stage in stages
    ]
    yield ""
    yield from aligned([*heading, "relaxation", "healing"], rows)
    for before, stage in pairwise(stages):
        name = {"hold": "relaxation", "slide": "healing"}.get(stage.kind, "")
        if name and getattr(stage, name) is None:
            yield f"no {name} of the {stage.kind} from {rounded(stage.start, 6)} transits on: {_why(before, stage)}"

"""`slipwave stability`: is steady sliding stable, where does it lose stability, and how do small disturbances grow?"""

import math
from typing import TYPE_CHECKING, Annotated

import typer

import slipwave
from reduced.families import DELAY, REDUCTIONS
from validation.commands.options import Json, Law, SceneName, Settings
from validation.output import figures, print_json, print_table, printed

if TYPE_CHECKING:
    from validation.door.stability import StabilityResult

StabilityModel = Annotated[
    str,
    typer.Option(
        "--model",
        help=f"{DELAY.name} (exact; so are auto and the full-wave models), "
        f"{', '.join(family.pattern for family in REDUCTIONS)}, or taylor (the truncation that cannot be used)",
    ),
]

EXAMPLES = (
    "slipwave stability paper",
    "slipwave stability grip --model fitted:4 --json",
)


def stability(
    source: SceneName, model: StabilityModel = "delay", settings: Settings = None, law: Law = None, json: Json = False
) -> None:
    """Stability of steady sliding from the slabs' impedance alone, for any scene and model."""
    result = slipwave.stability(source, model, settings=settings or ())
    printed(lambda: print_json(result.summary) if json else _print(result))


def _print(result: "StabilityResult") -> None:
    from validation.commands.header import print_header

    scene, found = result.scene, result.found
    print_header(scene)
    verdict = "stable" if found.stable else f"unstable: {found.unstable_roots} growing roots (certified count)"
    verdict = "neutral" if found.stable is None else verdict
    print(f"model {found.model}: steady sliding is {verdict} at V = {found.velocity:g}")
    print(result.reason)
    for note in result.notes:
        print(f"note: {note}")
    print()
    rows = [
        ["critical frequency omega_c [V*/L]", figures(found.omega_c, 12), ""],
        ["critical round trip log10 r_c", figures(found.log10_r_c, 12), f"scene {figures(math.log10(scene.transit), 10)}"],
        ["critical epsilon", figures(found.epsilon_c, 12), f"scene {figures(scene.upper.epsilon, 10)}"],
        ["limit of the fast roots, Re s [V*/L]", figures(found.essential_abscissa, 10), ""],
    ]
    print_table(["", "critical", "here"], [*rows, *_in_si(result)])
    print()
    roots = [
        [f"{figures(root.real, 8)} {root.imag:+.8g} i", figures(abs(root.imag) * scene.transit / (2.0 * math.pi), 6)]
        for root in found.leading_roots
        if root.imag >= 0.0
    ]
    print_table(["leading roots s [V*/L], conjugates left out", "cycles per transit"], roots)


def _in_si(result: "StabilityResult") -> list[list[str]]:
    """Rows of the table for a scene with units."""
    scene, found = result.scene, result.physical
    if found is None or scene.units is None:
        return []
    word, time = ("growth", found.growth_time) if result.found.stable is False else ("decay", found.decay_time)
    slabs = "thickness" if scene.alike else "upper thickness, both scaled together"
    return [
        [f"critical {slabs} [m]", figures(found.critical_thickness, 9), f"scene {figures(found.thickness, 9)}"],
        [
            "critical normal stress [Pa]",
            figures(found.critical_normal_stress, 9),
            f"scene {figures(scene.units.normal_stress, 9)}",
        ],
        [f"{word} time of the leading root [s]", "", figures(time, 9)],
        ["frequency of the leading root [Hz]", "", figures(found.frequency, 9)],
    ]

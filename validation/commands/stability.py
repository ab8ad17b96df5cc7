"""`slipwave stability`: is steady sliding stable, where does it lose stability, and how do small disturbances grow?"""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reduced.families import DELAY, REDUCTIONS
from validation.commands.options import Json, SceneName, Settings, read_scene
from validation.registry.families import one_port_of

if TYPE_CHECKING:
    from reduced.stability import Stability
    from slipwave.scene import Scene

StabilityModel = Annotated[
    str,
    typer.Option(
        "--model",
        help=f"{DELAY.name} (exact; so are auto and the full-wave models), "
        f"{', '.join(family.pattern for family in REDUCTIONS)}, or taylor (the truncation that cannot be used)",
    ),
]


def stability(source: SceneName, model: StabilityModel = "delay", settings: Settings = None, json: Json = False) -> None:
    """Stability of steady sliding from the slabs' impedance alone, for any scene and model."""
    from reduced.stability import analyse
    from validation.output import print_json

    scene = read_scene(source, settings)
    found = replace(analyse(scene, one_port_of(model)), model=DELAY.name if model == "auto" else model)
    if json:
        print_json(result_of(scene, found))
    else:
        _print(scene, found)


def result_of(scene: "Scene", found: "Stability") -> dict[str, Any]:
    """The JSON of the command (users rely on its keys); frequencies and roots in 1/(L/V*), null where there is no value."""
    return {
        "scene": scene.name,
        "model": found.model,
        "omega_c": found.omega_c,
        "log10_r_c": found.log10_r_c,
        "epsilon_c": found.epsilon_c,
        "velocity": found.velocity,
        "stable": found.stable,
        "unstable_roots": found.unstable_roots,
        "leading_roots": [[root.real, root.imag] for root in found.leading_roots],
        "essential_abscissa": found.essential_abscissa,
        "notes": notes_of(scene, found),
    }


def notes_of(scene: "Scene", found: "Stability") -> list[str]:
    """Remarks on the numbers: which V was taken on a ramp, why there is no verdict on a neutral root."""
    notes = []
    if not scene.drive.is_constant:
        notes.append(
            f"the drive changes: this is steady sliding at V = {found.velocity:g}, the one at t = 0; set drive.velocity for "
            "others"
        )
    if found.stable is None:
        notes.append(
            f"neutral within rounding: the leading root's real part {found.leading_roots[0].real:.2g} cannot be distinguished "
            "from 0; no other root grows"
        )
    return notes


def _print(scene: "Scene", found: "Stability") -> None:
    import math

    from validation.commands.wording import describe
    from validation.output import figures, print_table

    for line in describe(scene):
        print(line)
    verdict = "stable" if found.stable else f"unstable: {found.unstable_roots} growing roots (certified count)"
    verdict = "neutral" if found.stable is None else verdict
    print(f"model {found.model}: steady sliding is {verdict} at V = {found.velocity:g}")
    for note in notes_of(scene, found):
        print(f"note: {note}")
    print()
    rows = [
        ["critical frequency omega_c [V*/L]", figures(found.omega_c, 12), ""],
        ["critical round trip log10 r_c", figures(found.log10_r_c, 12), f"scene {figures(math.log10(scene.transit), 10)}"],
        ["critical epsilon", figures(found.epsilon_c, 12), f"scene {figures(scene.upper.epsilon, 10)}"],
        ["limit of the fast roots, Re s [V*/L]", figures(found.essential_abscissa, 10), ""],
    ]
    print_table(["", "critical", "here"], rows)
    print()
    roots = [
        [f"{figures(root.real, 8)} {root.imag:+.8g} i", figures(abs(root.imag) * scene.transit / (2.0 * math.pi), 6)]
        for root in found.leading_roots
        if root.imag >= 0.0
    ]
    print_table(["leading roots s [V*/L], conjugates left out", "cycles per transit"], roots)

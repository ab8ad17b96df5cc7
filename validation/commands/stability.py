"""`slipwave stability`: is steady sliding stable, and where would it change? From impedance alone, for any scene and model."""

from typing import TYPE_CHECKING

from validation.commands.options import Json, Model, SceneName, Settings, read_scene

if TYPE_CHECKING:
    from reduced.stability import Stability


def stability(scene: SceneName, model: Model = "auto", settings: Settings = None, json: Json = False) -> None:
    """Tell whether steady sliding is stable, its critical round trip and epsilon, and the leading roots."""
    from reduced.stability import analyse
    from validation.output import print_json
    from validation.wording import describe

    what = read_scene(scene, settings)
    found = analyse(what, "delay" if model == "auto" else model)
    if json:
        roots = [[root.real, root.imag] for root in found.leading_roots]
        print_json(
            {"scene": what.name}
            | {key: value for key, value in vars(found).items() if key != "leading_roots"}
            | {"leading_roots": roots}
        )
        return
    for line in describe(what):
        print(line)
    _print(found)


def _print(found: "Stability") -> None:
    from validation.output import figures

    verdict = "stable" if found.stable else "unstable"
    print(f"model {found.model}: steady sliding is {verdict} ({found.unstable_roots} unstable roots)")
    print(f"omega_c = {figures(found.omega_c, 12)} V*/L at the onset, log10 r_c = {figures(found.log10_r_c, 12)}")
    print(f"epsilon_c = {figures(found.epsilon_c, 12)} at the scene's r")
    print("leading roots [V*/L]: " + ", ".join(f"{root.real:.9g} {root.imag:+.9g}i" for root in found.leading_roots))
    if found.essential_abscissa == found.essential_abscissa:
        print(f"the infinitely many fast roots tend to the real part {figures(found.essential_abscissa, 9)}")

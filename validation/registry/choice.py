"""Models by their names on the command line: which family computes one, which options it takes, which scenes it can do.

A family whose module is not part of this installation is not listed.
"""

import string
from collections.abc import Collection
from functools import cache
from importlib.util import find_spec
from typing import Unpack

from slipwave.errors import SceneError
from slipwave.family import Exact, Family, features_of, in_words
from slipwave.input.wording import nearest, shorten
from slipwave.scene import Scene
from validation.registry.families import DELAY, FAMILIES, OPTIONS, Options, family_of, given


@cache
def _is_part(module: str) -> bool:
    return find_spec(module) is not None


def families() -> list[Family]:
    """The families of this installation, cheapest first."""
    return [family for family in FAMILIES if _is_part(family.module)]


def honouring(scene: Scene) -> list[Family]:
    """The families of this installation that can do `scene`."""
    return [family for family in families() if family.is_installed and not family.refusal(scene)]


def resolve(model: str, scene: Scene, among: Collection[Family] = FAMILIES) -> tuple[str, str]:
    """(model, why): `auto` becomes the cheapest model `among` some that is exact for the scene; any other name is returned with
    no reason."""
    if model != "auto":
        return model, ""
    chosen = [family for family in honouring(scene) if family in among]
    if not chosen:
        raise SceneError(f"model = 'auto': no model of this installation can do {in_words(features_of(scene))}")
    best = next((family for family in chosen if family.exact is not Exact.NEVER), chosen[0])
    refusal = DELAY.refusal(scene) or "it is not part of this installation"
    why = "exact for this scene" if best is DELAY else f"the delay system cannot do {refusal}"
    return best.example, why


def requested(model: str, scene: Scene, **options: Unpack[Options]) -> tuple[Family, Scene, int | None, Options]:
    """What `make` needs for a full name: its family, the scene, the number after the colon, and the options. Raises SceneError as
    `prepare` does."""
    family, number = parse(model)
    _require_options(model, family, options)
    if number is None:
        number = family.chosen(options.get("tolerance"))
    refusal = family.refusal(scene)
    if refusal:
        able = ", ".join(other.pattern for other in honouring(scene)) or "none of this installation"
        raise SceneError(f"model = {model!r}: cannot do {refusal} (scene {scene.name!r}); models that can: {able}")
    return family, scene, number, options


def parse(model: str) -> tuple[Family, int | None]:
    """Family and number of a model's name; no number where it is chosen or there is none. Raises SceneError."""
    name, colon, number = model.partition(":")
    family = family_of(name)
    if family is None or family not in families():
        known = ", ".join(["auto", *(family.pattern for family in families())])
        guess, rest = nearest(name, [family.name for family in families()]), name.lstrip(string.ascii_letters)
        meant = (
            f"{guess}:{rest}"
            if rest.isdigit() and any(family.name == guess and family.numbers for family in families())
            else guess
        )
        hint = f'; did you mean "{meant}"?' if guess else ""
        raise SceneError(f"model = {shorten(model)}: must be one of {known}{hint}")
    if not colon and family.suited is not None:
        return family, None
    if not family.numbers:
        if colon:
            raise SceneError(f"model = {shorten(model)}: {name} takes no number")
        return family, None
    if not (number.isascii() and number.isdigit() and len(number) < 9 and int(number) in family.numbers):
        raise SceneError(f"model = {shorten(model)}: must be {family.pattern} with {_numbers(family.numbers)}")
    return family, int(number)


def _numbers(allowed: range | tuple[int, ...]) -> str:
    if isinstance(allowed, range):
        return f"a whole number from {allowed.start} to {allowed.stop - 1}"
    return f"one of {', '.join(str(number) for number in allowed)}"


def _require_options(model: str, family: Family, options: Options) -> None:
    for name, value in given(options, *OPTIONS).items():
        if name not in family.options:
            takers = ", ".join(other.pattern for other in families() if name in other.options)
            raise SceneError(f"{name} = {value}: model {model} takes no {name}; models that do: {takers}")
    cfl, tolerance = options.get("cfl"), options.get("tolerance")
    if options.get("time") == "exact" and cfl is not None:
        raise SceneError(f"cfl = {cfl:g}: the exact march has no step limit; leave it out, or choose --time explicit")
    least, most = family.tolerances
    if tolerance is not None and not least <= tolerance <= most:
        raise SceneError(f"tolerance = {tolerance:g}: must lie in [{least:g}, {most:g}] for model {model}")

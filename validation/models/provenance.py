"""Provenance of a result: the global attributes of its file (docs/output-files.md), enough to compute it again."""

import datetime
import json
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import version
from typing import Any

from slipwave.errors import SceneError
from slipwave.files import CONVENTIONS
from slipwave.friction.law import name_of
from slipwave.friction.own import own_law
from slipwave.input.assemble import to_toml
from slipwave.scene import Scene
from slipwave.sources import commit
from validation.models.own import own_family

SCHEMA = 1
"""Version of the names in files and of the keys of the JSON of every command."""


def provenance(command: str, scene: Scene, model: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes of a result of `command`: the resolved scene as TOML (not for one that was made in Python), the model and the
    options of the call that were given, the scene's numbers, and when and by which program it was computed."""
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    law, family = own_law(name_of(scene.law)), own_family(model)
    program = f"slipwave {version('slipwave')}, commit {commit()}"
    scene_text = dict[str, str]()
    with suppress(SceneError):
        scene_text["scene_toml"] = to_toml(scene)
    return {
        "Conventions": CONVENTIONS,
        "title": f"slipwave {command} of scene {scene.name} with model {model}",
        "institution": "computed by the user",
        "source": program,
        "history": f"{now} slipwave {command}",
        "references": "Putelat, Willis and Dawes (2012), Wave-modulated orbits in rate-and-state friction",
        "command": command,
        "schema": SCHEMA,
        "date": now,
        "slipwave_version": version("slipwave"),
        "commit": commit(),
        "scene": scene.name,
        "scene_digest": scene.digest,
        **scene_text,
        **({"law_file": law.path.name, "law_digest": law.digest} if law else {}),
        "model": model,
        **({"family_file": family.path.name, "family_digest": family.digest} if family else {}),
        "options": json.dumps({name: value for name, value in options.items() if value is not None}),
        **_numbers(scene),
    }


def _numbers(scene: Scene) -> dict[str, float]:
    slabs = {"": scene.upper} if scene.alike else {"_upper": scene.upper, "_lower": scene.lower}
    numbers = {f"epsilon{name}": slab.epsilon for name, slab in slabs.items()}
    numbers |= {f"r{name}": slab.round_trip for name, slab in slabs.items()}
    numbers |= {"V": scene.velocity, "transit_in_friction_time": scene.transit}
    if scene.units is None:
        return numbers
    units = scene.units
    return numbers | {
        "transit_s": units.size("transit", scene.transit),
        "memory_length_m": units.memory_length,
        "reference_velocity_m_per_s": units.reference_velocity,
        "normal_stress_Pa": units.normal_stress,
    }

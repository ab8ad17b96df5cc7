"""Scenes in SI. Answers on a block of granite are known by hand: slabs of 10 m stick and slip, slabs of 0.2 m slide steadily."""

from typing import Any

GRANITE = {
    "interface": {"law": "ageing", "a_star": 0.6, "a": 0.01, "b": 0.015}
    | {"normal_stress": 5e6, "memory_length": 1e-5, "reference_velocity": 1e-6},
    "slab": {"density": 2700.0, "shear_modulus": 30e9, "thickness": 10.0},
    "drive": {"velocity": 1.0},
}
THIN = GRANITE | {"slab": GRANITE["slab"] | {"thickness": 0.2}}
SAMPLE: dict[str, Any] = {
    "name": "1 mm sample",
    "interface": {"law": "ageing", "a_star": 0.6, "a": 0.008, "b": 0.014}
    | {"normal_stress": "5 MPa", "memory_length": "5 um", "reference_velocity": "1 um/s"},
    "slab": {"density": "2.7 g/cm3", "shear_modulus": "30 GPa", "thickness": "1 mm"}
    | {"face": {"kind": "machine", "stiffness": "8 GPa/m", "impedance": 0, "mass": 0}},
    "drive": {"velocity": "10 um/s"},
    "start": {"kind": "jump", "size": 0.05},
    "run": {"until": "50 s"},
}
"""A laboratory sample in a machine, which stick-slips."""

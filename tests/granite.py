"""A block of granite in SI, whose answers are known by hand: 10 m thick slabs stick and slip, slabs of 0.2 m slide steadily."""

GRANITE = {
    "interface": {
        "law": "ageing",
        "a_star": 0.6,
        "a": 0.01,
        "b": 0.015,
        "normal_stress": 5e6,
        "memory_length": 1e-5,
        "reference_velocity": 1e-6,
    },
    "slab": {"density": 2700.0, "shear_modulus": 30e9, "thickness": 10.0},
    "drive": {"velocity": 1.0},
}
THIN = GRANITE | {"slab": GRANITE["slab"] | {"thickness": 0.2}}

"""One override changes one thing: whatever is set of one slab, nothing of the other one changes."""

import pytest

import slipwave

CHANGES = {
    "face.stiffness": ("grip", 3.0),
    "face.impedance": ("grip", 0.3),
    "face.mass": ("machine", 3.0),
    "face.kind": ("grip", "rigid"),
    "viscosity.time": ("viscous", 1e-6),
    "layers": ("layered", [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 2.5}]),
    "epsilon": ("paper", 3e-5),
    "log10_r": ("paper", -2.5),
}


@pytest.mark.parametrize("key", CHANGES)
@pytest.mark.parametrize("side", ["upper", "lower"])
def test_an_override_of_one_slab_leaves_the_other_as_it_was(key: str, side: str) -> None:
    name, value = CHANGES[key]
    before, after = slipwave.read(name), slipwave.read(name, {f"{side}.{key}": value})
    other = "lower" if side == "upper" else "upper"
    assert getattr(after, other) == getattr(before, other)
    assert getattr(after, side) != getattr(before, side)
    assert (after.law, after.drive, after.start, after.until) == (before.law, before.drive, before.start, before.until)

"""Every key of a scene file with its type and range (README: the table of scene keys). Shape only: `assemble` joins the keys.

A text in an annotation says what is allowed, as a `Range` does for a number; `complain` reads both.
"""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, PlainValidator, StringConstraints, Tag
from pydantic_core import PydanticCustomError

from slipwave.input.number import (
    LATER_VELOCITY,
    TIME,
    VELOCITY,
    Area,
    Coefficient,
    Density,
    Epsilon,
    Fraction,
    GripImpedance,
    GripStiffness,
    Length,
    LogRoundTrip,
    MachineImpedance,
    MachineMass,
    MachineStiffness,
    Relative,
    Relaxation,
    RoundTrip,
    Size,
    Stress,
    Until,
)
from slipwave.input.quantity import Quantity


def _printable(text: str) -> str:
    """`text`, if it has no characters that could control a terminal or that a file could not hold."""
    if not text.isprintable():
        raise PydanticCustomError("printable", "cannot be printed")
    return text


Text: TypeAlias = Annotated[
    str,
    StringConstraints(min_length=1, max_length=200),
    AfterValidator(_printable),
    "a text of 1 to 200 printable characters",
]
MAX_LAYERS = 100
MAX_RAMPS = 10_000


class Table(BaseModel):
    """A table of the scene file: no unknown keys, no coercion."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class RigidTable(Table):
    """The drive moves the outer face."""

    kind: Literal["rigid"] = "rigid"


class GripTable(Table):
    """Spring (relative to epsilon/r) and dashpot (relative to epsilon) between drive and outer face."""

    kind: Literal["grip"]
    stiffness: GripStiffness
    impedance: GripImpedance


class MachineTable(Table):
    """A grip with a mass on the slab's face (relative to epsilon r). Scenes with units give Pa/m, Pa s/m and kg/m2 instead, or,
    with the `area` of contact, N/m, N s/m and kg."""

    kind: Literal["machine"]
    stiffness: MachineStiffness
    impedance: MachineImpedance
    mass: MachineMass
    area: Area | None = None


class ReflectionTable(Table):
    """Bare reflection coefficient."""

    kind: Literal["reflection"]
    coefficient: Coefficient


class KelvinVoigtTable(Table):
    """Retardation time in L/V* (in SI scenes too, unless it has a unit)."""

    kind: Literal["kelvin-voigt"]
    time: Relaxation


class StandardLinearTable(Table):
    """Relaxation time in L/V* (in SI scenes too, unless it has a unit) and ratio of the relaxing to the lasting modulus."""

    kind: Literal["standard-linear"]
    time: Relaxation
    ratio: Relative


def _kind(default: str) -> Discriminator:
    def tag(value: Any) -> Any:
        """The `kind` of a table."""
        return value.get("kind", default) if isinstance(value, dict) else getattr(value, "kind", default)

    return Discriminator(tag)


FaceTable: TypeAlias = Annotated[
    Annotated[RigidTable, Tag("rigid")]
    | Annotated[GripTable, Tag("grip")]
    | Annotated[MachineTable, Tag("machine")]
    | Annotated[ReflectionTable, Tag("reflection")],
    _kind("rigid"),
]
ViscosityTable: TypeAlias = Annotated[
    Annotated[KelvinVoigtTable, Tag("kelvin-voigt")] | Annotated[StandardLinearTable, Tag("standard-linear")], _kind("")
]


class LayerTable(Table):
    """A sublayer, from the interface outwards: share of the round trip, impedance relative to the slab's epsilon."""

    fraction: Fraction
    impedance: Relative


Layers: TypeAlias = Annotated[
    list[LayerTable],
    Field(min_length=2, max_length=MAX_LAYERS),
    f"a list of 2 to {MAX_LAYERS} tables {{fraction, impedance}}, from the interface outwards",
]


class SlabTable(Table):
    """A slab: epsilon, or density and shear_modulus; and one of r, log10_r, thickness."""

    epsilon: Epsilon | None = None
    r: RoundTrip | None = None
    log10_r: LogRoundTrip | None = None
    density: Density | None = None
    shear_modulus: Stress | None = None
    thickness: Length | None = None
    face: FaceTable = RigidTable()
    viscosity: ViscosityTable | None = None
    layers: Layers | None = None


Ramps: TypeAlias = list[tuple[float | Quantity, float | Quantity]]
_RAMPS = "a velocity or a list of [time, velocity]"


def _ramps(value: Any) -> Ramps:
    """The ramps: one velocity V becomes [[0, V]]; in a list the first velocity must be positive."""
    if not isinstance(value, list):
        return [(0.0, VELOCITY(value))]
    if not 1 <= len(value) <= MAX_RAMPS or not all(isinstance(pair, list) and len(pair) == 2 for pair in value):
        raise PydanticCustomError("ramps", f"must be {_RAMPS}")
    return [(TIME(time), (LATER_VELOCITY if k else VELOCITY)(velocity)) for k, (time, velocity) in enumerate(value)]


class DriveTable(Table):
    """Total velocity in V*, or ramps [time in transits of the upper slab, velocity], constant outside them; the same time
    twice is a step, V = 0 a hold."""

    velocity: Annotated[Ramps, PlainValidator(_ramps), _RAMPS]


class StartTable(Table):
    """How the run starts; `size` is the disturbance of psi."""

    kind: Literal["nudge", "jump", "orbit"] = "nudge"
    size: Size | None = None


class RunTable(Table):
    """Length of the run in transits of the upper slab, or until its motion is settled, and what is recorded."""

    until: Until | None = None
    record: Annotated[list[Literal["events", "interface", "fields"]], 'a list of "events", "interface", "fields"'] = ["events"]


class SceneTable(Table):
    """A whole scene file; [interface] is checked against its law's own parameters (`validate`)."""

    name: Text | None = None
    title: Text | None = None
    interface: dict[str, Any]
    slab: SlabTable | None = None
    upper: SlabTable | None = None
    lower: SlabTable | None = None
    drive: DriveTable
    start: StartTable = StartTable()
    run: RunTable = RunTable()

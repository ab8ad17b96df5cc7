"""The table of keys: every key of a scene file with type, allowed values, units and meaning, on one line each.

Validation, messages, short keys, the JSON Schema (`slipwave schema`) and README's table of keys are all read from here. Keys that
depend on each other are combined in `assemble`. A text in an annotation states the allowed values, as `Numbers` does for a
number.
"""

import math
import numbers
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints, create_model
from pydantic.fields import FieldInfo
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from slipwave.friction import LAWS
from slipwave.input.quantity import KINDS, Quantity, examples, looks_measured, quantity
from slipwave.scene.recorded import RECORDED


@dataclass(frozen=True)
class Numbers:
    """The numbers from `low` to `high`, as metadata of a key's type: its validator and its JSON Schema.

    With `units` a text with one of them ("5 MPa") is allowed too and becomes a `Quantity`. `bare`: the unit of numbers without
    one.
    """

    low: float
    high: float
    units: tuple[str, ...] = ()
    bare: str = ""

    def __call__(self, value: Any) -> Any:
        """`value` as a float or a `Quantity`; raises the pydantic error that states what is allowed."""
        if self.units and isinstance(value, str) and looks_measured(value):
            try:
                return quantity(value, *self.units)
            except ValueError as error:
                raise PydanticCustomError("range", "{reason}", {"reason": str(error)}) from None
        if not isinstance(value, bool) and isinstance(value, numbers.Real):
            try:
                number = float(value)
            except (OverflowError, ValueError):
                number = math.inf
            if self.low <= number <= self.high:
                return number
        raise self.refusal()

    def refusal(self) -> PydanticCustomError:
        """The error that states what is allowed."""
        return PydanticCustomError("range", "must be {allowed}", {"allowed": str(self)})

    def __str__(self) -> str:
        number = f"a number from {self.low:g} to {self.high:g}"
        return f"{number}, or with a unit, as in {examples(self.units)}" if self.units else number

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        return self.json_schema()

    def json_schema(self) -> dict[str, Any]:
        """The range, and a text that begins with a number if there are units, in the words of JSON Schema."""
        number = {"type": "number", "minimum": self.low, "maximum": self.high}
        measured = {"type": "string", "pattern": r"^\s*[-+]?\.?\d", "examples": [KINDS[unit][1] for unit in self.units]}
        return {"anyOf": [number, measured]} if self.units else number


class Physical(Numbers):
    """A number in SI units in the range, or a text with such a unit; both become a float in SI."""

    def __call__(self, value: Any) -> Any:
        """As `Numbers`, but a float in all cases."""
        given = super().__call__(value)
        return super().__call__(given.value) if isinstance(given, Quantity) else given


def physical(unit: str) -> Physical:
    """A number in the SI `unit`, in the range of laboratories."""
    return Physical(1e-15, 1e15, (unit,))


EPSILON = Numbers(1e-12, 1e6)
ROUND_TRIP = Numbers(1e-9, 1e6)
VELOCITY = Numbers(1e-12, 1e12, ("m/s",), "in V*")
LATER_VELOCITY = Numbers(0.0, VELOCITY.high, VELOCITY.units, VELOCITY.bare)
TIME = Numbers(0.0, 1e9, ("s",), "of transits")
RELAXATION = Numbers(1e-15, 1e9, ("s",), "in L/V*")
UNTIL = Numbers(1e-3, 1e9, ("s",), "of transits")
RATIO = Numbers(1e-9, 1e9)
"""Ratio of two quantities of the same kind."""

UNIT_KEYS = ("normal_stress", "memory_length", "reference_velocity")
MAX_LAYERS = 100
MAX_RAMPS = 10_000
_PARAMETERS = {
    "a_star": (Numbers(-1e3, 1e3), "friction of steady sliding at V*"),
    "a": (Numbers(1e-9, 10.0), "direct effect"),
    "b": (Numbers(0.0, 10.0), "evolution effect"),
    "cutoff_velocity": (VELOCITY, "slip rate above which the state effect is cut off"),
    "saturation_velocity": (VELOCITY, "slip rate below which contacts age no further"),
}
_OTHER_PARAMETER = (Numbers(-1e9, 1e9), "parameter of the law")


def _printable(text: str) -> str:
    """`text`, if it has no control characters and none that a file cannot contain."""
    if not text.isprintable():
        raise PydanticCustomError("printable", "cannot be printed")
    return text


_SHORT = StringConstraints(min_length=1, max_length=200)
Measured: TypeAlias = float | Quantity
Text: TypeAlias = Annotated[str, _SHORT, AfterValidator(_printable), "a text of 1 to 200 printable characters"]


def _optional(meaning: str, title: str | None = None) -> Any:
    return Field(default=None, title=title, description=meaning)


class KeyTable(BaseModel):
    """A table of the scene file: no unknown keys, no coercion."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class InterfaceTable(KeyTable):
    """The friction law, its parameters and, for scenes in SI, all three units."""

    law: str = Field(description="friction law")
    normal_stress: Annotated[float, physical("Pa")] | None = _optional("sigma, for scenes in SI", "normal stress σ")
    memory_length: Annotated[float, physical("m")] | None = _optional("L, for scenes in SI", "memory length L")
    reference_velocity: Annotated[float, physical("m/s")] | None = _optional("V*, for scenes in SI", "reference velocity V*")


class RigidTable(KeyTable):
    """The drive moves the outer face."""

    kind: Literal["rigid"] = Field(default="rigid", description="what holds the outer face")


class GripTable(KeyTable):
    """Spring and dashpot between drive and outer face."""

    kind: Literal["grip"]
    stiffness: Annotated[Measured, Numbers(1e-9, 1e9, ("Pa/m",))] = Field(
        title="stiffness of the face's spring / (ε/r)", description="relative to epsilon/r"
    )
    impedance: Annotated[Measured, Numbers(0.0, 1e9, ("Pa s/m",))] = Field(
        title="impedance of the face's dashpot / ε", description="relative to epsilon"
    )


class MachineTable(KeyTable):
    """A grip with a mass on the slab's face. A mass of 1 is twice the slab's own."""

    kind: Literal["machine"]
    stiffness: Annotated[Measured, Numbers(0.0, 1e15, ("Pa/m", "N/m"))] = Field(
        title="stiffness of the face's spring / (ε/r)", description="relative to epsilon/r, or in SI"
    )
    impedance: Annotated[Measured, Numbers(0.0, 1e15, ("Pa s/m", "N s/m"))] = Field(
        title="impedance of the face's dashpot / ε", description="relative to epsilon, or in SI"
    )
    mass: Annotated[Measured, Numbers(0.0, 1e15, ("kg/m2", "kg"))] = Field(
        title="mass on the face / (ε r)", description="relative to epsilon r, or in SI"
    )
    area: Annotated[float, physical("m2")] | None = _optional("of contact, in SI: then numbers are N/m, N s/m, kg")


class ReflectionTable(KeyTable):
    """Bare reflection coefficient."""

    kind: Literal["reflection"]
    coefficient: Annotated[float, Numbers(-1.0, 1.0)] = Field(
        title="reflection coefficient of the outer face", description="1 is rigid, 0 absorbs waves and load"
    )


class KelvinVoigtTable(KeyTable):
    """Creep that ends."""

    kind: Literal["kelvin-voigt"] = Field(description="viscosity; none: elastic")
    time: Annotated[Measured, RELAXATION] = Field(
        title="retardation time / (L/V*)", description="retardation time in L/V*, in SI scenes too"
    )


class StandardLinearTable(KeyTable):
    """Stress that relaxes to a part of itself."""

    kind: Literal["standard-linear"] = Field(description="viscosity; none: elastic")
    time: Annotated[Measured, RELAXATION] = Field(
        title="relaxation time / (L/V*)", description="relaxation time in L/V*, in SI scenes too"
    )
    ratio: Annotated[float, RATIO] = Field(
        description="the relaxing modulus over the lasting one; epsilon, r and shear_modulus are those of their sum, unrelaxed"
    )


def _rigid_by_default(face: Any) -> Any:
    return {"kind": "rigid"} | face if isinstance(face, dict) else face


FaceTable: TypeAlias = Annotated[
    RigidTable | GripTable | MachineTable | ReflectionTable,
    Field(discriminator="kind"),
    BeforeValidator(_rigid_by_default),
]
ViscosityTable: TypeAlias = Annotated[KelvinVoigtTable | StandardLinearTable, Field(discriminator="kind")]


class LayerTable(KeyTable):
    """A sublayer."""

    fraction: Annotated[float, Numbers(1e-9, 1.0)] = Field(description="share of the round trip; all add up to 1")
    impedance: Annotated[float, RATIO] = Field(description="relative to the slab's epsilon")


_LAYERS = f"a list of 2 to {MAX_LAYERS} tables {{fraction, impedance}}, from the interface outwards"
Layers: TypeAlias = Annotated[list[LayerTable], Field(min_length=2, max_length=MAX_LAYERS), _LAYERS]


class SlabTable(KeyTable):
    """A slab: epsilon, or density and shear_modulus; and one of r, log10_r, thickness."""

    epsilon: Annotated[float, EPSILON] | None = _optional("impedance rho c V*/sigma", "impedance of a slab ε")
    r: Annotated[float, ROUND_TRIP] | None = _optional("round trip over L/V*", "round trip r / (L/V*)")
    log10_r: Annotated[float, Numbers(-9.0, 6.0)] | None = _optional("its decimal logarithm, instead of r", "round trip log₁₀ r")
    density: Annotated[float, physical("kg/m3")] | None = _optional(
        "rho, with shear_modulus, in SI instead of epsilon", "density ρ"
    )
    shear_modulus: Annotated[float, physical("Pa")] | None = _optional(
        "G, with density, in SI instead of epsilon", "shear modulus G"
    )
    thickness: Annotated[float, physical("m")] | None = _optional("H of one slab, in SI instead of r", "thickness of a slab H")
    face: FaceTable = RigidTable()
    viscosity: ViscosityTable | None = None
    layers: Layers | None = None


Ramps: TypeAlias = list[tuple[Measured, Measured]]


class _Ramps(Numbers):
    """V, or a list of [time, V] whose first V is positive; one V becomes [[0, V]]."""

    def __call__(self, value: Any) -> Ramps:
        if not isinstance(value, list):
            return [(0.0, VELOCITY(value))]
        if not 1 <= len(value) <= MAX_RAMPS or not all(isinstance(pair, list) and len(pair) == 2 for pair in value):
            raise self.refusal()
        return [(TIME(time), (LATER_VELOCITY if k else VELOCITY)(velocity)) for k, (time, velocity) in enumerate(value)]

    def __str__(self) -> str:
        return "a velocity or a list of [time, velocity]"

    def json_schema(self) -> dict[str, Any]:
        pair = {"type": "array", "prefixItems": [TIME.json_schema(), super().json_schema()], "minItems": 2, "maxItems": 2}
        return {"anyOf": [VELOCITY.json_schema(), {"type": "array", "items": pair, "minItems": 1, "maxItems": MAX_RAMPS}]}


class MachineOfSampleTable(KeyTable):
    """Springs alike on both outer faces."""

    k: Annotated[Measured, Numbers(1e-12, 1e12, ("1/m",))] = Field(
        title="stiffness of the whole sample over normal stress k",
        description="stiffness of the slabs and equal springs on their faces over the normal stress, in 1/L or SI; "
        "instead of face",
    )


class DriveTable(KeyTable):
    """The relative velocity of the outer faces, constant outside the ramps."""

    velocity: Annotated[Ramps, _Ramps(**vars(LATER_VELOCITY))] = Field(
        title="velocity of the drive V / V*",
        description="V in V*, or ramps [time in transits, V]; the same time twice is a step, V = 0 a hold",
    )


class StartTable(KeyTable):
    """How the run starts."""

    kind: Literal["nudge", "jump", "orbit"] = Field(
        default="nudge", description="smooth, a jump of psi, or on the model's own orbit"
    )
    size: Annotated[float, Numbers(-100.0, 100.0)] | None = _optional("of the disturbance of psi")


_RECORD = "a list of " + ", ".join(f'"{name}"' for name in RECORDED)


class RunTable(KeyTable):
    """The length of the run and what is recorded."""

    until: Annotated[Measured, UNTIL] | None = _optional(
        "length in transits of the upper slab; none: until the motion is settled"
    )
    record: Annotated[list[Literal[RECORDED]], _RECORD] = Field(  # type: ignore[valid-type]
        default=["events"], description="what is kept"
    )


class SceneTable(KeyTable):
    """A whole scene file; `scene_keys` has the [interface] of each law."""

    name: Text | None = _optional("name of the scene; none: that of the file")
    title: Text | None = _optional("one line about it")
    interface: InterfaceTable
    slab: SlabTable | None = None
    upper: SlabTable | None = _optional("instead of slab, where the slabs differ: the same keys")
    lower: SlabTable | None = _optional("instead of slab, where the slabs differ: the same keys")
    machine: MachineOfSampleTable | None = None
    drive: DriveTable
    start: StartTable = StartTable()
    run: RunTable = RunTable()


def scene_keys() -> type[SceneTable]:
    """The schema of scene files with the friction laws that this process knows."""
    return _scene_keys(tuple((name, law.parameters) for name, law in LAWS.items()))


@cache
def _scene_keys(laws: tuple[tuple[str, Any], ...]) -> type[SceneTable]:
    tables = tuple(_interface_table(name, parameters) for name, parameters in laws)
    union: Any = Annotated[Union[tables], Field(discriminator="law")]  # noqa: UP007
    return create_model("Scene", __base__=SceneTable, interface=(union, ...))


def _interface_table(name: str, parameters: Any) -> type[KeyTable]:
    """[interface] of the law `name` with this parameter class."""
    fields: dict[str, Any] = {"law": (Literal[name], Field(description="friction law"))}
    for key in parameters._fields:
        allowed, meaning = _PARAMETERS.get(key, _OTHER_PARAMETER)
        title = f"{meaning} {key}" if key in _PARAMETERS else None
        default = parameters._field_defaults.get(key, ...)
        fields[key] = (Annotated[float, allowed], Field(default, title=title, description=meaning))
    fields |= {key: (field.annotation, field) for key, field in InterfaceTable.model_fields.items() if key != "law"}
    return create_model(name, __base__=KeyTable, **fields)


class _WithoutNull(GenerateJsonSchema):
    """TOML has no null: a key without a value is left out."""

    def nullable_schema(self, schema: Any) -> dict[str, Any]:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: Any) -> dict[str, Any]:
        return self.generate_inner(schema["schema"]) if schema.get("default") is None else super().default_schema(schema)


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of scene files, for editors."""
    return {"$schema": _WithoutNull.schema_dialect} | scene_keys().model_json_schema(schema_generator=_WithoutNull)


def tables_in(hint: Any, lists: bool = True) -> dict[str, type[KeyTable]]:
    """Kind -> table, of the tables that a type of the schema contains, also in `lists`. The kind is the only value of a table's
    first key, else empty."""
    if isinstance(hint, type) and issubclass(hint, KeyTable):
        words = get_args(next(iter(hint.model_fields.values())).annotation)
        return {words[0] if len(words) == 1 else "": hint}
    parts = get_args(hint) if lists or get_origin(hint) is not list else ()
    return {kind: table for part in parts for kind, table in tables_in(part, lists).items()}


def allowed_in(hint: Any) -> Iterator[Numbers | str]:
    """Allowed values of a key, from the metadata of its type or of the type's parts."""
    yield from (item for item in getattr(hint, "metadata", getattr(hint, "__metadata__", ())) if isinstance(item, Numbers | str))
    for part in (hint.annotation,) if isinstance(hint, FieldInfo) else get_args(hint):
        yield from allowed_in(part)


def allowed_numbers(table: KeyTable, key: str) -> Numbers:
    """The numbers that a key of a checked table may be."""
    return next(kind for kind in allowed_in(type(table).model_fields[key]) if isinstance(kind, Numbers))

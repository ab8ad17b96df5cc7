"""Turns raw tables into validated tables; the first fault becomes a SceneError of one line."""

from collections.abc import Hashable
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, cast

from pydantic import BaseModel, BeforeValidator, ValidationError, create_model

from slipwave.errors import SceneError
from slipwave.friction import LAWS
from slipwave.input import schema
from slipwave.input.complain import complaint
from slipwave.input.number import Length, Range, Speed, Stress
from slipwave.input.wording import choices, shorten

Checked = TypeVar("Checked", bound=BaseModel)

_PARAMETER_RANGES = {"a_star": Range(-1e3, 1e3), "a": Range(1e-9, 10.0), "b": Range(0.0, 10.0)}
_OTHER_PARAMETER = Range(-1e9, 1e9)
_UNITS: dict[str, Any] = {"normal_stress": Stress, "memory_length": Length, "reference_velocity": Speed}


class Validated(NamedTuple):
    """The scene's tables, the law's name, its parameters, and L, V*, sigma if given."""

    tables: schema.SceneTable
    law: str
    parameters: dict[str, float]
    units: dict[str, float]


def validate(data: dict[str, Any]) -> Validated:
    """Check every key of a scene's raw tables. Raises SceneError naming the first faulty key, its value and its range."""
    tables = _checked(schema.SceneTable, data, ())
    law = tables.interface.get("law")
    if not isinstance(law, str) or law not in LAWS:
        raise SceneError(f"interface.law = {shorten(law)}: must be {choices(LAWS, law)}")
    table = _interface_table(cast(Hashable, LAWS[law].parameters))
    checked = _checked(table, tables.interface, ("interface",)).model_dump()
    units = {key: checked[key] for key in _UNITS if checked[key] is not None}
    parameters = {key: checked[key] for key in LAWS[law].parameters._fields}
    return Validated(tables, law, parameters, units)


@cache
def _interface_table(parameters: Any) -> type[BaseModel]:
    """Schema of [interface] for the law with this parameter class: its parameters and, for SI scenes, the three units."""
    fields: dict[str, Any] = {"law": (Annotated[str, "the name of a friction law"], ...)}
    for key in parameters._fields:
        allowed = Annotated[float, BeforeValidator(_PARAMETER_RANGES.get(key, _OTHER_PARAMETER))]
        fields[key] = (allowed, parameters._field_defaults.get(key, ...))
    fields |= {key: (kind | None, None) for key, kind in _UNITS.items()}
    return create_model("InterfaceTable", __base__=schema.Table, **fields)


def _checked(model: type[Checked], data: dict[str, Any], above: tuple[str, ...]) -> Checked:
    try:
        return model.model_validate(data)
    except ValidationError as failure:
        # a misspelt key is unknown, and the right one is missing: the unknown key is reported, because it explains both
        faults = sorted(
            failure.errors(include_url=False), key=lambda fault: fault["type"] not in ("extra_forbidden", "invalid_key")
        )
        raise SceneError(complaint(faults[0], above, model.model_fields)) from None

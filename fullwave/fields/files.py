"""Field records as files and as a picture: netCDF through xarray; VTU (a space-time sheet) and XDMF (a series of profiles)
through meshio; velocity and stress in the (time, depth) plane through matplotlib.

Position is the depth as a fraction of the travel time, counted upwards from the interface: positive in the upper slab, negative
in the lower. Every file is written whole or not at all.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fullwave.fields.record import QUANTITIES, Field
from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import whole_or_absent
from slipwave.observe.pieces import Array
from slipwave.scene.units import IN_SI


def write_field(path: Path, field: Field) -> None:
    """Write `field` as .nc, .vtu or .xdmf. Raises SceneError for any other name or if the file cannot be written."""
    writers: dict[str, Callable[[Path, Field], None]] = {
        ".nc": lambda path, field: field.dataset().to_netcdf(path, engine="netcdf4"),
        ".vtu": _write_sheet,
        ".xdmf": _write_series,
    }
    if path.suffix not in writers:
        raise SceneError(f"fields = {str(path)!r}: the name must end in {', '.join(writers)}")
    require("files", f"fields = {str(path)!r}")
    with whole_or_absent(path) as temporary:
        writers[path.suffix](temporary, field)


def profile(field: Field) -> tuple[Array, Array, Array]:
    """(position (n,), velocity (k, n), stress (k, n)) through both slabs, from the lower outer face to the upper one; the lower
    of alike slabs is the reflected upper one. The interface appears twice, once per slab."""
    upper = field.upper
    depth, velocity, stress = (
        (upper.depth, -upper.velocity, upper.stress)
        if field.lower is None
        else (field.lower.depth, field.lower.velocity, field.lower.stress)
    )
    position = np.concatenate((-depth[::-1], upper.depth))
    return position, np.hstack((velocity[:, ::-1], upper.velocity)), np.hstack((stress[:, ::-1], upper.stress))


def _write_sheet(path: Path, field: Field) -> None:
    """Write the space-time sheet: quadrilaterals over (time in transits, position), with velocity and stress at the points, for a
    scene with units in SI too.

    Cells of zero height (at the interface and at element boundaries) are left out, so slip appears as a sharp cut.
    """
    import meshio

    position, velocity, stress = profile(field)
    moments, depths = field.time.size, position.size
    points = np.zeros((moments * depths, 3))
    points[:, 0] = np.repeat(field.time, depths)
    points[:, 1] = np.tile(position, moments)
    thick = np.flatnonzero(np.diff(position) > 0.0)
    corner = (np.arange(moments - 1)[:, None] * depths + thick).ravel()
    quads = np.column_stack((corner, corner + depths, corner + depths + 1, corner + 1))
    values = {"velocity": velocity.ravel(), "stress": stress.ravel()}
    mesh = meshio.Mesh(points, [("quad", quads)], point_data=values | _in_si(field, time=points[:, 0], **values))
    mesh.write(path, file_format="vtu")


def _in_si(field: Field, **values: Array) -> dict[str, Array]:
    """Twins in SI of `time`, `velocity` and `stress`, named as in the JSON, for a scene with units; else nothing."""
    sizes = {name: field.si_size(name) for name in values}
    return {f"{name}_{IN_SI[QUANTITIES[name][1]][1]}": values[name] * size for name, size in sizes.items() if size is not None}


def _write_series(path: Path, field: Field) -> None:
    """Write one XML file that contains all data, so that it is whole or absent."""
    import meshio

    position, velocity, stress = profile(field)
    points: NDArray[Any] = np.column_stack((np.zeros(position.size), position, np.zeros(position.size)))
    thick = np.flatnonzero(np.diff(position) > 0.0)
    with meshio.xdmf.TimeSeriesWriter(path, data_format="XML") as writer:
        writer.write_points_cells(points, [("line", np.column_stack((thick, thick + 1)))])
        for time, moving, loaded in zip(field.time, velocity, stress, strict=True):
            values = {"velocity": moving, "stress": loaded}
            writer.write_data(float(time), point_data=values | _in_si(field, **values))

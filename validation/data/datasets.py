"""Datasets of results: `xarray` is loaded only when one is made or read."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipwave.errors import SceneError
from slipwave.extras import require

if TYPE_CHECKING:
    from xarray import DataArray as DataArray
    from xarray import Dataset as Dataset
else:
    DataArray = Dataset = Any


def new_dataset(*parts: Any, **named: Any) -> Dataset:
    """An `xarray.Dataset` of these parts. Raises SceneError where xarray is not installed."""
    require("files", "a dataset")
    import xarray

    return xarray.Dataset(*parts, **named)


def load_dataset(path: str | Path, problem: str) -> Dataset:
    """The dataset of a netCDF file. Raises SceneError, which begins with the `problem`, if it is none."""
    import xarray

    try:
        return xarray.load_dataset(path, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise SceneError(f"{problem}: {str(error).lower()}") from None

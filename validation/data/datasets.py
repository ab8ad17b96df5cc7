"""Datasets of results: `xarray` is loaded only when one is made or read."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import ONE_THREAD, reason_of

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


def words_of_flags(data: Dataset, names: Iterable[str]) -> Dataset:
    """The dataset whose CF flags `names` are words, so that `data.verdict == "too short"` compares; "" where there is none."""
    said = {}
    for name in names:
        if "flag_meanings" in data.get(name, data).attrs and data[name].dtype.kind in "iuf":
            words, numbers = np.array([*flag_words(data[name]), ""]), flag_numbers(data[name])
            said[name] = data[name].copy(data=words[np.where((numbers >= 0) & (numbers < len(words)), numbers, -1)])
    return data.assign(said)


def as_flags(data: Dataset) -> Dataset:
    """The dataset as in files: words that are CF flags as their numbers, -1 where there is none."""
    told = {
        str(name): column
        for name, column in data.data_vars.items()
        if "flag_meanings" in column.attrs and column.dtype.kind == "U"
    }
    return data.assign({name: column.copy(data=flag_numbers(column)) for name, column in told.items()})


def flag_numbers(flags: DataArray) -> "np.ndarray[Any, np.dtype[np.int8]]":
    """The numbers of CF flags, whether these are in words or not."""
    if flags.dtype.kind != "U":
        return np.asarray(np.nan_to_num(flags.values, nan=-1.0), dtype=np.int8)
    known = {word: number for number, word in enumerate(flag_words(flags))}
    return np.array([known.get(str(word), -1) for word in flags.values.ravel()], dtype=np.int8).reshape(flags.shape)


def flag_words(flags: DataArray) -> list[str]:
    """The words of CF flags, in the order of their numbers."""
    return [word.replace("_", " ") for word in flags.attrs["flag_meanings"].split()]


def load_dataset(path: str | Path, problem: str) -> Dataset:
    """The dataset of a netCDF file. Raises SceneError, which begins with the `problem`, if it is none."""
    import xarray

    try:
        with ONE_THREAD:
            return xarray.load_dataset(path, engine="netcdf4")
    except (OSError, ValueError) as error:
        raise SceneError(f"{problem}: {reason_of(error)}") from None

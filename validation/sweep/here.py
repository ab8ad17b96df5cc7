"""A small sweep computed in this process, with no folder kept: what studies and scripts need."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from validation.sweep.gather import dataset_of
from validation.sweep.plan import Plan
from validation.sweep.store import Store
from validation.sweep.sweep import Where, perform_sweep

if TYPE_CHECKING:
    from xarray import Dataset as Dataset
else:
    Dataset = Any


def swept_here(plan: Plan) -> Dataset:
    """All points of `plan`, gathered. Raises what `perform_sweep` raises."""
    with TemporaryDirectory() as folder, ThreadPoolExecutor(1) as here:
        swept = perform_sweep(plan, Store(Path(folder)), Where(workers=1, executor=here))
        return dataset_of(plan, swept.store)

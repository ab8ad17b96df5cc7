"""Libraries that a light install leaves out, and the extra that installs each: `pip install 'slipwave[files]'`."""

from importlib.util import find_spec

from slipwave.errors import SceneError

EXTRAS = {
    "files": ("xarray", "netCDF4", "meshio"),
    "plot": ("matplotlib",),
    "fem": ("skfem",),
    "report": ("jinja2", "markupsafe", "PIL"),
    "cluster": ("distributed",),
}
"""Extra -> modules that it installs."""

OF_THE_REPORT = ("files", "plot", "fem", "report")
"""Extras that the extra `report` installs."""


def missing(extra: str) -> list[str]:
    """The modules of `extra` that are not installed."""
    extras = OF_THE_REPORT if extra == "report" else (extra,)
    return [name for extra in extras for name in EXTRAS[extra] if not _is_installed(name)]


def require(extra: str, what: str) -> None:
    """Raises SceneError if modules of `extra`, which `what` needs, are not installed; it says how to install them."""
    absent = missing(extra)
    if absent:
        raise SceneError(f"{what}: needs {' and '.join(absent)}: pip install 'slipwave[{extra}]'")


def _is_installed(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except (ImportError, ValueError):  # hidden from this process
        return False

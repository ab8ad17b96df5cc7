"""numba for all packages: compiled functions, their cache on disk, and dispatch by class."""

from slipwave.compiled.functions import allocating, inlined, njit

__all__ = ["allocating", "inlined", "njit"]

"""What is simulated: friction laws, slabs, drive, start and observers. Imports no solver and none of the other packages."""

from slipwave.input import read

__all__ = ["read"]

"""What is simulated: friction laws, slabs, drive, start and observers. Knows no solver and imports none of the other rooms."""

from slipwave.input import read

__all__ = ["read"]

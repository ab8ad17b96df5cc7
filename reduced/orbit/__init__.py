"""Periodic orbits of any model whose motion over a period is a map (`slipwave.step.flow.Flow`)."""

from reduced.orbit.periodic import PeriodicOrbit, periodic_orbit

__all__ = ["PeriodicOrbit", "periodic_orbit"]

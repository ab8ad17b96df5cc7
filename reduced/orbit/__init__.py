"""Periodic orbits of any model that offers its motion over a period as a map (`slipwave.step.flow.Flow`)."""

from reduced.orbit.periodic import PeriodicOrbit, periodic_orbit

__all__ = ["PeriodicOrbit", "periodic_orbit"]

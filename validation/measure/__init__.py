"""Measurements on runs: cycles, settled orbits, ripples, orders of convergence."""

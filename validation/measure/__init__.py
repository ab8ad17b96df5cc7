"""What is measured of a run: cycles, settled orbits, ripples, orders of convergence."""

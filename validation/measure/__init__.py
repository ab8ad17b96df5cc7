"""What studies measure: orbits and settled runs, regimes, branches over r, orders of convergence, limits and noise of grids."""

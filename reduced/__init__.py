"""Models without a grid: exact delay system, ODE reductions, impedance and stability. Imports only `slipwave`."""

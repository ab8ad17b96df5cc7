"""Reduced models over one period as differentiable maps (`slipwave.step.flow`), for those who look for periodic orbits."""

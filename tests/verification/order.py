"""How a test holds a scheme to its declared order; limits of fine grids."""

import numpy as np

from slipwave.observe.statistics import Estimate
from validation.measure.order_fit import fit_order, shortfall


def extrapolated(coarse, fine, order):
    """Richardson's limit of two runs, one with twice the cells of the other."""
    return float(fine + (fine - coarse) / (2.0**order - 1.0))


def richardson(coarse, middle, fine, order):
    """Richardson's limit of the two finer of three runs; its error: the distance from that of the two coarser."""
    first, second = extrapolated(coarse, middle, order), extrapolated(middle, fine, order)
    return Estimate(second, abs(second - first))


def assert_order(errors, steps, declared, tolerance=0.1, absolute=None, at_least=False):
    """Order over at least four levels (steps decreasing) within `tolerance`, the finest error below `absolute`."""
    errors, steps = np.abs(np.asarray(errors, dtype=float)), np.asarray(steps, dtype=float)
    assert errors.size >= 4, "an order needs four levels"
    result = fit_order(1.0 / steps, errors)
    message = shortfall(result, declared, tolerance, at_least)
    assert not message, f"{message}; errors {[f'{error:.3e}' for error in errors]}"
    if absolute is not None:
        assert errors[-1] < absolute, f"finest error {errors[-1]:.3e} is not below {absolute:g}; {result}"

"""Records as files, and what a fit to one must say of the parameters with which it was made."""

import math

import numpy as np


def written(path, heading, *columns):
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=heading, comments="", fmt="%.12g")
    return str(path)


def assert_held(found, truth, wide=math.inf):
    """The intervals hold the truth, and are narrower than a share of it."""
    for key, value in truth.items():
        row = found.summary["parameters"][key]
        assert row["low"] < value < row["high"], key
        assert row["high"] - row["low"] < wide * value, key

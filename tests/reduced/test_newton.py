"""Newton's method on equations whose solutions are known."""

import math

import numpy as np
import pytest

from reduced.orbit.newton import Evaluated, solve_by_newton
from slipwave.errors import NumericsError


class Equations:
    """`residual(u)` = 0 with its `derivative`, and what was asked for."""

    def __init__(self, residual, derivative):
        self._residual, self._derivative, self.tried = residual, derivative, []

    def evaluate(self, u):
        self.tried.append(u)
        return Evaluated(u, self._residual(u), None)

    def derivative(self, at):
        return self._derivative(at.unknowns)

    def solved(self, guess, tolerance=1e-13, near=1e-7, first=None):
        return solve_by_newton(self.evaluate, self.derivative, np.array(guess), tolerance, near, first)


def test_steps_are_shortened_until_they_help_and_a_neighbour_that_misleads_is_not_followed():
    """For arctan the full step from 3 leads to -9.5, and on to ever larger values. The derivative of the neighbour leads from 0.5
    to -4600, whence no shortened step comes back."""
    far, near = (Equations(np.arctan, lambda u: np.diag(1.0 / (1.0 + u * u))) for _ in range(2))
    assert abs(far.solved([3.0]).at.unknowns[0]) < 1e-12
    assert max(abs(u[0]) for u in far.tried) < 10.0
    assert abs(near.solved([0.5], first=np.array([[1e-4]])).at.unknowns[0]) < 1e-12
    assert min(u[0] for u in near.tried) == pytest.approx(0.5 - 1e4 * math.atan(0.5))


def test_steps_leave_what_cannot_be_evaluated():
    """The logarithm has no value at the end of the full step from 3."""

    def residual(u):
        if u[0] <= 0.0:
            raise NumericsError("no logarithm")
        return np.log(u)

    equations = Equations(residual, lambda u: np.diag(1.0 / u))
    assert equations.solved([3.0]).at.unknowns[0] == pytest.approx(1.0, abs=1e-13)


def test_residuals_at_rounding_are_accepted():
    """A residual that cannot fall below 3e-11 counts as zero; one that cannot fall below 3e-7 does not."""
    for floor in (3e-11, 3e-7):
        equations = Equations(lambda u, floor=floor: u - 1.0 + floor * np.sign(u - 1.0 + 1e-300), lambda u: np.eye(1))
        if floor < 1e-9:
            assert equations.solved([1.5]).at.unknowns[0] == pytest.approx(1.0, abs=1e-10)
        else:
            with pytest.raises(NumericsError, match=r"no convergence in 25 iterations: a residual of \de-07 is left"):
                equations.solved([1.5])


def only_at_the_guess(u):
    if u[0] != 2.0:
        raise NumericsError("it runs away")
    return u


@pytest.mark.filterwarnings("ignore:Diagonal number")
@pytest.mark.parametrize(
    ("residual", "derivative", "guess", "message"),
    [
        (
            lambda u: u * u + 1.0,
            lambda u: np.diag(2.0 * u),
            [1.3],
            r"no convergence in 25 iterations: a residual of 1\.?\d* is left",
        ),
        (
            lambda u: u.sum() * np.r_[1, 2] - 1,
            lambda u: np.array([[1.0, 1], [2, 2]]),
            [3.0, 1.0],
            "the linearised equations are sing",
        ),
        (only_at_the_guess, lambda u: np.eye(1), [2.0], "no motion can be computed along Newton's step"),
    ],
)
def test_no_solution(residual, derivative, guess, message):
    with pytest.raises(NumericsError, match=message):
        Equations(residual, derivative).solved(guess)

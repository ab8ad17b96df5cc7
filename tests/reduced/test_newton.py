"""Newton's method on equations whose solutions are known."""

import math

import numpy as np
import pytest

from reduced.orbit.newton import Evaluated, solve_by_newton
from slipwave.errors import NumericsError


class Equations:
    """`residual(u)` = 0 with its `derivative`, and what was asked for."""

    def __init__(self, residual, derivative):
        self._residual, self._derivative, self.tried, self.derivatives = residual, derivative, [], 0

    def evaluate(self, u):
        self.tried.append(u)
        return Evaluated(u, self._residual(u), None)

    def derivative(self, at):
        self.derivatives += 1
        return self._derivative(at.unknowns)

    def solved(self, guess, tolerance=1e-13, near=1e-7, first=None):
        return solve_by_newton(self.evaluate, self.derivative, np.array(guess), tolerance, near, first)


def circle_and_line():
    """x^2 + y^2 = 2 and x = y."""
    return Equations(lambda u: np.array([u @ u - 2.0, u[0] - u[1]]), lambda u: np.array([2.0 * u, [1.0, -1.0]]))


def test_one_derivative_serves_until_the_end():
    """The first error is squared; from then on each is below the product of the two before it, as a secant's, since every step
    corrects the derivative. A derivative as it was taken would only divide the error by 5 each time."""
    equations = circle_and_line()
    solved = equations.solved([1.5, 1.2], near=1.0)
    np.testing.assert_allclose(solved.at.unknowns, 1.0, rtol=0.0, atol=1e-13)
    errors = [np.abs(u - 1.0).max() for u in equations.tried]
    assert errors[1] < errors[0] ** 2
    assert all(new < last * before for before, last, new in zip(errors, errors[1:], errors[2:], strict=False))
    assert solved.iterations <= 8
    assert equations.derivatives == 1


def test_a_derivative_serves_as_long_as_it_contracts():
    """From nearby, with the derivative of a neighbour, none is taken; far away it is taken anew; one is returned from nearby."""
    matrix = np.array([[2.0, 2.0], [1.0, -1.0]])
    near, far = circle_and_line(), circle_and_line()
    near.solved([1.001, 1.0], near=1.0, first=matrix)
    assert near.derivatives == 1  # that of the solution: the neighbour's distance is not known
    solved = far.solved([1.001, 1.0], near=1e-7, first=9.0 * matrix)
    assert far.derivatives >= 1
    np.testing.assert_allclose(solved.at.unknowns, 1.0, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(solved.derivative, matrix, rtol=0.0, atol=1e-6)
    assert solved.away < 1e-7


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

"""A value with its derivative in s: one formula of an impedance gives both Z and dZ/ds (forward differentiation)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Complex: TypeAlias = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Jet:
    """Complex arrays `value` and `slope` = d value/ds of one shape."""

    value: Complex
    slope: Complex

    @staticmethod
    def variable(s: object) -> Jet:
        """s itself: slope 1."""
        value = np.asarray(s, dtype=np.complex128)
        return Jet(value, np.ones_like(value))

    def constant(self, number: complex) -> Jet:
        """`number` as a jet of this one's shape: slope 0."""
        return Jet(np.full_like(self.value, number), np.zeros_like(self.value))

    def __add__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.slope)
        return Jet(self.value + other.value, self.slope + other.slope)

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.slope)

    def __sub__(self, other: Jet | complex) -> Jet:
        return self + (-other)

    def __rsub__(self, other: complex) -> Jet:
        return -self + other

    def __mul__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value * other, self.slope * other)
        return Jet(self.value * other.value, self.slope * other.value + self.value * other.slope)

    __rmul__ = __mul__

    def __truediv__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value / other, self.slope / other)
        quotient = self.value / other.value
        return Jet(quotient, (self.slope - quotient * other.slope) / other.value)

    def __rtruediv__(self, other: complex) -> Jet:
        return self.constant(other) / self

    def sqrt(self) -> Jet:
        """Principal square root."""
        root = np.sqrt(self.value)
        return Jet(root, self.slope / (2.0 * root))

    def expm1(self) -> Jet:
        """e^x - 1 without cancellation near 0; -1 for a large negative real part."""
        value = np.expm1(self.value)
        return Jet(value, (1.0 + value) * self.slope)

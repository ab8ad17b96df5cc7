"""An additional scikit-fem element: the Lagrange polynomials on the Gauss-Lobatto nodes of an interval, of any degree.

scikit-fem has only cubic Lagrange and hierarchical interval elements, whose mass matrix cannot be lumped. With nodes at the
Gauss-Lobatto points the lumped matrix (quadrature in the same points) is positive at every degree: the spectral element.
"""

import numpy as np
from skfem.element import ElementH1
from skfem.refdom import RefLine

from fullwave.operators.lobatto import gauss_lobatto
from slipwave.observe.pieces import Array, interpolation_matrix, lagrange_basis


class ElementLineGLL(ElementH1):  # type: ignore[misc]
    """Degree >= 1, on the reference interval [0, 1]; vertices first, then the inner nodes from left to right."""

    nodal_dofs = 1
    refdom = RefLine

    def __init__(self, degree: int) -> None:
        nodes = 0.5 * (gauss_lobatto(degree)[0] + 1.0)
        self.interior_dofs = degree - 1
        self.maxdeg = degree
        self.dofnames = ["u"] * degree
        self._basis = lagrange_basis(nodes)
        self._order = np.concatenate(([0, degree], np.arange(1, degree)))
        self.doflocs = nodes[self._order][:, None]

    def lbasis(self, X: Array, i: int) -> tuple[Array, Array]:  # scikit-fem names X
        """Value and derivative of function `i` at the points X, shape (1, points)."""
        if i > self.maxdeg:
            self._index_error()
        values = interpolation_matrix(self._basis, X.ravel())
        k = self._order[i]
        slopes = values @ self._basis.derivative[:, k]
        return values[:, k].reshape(X.shape[1:]), slopes.reshape(X.shape)

"""The spectrum of steady sliding: how many roots are unstable (certified), and the leading ones."""

import numpy as np

from reduced.impedance import Complex
from reduced.stability.characteristic import Characteristic
from reduced.stability.roots import count_zeros, half_disc, polish, zeros_in

_INSET = 1e-9
"""The contour runs this far right of the imaginary axis, relative to its radius: a neutral root does not count as unstable."""

_RIPPLES = 4.6
"""Leading roots are looked for up to this many times pi per transit: two pairs of reverberations."""


def unstable_count(problem: Characteristic, active: bool = False) -> int:
    """Roots with Re s > 0, by the argument principle.

    For a passive slab all of them lie within `FrictionSlopes.reach` of -G_phi, so the count is complete; `active` (a slab with
    unstable poles of its own) counts within 20 per transit instead. Raises NumericsError if a root lies on the contour.
    """
    radius = problem.slopes.reach
    if active:
        radius = max(radius, 20.0 / problem.transit)
    elif not problem.slopes.weakening:
        return 0
    return count_zeros(problem.jet, half_disc(1.001 * radius, _INSET * radius))


def leading_roots(problem: Characteristic, most: int = 8) -> Complex:
    """The `most` roots with the largest real parts among those with |Im s| below two ripple frequencies, conjugates included.

    The rectangle searched is widened to the left until it holds enough; in it the number of roots is certified. 1/(L/V*).
    """
    right = max(problem.slopes.reach, 1.0 / problem.transit)
    top = max(1.05 * problem.slopes.reach, _RIPPLES * np.pi / problem.transit)
    wall = 0.9 * problem.leftmost
    best: Complex = np.empty(0, dtype=np.complex128)
    for depth in (0.3, 1.0, 3.0, 6.0):
        left = max(-depth / problem.transit, wall)
        best = zeros_in(problem.jet, left, right, top)
        best = best[~problem.idle(best)]
        if best.size >= most or left == wall:
            break
    return best[:most]


def follow_root(problem: Characteristic, start: complex) -> complex:
    """The root Newton's method reaches from `start`; nan if it reaches none."""
    return complex(polish(problem.jet, np.array([start]))[0])

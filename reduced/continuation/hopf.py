"""Where a branch of orbits is born: the loss of stability of steady sliding."""

import numpy as np
import scipy.linalg

from reduced.continuation.point import FlowAt, Metric, Point, point_near
from slipwave.errors import NumericsError

_FIRST_AMPLITUDE = 0.02  # of psi
_NULL = 1e-3  # singular values of two null vectors, relative to 1, which damped motions have, or to typical larger ones


def from_hopf(flow_at: FlowAt, parameter: float, period: float, metric: Metric) -> Point:
    """The first small orbit of the branch that begins at the Hopf point at `parameter`, where disturbances of steady sliding
    oscillate with `period` (transits) and neither grow nor decay.

    There the derivative of the motion over a period has two null vectors: the oscillation at two of its phases. The orbit is
    sought at a given amplitude along one of them; the other is the motion along the orbit. Raises NumericsError if the steady
    state does not oscillate so.
    """
    flow = flow_at(parameter)
    steady = flow.steady
    linear = flow.tangent(flow.march(steady, period)) - np.eye(steady.size)
    _, sizes, rows = scipy.linalg.svd(linear)
    if sizes[-2] > _NULL * max(1.0, float(np.median(sizes))):
        raise NumericsError(
            f"{flow.model}: steady sliding does not oscillate with a period of {period:.6g} transits there "
            f"(scene {flow.scene.name!r})"
        )
    slow = rows[-2:]
    shape = slow.T @ slow[:, -1]  # the phase at which psi is largest
    along = np.append(shape / abs(shape[-1]), [0.0, 0.0])
    guess = np.concatenate([steady, [period, parameter]]) + _FIRST_AMPLITUDE * along
    return point_near(flow_at, guess, along / metric.length(along), metric)

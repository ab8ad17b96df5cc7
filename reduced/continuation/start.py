"""The first point of a branch: near a Hopf point, near a period doubling, from a given orbit, or stored; and the orbits of a
branch at one value of its parameter.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy.linalg

from reduced.continuation.point import FlowFamily, Metric, OrbitPoint, direction, point_near
from reduced.continuation.special import Special
from reduced.orbit.closing import Closed, FlowAt, by_parameter, close
from reduced.orbit.periodic import difference_of_parts
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import State

_FIRST_AMPLITUDE = 0.02  # of psi, of the first orbit near a Hopf point
_NULL = 1e-3  # singular values of two null vectors, relative to 1, which damped motions have, or to typical larger ones
_AMPLITUDES = (3e-3, 1e-3, 1e-4)  # of the largest component of a doubled orbit; the first with which Newton's method converges
_ALIKE = 0.1  # difference of the halves, over the amplitude, below which the orbit is a simple one
_NEAR = 1e-3  # distance of the multiplier from -1
_MESH = "mesh_"  # before names of arrays of the mesh
_SAME_ORBIT = 1e-9  # difference of two periods that count as one orbit's, relative


def metric_for(low: float, high: float) -> Metric:
    """Metric of a branch between two parameters: their difference counts as much as twenty transits of period. A delay system's
    orbits at one parameter differ by about a transit of period from fold to fold, so that folds are round in it."""
    return Metric(20.0, abs(high - low) or 1.0)


def from_orbit(flow_at: FlowAt, closed: Closed, parameter: float, towards: float, metric: Metric) -> OrbitPoint:
    """An orbit found at a fixed `parameter` as a point of its branch, oriented towards the parameter `towards`."""
    free = replace(closed, parameter=parameter, drift=by_parameter(flow_at, closed.cycle, parameter, metric.parameter))
    along = np.zeros(closed.cycle.start.size + 2)
    along[-1] = np.sign(towards - parameter) * metric.parameter
    return OrbitPoint(free, direction(free, along, metric))


def from_hopf(flow_at: FlowAt, parameter: float, period: float, metric: Metric) -> OrbitPoint:
    """The first small orbit of the branch that begins at the Hopf point at `parameter`, where disturbances of steady sliding
    oscillate with `period` (transits) and neither grow nor decay.

    There the derivative of the closing condition has two null vectors: the oscillation at two phases. The orbit is computed at a
    given amplitude along one of them; the other is the motion along the orbit. Raises NumericsError if the steady state has no
    such oscillation.
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
    return point_near(flow_at, guess, along, metric)


def from_doubling(family: FlowFamily, special: Special, metric: Metric) -> tuple[FlowFamily, OrbitPoint]:
    """The first orbit of twice the period near the period doubling `special`, and the family on a mesh for it: displaced along
    the eigenvector of the multiplier -1, by which the two halves of the doubled orbit differ.

    Raises NumericsError if the special point is no period doubling, or no such orbit is found.
    """
    closed = special.point.closed
    values, vectors = scipy.linalg.eig(closed.monodromy)
    passing = int(np.abs(values + 1.0).argmin())
    if special.kind != "PD" or abs(values[passing] + 1.0) > _NEAR:
        raise NumericsError(f"parameter = {closed.parameter:.10g} is no period doubling: the multiplier is {values[passing]:.6g}")
    shape = vectors[:, passing].real
    failed = NumericsError("")
    for amplitude in _AMPLITUDES:
        try:
            return _displaced(family, special.point, shape / np.abs(shape).max(), amplitude, metric)
        except NumericsError as reason:
            failed = reason
    raise failed


def _displaced(
    family: FlowFamily, simple: OrbitPoint, shape: Array, amplitude: float, metric: Metric
) -> tuple[FlowFamily, OrbitPoint]:
    """The doubled orbit at this amplitude of its deviation `shape` from the simple one, measured across the branch of simple
    orbits, which is so excluded."""
    closed = simple.closed
    period = 2.0 * closed.cycle.period
    flow, state = closed.flow.remeshed(closed.cycle._replace(start=closed.cycle.start + amplitude * shape, period=period), 1.0)
    family = family.on(flow)
    branch = simple.tangent[:-2]
    along = np.append(shape - (shape @ branch) / (branch @ branch) * branch, [0.0, 0.0])
    point = point_near(family, np.append(state, [period, closed.parameter]), along, metric)
    if difference_of_parts(point.closed, 2) < _ALIKE * amplitude:
        raise NumericsError(f"no orbit of twice the period was found near parameter = {closed.parameter:.10g}")
    return family, point


def without_derivatives(point: OrbitPoint) -> State:
    """Arrays by name of a point: its `unknowns` (x, T, p), `tangent`, and the mesh."""
    mesh = {f"{_MESH}{name}": np.atleast_1d(array) for name, array in point.closed.flow.mesh_state().items()}
    return mesh | {"unknowns": point.unknowns, "tangent": point.tangent}


def stored(point: OrbitPoint, step: float) -> State:
    """Arrays by name from which a branch continues bit by bit: those `without_derivatives`, the next `step`, and the derivatives
    of `Closed`, which may be those of a neighbour, and are large."""
    closed = point.closed
    derivatives = {"monodromy": closed.monodromy, "velocity": closed.velocity, "drift": closed.drift}
    return without_derivatives(point) | {"step": np.array([step])} | derivatives


def from_stored(family: FlowFamily, saved: Mapping[str, Array]) -> tuple[FlowFamily, OrbitPoint, float]:
    """The family on the stored mesh, the point, and the next step."""
    *start, period, parameter = saved["unknowns"].tolist()
    flow = family(parameter).on_mesh(mesh_of(saved))
    cycle = flow.march(np.array(start), period)
    residual = float(np.abs(cycle.end - cycle.start).max())
    derivatives = (saved["monodromy"], saved["velocity"], saved["drift"])
    closed = Closed(flow, cycle, residual, *derivatives, parameter, 0)
    return family.on(flow), OrbitPoint(closed, saved["tangent"]), float(saved["step"][0])


def from_outline(family: FlowFamily, saved: Mapping[str, Array], metric: Metric) -> tuple[FlowFamily, OrbitPoint]:
    """The family on the stored mesh, and the point that was stored `without_derivatives`, closed again. Raises NumericsError if
    it does not close."""
    flow = family(float(saved["unknowns"][-1])).on_mesh(mesh_of(saved))
    family = family.on(flow)
    return family, point_near(family, saved["unknowns"], saved["tangent"], metric)


def mesh_of(saved: Mapping[str, Array]) -> State:
    """The mesh of a point that was stored `without_derivatives`."""
    return {name.removeprefix(_MESH): saved[name] for name in saved if name.startswith(_MESH)}


def orbits_at(points: Iterable[OrbitPoint], parameter: float, scene: Scene) -> list[Closed]:
    """All orbits of a branch at one value of its `parameter`, in order along the branch, each by Newton's method from the points
    on both sides; `scene` is the scene at this value. Raises NumericsError if Newton's method fails."""
    orbits: list[Closed] = []
    for left, right in pairwise(points):
        if (left.parameter - parameter) * (right.parameter - parameter) <= 0.0:
            same = left.unknowns.size == right.unknowns.size  # else their meshes differ
            along = right.unknowns - left.unknowns if same else right.tangent
            guess = right.unknowns + (parameter - right.parameter) / along[-1] * along
            orbit = close(right.closed.flow.of(scene), guess[:-2], float(guess[-2]))
            if not orbits or abs(orbit.cycle.period / orbits[-1].cycle.period - 1.0) > _SAME_ORBIT:
                orbits.append(orbit)
    return orbits

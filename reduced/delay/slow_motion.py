"""Slow motion of a network of lines, over a step much longer than its delays.

Where the slip rate hardly changes in a round trip, every wave follows it: for s far below the slowest resonance, a quantity of
transfer function T(s) from the slip rate is

    T(s) dv = c_(-1)/s dv + c_0 dv + c_1 s dv + ...,

that is c_(-1) times the slip plus c_0 dv + c_1 dv' + ..., exact for polynomials but for the truncated terms. So friction can be
stepped by collocation with a full impedance (`slipwave.step.impedance`) however long the step is. The coefficients follow from
values of T on a circle about s = 0 that encloses no resonance.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.delay.network_kernel import INWARD, LOAD, OUTWARD, VELOCITY
from reduced.delay.transmission_lines import Lines
from slipwave.friction import law_of_step, to_own, to_step
from slipwave.observe.pieces import Array, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.step.collocation import rule_of
from slipwave.step.impedance import Full
from slipwave.step.newton import solve
from slipwave.step.nodal import Interface, Limits, nodal_of

Complex = NDArray[np.complex128]

TERMS = 5
"""c_0 to c_4."""

_POINTS = 256  # on the circle
_LARGEST, _SMALLEST = 3.0, 1e-6  # radius, 1/transit
_INSIDE = 0.5  # of the largest radius without a resonance


def _transfers(lines: Lines) -> tuple[Array, Array, Array, float]:
    """Coefficients c_(-1), c_0, .. of the memory of `lines` whose outer faces all have a spring or are rigid: of the stress
    (TERMS + 1,) at the interface, of the waves (layers, 2, TERMS + 1) as they are launched, of the tops (slabs, 2, TERMS + 1);
    and the radius (1/transit) of the circle: about half the slowest resonance."""
    angles = np.exp(2j * np.pi * (np.arange(_POINTS) + 0.5) / _POINTS)
    radius = _LARGEST
    while radius > _SMALLEST and _zeros(_responses(lines, radius * angles)[0]) > 1:
        radius *= 0.7
    s = _INSIDE * radius * angles
    slip, stress, waves, tops = _responses(lines, s)
    powers = s[:, None] ** -np.arange(-1.0, TERMS) / _POINTS
    stress_row, wave_rows, top_rows = ((values / slip @ powers).real for values in (stress, waves, tops))
    wave_rows[..., 0] = stress_row[0]  # at rest all lines have one stress; rounding of that would set off waves
    top_rows[..., 0] = np.where(np.any(top_rows, axis=-1) & (np.arange(2) == LOAD), stress_row[0], 0.0)
    return stress_row, wave_rows, top_rows, _INSIDE * radius


def _zeros(values: Complex) -> int:
    """Winding number of `values` on a circle around zero."""
    return round(float(np.angle(np.roll(values, -1) / values).sum()) / (2.0 * np.pi))


def _responses(lines: Lines, s: Complex) -> tuple[Complex, Complex, Complex, Complex]:
    """Slip rate, stress, waves and tops at all `s` (1/transit), each (.., points), up to one common factor without poles."""
    slabs = len(lines.tops)
    waves, tops = np.zeros((lines.travel.size, 2, s.size), complex), np.zeros((slabs, 2, s.size), complex)
    stresses, rates = np.empty((slabs, s.size), complex), np.empty((slabs, s.size), complex)
    for slab, top in enumerate(lines.tops):
        stress, rate = np.ones_like(s), np.zeros_like(s)
        if not top.is_rigid:
            tops[slab, LOAD], rate = top.spring, -s
            stress = tops[slab, LOAD] - (top.mass * s + top.dashpot) * rate
            tops[slab, VELOCITY] = rate
        for layer in range(lines.last[slab], lines.first[slab] - 1, -1):
            impedance, late = lines.impedance[layer], np.exp(s * lines.travel[layer])
            waves[layer, INWARD] = stress + impedance * rate
            waves[layer, OUTWARD] = (stress - impedance * rate) * late
            arrived = waves[layer, INWARD] / late
            stress, rate = 0.5 * (waves[layer, OUTWARD] + arrived), (arrived - waves[layer, OUTWARD]) / (2.0 * impedance)
        stresses[slab], rates[slab] = stress, rate
    if slabs == 1:
        return lines.weight * rates[0], stresses[0], waves, tops
    common = stresses[::-1]  # both slabs have the same stress at the interface
    for slab, (first, last) in enumerate(zip(lines.first, lines.last, strict=True)):
        waves[first : last + 1] *= common[slab]
        tops[slab] *= common[slab]
    return rates[0] * stresses[1] + rates[1] * stresses[0], stresses[0] * stresses[1], waves, tops


class SlowStep(NamedTuple):
    """A solved step of slow motion from the time `start` (transits) and of the `length`: `guess`, nodal psi and z; `rate` (s,),
    nodal dv; `load`, the load at its start, as a slip; `psi` at its start; `tail`, the highest Legendre coefficient of z; whether
    Newton's method `solved` it within its limit."""

    start: float
    length: float
    guess: Interface
    rate: Array
    load: float
    psi: float
    tail: float
    solved: bool


class SlowMotion:
    """Steps of slow motion of the `lines` of a `scene`, with polynomials through `stages` Radau nodes. `to_stress` and `radius`:
    those of `_transfers`."""

    def __init__(self, scene: Scene, lines: Lines, stages: int, limits: Limits) -> None:
        self._scene, self._stages, self._limits = scene, stages, limits
        self.to_stress, self._to_waves, self._to_tops, self.radius = _transfers(lines)
        self._matrices, self._rule, self._shape = rule_of(stages)
        self._basis, self._nodal = lagrange_basis(self._matrices.nodes), nodal_of(stages)
        self._with_start = lagrange_basis(np.append(0.0, self._matrices.nodes))
        self._apart, self._held = lines.apart, np.any(self._to_tops != 0.0, axis=(1, 2))

    def step(self, start: float, length: float, begin: Array, guess: Interface) -> SlowStep:
        """Solve the step of `length` from `begin` (psi, load) at the time `start`; V is constant."""
        scene, terms, shape = self._scene, self.to_stress, self._shape
        velocity, (psi, load) = scene.drive.at(start + 0.5 * length), begin.tolist()
        derive, power = self._basis.derivative / length, np.eye(self._stages)
        matrix = -terms[0] * length * self._matrices.integral
        for term in terms[1:]:
            matrix = matrix - term * power
            power = power @ derive
        nodal = self._nodal
        nodal.incoming[:] = scene.steady_stress + terms[0] * load + velocity * matrix.sum(axis=1)
        nodal.left[:], nodal.psi[:], nodal.z[:] = psi, guess.psi, guess.z
        law = law_of_step(scene.law, psi)
        to_step(law, scene.law, nodal.z)
        used = solve(law, shape, Full(matrix), length * scene.transit, self._rule, self._limits.newton, nodal)
        tail = abs(float(self._rule.tail @ nodal.z))
        solved = used > 0 and tail <= self._limits.resolution and float(nodal.slope.max()) <= self._limits.growth
        to_own(law, nodal.z)
        interface = Interface(nodal.psi.copy(), nodal.z.copy())
        return SlowStep(start, length, interface, nodal.v - velocity, load, psi, tail, solved)

    def interface(self, slow: SlowStep, times: Array) -> Interface:
        """psi and z at `times` (..) in a step or slightly outside."""
        at = ((times - slow.start) / slow.length).ravel()
        psi = interpolation_matrix(self._with_start, at) @ np.append(slow.psi, slow.guess.psi)
        z = interpolation_matrix(self._basis, at) @ slow.guess.z
        return Interface(psi.reshape(times.shape), z.reshape(times.shape))

    def slip(self, slow: SlowStep, times: Array) -> Array:
        """Integral of v - V from the step's start to `times`, in V* times transits."""
        return self._terms(slow, times)[..., 0] - slow.load

    def stress(self, slow: SlowStep, times: Array) -> Array:
        """Friction stress at `times`."""
        return self._scene.steady_stress + self._terms(slow, times) @ self.to_stress

    def memory(self, slow: SlowStep, times: Array, now: float) -> tuple[Array, Array, float]:
        """Waves launched at `times` (..), as deviations, of shape (layers, 2, ..); load and velocity of each outer face, and the
        slip, at the time `now`."""
        terms = self._terms(slow, np.append(times, now))
        drift = self._scene.drive.at(slow.start + 0.5 * slow.length) - self._scene.velocity
        shift = (drift * self._apart).reshape(*self._apart.shape, *(1 for _ in range(times.ndim)))
        waves = np.tensordot(self._to_waves, terms[:-1].reshape(*times.shape, -1), axes=(2, -1)) + shift
        tops = np.asarray(self._to_tops @ terms[-1])
        tops[self._held, VELOCITY] += 0.5 * drift
        return waves, tops, float(terms[-1, 0] - slow.load)

    def _terms(self, slow: SlowStep, times: Array) -> Array:
        """Slip (with the load of the step's start), dv, dv', .. at `times` (..); shape (.., TERMS + 1)."""
        at = ((times - slow.start) / slow.length).ravel()
        rows, values = interpolation_matrix(self._basis, at), slow.rate
        slips = np.append(0.0, slow.length * self._matrices.integral @ slow.rate)
        columns = [slow.load + interpolation_matrix(self._with_start, at) @ slips]
        for _ in range(TERMS):
            columns.append(rows @ values)
            values = self._basis.derivative @ values / slow.length
        return np.stack(columns, axis=-1).reshape(*times.shape, TERMS + 1)

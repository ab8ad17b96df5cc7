"""One step of a network for small disturbances of a slow motion: linear, with the friction of that motion frozen.

Trapped waves pass many thousand steps while friction hardly changes. Their linear map over one step is raised to that power by
squaring.
"""

from typing import NamedTuple

import numpy as np

from reduced.delay.flow_kernel import send
from reduced.delay.network_kernel import Network, passage_of
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Forcing
from slipwave.step.collocation import radau, rule_of
from slipwave.step.nodal import Interface


class Disturbance(NamedTuple):
    """Memory of a network, as a deviation: `waves` (layers, 2, ring, s), oldest step first, `tops` (slabs, 2), and `rest`: psi
    and y."""

    waves: Array
    tops: Array
    rest: Array

    @property
    def vector(self) -> Array:
        """All entries, in this order."""
        return np.concatenate([self.waves.ravel(), self.tops.ravel(), self.rest])

    def like(self, vector: Array) -> "Disturbance":
        """The entries of a `vector` in the shapes of this one."""
        waves, rest = self.waves.size, vector.size - 2
        return Disturbance(vector[:waves].reshape(self.waves.shape), vector[waves:rest].reshape(self.tops.shape), vector[rest:])


class Friction(NamedTuple):
    """Derivatives of v by z, of mu by z and psi, and of psi' (friction clock) by z and psi."""

    v_z: float
    mu_z: float
    mu_psi: float
    g_z: float
    g_psi: float


def mean_friction(law: Law, interface: Interface, weights: Array) -> Friction:
    """`Friction` averaged over k times with psi and z (k,) of `interface` and `weights` (k,), whose sum is 1."""
    rows = np.array([respond(law, float(z), float(psi)) for psi, z in zip(*interface, strict=True)])
    return Friction(*(weights @ rows[:, [1, 3, 4, 6, 7]]))


class FrozenStep:
    """The linear step of a `network` of step `length` (transits), computed by sending unit disturbances and unit interface
    stresses through the march's own functions. `empty`: the zero disturbance."""

    def __init__(self, network: Network, length: float, stages: int, forcing: Forcing) -> None:
        self._impedance, self._forcing, self._length = network.interface_impedance, forcing, length
        self._integral = radau(stages).integral
        ring, layers, slabs = int(network.back.max()) + 1, network.impedance.size, network.first.size
        self.empty = Disturbance(np.zeros((layers, 2, ring, stages)), np.zeros((slabs, 2)), np.zeros(2))
        self.size = self.empty.vector.size
        units, cuts = np.eye(self.size + stages), np.cumsum([self.empty.waves.size, self.empty.tops.size, 2])
        waves, tops, rest, stress = (part.copy() for part in np.split(units, cuts, axis=1))
        waves, incoming = waves.reshape(-1, *self.empty.waves.shape), np.zeros_like(stress)
        lines = (network, waves, tops.reshape(-1, *self.empty.tops.shape), passage_of(network, stages))
        _, rule, nodes = rule_of(stages)
        send(nodes, *lines, length, rule.integral, stress, incoming)
        after = np.column_stack([np.roll(waves, -1, axis=3).reshape(len(units), -1), tops, rest])
        self._free, self._sent = after[: self.size].T.copy(), after[self.size :].T.copy()
        self._arriving = incoming[: self.size]

    @property
    def by_slip(self) -> Array:
        """The change (n, s) of the memory by the nodal slip rate, but for that of psi."""
        change = -self._impedance * self._sent
        change[-1] = -self._forcing.stiffness * self._length * self._integral[-1]
        return change

    def matrix(self, friction: Friction) -> tuple[Array, Array]:
        """The map (n, n) of a disturbance over one step, and the nodal stress (s, n) that it causes."""
        v_z, mu_z, mu_psi, g_z, g_psi = friction
        h, identity = self._length * self._forcing.transit, np.eye(self._integral.shape[0])
        by_stress = 1.0 / (mu_z + self._impedance * v_z)
        system = identity - h * (g_psi - g_z * by_stress * mu_psi) * self._integral
        begins = np.zeros((identity.shape[0], self.size))
        begins[:, -2] = 1.0
        psi = np.linalg.solve(system, begins + h * g_z * by_stress * self._integral @ self._arriving.T)
        z = by_stress * (self._arriving.T - mu_psi * psi)
        stress = mu_z * z + mu_psi * psi
        matrix = self._free + self._sent @ stress
        matrix[-2] = psi[-1]
        matrix[-1] -= self._forcing.stiffness * self._length * v_z * self._integral[-1] @ z
        return matrix, stress


def powers_of(matrix: Array, most: int) -> list[Array]:
    """Powers 1, 2, 4, .. of the matrix (n, n), up to `most`."""
    powers = [matrix]
    while 2 ** len(powers) <= most:
        powers.append(powers[-1] @ powers[-1])
    return powers


def advanced(powers: list[Array], vector: Array, count: int) -> Array:
    """The `vector` after `count` steps, by the powers of their matrix."""
    for bit, power in enumerate(powers):
        if count >> bit & 1:
            vector = power @ vector
    return vector


def slow_parts(powers: list[Array], rows: Array) -> Array:
    """`rows` (k, n) of quantities averaged over steps with a weight that removes oscillations: four successive box averages over
    as many steps as the highest power."""
    for _ in range(4):
        for power in powers[:-1]:
            rows = 0.5 * (rows + rows @ power)
    return rows

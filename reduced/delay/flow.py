"""The delay system over one period (`Flow`), for any pair of lossless slabs, by steps that divide its delays where possible.

Delayed values are then nodal values of past steps. A period is no whole number of steps: the waves at its end are the L2
projection of those of the last steps on steps that end with it. Nodal values of a step are orthogonal, so that with psi held no
period can gain energy; with interpolated waves noise would grow in a period, in a slab that loses little by a twentieth.
"""

import math
from collections.abc import Sequence
from functools import cache, cached_property

import numpy as np

from reduced.delay.flow_kernel import driven_matrix, exchange_matrix, exchange_of, logs_of_return, march_back, march_tangent
from reduced.delay.march import DelayMemory, clock_of, dense_resolution, march_delay, present
from reduced.delay.network_kernel import INWARD, LOAD, OUTWARD, VELOCITY, NetworkLines, lines_with
from reduced.delay.transmission_lines import COINCIDENT, NODES, lines_of, network_of, shifted_rows
from slipwave.errors import NumericsError
from slipwave.friction import resampled, smooth, unknown_of
from slipwave.friction.law import friction_slopes
from slipwave.observe.pieces import Array, Basis, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.scene.drive import Constant
from slipwave.solve import State
from slipwave.step.collocation import radau, rule_of
from slipwave.step.flow import NO_PUSH, Cycle, Pulses, Push, eigenvalues_without, impulses
from slipwave.step.newton import first_guess
from slipwave.step.nodal import DONE, Limits, Physics, nodal_of
from slipwave.step.tangent import Motion
from slipwave.threads import one_thread

_NEWTON = 1e-13
_FEWEST = 3.0  # steps per transit
_FINE = 32  # points of quadrature in a step
_UNDAMPED = 1e-9  # decay in a transit
_CHANGE = 1e-5  # of a step's length, for slopes of its polynomials
_SQUARINGS = 20
_LEFT = 1e-6  # singular value, over the largest, of what has not died out
_SAME = 1e-13  # relative difference of travel times that is rounding
_LOOSE, _TRIED = (1.01, 1.3), 100  # numbers of steps, relative, of which one is taken where travel times change
_ANY_STEP = Limits(_NEWTON, math.inf, math.inf)  # a mesh that does not change rejects no step


class DelayFlow:
    """The motion in steps of `length` (transits). A state is the waves launched in the last `kept` steps, layer by layer,
    outwards and inwards, oldest first; spring stress and velocity of each outer face, where it has a spring or a mass; psi."""

    model = "delay"

    def __init__(self, scene: Scene, per_transit: float, divides: bool = True) -> None:
        """Steps divide the delays where possible, if it `divides`."""
        self.scene, self._divides = scene, divides
        matrices, self._rule, self._nodes = rule_of(NODES)
        self.nodes = matrices.nodes
        self._basis, self._with_left = _bases(NODES)
        self._lines = lines_of(scene)
        longest = min(1.0 / max(_FEWEST, per_transit), float(self._lines.travel.min()))
        divisor = self._lines.divisor if divides else None
        self.length = divisor / math.ceil(divisor / longest - COINCIDENT) if divisor else longest
        self.kept = math.ceil(float(self._lines.travel.max()) / self.length - COINCIDENT)
        self._network = network_of(scene, self._lines, self.length, self.nodes)
        self._shape = (self._lines.travel.size, 2, self.kept, NODES)
        self.tops_remembered = np.array([(top.spring > 0.0, top.mass > 0.0) for top in self._lines.tops])
        self.size = math.prod(self._shape) + int(self.tops_remembered.sum()) + 1
        self._last: tuple[Cycle, NetworkLines] | None = None

    @property
    def steady(self) -> Array:
        """As `Flow`: no waves, in deviations from steady sliding."""
        return np.append(np.zeros(self.size - 1), self.scene.steady_psi)

    def of(self, scene: Scene) -> "DelayFlow":
        """As `Flow`: where travel times differ, in as many steps of the longest, so that a state has as many values. It has more
        where these steps are too long for a wave, and others where slabs are one pair in one of both scenes."""
        travel, other = self._lines.travel, lines_of(scene).travel
        longer = 1.0 if _are_same(travel, other) else float(other.max() / travel.max())
        return DelayFlow(scene, 1.0 / (longer * self.length), self._divides and _are_same(travel, other))

    def mesh_state(self) -> State:
        """As `Flow`: steps per transit."""
        return {"per_transit": np.array([1.0 / self.length]), "divides": np.array([float(self._divides)])}

    def on_mesh(self, state: State) -> "DelayFlow":
        """As `Flow`."""
        return DelayFlow(self.scene, float(state["per_transit"][0]), bool(state["divides"][0]))

    def march(self, start: Array, period: float, push: Push = NO_PUSH) -> Cycle:
        """As `Flow`."""
        scene, (steps, fraction) = self.scene, self._steps(period)
        pieces, lines = empty_pieces(steps, NODES), self.lines_at(start)
        steady, z = np.full(NODES, self._network.base), unknown_of(scene.law, scene.velocity)
        guess, _ = first_guess(self._nodes, scene.law, scene.impedance, steady, start[-1], z)
        memory = DelayMemory(guess, present(0.0, float(start[-1]), scene.steady_stress))
        done, iterations, verdict, forcing = 0, 0, DONE, scene.forcing._replace(nudge=0.0)
        for part, stress, drive in push.parts(Constant(scene.velocity), steps):
            if verdict == DONE and part.stop > part.start:
                here = lines._replace(network=lines.network._replace(base=lines.network.base + stress))
                clock, physics = (
                    clock_of(0.0, done, part.stop - done, self.length),
                    Physics(scene.law, forcing, drive, self._rule),
                )
                march = (physics, here, memory, nodal_of(NODES), clock, _ANY_STEP, 0)
                more, used, verdict = march_delay(self._nodes, *march, pieces.part(part))
                done, iterations = done + more, iterations + used
        if verdict != DONE:
            raise NumericsError(
                f"delay: the step at {done * self.length:.6g} of {period:.6g} transits cannot be solved (scene {scene.name!r})"
            )
        cycle = Cycle(period, start, self._within_last(lines, pieces, start[-1], fraction), pieces, iterations)
        self._last = cycle, lines
        return cycle

    def velocity(self, cycle: Cycle) -> Array:
        """As `Flow`: the slope of the polynomials of the last steps, kept from the last march."""
        if self._last is None or self._last[0] is not cycle:
            return self.velocity(self.march(cycle.start, cycle.period))
        lines, (_, fraction) = self._last[1], self._steps(cycle.period)
        later, earlier = (
            self._within_last(lines, cycle.pieces, cycle.start[-1], fraction + shift) for shift in (_CHANGE, -_CHANGE)
        )
        return (later - earlier) / (2.0 * _CHANGE * self.length)

    def tangent(self, cycle: Cycle, frozen: bool = False) -> Array:
        """As `Flow`. If `frozen`, psi is held at its values along `cycle`: the motion of the waves alone."""
        nodes, integral = self._nodes, self._rule.integral
        exchange = exchange_of(nodes, self._network, self.length, integral)
        faces, memory = exchange.weights.shape[0], self._memory(np.eye(self.size))
        _, fraction = self._steps(cycle.period)
        motion, h = Motion(cycle.pieces.z, cycle.pieces.psi, frozen), self.length * self.scene.transit
        last = self._psi_row(fraction)
        cursor = march_tangent(nodes, self.scene.law, exchange, h, integral, motion, memory, self.kept, last)
        waves, tops, psi = memory[:, :faces], memory[cursor - 1, faces:-1], memory[cursor - 1, -1]
        waves = waves.reshape(self.kept + 1, self._shape[0], 2, NODES, -1)
        return self._state(waves, tops.reshape(*self.tops_remembered.shape, -1), psi, cursor, fraction)

    def pulses(self, cycle: Cycle, functional: Array) -> Pulses:
        """As `Flow`, in whole steps that end with the cycle."""
        nodes, network, integral = self._nodes, self._network, self._rule.integral
        steps, fraction = self._steps(cycle.period)
        early = (1.0 - fraction) * self.length
        pieces = self.march(self.march(cycle.start, cycle.period - early).end, steps * self.length).pieces
        exchange = exchange_of(nodes, network, self.length, integral)
        matrices = [matrix_of(nodes, network, self.length, integral) for matrix_of in (exchange_matrix, driven_matrix)]
        motion, h, changes = Motion(pieces.z, pieces.psi, False), self.length * self.scene.transit, np.empty((2, *pieces.z.shape))
        memory = np.ascontiguousarray(self._memory(functional[:, None])[..., 0])
        march_back(nodes, self.scene.law, exchange, (matrices[0], matrices[1]), h, integral, motion, memory, changes)
        return impulses(pieces.time - early, pieces.length, self.nodes, changes)

    def essential_radius(self, cycle: Cycle) -> float:
        """As `Flow`: the spectral radius of the waves' motion with psi held. For plain slabs of equal round trips the interface
        returns a wave with the factor rho = (F_v - Z)/(F_v + Z), and the radius is exp of the integral of ln |rho| over the
        period. Slabs of incommensurate round trips with lossless faces have modes with arbitrarily small stress at the interface:
        the radius is 1. In all other cases it is that of the frozen `tangent`."""
        if self.scene.is_plain:
            steps, fraction = self._steps(cycle.period)
            points, weights = np.polynomial.legendre.leggauss(_FINE)
            total = 0.0
            for part, length in ((slice(0, steps - 1), 1.0), (slice(steps - 1, steps), fraction)):
                rows = interpolation_matrix(self._basis, 0.5 * length * (points + 1.0))
                law, psi = self.scene.law, cycle.pieces.psi[part]
                z = resampled(law, cycle.pieces.z[part], psi, lambda nodal: nodal @ rows.T)  # noqa: B023 (called at once)
                total += 0.5 * length * float(logs_of_return(law, 0.5 * self._lines.impedance[0], z, psi @ rows.T) @ weights)
            return math.exp(self.length * total)
        if self.undecided:
            return 1.0
        return float(np.abs(eigenvalues_without(self.tangent(cycle, frozen=True), self.idle)).max())

    @cached_property
    def idle(self) -> Array:
        """As `Flow`, for slabs with commensurate round trips: the states that do not decay in a step with a maximally absorbing
        interface. None for slabs with an `equivalent`: in the motion of that slab alone, the other moves against it."""
        scene, divisor = self.scene, self._lines.divisor
        lossless = all(slab.termination.is_rigid or not slab.termination.dashpot for slab in scene.slabs)
        if scene.equivalent is not None or divisor is None or not lossless:
            return np.zeros((self.size, 0))
        if all(slab.is_plain for slab in scene.slabs) and not (np.rint(self._lines.travel / divisor) % 2.0).all():
            return np.zeros((self.size, 0))  # round trips in a ratio that is not odd:odd
        impedance = self._network.interface_impedance
        rate = scene.velocity * friction_slopes(scene.law, scene.velocity).direct / impedance
        pieces = empty_pieces(1, NODES)
        pieces.z[:], pieces.psi[:] = unknown_of(scene.law, rate), scene.steady_psi
        return _idle_states(self.tangent(Cycle(self.length, self.steady, self.steady, pieces, 0), frozen=True))

    @cached_property
    def undecided(self) -> bool:
        """As `Flow`: true for incommensurate round trips."""
        if self._lines.divisor is not None:
            return False
        from reduced.stability.essential import essential_abscissa

        return essential_abscissa(self.scene) > -_UNDAMPED / self.scene.transit

    def roughness(self, cycle: Cycle, tolerance: float) -> float:
        """As `Flow`."""
        tail, psi = self._rule.tail, cycle.pieces.psi
        largest = max(float(np.abs(values @ tail).max()) for values in (smooth(self.scene.law, cycle.pieces.z, psi), psi))
        return largest / dense_resolution(tolerance, NODES)

    def remeshed(self, cycle: Cycle, finer: float) -> "tuple[DelayFlow, Array]":
        """As `Flow`."""
        return self._onto(DelayFlow(self.scene, finer / self.length, self._divides), cycle.start)

    def loosened(self, start: Array, scenes: Sequence[Scene]) -> "tuple[DelayFlow, Array]":
        """As `Flow`: where travel times differ, on shorter steps of which none is a whole number, and which are short enough for
        every wave of the `scenes`."""
        travel, others = self._lines.travel, [lines_of(scene).travel for scene in scenes]
        others = [other for other in others if other.size == travel.size and not _are_same(travel, other)]
        if not others:
            return self, start
        shortest = min(float(min(other.min(), 1.0 / _FEWEST) / other.max()) for other in others)
        steps = np.linspace(*_LOOSE, _TRIED) * max(1.0 / self.length, 1.0 / (shortest * travel.max()))
        parts = np.outer(steps, travel) % 1.0
        best = int(np.minimum(parts, 1.0 - parts).min(axis=1).argmax())
        return self._onto(DelayFlow(self.scene, float(steps[best]), False), start)

    def _onto(self, new: "DelayFlow", start: Array) -> "tuple[DelayFlow, Array]":
        waves, rest = np.split(start, [math.prod(self._shape)])
        return new, new.sampled(waves.reshape(self._shape), self.length, rest)

    def sampled(self, waves: Array, length: float, rest: Array) -> Array:
        """The state with `waves` (layers, 2, past steps, s) launched in steps of `length` (transits), oldest first, and the
        `rest` of the state. Before the oldest step its polynomials go on: where a step is no part of both delays, more are kept
        than cover them."""
        past = waves.shape[2]
        ages = (np.arange(self.kept)[:, None] - self.kept + self.nodes).ravel() * self.length / length + past
        step = np.clip(np.ceil(ages - 1e-12).astype(int) - 1, 0, past - 1)
        rows = interpolation_matrix(self._basis, np.minimum(ages - step, 1.0))
        return np.concatenate([np.einsum("ldgk,gk->ldg", waves[:, :, step], rows).ravel(), rest])

    def _steps(self, period: float) -> tuple[int, float]:
        """Number of steps that cover the period, and the part of the last one that belongs to it, in (0, 1]."""
        steps = max(1, math.ceil(period / self.length - COINCIDENT))
        return steps, period / self.length - (steps - 1)

    def _psi_row(self, fraction: float) -> Array:
        return np.asarray(interpolation_matrix(self._with_left, np.array([fraction]))[0])

    def lines_at(self, start: Array) -> NetworkLines:
        """The lines at the state `start`, with one free slot in the ring."""
        waves, tops, _ = self._parts(start[:, None])
        return lines_with(self._network, np.ascontiguousarray(np.moveaxis(waves[..., 0], 0, 2)), tops[..., 0], self.kept)

    def _within_last(self, lines: NetworkLines, pieces: Pieces, first: float, fraction: float) -> Array:
        """The state at `fraction` of the last step of a march with these `pieces`; psi was `first` at its start."""
        left = pieces.psi[-2, -1] if pieces.psi.shape[0] > 1 else first
        psi = self._psi_row(fraction) @ np.r_[left, pieces.psi[-1]]
        ring, tops = np.moveaxis(lines.waves, 2, 0)[..., None], lines.tops[..., None]
        return self._state(ring, tops, np.array([psi]), int(lines.cursor[0]), fraction)[:, 0]

    def _parts(self, states: Array) -> tuple[Array, Array, Array]:
        """Waves in a ring (steps, layers, 2, s, m), faces (slabs, 2, m) and psi (m,) of `states` (n, m)."""
        (layers, _, kept, _), count, waves = self._shape, states.shape[1], math.prod(self._shape)
        ring = np.zeros((kept + 1, layers, 2, NODES, count))
        ring[:-1] = np.moveaxis(states[:waves].reshape(*self._shape, count), 2, 0)
        tops = np.zeros((*self.tops_remembered.shape, count))
        tops[self.tops_remembered] = states[waves:-1]
        return ring, tops, states[-1].copy()

    def _memory(self, states: Array) -> Array:
        """The memory of `march_tangent` (kept + 1, rows, m) that `states` (n, m) leave."""
        waves, tops, psi = self._parts(states)
        rest = np.zeros((self.kept + 1, tops[..., 0].size + 1, psi.size))
        rest[self.kept - 1, :-1], rest[self.kept - 1, -1] = tops.reshape(-1, psi.size), psi
        return np.concatenate([waves.reshape(self.kept + 1, -1, psi.size), rest], axis=1)

    def _state(self, ring: Array, tops: Array, psi: Array, cursor: int, fraction: float) -> Array:
        """States (n, m) at `fraction` of the last step in the ring, with the faces `tops` at its end."""
        ordered = ring[(cursor + np.arange(self.kept + 1)) % (self.kept + 1)]
        early, late = shifted_rows(fraction, NODES)
        waves = np.moveaxis(early @ ordered[:-1] + late @ ordered[1:], 0, 2)
        faces = self._faces(ordered, tops, fraction) if self.tops_remembered.any() else tops
        return np.concatenate([waves.reshape(-1, psi.size), faces[self.tops_remembered], psi[None]])

    def _faces(self, ordered: Array, tops: Array, fraction: float) -> Array:
        """Load and velocity (slabs, 2, m) of the outer faces at `fraction` of the last step, from those at its end. A face at the
        velocity w returns the wave P that arrives as P + 2 e w, which gives w at the nodes of the step."""
        points, weights = np.polynomial.legendre.leggauss(NODES)
        rest = 1.0 - fraction
        later = 0.5 * rest * weights @ interpolation_matrix(self._basis, fraction + 0.5 * rest * (points + 1.0))
        here = interpolation_matrix(self._basis, np.array([fraction]))[0]
        network, faces = self._network, tops.copy()
        for slab, layer in enumerate(network.last):
            past = ordered[self.kept - network.back[layer], layer, OUTWARD]
            arrived = np.einsum("njk,nkm->jm", network.weights[layer], past)
            velocity = (ordered[self.kept, layer, INWARD] - arrived) / (2.0 * network.impedance[layer])
            faces[slab, LOAD] += self.length * network.spring[slab] * (later @ velocity)
            faces[slab, VELOCITY] = here @ velocity
        return faces


def _are_same(travel: Array, other: Array) -> bool:
    """Whether travel times are the same, but for rounding."""
    return travel.size == other.size and bool(np.allclose(travel, other, _SAME, 0.0))


def _idle_states(step: Array) -> Array:
    """Orthonormal basis (n, m) of the states that do not decay under repeated application of `step` (n, n)."""
    power = step
    with one_thread():
        for _ in range(_SQUARINGS):
            power = power @ power
        states, sizes, _ = np.linalg.svd(power)
    return states[:, sizes > _LEFT * max(float(sizes[0]), 1.0)]


@cache
def _bases(stages: int) -> tuple[Basis, Basis]:
    """Bases of a step's nodes, and of these with the step's start."""
    nodes = radau(stages).nodes
    return lagrange_basis(nodes), lagrange_basis(np.r_[0.0, nodes])

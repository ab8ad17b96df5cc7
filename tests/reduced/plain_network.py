"""The delay system of any pair of lossless slabs, slowly, as one would write it by hand: a witness that shares no step with us.

Characteristics from MODEL.md section 3, in whole stresses and velocities (no deviations), both slabs apart, in transits of the
upper slab. The lower slab's velocities have the opposite sign, so that v = w_1 + w_2, and either face is driven at V/2. With the
waves U = sigma - e w outwards and D = sigma + e w inwards, which arrive unchanged after a layer's travel time,

    interface  mu = Z (sum D_i/e_i - v) = F(v, psi),    U = 2 mu - D          F = a_* + a ln v + b psi
    joint      (e_in + e_out) w = D - U,                D = U + 2 e_in w,     U = D - 2 e_out w
    face       m w' = y + Z_g (V/2 - w) - U - e w,      y' = K (V/2 - w),     D = U + 2 e w            (rigid: w = V/2)
    state      psi' = r (e^-psi - v)  or  -r v (ln v + psi),  plus the nudge

Friction is one scalar equation, solved by Wright's omega; psi, the springs and the masses are collocated at 12 Gauss nodes. Steps
end on every break point: knots of V, and t = 0 if the start jumps, plus all sums of travel times. A step is halved until the last
Legendre coefficients of ln v, psi, Z v/a and of the waves from springs and masses, as changes of ln v, are
below 3e-12.
"""

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from scipy.special import wrightomega

from slipwave.friction.slip import Slip
from slipwave.scene import Scene
from slipwave.scene.slab import GripFace, MachineFace, ReflectingFace, Slab

NODES = 12
SAME = 1e-9
RESOLVED = 3e-12
SHORT, NOISE, ADDS = 1e-4, 1e-8, 1e-13  # so short a step may have so large an error or one that adds so little
STEEPEST = 4.0
POINTS, WEIGHTS = (0.5 * (x + o) for x, o in zip(legendre.leggauss(NODES), (1.0, 0.0), strict=True))
VANDER = legendre.legvander(2.0 * POINTS - 1.0, NODES - 1)
COEFFICIENTS = np.linalg.inv(VANDER)
INTEGRAL = np.column_stack([0.5 * legendre.legval(2.0 * POINTS - 1.0, legendre.legint(row, lbnd=-1)) for row in np.eye(NODES)])
INTEGRAL = INTEGRAL @ COEFFICIENTS
BARYCENTRIC = 1.0 / np.prod(np.subtract.outer(POINTS, POINTS) + np.eye(NODES), axis=1)


def rows_at(x):
    """(n, NODES): weights of the nodal values for the polynomial's values at x."""
    distance = x[:, None] - POINTS
    hit = np.abs(distance) < 1e-15
    weights = BARYCENTRIC / np.where(hit, 1.0, distance)
    weights = np.where(hit.any(axis=1)[:, None], hit, weights)
    return weights / weights.sum(axis=1)[:, None]


def break_points(scene, until):
    """Sorted times in [0, until]: knots of V (and 0 of a jump) plus all sums of travel times."""
    steps = {float(t) for slab in (scene.upper, scene.lower) for t in travel_times(scene, slab)}
    new = {0.0, *scene.drive.knots}
    found = sorted(new) if scene.start.jump_size or scene.drive.knots else [0.0]
    while new:
        reached = np.unique(np.round([t + step for t in new for step in steps if t + step < until - SAME], 12))
        reached = reached[np.append(True, np.diff(reached) > SAME)] if reached.size else reached
        known = np.array(found)
        new = {float(t) for t in reached if np.abs(known[max(0, np.searchsorted(known, t) - 1) :][:2] - t).min() > SAME}
        found = sorted([*found, *new])
        if not scene.start.jump_size and not scene.drive.knots:
            break
    return np.array([t for t in found if t < until - SAME] + [until])


def travel_times(scene, slab):
    """One way through each layer, in transits."""
    return np.array([0.5 * slab.round_trip / scene.transit * layer.fraction for layer in slab.layers])


@dataclass
class MarchedSlab:
    """A slab with its past waves: `launched` (2, layers) lists of (copies, NODES), outwards and inwards."""

    scene: Scene
    slab: Slab
    copies: int
    launched: list[list[list[np.ndarray]]] = field(default_factory=list)

    def __post_init__(self):
        scene, slab = self.scene, self.slab
        self.e = np.array([slab.epsilon * layer.impedance for layer in slab.layers])
        self.travel = travel_times(scene, slab)
        self.launched = [[[] for _ in self.e] for _ in range(2)]
        time, last, self.rigid = slab.round_trip / scene.transit, self.e[-1], False
        match slab.face:
            case MachineFace(stiffness, impedance, mass):
                self.spring, self.dashpot, self.mass = stiffness / time, impedance, mass * time
                self.spring, self.dashpot, self.mass = (slab.epsilon * x for x in (self.spring, self.dashpot, self.mass))
            case GripFace(stiffness, impedance):
                self.spring, self.dashpot, self.mass = stiffness * slab.epsilon / time, impedance * slab.epsilon, 0.0
            case ReflectingFace(coefficient):
                self.spring, self.dashpot, self.mass = 0.0, last * (1.0 + coefficient) / (1.0 - coefficient), 0.0
            case _:
                self.rigid = True
        half, stress = 0.5 * scene.velocity, steady(scene)[1]
        self.steady = stress - self.e * half, stress + self.e * half
        self.load, self.velocity = np.full(self.copies, stress), np.full(self.copies, half)

    def arrived(self, layer, way, time, starts, lengths):
        """Waves (copies, NODES) at the nodes' `time` (NODES,) that were launched a travel time before."""
        at, parts = time - self.travel[layer], []
        while at.size:
            k = bisect_right(starts, at[0]) - 1
            count = bisect_right(at, starts[k + 1]) if k + 1 < len(starts) else at.size
            if k < 0:
                parts.append(np.full((self.copies, count), self.steady[way][layer]))
            else:
                parts.append(self.launched[way][layer][k] @ rows_at((at[:count] - starts[k]) / lengths[k]).T)
            at = at[count:]
        return np.concatenate(parts, axis=1)

    def enter(self, time, length, starts, lengths, half):
        """D at the interface; the waves that leave joints and face, and the face at the step's end, are left in `fresh`."""
        count = self.e.size
        out = [self.arrived(k, 0, time, starts, lengths) for k in range(count)]
        back = [self.arrived(k, 1, time, starts, lengths) for k in range(count)]
        fresh_out, fresh_back = [None] * count, [None] * count
        face = self.load, self.velocity
        if self.rigid:
            fresh_back[-1] = out[-1] + 2.0 * self.e[-1] * half
        else:
            w, face = self.face(length, out[-1], half)
            fresh_back[-1] = out[-1] + 2.0 * self.e[-1] * w
        for k in range(count - 1):
            inner, outer = self.e[k], self.e[k + 1]
            w = (back[k + 1] - out[k]) / (inner + outer)
            fresh_back[k], fresh_out[k + 1] = out[k] + 2.0 * inner * w, back[k + 1] - 2.0 * outer * w
        self.fresh = fresh_out, fresh_back, face
        return back[0]

    def face(self, length, arrived, half):
        """w (copies, NODES) of the face, and load and velocity at the step's end."""
        hk, resistance, identity = length * self.spring, self.dashpot + self.e[-1], np.eye(NODES)
        system, push = (
            resistance * identity + hk * INTEGRAL,
            self.load[:, None] + hk * INTEGRAL @ half + self.dashpot * half - arrived,
        )
        if self.mass > 0.0:
            system, push = self.mass * identity + length * INTEGRAL @ system, length * push @ INTEGRAL.T
            push = push + self.mass * self.velocity[:, None]
        w = np.linalg.solve(system, push.T).T
        load = self.load + hk * (half - w) @ WEIGHTS
        if self.mass == 0.0:
            return w, (load, self.velocity)
        spring = self.load[:, None] + hk * (half - w) @ INTEGRAL.T
        force = spring + self.dashpot * (half - w) - arrived - self.e[-1] * w
        return w, (load, self.velocity + length / self.mass * force @ WEIGHTS)

    def keep(self, mu, entered):
        out, back, (self.load, self.velocity) = self.fresh
        out[0] = 2.0 * mu - entered
        for k in range(self.e.size):
            self.launched[0][k].append(out[k])
            self.launched[1][k].append(back[k])


def steady(scene):
    law, z = scene.law, np.log(scene.velocity)
    return -z, law.a_star + (law.a - law.b) * z


def plain_network(scene, until, kicks=()):
    """ln v, psi and mu (1 + kicks, 3) at `until` (transits): of the scene, and of copies whose psi is displaced by `size` at the
    end of a step at or after `time`, for (time, size) in `kicks`."""
    return Plain(scene, len(kicks) + 1).march(until, list(kicks))


class Plain:
    """The march; `starts` and `lengths` of its steps."""

    def __init__(self, scene, copies):
        self.scene, law = scene, scene.law
        self.sides = [MarchedSlab(scene, slab, copies) for slab in (scene.upper, scene.lower)]
        self.near = np.array([side.e[0] for side in self.sides])
        self.impedance = 1.0 / np.sum(1.0 / self.near)
        self.a_star, self.a, self.b, self.slip = law.a_star, law.a, law.b, isinstance(law, Slip)
        self.psi = np.full(copies, steady(scene)[0] + scene.start.jump_size)
        self.starts, self.lengths = [], []

    def march(self, until, kicks):
        points, longest = break_points(self.scene, until), min(0.25, *(side.travel.min() for side in self.sides))
        usual = 0.5 * longest
        for begin, end in pairwise(points):
            parts = 2 ** max(0, int(np.ceil(np.log2((end - begin) / min(longest, 2.0 * usual)) - 1e-9)))
            edges = np.linspace(begin, end, parts + 1)
            waiting, usual = list(pairwise(edges))[::-1], min(longest, 2.0 * usual)
            while waiting:
                start, stop = waiting.pop()
                if not self.step(start, stop - start):
                    assert stop - start > 1e-8, f"plain network: not resolved at t = {start}"
                    middle = 0.5 * (start + stop)
                    waiting += [(middle, stop), (start, middle)]
                    usual = 0.5 * (stop - start)
                    continue
                for copy, (time, size) in enumerate(kicks, 1):
                    if size and stop > time:
                        self.psi[copy] += size
                        kicks[copy - 1] = (time, 0.0)
        return self.final

    def ln_v(self, psi, push):
        """ln v of  a_* + a ln v + b psi + Z v = push."""
        load = (push - self.a_star - self.b * psi) / self.a
        omega = wrightomega(load + np.log(self.impedance / self.a))
        return np.where(omega > 1.0, np.log(omega * (self.a / self.impedance)), load - omega)

    def step(self, start, length):
        """Whether the step is resolved; it is then kept."""
        scene, time = self.scene, start + length * POINTS
        half = 0.5 * np.interp(time, scene.drive.times, scene.drive.velocities)
        entered = [side.enter(time, length, self.starts, self.lengths, half) for side in self.sides]
        push = self.impedance * sum(wave / e for wave, e in zip(entered, self.near, strict=True))
        nudge = scene.start.nudge_size * np.exp(-((time - 6.0) ** 2))
        psi = np.repeat(self.psi[:, None], NODES, axis=1)
        for _ in range(40):
            z = self.ln_v(psi, push)
            v, healing = np.exp(z), np.exp(-psi)
            by_psi = -self.b / (self.a + self.impedance * v)  # of ln v
            if self.slip:
                rate, slope = -v * (z + psi), -v * ((z + psi) * by_psi + by_psi + 1.0)
            else:
                rate, slope = healing - v, -healing - v * by_psi
            rate, slope = scene.transit * rate + nudge, scene.transit * slope
            wrong = self.psi[:, None] + length * rate @ INTEGRAL.T - psi
            change = np.linalg.solve(np.eye(NODES) - length * INTEGRAL * slope[:, None, :], wrong[..., None])[..., 0]
            psi = psi + np.clip(change, -2.0, 2.0)
            if not np.isfinite(psi).all() or length * slope.max() > 1e3:
                return False
            if np.abs(change).max() < 1e-13 * max(1.0, np.abs(psi).max()):
                break
        else:
            return False
        resolved = [z, psi, self.impedance / self.a * v]
        resolved += [self.impedance / (self.a * side.e[-1]) * side.fresh[1][-1] for side in self.sides if not side.rigid]
        tails = [np.abs(values[0] @ COEFFICIENTS[-2:].T).max() for values in resolved]
        if max(tails) > (RESOLVED if length > SHORT else max(NOISE, ADDS / length)) or length * slope[0].max() > STEEPEST:
            return False
        mu = push - self.impedance * v
        for side, wave in zip(self.sides, entered, strict=True):
            side.keep(mu, wave)
        self.psi = self.psi + length * rate @ WEIGHTS
        self.starts.append(start)
        self.lengths.append(length)
        push_end = push @ rows_at(np.ones(1))[0]
        last = self.ln_v(self.psi, push_end)
        self.final = np.column_stack([last, self.psi, push_end - self.impedance * np.exp(last)])
        return True

"""The delay system of docs/benchmark.md by numpy alone: a second program beside slipwave, of which it imports nothing.

The interface between any slabs is what their delay lines return: m = mu - mu_ss is -z (g + R g_d) of each line of impedance z,
g_d that of one delay before, and v - V is the sum of their g - R g_d. Alike slabs are one line of half their impedance.

Each transit is cut into panels, each with a polynomial of psi through Chebyshev-Lobatto points that satisfies the equation of
state there (slipwave: Radau points and local elimination). The tangent carries derivatives through all panels, so that
Newton's method closes orbits and the monodromy matrix gives multipliers.    python second_program.py
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

A_STAR, A, B, EPSILON, V = 0.369, 0.0349, 0.0489, 2.8e-5, 100.0
PASSED = -5.2
"""psi at which orbits begin: it falls through this value once in every slip event, much faster than it heals."""
STEADY_PSI, STEADY_MU = -np.log(V), A_STAR + (A - B) * np.log(V)
Array = np.ndarray


class Line(NamedTuple):
    """A slab as the interface sees it: its impedance, after how many transits it returns a wave, and which share of it."""

    impedance: float = 0.5 * EPSILON
    delay: float = 1.0
    share: float = 1.0


class Mesh:
    """`panels` of equal length in a transit, and polynomials of `degree` on each, for slabs that are these `lines`."""

    def __init__(self, panels: int = 8, degree: int = 16, lines: tuple[Line, ...] = (Line(),)) -> None:
        self.panels, self.degree, self.lines = panels, degree, lines
        self.impedance = 1.0 / sum(1.0 / one.impedance for one in lines)
        """That of all lines together."""
        unit = -np.cos(np.pi * np.arange(degree + 1) / degree)
        self.points = 0.5 * (1.0 + unit)
        powers = chebyshev.chebvander(unit, degree)
        self._to_coefficients = np.linalg.inv(powers)
        integrals = np.stack([chebyshev.chebint(row, lbnd=-1.0) for row in np.eye(degree + 1)])
        at_points = chebyshev.chebvander(unit, degree + 1) @ integrals.T
        self.integral = 0.5 / panels * at_points @ self._to_coefficients
        """Values of f at the points of a panel to those of its integral from the panel's beginning."""
        self._returns = [self._return(one) for one in lines]
        self.memory = max(back for parts in self._returns for back, _ in parts)
        """Panels before now on which the lines depend."""

    def rows(self, places: Array) -> Array:
        """Weights of a panel's points in the values at `places` (0 to 1), one row each."""
        rows: Array = chebyshev.chebvander(2.0 * places - 1.0, self.degree) @ self._to_coefficients
        return rows

    def row(self, place: float) -> Array:
        """Weights of a panel's points in the value at `place`."""
        row: Array = self.rows(np.array([place]))[0]
        return row

    def _return(self, line: Line) -> list[tuple[int, Array]]:
        """How many panels ago each panel was from which a line returns waves to one, and its weights in them: one panel if the
        delay is a whole number of panels, else two."""
        back = int(np.floor(line.delay * self.panels + 1e-9))
        places = self.points - max(line.delay * self.panels - back, 0.0)
        early = places < -1e-9
        parts = [(back, line.share * self.rows(places) * ~early[:, None])]
        return [*parts, (back + 1, line.share * self.rows(places + 1.0) * early[:, None])] if early.any() else parts

    def returned(self, panels: list[Array]) -> Array:
        """The waves R g_d, (points, lines, ...), in the panel that follows these panels of g."""
        found = [sum(weights @ panels[-back][:, i] for back, weights in parts) for i, parts in enumerate(self._returns)]
        return np.stack(found, axis=1)


class State(NamedTuple):
    """g of each line before now, (mesh.memory panels, points, lines), and psi now."""

    g: Array
    psi: float


class Panel(NamedTuple):
    """The solution at the points of one panel, from `time` (transits) on: g (points, lines), psi and ln v; `tangent` holds
    derivatives of (g, psi) there by the unknowns of the start."""

    time: float
    g: Array
    psi: Array
    ln_v: Array
    tangent: tuple[Array, Array] | None


def steady(mesh: Mesh, jump: float = 0.0) -> State:
    """Steady sliding at V, with psi off by `jump`."""
    return State(np.zeros((mesh.memory, mesh.degree + 1, len(mesh.lines))), STEADY_PSI + jump)


def ln_rate(impedance: float, psi: Array, waves: Array, guess: Array) -> Array:
    """ln v where friction meets `waves`, the sum of R g_d: a ln v + b psi + a_* = mu_ss - impedance (v - V + 2 waves)."""
    ln_v = guess
    for _ in range(60):
        v = np.exp(np.minimum(ln_v, 30.0))
        off = A * ln_v + B * psi + A_STAR - STEADY_MU + impedance * (v - V + 2.0 * waves)
        step = off / (A + impedance * v)
        ln_v = ln_v - np.clip(step, -3.0, 3.0)
        if np.abs(step).max() < 1e-14:
            break
    return ln_v


def march(
    mesh: Mesh, r: float, start: State, until: float, nudge: float = 0.0, tangent: tuple[Array, Array] | None = None
) -> Iterator[Panel]:
    """The panels from t = 0 on that cover `until`; a `tangent` of the start, (memory, points, lines, unknowns) and (unknowns,),
    is carried along."""
    past, psi0, length = list(start.g), start.psi, 1.0 / mesh.panels
    carried = None if tangent is None else list(tangent[0])
    d_psi0 = None if tangent is None else tangent[1]
    ln_v, k = np.full(mesh.degree + 1, np.log(V)), 0
    shares = np.array([mesh.impedance / one.impedance for one in mesh.lines])
    while k * length < until - 1e-13:
        time, waves = k * length, mesh.returned(past)
        both = waves.sum(axis=1)
        push = nudge * np.exp(-((time + length * mesh.points - 6.0) ** 2))
        psi = np.full(mesh.degree + 1, psi0)
        for _ in range(80):
            ln_v = ln_rate(mesh.impedance, psi, both, ln_v)
            v = np.exp(ln_v)
            slope_v = -B * v / (A + mesh.impedance * v)  # of v by psi
            off = psi - psi0 - mesh.integral @ (r * (np.exp(-psi) - v) + push)
            matrix = np.eye(psi.size) + mesh.integral * (r * (np.exp(-psi) + slope_v))
            step = np.linalg.solve(matrix, off)
            psi = psi - np.clip(step, -1.0, 1.0)
            if np.abs(step).max() < 2e-14:
                break
        if not np.abs(step).max() < 1e-9:
            raise ValueError(f"no solution in the panel at t = {time}: the last step was {np.abs(step).max():.1e}")
        ln_v = ln_rate(mesh.impedance, psi, both, ln_v)
        v = np.exp(ln_v)
        g, tangents = shares * (v - V + 2.0 * both)[:, None] - waves, None
        if carried is not None and d_psi0 is not None:
            d_waves = mesh.returned(carried)
            d_both = d_waves.sum(axis=1)
            by_wave = -2.0 * mesh.impedance * v / (A + mesh.impedance * v)  # of v by the sum of R g_d
            d_psi = np.linalg.solve(matrix, d_psi0 - mesh.integral @ (r * by_wave[:, None] * d_both))
            d_v = slope_v[:, None] * d_psi + by_wave[:, None] * d_both
            d_g = shares[:, None] * (d_v + 2.0 * d_both)[:, None] - d_waves
            carried.append(d_g)
            d_psi0, tangents = d_psi[-1], (d_g, d_psi)
        yield Panel(time, g, psi, ln_v, tangents)
        past.append(g)
        psi0, k = float(psi[-1]), k + 1


def psi_at(mesh: Mesh, r: float, times: list[float], nudge: float = 0.0, jump: float = 0.0) -> list[float]:
    """psi at `times` (transits), from steady sliding with a nudge or a jump."""
    found: dict[float, float] = {}
    for panel in march(mesh, r, steady(mesh, jump), max(times), nudge):
        for time in times:
            place = (time - panel.time) * mesh.panels
            if 0.0 < place <= 1.0 + 1e-12:
                found[time] = float(mesh.row(min(place, 1.0)) @ panel.psi)
    return [found[time] for time in times]


class Orbit(NamedTuple):
    """A closed orbit from `start`: its r and period (transits), the monodromy matrix by (g, psi), and all its panels."""

    r: float
    period: float
    start: State
    monodromy: Array
    panels: list[Panel]

    @property
    def multipliers(self) -> Array:
        """The largest first."""
        found = np.linalg.eigvals(self.monodromy)
        return found[np.argsort(-np.abs(found))]


def _arrived(mesh: Mesh, panels: list[Panel], period: float, pick: Callable[[Panel], tuple[Array, Array]]) -> tuple[Array, Array]:
    """(g before t = `period`, a row for each panel, point and line, psi then) of what `pick` takes from a panel; g is
    interpolated."""
    length, edge = 1.0 / mesh.panels, 1e-12
    rows = []
    for time in (period + length * (np.arange(-mesh.memory, 0)[:, None] + mesh.points)).ravel():
        k = min(int(time / length + edge), len(panels) - 1)
        rows.append(np.tensordot(mesh.row(time / length - k), pick(panels[k])[0], 1))
    k = min(int(period / length), len(panels) - 1)
    return np.concatenate(rows), mesh.row(period / length - k) @ pick(panels[k])[1]


def closed(mesh: Mesh, r: float, period: float, start: State, fixed: str = "r") -> Orbit:
    """The orbit near a guess, by Newton's method in (g, psi) and the period, or r if the period is `fixed`. The orbit begins in
    the slip event, where psi = PASSED. The matrix is kept as long as it serves. Raises ValueError if there is no orbit."""
    last, inverse = np.inf, None
    for _ in range(40):
        panels = list(march(mesh, r, start, period))
        off = np.append(_ends(mesh, panels, period) - np.append(start.g, start.psi), start.psi - PASSED)
        if inverse is None:
            inverse = np.linalg.inv(_newton_matrix(mesh, r, period, start, fixed))
        step = -inverse @ off
        size = max(np.abs(step[:-1]).max() / V, abs(step[-1]))
        if size < 1e-13 or (size < 1e-10 and size > 0.5 * last):  # what is left is rounding
            return Orbit(r, period, start, _monodromy(mesh, r, period, start), panels)
        if size > 0.3 * last:
            inverse = None
        start = State(start.g + step[: start.g.size].reshape(start.g.shape), float(start.psi + step[-2]))
        period, r, last = (period + step[-1], r, size) if fixed == "r" else (period, r * (1.0 + step[-1]), size)
    raise ValueError(f"no orbit at r = {r}, T = {period}: the last step was {size:.1e}")


def _ends(mesh: Mesh, panels: list[Panel], period: float) -> Array:
    return np.append(*_arrived(mesh, panels, period, lambda one: (one.g, one.psi)))


def _monodromy(mesh: Mesh, r: float, period: float, start: State) -> Array:
    """Derivatives of (g, psi) after the period by those of the start."""
    unit = np.eye(start.g.size + 1)
    panels = list(march(mesh, r, start, period, tangent=(unit[:-1].reshape(*start.g.shape, -1), unit[-1])))
    return np.vstack(_arrived(mesh, panels, period, lambda one: one.tangent or (one.g, one.psi)))


def _newton_matrix(mesh: Mesh, r: float, period: float, start: State, fixed: str) -> Array:
    """Derivatives of what is left open by (g, psi), and by the period or the logarithm of r."""
    size, delta = start.g.size + 1, 1e-6
    matrix = np.zeros((size + 1, size + 1))
    matrix[:size, :size] = _monodromy(mesh, r, period, start) - np.eye(size)
    for sign in (1.0, -1.0):
        there = (r, period + sign * delta) if fixed == "r" else (r * (1.0 + sign * delta), period)
        matrix[:size, size] += sign * _ends(mesh, list(march(mesh, there[0], start, there[1])), there[1]) / (2.0 * delta)
    matrix[size, size - 1] = 1.0
    return matrix


def settled(mesh: Mesh, r: float, until: float) -> tuple[float, State]:
    """The last period of a run from the nudge, and the state in its last slip event, where psi falls through PASSED."""
    panels = list(march(mesh, r, steady(mesh), until, nudge=0.5))
    places = np.linspace(0.0, 1.0, 65)
    rows = np.array([mesh.row(place) for place in places])
    times = np.concatenate([one.time + places[1:] / mesh.panels for one in panels])
    psi = np.concatenate([(rows @ one.psi)[1:] for one in panels])
    falls = np.flatnonzero((psi[:-1] > PASSED) & (psi[1:] <= PASSED))
    before, last = (times[k] + (psi[k] - PASSED) / (psi[k] - psi[k + 1]) * (times[k + 1] - times[k]) for k in falls[-2:])
    g, end = _arrived(mesh, panels, last, lambda one: (one.g, one.psi))
    return float(last - before), State(g.reshape(mesh.memory, mesh.degree + 1, -1), float(end))


def figures(mesh: Mesh, orbit: Orbit) -> dict[str, float]:
    """Stress drop, ln v_max and ln v_min over the period, from the polynomials on a fine grid and a parabola at the extremum."""
    fine = np.linspace(0.0, 1.0, 513)
    rows = np.array([mesh.row(place) for place in fine])
    ln_v = np.concatenate([(rows @ one.ln_v)[:-1] for one in orbit.panels])
    mu = np.concatenate([(rows @ (A_STAR + A * one.ln_v + B * one.psi))[:-1] for one in orbit.panels])
    top, bottom = _extreme(mu, 1.0), _extreme(mu, -1.0)
    return {"stress_drop": top - bottom, "v_max": np.exp(_extreme(ln_v, 1.0)), "v_min": np.exp(_extreme(ln_v, -1.0))}


def _extreme(values: Array, sign: float) -> float:
    """The largest (or smallest) value between samples, by the quartic through the five samples about it."""
    k = int(np.clip(np.argmax(sign * values), 2, values.size - 3))
    quartic = np.polyfit(np.arange(-2.0, 3.0), values[k - 2 : k + 3], 4)
    turns = np.roots(np.polyder(quartic))
    inside = [float(root.real) for root in turns if abs(root.imag) < 1e-9 and abs(root.real) < 1.5]
    return float(sign * max(sign * np.polyval(quartic, place) for place in [*inside, 0.0]))


def onset() -> tuple[float, float]:
    """log10 r and the period at which steady sliding of alike slabs loses stability: s = i omega is a root of Q, equations (20),
    (38), (39)."""
    omega, r_star = V * np.sqrt((B - A) / A), EPSILON / (B - A)
    r = 2.0 / omega * np.arctan(0.5 * r_star * omega)
    return float(np.log10(r)), float(2.0 * np.pi / (omega * r))


def hopf(lines: tuple[Line, ...], log10_r: float, period: float) -> tuple[float, float]:
    """The same for any lines, near a guess, by Newton's method: i omega is a root of 1 + (a/V - b r/(s + r V)) Y(s), in which
    Y, the sum of (1 - R e^-sd)/(z (1 + R e^-sd)), is what the lines answer to a stress."""
    place, delta = np.array([log10_r, np.log(period)]), 1e-6

    def off(place: Array) -> Array:
        s, r = 2j * np.pi * np.exp(-place[1]), 10.0 ** place[0]
        waves = [(one.impedance, one.share * np.exp(-s * one.delay)) for one in lines]
        answer = sum((1.0 - wave) / (z * (1.0 + wave)) for z, wave in waves)
        value = 1.0 + (A / V - B * r / (s + r * V)) * answer
        return np.array([value.real, value.imag])

    for _ in range(20):
        by_both = [(off(place + one) - off(place - one)) / (2.0 * delta) for one in delta * np.eye(2)]
        place = place - np.linalg.solve(np.transpose(by_both), off(place))
    return float(place[0]), float(np.exp(place[1]))


def special(mesh: Mesh, kind: str, r: float, period: float, start: State, apart: float = 0.01) -> tuple[float, float]:
    """(log10 r, period) of the special point near an orbit: where r turns ("fold"), a multiplier is -1 ("doubling"), or a pair's
    modulus is 1 ("torus"); from orbits of five periods so far `apart`."""
    orbits = []
    for place in apart * np.array([0.0, 1.0, 2.0, -1.0, -2.0]):
        near = orbits[0] if orbits and place == -apart else orbits[-1] if orbits else Orbit(r, period, start, np.eye(1), [])
        orbits.append(closed(mesh, near.r, period + place, near.start, fixed="period"))
    places, log10_r = np.array([one.period - period for one in orbits]), np.array([np.log10(one.r) for one in orbits])
    along = np.polyfit(places, log10_r, 4)
    zero = np.polyder(along) if kind == "fold" else np.polyfit(places, [_test(kind, one.multipliers) for one in orbits], 4)
    place = min((root.real for root in np.roots(zero) if abs(root.imag) < 1e-9), key=abs)
    return float(np.polyval(along, place)), float(period + place)


def _test(kind: str, multipliers: Array) -> float:
    """0 at a special point of that kind."""
    if kind == "doubling":
        return float((multipliers[np.argmin(np.abs(multipliers + 1.0))] + 1.0).real)
    pairs = multipliers[np.abs(multipliers.imag) > 1e-3]
    return float(np.abs(pairs[np.argmin(np.abs(np.abs(pairs) - 1.0))]) - 1.0)

"""Start values of a fit, for scenes whose values are far from the best ones."""

from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np
from scipy.optimize import brentq

from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.fit.cycles import MeanCycle
from validation.fit.parameters import Free, sizes

_FACTORS = (
    ("memory_length", 0.1),
    ("memory_length", 10.0),
    ("memory_length", 0.3),
    ("memory_length", 3.0),
    ("ab", 0.4),
    ("ab", 2.5),
)
_GROUPS = {"memory_length": ("memory_length",), "ab": ("a", "b")}
_SPRINGS = ("stiffness", "shear_modulus", "thickness")
_LOGARITHM = 15.0  # of the slip rate in an event over that between two: friction falls by so many times b - a
_KAPPAS = (0.1, 0.3, 0.03, 0.6)  # of the critical stiffness
_BELOW = (0.93, 0.8, 0.5)
_RATIOS = (None, 0.6, 0.8)  # a/b; None: the scene's, if it can stick and slip


def other_starts(free: Sequence[Free], first: Array) -> Iterator[Array]:
    """Start values with another memory length, and with other a and b."""
    for group, factor in _FACTORS:
        moves = [one.is_positive and _word(one) in _GROUPS[group] for one in free]
        if any(moves):
            yield first + np.log(factor) * np.array(moves, dtype=float)


def sticking_starts(free: Sequence[Free], first: Array, cycle: MeanCycle, scene_of: Callable[[Array], Scene]) -> Iterator[Array]:
    """Start values at which steady sliding is unstable, friction falls by about as much as in the mean cycle and, if the spring
    is free, rises before an event at the measured rate."""
    index = {_word(one): k for k, one in enumerate(free) if one.is_positive}
    size = cycle.friction.size
    middle = slice(size // 3, 2 * (size // 3))
    steep = float(np.polyfit(np.arange(size // 3) * cycle.period / size, cycle.friction[middle], 1)[0])
    for kappa, ratio in product(_KAPPAS, _RATIOS):
        inner = first.copy()
        for word in _SPRINGS:
            if word in index and steep > 0.0:
                inner[index[word]] = _as_stiff(free, inner, index[word], steep, scene_of)
                break
        a, b = _effects(scene_of(inner))
        share, weaker = ratio or (a / b if 0.0 < a < 0.9 * b else 0.7), cycle.drop / _LOGARITHM
        if "a" in index:
            inner[index["a"]] = np.log(weaker * share / (1.0 - share) if "b" in index else max(b - weaker, 0.1 * b))
        if "b" in index:
            inner[index["b"]] = np.log(weaker / (1.0 - share) if "a" in index else a + weaker)
        scene = scene_of(inner)
        a, b = _effects(scene)
        weaker = b - a
        if "memory_length" in index and weaker > 0.0:
            inner[index["memory_length"]] += np.log(kappa * weaker * scene.transit / scene.stiffness)
        yield inner


def _effects(scene: Scene) -> tuple[float, float]:
    """a and b of the scene's law; 0 where a law of the user's own has none."""
    parameters = scene.law._asdict()
    return parameters.get("a", 0.0), parameters.get("b", 0.0)


def unstable_starts(free: Sequence[Free], first: Array, scene_of: Callable[[Array], Scene]) -> Iterator[Array]:
    """The first values with one of a, b and L changed, so that steady sliding is unstable: the stiffness is one of some shares of
    the critical one."""
    index = {_word(one): k for k, one in enumerate(free) if one.is_positive}
    scene = scene_of(first)
    a, b = _effects(scene)
    for kappa in _BELOW:
        inner, weaker = first.copy(), scene.stiffness / scene.transit / kappa
        if "a" in index and b > weaker:
            inner[index["a"]] = np.log(b - weaker)
        elif "b" in index:
            inner[index["b"]] = np.log(a + weaker)
        elif "memory_length" in index and b > a:
            inner[index["memory_length"]] += np.log((b - a) / weaker)
        else:
            return
        yield inner


def _as_stiff(free: Sequence[Free], inner: Array, k: int, steep: float, scene_of: Callable[[Array], Scene]) -> float:
    """The k-th value at which a locked interface is loaded at the rate `steep`; unchanged if there is none."""

    def short(x: float) -> float:
        scene = scene_of(np.where(np.arange(inner.size) == k, x, inner))
        return float(np.log(scene.stiffness * scene.velocity / sizes(scene)[0] / steep))

    low, high = free[k].inner(free[k].low), free[k].inner(free[k].high)
    return float(brentq(short, low, high, xtol=1e-3)) if short(low) * short(high) < 0.0 else float(inner[k])


def _word(one: Free) -> str:
    return one.name.rpartition(".")[2]

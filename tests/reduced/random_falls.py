"""Random pairs of slabs whose drive falls so far that slip reverses, for laws that allow v <= 0.

`python -m tests.reduced.random_falls 100` judges that many and prints those that fail.
"""

import sys
from typing import NamedTuple

import numpy as np

from reduced.delay.system import delay_system
from slipwave import read
from slipwave.errors import NumericsError
from slipwave.solve import follow
from slipwave.step.nodal import NOT_SMOOTH
from tests.reduced.random_networks import fit_out
from validation.compute.build import build

KINDS = ("alike", "unlike", "irrational", "layered", "grip", "reflection", "machine")
LAWS = ("ageing-regularised", "slip-regularised", "spinodal")
CELLS = (512, 2048)
ALLOWED, BY_FD = 10.0, 0.05


class Fall(NamedTuple):
    """`halved`: the largest difference of psi and mu at the end from those by steps half as long, over the tolerance; `fd`: that
    from `fd`; whether v `reverses` in the run; `refused`: the reason."""

    seed: int
    scene: str
    halved: float
    fd: float
    reverses: bool
    refused: str

    @property
    def is_right(self):
        return self.halved <= ALLOWED and self.fd <= BY_FD


def random_fall(seed):
    """The scene and the words of a number."""
    rng = np.random.default_rng(seed)
    kind, law = KINDS[seed % len(KINDS)], LAWS[seed // len(KINDS) % len(LAWS)]
    a = rng.uniform(0.01, 0.05)
    epsilon, r = 10.0 ** rng.uniform(-5.0, -4.0), 10.0 ** rng.uniform(-3.2, -2.3)
    upper = {"epsilon": epsilon, "r": r}
    lower = dict(upper)
    if kind != "alike":
        lower = {"epsilon": epsilon * rng.uniform(0.3, 3.0), "r": r * rng.choice([0.5, 1.0, 1.5, 2.0])}
    if kind == "irrational":
        lower["r"] = r * rng.uniform(0.5, 2.0)
    fit_out(rng, upper, kind, [0.25, 0.5, 0.75])
    ratio = 10.0 ** rng.uniform(np.log10(30.0), 6.0)
    velocity = 10.0 ** rng.uniform(-0.3, 0.5) / min(upper["epsilon"], lower["epsilon"])  # waves that friction cannot carry
    rise, fall = np.round(rng.uniform([2.0, 12.0], [6.0, 18.0]) * 4.0) / 4.0
    if rng.random() < 0.3:
        rise, fall = rng.uniform([2.0, 12.0], [6.0, 18.0])
    after = velocity / ratio if rng.random() < 0.8 else 0.0
    ramp = rng.uniform(0.2, 2.0) if rng.random() < 0.3 else 0.0
    knots = [[0.0, 100.0], [rise, 100.0], [rise, velocity], [fall, velocity], [fall + ramp, after]]
    interface = {"law": law, "a_star": 0.369, "a": a, "b": a * rng.uniform(0.7, 2.0)}
    if law == "spinodal":
        interface |= {"cutoff_velocity": 10.0 ** rng.uniform(3.0, 6.0), "saturation_velocity": 10.0 ** rng.uniform(-4.0, -1.0)}
    scene = {
        "interface": interface,
        "drive": {"velocity": [[float(t), float(v)] for t, v in knots]},
        "upper": upper,
        "lower": lower,
        "start": {"size": 0.0},
        "run": {"until": 31.87},
    }
    return read(scene), f"{kind}, {law}, ramp {ramp:.2g}, to {after:.3g}"


class Lowest:
    """The least rate unknown at the nodes."""

    least = np.inf

    def scan(self, pieces):
        self.least = min(self.least, pieces.z.min())


def judge(seed, tolerance=1e-9):
    scene, words = random_fall(seed)
    lowest = Lowest()
    try:
        solver = delay_system(scene, tolerance)
        final = follow(solver, scene.until, observers=[lowest])
        finer = delay_system(scene, tolerance)
        while finer.steps < 2.0 * solver.steps:
            finer._refine(NOT_SMOOTH)
        other = follow(finer, scene.until)
        fd = by_leapfrog(scene)
    except NumericsError as refusal:
        return Fall(seed, words, np.inf, np.inf, False, str(refusal))
    ends = [np.array([one.psi, one.mu]) for one in (final, other, fd)]
    differences = [float(np.abs(one - ends[0]).max()) for one in ends[1:]]
    return Fall(seed, words, differences[0] / tolerance, differences[1], bool(lowest.least < 0.0), "")


def by_leapfrog(scene):
    """The end of the run by `fd`, with more cells where its steps are too long for the state."""
    try:
        return follow(build("fd", scene, cells=CELLS[0]), scene.until)
    except NumericsError:
        return follow(build("fd", scene, cells=CELLS[1]), scene.until)


if __name__ == "__main__":
    first, last = (0, *map(int, sys.argv[1:]))[-2:]
    found = []
    for seed in range(first, last):
        found.append(judge(seed))
        if not found[-1].is_right:
            print(found[-1], flush=True)
    largest = [max(getattr(one, name) for one in found if not one.refused) for name in ("halved", "fd")]
    print(
        f"{sum(one.is_right for one in found)} of {len(found)} right, {sum(one.reverses for one in found)} reverse; largest "
        f"difference by half the step {largest[0]:.3g} tolerances, from fd {largest[1]:.3g}"
    )

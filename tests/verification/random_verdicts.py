"""Verdicts of runs of random scenes, each judged by what the classifier does not look at.

.venv/bin/python -m tests.verification.random_verdicts 5000 5100

The run goes on to four times its length, and the judge reads the state psi alone, from the polynomials of the march: no events,
no cycles, no figures of the classifier. Seconds are those of the processor.

    steady, decaying    no root of steady sliding grows (certified count), and the range of psi ends below half of what it was at
                        the end of the run, or falls at the rate of the leading root
    growing             a root grows, and the range of psi rises after the run
    periodic (n)        the motion after the run and that at the end repeat after this period, and after no part of it
    torus               it is not so after 1 to 16 cycles at the end, and the largest Lyapunov exponent is zero within its margin
    irregular           it is not, and the exponent is above its margin (where steps differ: neighbours 1e-8 apart part)
    settling, too short no claim on the motion; a run of the length that is named, or of eight times the length, should make one
"""

import math
import signal
import sys
import time
from collections import Counter
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from reduced.stability import analyse, characteristic, scaled, spectrum, unstable_count
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.ageing import Ageing
from slipwave.friction.slip import Slip
from slipwave.observe import HistoryObserver
from slipwave.scene import Scene
from slipwave.scene.drive import Start, steady_drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, MachineFace, Slab
from slipwave.solve import follow
from slipwave.solve.lyapunov import largest_exponent
from validation.compute.build import build
from validation.compute.models import one_port_of
from validation.compute.outlook import outlook
from validation.compute.run import Run, needed, reconsidered, simulate

KINDS = ["plain", "plain", "plain", "unlike", "layers", "grip", "machine", "viscous"]
MODELS = ["delay"] * 7 + ["kelvin-voigt", "modal:2", "block12", "quasidynamic"]
LONGER, AGAIN, SECONDS = 4.0, 8.0, 20
SAME, OTHER = 5e-3, 1e-3
"""Differences of psi one period later, over its deviation, root mean square: of a periodic motion, and of one that is none."""

_PARTED = 1e-3
"""Difference of motions that began 1e-8 apart from which they have parted."""

NONE = "undecided: "

_PLACES = np.sort(np.random.default_rng(1).random(1000))
"""Of the stretch that is compared: no multiple of a period."""


class Case(NamedTuple):
    """A scene to be run by a model to `until` (transits)."""

    scene: Scene
    model: str
    until: float


class Answer(NamedTuple):
    """The verdict's word, and what the judge says: "right", "wrong: ..." or "undecided: ..."."""

    verdict: str
    judge: str


class Watched(NamedTuple):
    """A run, reconsidered by what is known of steady sliding, and its motion from its middle to four times its length."""

    run: Run
    motion: HistoryObserver

    def psi(self, times):
        """Psi at `times` (transits)."""
        return np.asarray(self.motion.at(times)[2])


def case_of(number):
    """The case of this number: near the onset of stick-slip, on either side, or up to 2.5 times the thickness there."""
    rng = np.random.default_rng([77, number])
    while True:
        scene, model = _scene(rng, number)
        try:
            onset = analyse(scene, one_port_of(model)).log10_r_c
        except (SceneError, NumericsError):
            continue
        if math.isfinite(onset):
            beyond = rng.uniform(-0.02, 0.03) if rng.random() < 0.4 else rng.uniform(0.0, 0.4)
            there = scaled(scene, round_trip=10.0 ** (onset + beyond) / scene.transit)
            cycle = outlook(there, one_port_of(model)).period
            until = round(min(6000.0, max(200.0, cycle * 10.0 ** rng.uniform(1.0, 2.3))))
            if until > 40.0 * cycle or rng.random() < 0.05:
                return Case(there, model, float(until))


def _scene(rng, number):
    def among(low, high):
        return float(10.0 ** rng.uniform(math.log10(low), math.log10(high)))

    kind, model = str(rng.choice(KINDS)), str(rng.choice(MODELS))
    a = among(0.01, 0.05)
    gap, velocity = a * among(0.1, 1.0), among(1.0, 1000.0)
    r = 0.2 / velocity
    upper = lower = Slab(gap * r * among(0.05, 20.0), r)
    if kind == "unlike":
        ratio = rng.integers(1, 5) / rng.integers(1, 5)
        lower = Slab(upper.epsilon * among(0.3, 3.0), r * float(ratio))
    elif kind == "layers":
        parts = rng.dirichlet(np.ones(2))
        lower = upper = replace(upper, layers=tuple(Layer(float(part), among(0.3, 3.0)) for part in parts))
    elif kind in ("grip", "machine"):
        face = GripFace(among(0.1, 10.0), among(0.1, 10.0))
        held = replace(upper, face=face if kind == "grip" else MachineFace(face.stiffness, face.impedance, among(0.1, 3.0)))
        upper, lower = held, held
    elif kind == "viscous":
        lower = upper = replace(upper, viscosity=KelvinVoigtViscosity(r * among(1e-3, 0.1)))
        model = "modal:2"
    law = Slip(0.4, a, a + gap) if rng.random() < 0.15 else Ageing(0.4, a, a + gap)
    start = Start(size=among(0.02, 2.0))
    return Scene(f"{kind}-{number}", law, upper, lower, steady_drive(velocity), start), model


def watched(case):
    """The run of a case, and how it goes on."""
    solver = build(case.model, case.scene)
    state = HistoryObserver(case.scene.law, solver.nodes, 0.5 * case.until)
    run = reconsidered(simulate(solver, case.until, [state]), one_port_of(case.model))
    if run.failed:
        raise NumericsError(run.failed)
    follow(solver, LONGER * case.until, [state])
    return Watched(run, state)


def judged(case):
    """The verdict on a case and the judge's word on it. Raises what the run raises."""
    seen = watched(case)
    verdict = seen.run.verdict
    if verdict.kind in ("settling", "too short"):
        return Answer(verdict.kind, _later(case, seen))
    if verdict.kind in ("steady", "decaying", "growing"):
        return Answer(verdict.kind, _beside_sliding(case, seen))
    if verdict.kind == "periodic":
        return Answer(f"periodic {verdict.multiplicity}", _on_period(case, seen))
    return Answer(verdict.kind, _on_wandering(case, seen))


def _beside_sliding(case, seen):
    problem = characteristic(case.scene, one_port_of(case.model))
    grows, kind = bool(unstable_count(problem)), seen.run.verdict.kind
    if grows != (kind == "growing"):
        return f"wrong: {kind}, while {'a root grows' if grows else 'no root grows'}"
    onset = 2.0 * math.pi / problem.slopes.omega_c / case.scene.transit
    width = min(2.0 * onset, 0.5 * case.until)
    at_end, last = (float(np.ptp(seen.psi(np.linspace(end - width, end, 2000)))) for end in (case.until, LONGER * case.until))
    if last < 1e-9 or (kind != "growing" and last < 0.5 * at_end) or (kind == "growing" and last > at_end):
        return "right"
    rate = spectrum(case.scene, one_port_of(case.model)).rate * case.scene.transit
    fall = math.log(last / at_end) / (rate * (LONGER - 1.0) * case.until)
    return "right" if 0.7 < fall < 1.5 else f"wrong: {kind}, range from {at_end:.4g} to {last:.4g}, {fall:.3g} of the root's rate"


def apart(seen, begin, end, period):
    """The least root mean square of psi one period later less psi, over the deviation of psi, from `begin` to `end`, and the
    period (transits) near `period`, within a hundredth, where that is."""
    times = begin + (end - 1.01 * period - begin) * _PLACES
    early = seen.psi(times)
    spread = float(np.std(early))

    def at(lag):
        return float(np.sqrt(np.mean((seen.psi(times + lag) - early) ** 2))) / spread

    lags = period * np.linspace(0.99, 1.01, 21)
    best, width = min(lags, key=at), lags[1] - lags[0]
    for _ in range(4):
        best, width = min(best + width * np.linspace(-1.0, 1.0, 7), key=at), 0.25 * width
    return at(best), float(best)


def _on_period(case, seen):
    """Whether the period of the cycles is one of the motion right after the run, and at the end of it."""
    verdict, last = seen.run.verdict, LONGER * case.until
    periods = seen.run.events.period[-verdict.multiplicity :]
    if verdict.multiplicity == 1:
        periods = np.array([seen.run.statistics.period.mean])  # is that of the motion, not of a transient before it
    period = float(periods.sum())
    size = min(case.until, 6.0 * period)
    if size < 1.3 * period:
        return NONE + "the period is long"
    found = [apart(seen, begin, begin + size, period) for begin in (case.until, last - size)]
    if found[1][0] > SAME:
        return f"wrong: psi differs by {found[0][0]:.2g} and {found[1][0]:.2g} of itself a period of {period:.5g} later"
    if abs(found[1][1] / period - 1.0) > 2e-3:
        return f"wrong: the period moves from {period:.6g} to {found[1][1]:.6g}"
    for n in range(1, verdict.multiplicity):
        if apart(seen, last - size, last, float(periods[:n].sum()))[0] < 0.1 * OTHER:
            return f"wrong: the period is that of {n} events"
    return "right"


def _on_wandering(case, seen):
    verdict, mean, last = seen.run.verdict, seen.run.statistics.period.mean, LONGER * case.until
    most = min(16, int(case.until / (1.5 * mean)))
    closest = min((apart(seen, last - case.until, last, n * mean)[0], n) for n in range(1, most + 1))
    if closest[0] < OTHER:
        return f"wrong: {verdict.kind}, while psi differs by {closest[0]:.2g} of itself {closest[1]} cycles later"
    told = f"closest return {closest[0]:.2g} after {closest[1]} cycles"
    try:
        solver = build(case.model, case.scene)
        follow(solver, LONGER * case.until)
        exponent = largest_exponent(solver, build(case.model, case.scene), mean)
        chaotic = exponent.rate > 1.5 * exponent.margin and exponent.rate * mean > 1e-3
        told = f"exponent {exponent.rate:.3g} +- {exponent.margin:.2g}, {told}"
    except NumericsError:  # the steps of the two marches part
        parted = _separation(case, seen)
        chaotic = parted > _PARTED
        told = f"motions that begin 1e-8 apart are {parted:.2g} apart, {told}"
    if verdict.kind == "irregular":
        return "right" if chaotic else NONE + told
    return f"wrong: torus, {told}" if chaotic else "right"


def _separation(case, seen):
    """Difference of psi from that of a run whose start differs by 1e-8 of itself, root mean square over the deviation of psi,
    at the end of the longer run."""
    scene = replace(case.scene, start=Start(size=case.scene.start.size * (1.0 + 1e-8)))
    solver = build(case.model, scene)
    other, end = HistoryObserver(scene.law, solver.nodes, 0.5 * case.until), LONGER * case.until
    follow(solver, end, [other])
    times = end - 0.5 * case.until * (1.0 - _PLACES)
    here = seen.psi(times)
    return float(np.sqrt(np.mean((other.at(times)[2] - here) ** 2)) / np.std(here))


def _later(case, seen):
    """Whether the length that is named, or eight times the length, is long enough."""
    verdict = seen.run.verdict
    named = needed(verdict, case.scene, one_port_of(case.model))
    if verdict.kind == "too short" and not named > case.until:
        return f"wrong: too short, and the length named is {named:g} for {case.until:g}"
    longer = reconsidered(simulate(build(case.model, case.scene), AGAIN * case.until), one_port_of(case.model))
    return "right" if longer.kind not in ("settling", "too short") else f"still {longer.kind} at eight times the length"


@contextmanager
def within(seconds):
    """TimeoutError after so many seconds of the processor."""

    def give_up(*_):
        raise TimeoutError

    signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def main(first, last):
    """Prints each verdict from `first` to before `last`, and the sums; the number of wrong ones."""
    sums = Counter()
    for number in range(first, last):
        case, began = case_of(number), time.process_time()
        told: Any
        try:
            with within(SECONDS):
                told = judged(case)
        except TimeoutError:
            told = Answer("dear", "takes too long")
        except (NumericsError, SceneError) as failure:
            told = Answer("failed", str(failure))
        sums.update([told.verdict.split()[0], told.judge.split(":")[0]])
        took = time.process_time() - began
        print(f"{number} {case.scene.name} {case.model} {case.until:g} {took:.1f} s: {told.verdict}: {told.judge}", flush=True)
    print(dict(sums))
    return sums["wrong"]


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) > 0)

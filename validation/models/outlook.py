"""How long a run is. Before a run of a scene it is predicted whether steady sliding is stable, how fast it is left or reached,
and the period of a cycle.

The period is the longer of two. At the onset of stick-slip it is 2 pi/omega_c. Far beyond, it is the time D/(k V) in which the
drive restores, through the stiffness k, the stress D that an event releases. Friction falls by w = -V d mu_ss/dV for every e-fold
of the slip rate; the state heals during T = D/(k V), and the event slips at v = D/(2 Z), limited by radiation. Inertia doubles
the drop:

    D = 2 w ln(1 + T v),     solved by iteration.

It is accurate within a factor of about two and sets the length of the first stretch of a run.

A run lasts to a given time, until its second half has a number of cycles, or until its motion is settled (`Length`).

`amplified_rounding`: whether a run from steady sliding is decided by its start or by rounding.

Where steady sliding is unstable, a disturbance of psi grows as e^(sigma t), t in transits, sigma the leading root. The nudge of a
smooth start acts late (its peak is at t = 6); extrapolated back to t = 0 it is

    N = size int_0^inf e^(-sigma t - (t - 6)^2) dt = size (sqrt(pi)/2) e^-36 w(i (sigma/2 - 6)),

w the Faddeeva function; a jump is its size. Rounding of psi acts from t = 0 on. Their ratio is the relative uncertainty of the
amplitude with which the run leaves steady sliding; divided by sigma, that of the time.

`costly_steps`: loss of accuracy by a step of V. Models with equal time steps shift it to the end of a step, and no grid resolves
the front of its wave.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from reduced.parameters import scaled
from slipwave.friction.law import friction_slopes
from slipwave.observe import Events, MotionVerdict, summarise
from slipwave.observe.torus import MANY
from slipwave.observe.verdict import REPEATS
from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE, NUDGE_REACH, StartKind
from slipwave.solve import Solver

Ended: TypeAlias = Literal["until", "cycles", "settled", "limit"]
"""Reason of the end of a run: at the given time, with the requested cycles, settled, or at the limit of work."""

LIMIT = 300.0
"""Longest run time (s), by a count of the work, of a run until it is settled."""

LONGEST_RUN = 1e9
"""Transits; the longest run."""

_FIRST = 16.0  # expected cycles, half of them judged
_LONGER = 1.25  # from one look to the next
_DIES_OUT = 16.0  # decay times until 1e-7 of a disturbance is left
_ENOUGH = 8  # cycles that repeat
_STEP = 1.02  # from one look for cycles to the next, if a cycle is shorter

EXPECTED_ERROR = 1e-9
"""Relative error expected of a model without a requested tolerance."""

LEFT_BY_ROUNDING = 40.0
"""Growth times after which rounding alone has destroyed steady sliding."""

_NO_ECHO = 20.0
"""Growth per transit from which the leading root is real, found from the right: its echoes are e^-20 of it."""

_ERFC_ENDS = 26.0
"""Beyond it erfc(x) underflows."""

_ROUNDS = 50


@lru_cache(maxsize=32)
def is_stable(scene: Scene, model: str) -> bool | None:
    """Whether steady sliding at the velocity with which the drive of `scene` ends is stable; None if V ends at 0 or the rate of
    growth is 0 within rounding. Takes a third of the time of `growth_rate`."""
    from reduced.stability.spectrum import certified

    velocity = scene.drive.velocities[-1]
    return None if velocity == 0.0 else certified(scaled(scene, velocity=velocity), model)[0]


def growth_rate(scene: Scene, model: str) -> float:
    """Growth (> 0) or decay, per transit, of disturbances of steady sliding at the velocity with which the drive of `scene` ends;
    0 in a hold. `model` is one with the one-port of the model that runs."""
    from reduced.stability import spectrum

    velocity = scene.drive.velocities[-1]
    return spectrum(scaled(scene, velocity=velocity), model).rate * scene.transit if velocity else 0.0


def expected_period(scene: Scene) -> float:
    """Of a cycle at the velocity with which the drive of `scene` ends, in transits; infinite in a hold."""
    velocity = scene.drive.velocities[-1]
    if velocity == 0.0:
        return math.inf
    final = scaled(scene, velocity=velocity)
    slopes = friction_slopes(final.law, velocity)
    onset = 2.0 * math.pi / (slopes.omega_c if slopes.weakening else slopes.healing)
    released = _stress_released(final) if slopes.weakening else 0.0
    loading = final.stiffness * velocity
    return max(onset / scene.transit, released / loading if loading else math.inf if released else 0.0)


def _stress_released(scene: Scene) -> float:
    """Stress drop D (normal stress) of a scene with a constant drive and weakening friction; infinite without loading."""
    weakening = -scene.velocity * friction_slopes(scene.law, scene.velocity).steady
    loading = scene.stiffness * scene.velocity / scene.transit  # per L/V*
    if loading == 0.0:
        return math.inf
    drop = weakening
    for _ in range(_ROUNDS):
        if drop == 0.0:
            break
        slip = 2.0 * math.log(drop) - math.log(loading) - math.log(2.0 * scene.impedance)  # ln (T v), which may overflow
        drop = 2.0 * weakening * (slip + math.log1p(math.exp(-slip)) if slip > 0.0 else math.log1p(math.exp(slip)))
    return drop


class JudgedHalf(NamedTuple):
    """The second half of a run `until` now (transits): its `cycles`, and the verdict, None if events are not recorded."""

    until: float
    verdict: MotionVerdict | None
    cycles: Events

    @property
    def halves_agree(self) -> bool:
        """Whether period and stress drop have the same mean over the earlier and the later half of the cycles, each of whole
        periods: within 1e-3, or the larger of the margins if they never repeat."""
        assert self.verdict is not None
        events = self.verdict.multiplicity or 1
        half = self.verdict.cycles // (2 * events) * events
        parts = [Events(*(column[part] for column in self.cycles)) for part in (slice(-2 * half, -half), slice(-half, None))]
        earlier, later = (summarise(part, not self.verdict.wanders) for part in parts)
        for name in ("period", "stress_drop"):
            before, after = getattr(earlier, name).mean, getattr(later, name).mean
            margins = [part.margins[name] for part in (earlier, later) if self.verdict.wanders]
            if abs(before - after) > max([REPEATS * before, *margins]):
                return False
        return True


@dataclass(kw_only=True)
class Length:
    """How long a run is: to the time `until` (transits). No stretch is begun beyond which the whole run would take more than
    `most_seconds`."""

    until: float = math.inf
    most_seconds: float = math.inf

    def ends(self, after: float) -> Iterator[float]:
        """The ends of its stretches, rising, of a run that is at the time `after` (transits)."""
        yield self.until

    def ended(self, now: JudgedHalf) -> Ended | None:
        """Reason to end the run here; None to continue."""
        return "until"


@dataclass
class UntilSettled(Length):
    """Run until the motion is no longer a transient, as far as its cycles show, at most to `until`. `model` is one with the
    one-port of the model that runs.

    Cycles that repeat are settled if there are 8 or more, cycles that never repeat if there are 16 or more, and if the means of
    period and stress drop over the earlier and the later half of them agree: within 1e-3, or within the margins of cycles that
    never repeat. A decaying run is settled if steady sliding is stable; a driven run always.
    """

    scene: Scene
    model: str
    most_seconds: float = field(default=LIMIT, kw_only=True)

    def ends(self, after: float) -> Iterator[float]:
        """As `Length`: a quarter of a given time, a half and the whole. Else the first is after the start and 16 expected cycles,
        late enough that the drive rests in the second half, and each later one is a quarter later."""
        if math.isfinite(self.until):
            yield from (end for end in (0.25 * self.until, 0.5 * self.until, self.until) if end > after)
            return
        changes = 0.0 if self.scene.drive.is_constant else self.scene.drive.times[-1]
        period, first = expected_period(self.scene), 0.0
        if math.isfinite(period):
            stable = is_stable(self.scene, self.model)
            first = min(_DIES_OUT / -growth_rate(self.scene, self.model) if stable else math.inf, _FIRST * period)
        end = min(2.0 * (changes + NUDGE_CENTRE + NUDGE_REACH) + first, LONGEST_RUN)
        while end <= LONGEST_RUN:
            if end > after:
                yield end
            end *= _LONGER

    def ended(self, now: JudgedHalf) -> Ended | None:
        """As `Length`. Only a motion without cycles needs the roots of steady sliding."""
        return "settled" if self._settled(now) else None

    def _settled(self, now: JudgedHalf) -> bool:
        if now.verdict is None:
            return True
        match now.verdict.kind:
            case "driven":
                return True
            case "decaying":
                return is_stable(self.scene, self.model) is not False
            case "steady":
                if is_stable(self.scene, self.model) is not False:
                    return True
                return growth_rate(self.scene, self.model) * now.until > LEFT_BY_ROUNDING
            case "periodic":
                return now.verdict.cycles >= max(_ENOUGH, 2 * (now.verdict.multiplicity or 1)) and now.halves_agree
            case "torus" | "irregular":
                return now.verdict.cycles >= MANY and now.halves_agree
        return False


@dataclass
class UntilCycles(Length):
    """Run until the second half of the run so far has `wanted` complete cycles, checked once per expected cycle. Stable steady
    sliding ends it too, because no cycles will follow. `model` as for `UntilSettled`."""

    wanted: int
    scene: Scene
    model: str

    def ends(self, after: float) -> Iterator[float]:
        """As `Length`."""
        period = expected_period(self.scene)
        end = cycle = period if math.isfinite(period) else 1.0
        while end < LONGEST_RUN:
            if end > after:
                yield end
            end = max(end + cycle, _STEP * end)

    def ended(self, now: JudgedHalf) -> Ended | None:
        """As `Length`."""
        if now.verdict is None or now.verdict.cycles >= self.wanted:
            return "cycles"
        return "settled" if now.verdict.kind == "steady" and is_stable(self.scene, self.model) is not False else None


def length_of(scene: Scene, model: str, cycles: int | None = None) -> Length:
    """The length of a run: `cycles` if given, else that of the scene, else until settled. `model`: one with the one-port of the
    model that runs."""
    if cycles is not None:
        return UntilCycles(cycles, scene, model)
    if scene.until is not None:
        return Length(until=scene.until)
    settled = UntilSettled(scene, model)
    return settled if scene.record else Length(until=next(settled.ends(0.0)))


def needed(verdict: MotionVerdict | None, scene: Scene, model: str) -> float:
    """Length (transits) of a run with enough cycles, if this one is too short: from its cycles, else from the expected period;
    infinite if no run may be so long. `model` as for `length_of`."""
    if verdict is None or verdict.cycles or verdict.kind != "too short":
        return verdict.needed if verdict else math.nan
    expected = next(UntilSettled(scene, model).ends(0.0))
    return max(verdict.needed, expected) if expected < LONGEST_RUN else math.inf


def amplified_rounding(scene: Scene, model: str, until: float, tolerance: float | None = None) -> tuple[float, str] | None:
    """Effect of amplified rounding on a run of `scene` to `until` (transits): its share of the growing amplitude of the start's
    disturbance, and a line for the user; None if it stays below `tolerance`. `model` is one with the one-port of the model that
    runs."""
    wanted = EXPECTED_ERROR if tolerance is None else tolerance
    slopes = friction_slopes(scene.law, scene.velocity)
    fastest = (slopes.reach - slopes.healing) * scene.transit  # no root of a passive slab grows faster
    if scene.start.kind is StartKind.ORBIT or not slopes.weakening or _share(scene, fastest) <= wanted:
        return None
    from reduced.stability import characteristic, follow_root, spectrum

    if fastest > _NO_ECHO:
        leading = follow_root(characteristic(scene, model), slopes.reach - slopes.healing)
    else:
        leading = next(iter(spectrum(scene, model).leading), 0j)
    growth = complex(leading) * scene.transit
    knots = zip(scene.drive.times, scene.drive.velocities, strict=True)
    changes = [time for (time, before), (_, after) in pairwise(knots) if before != after]
    until = min(until, *changes, math.inf)  # a change of V is a disturbance of its own, far above rounding
    if not growth.real > 0.0 or math.log(_rounding(scene)) + growth.real * until <= math.log(wanted):
        return None
    share = _share(scene, growth)
    grows = f"steady sliding is unstable, disturbances grow at {growth.real:.3g} per transit"
    if share >= 1.0:
        outgrown, advice = f"rounding outgrows the start {share:.1e} times", "start.kind = 'jump'"
        if math.isinf(share):
            outgrown, advice = "the start disturbs nothing", "a start.size other than 0"
        note = f"not determined: {grows}, and {outgrown}: rounding decides when it is left, and all that follows; use {advice}"
    else:
        note = (
            f"not determined beyond {share:.1e}: {grows}, and rounding is that share of what leaves it: events are dated to "
            f"{share / growth.real:.1e} transits"
        )
    return (share, note) if share > wanted else None


def _rounding(scene: Scene) -> float:
    return float(np.finfo(float).eps) * max(1.0, abs(scene.steady_psi))


def _share(scene: Scene, growth: complex) -> float:
    """Rounding over the start's disturbance, both extrapolated back to t = 0."""
    start = scene.start
    if start.kind is StartKind.JUMP:
        left = abs(start.jump_size)
    else:
        tail = _tail(0.5 * growth - NUDGE_CENTRE)
        left = abs(start.nudge_size * 0.5 * math.sqrt(math.pi) * math.exp(-(NUDGE_CENTRE**2)) * tail)
    return _rounding(scene) / left if left > 0.0 else math.inf


def _tail(x: complex) -> complex:
    """w(i x) = e^(x^2) erfc(x)."""
    if x.imag == 0.0 and abs(x.real) < _ERFC_ENDS:
        return math.exp(x.real**2) * math.erfc(x.real)
    from scipy.special import wofz  # a fifth of a second, which few scenes need

    return complex(wofz(1j * x))


_ON_A_STEP = 1e-6
"""Share of a time step; a step of V closer to its end than this coincides with it."""


def costly_steps(solver: Solver) -> list[str]:
    """A note if steps of V lower the order of a full wave, because they fall within time steps or by their fronts; none if V has
    no steps after the start, if the model represents them exactly, and for a leapfrog with V's steps at the ends of its own."""
    drive = solver.scene.drive
    pairs = pairwise(zip(drive.times, drive.velocities, strict=True))
    jumps = [late for (early, before), (late, after) in pairs if early == late > 0.0 and before != after]
    pieces = solver.transits_per_piece
    if not (solver.nodes[0] > 0.0 or math.isnan(pieces)):  # else it ends a step at every knot
        step = pieces / (solver.nodes.size - 1)
        if any(abs(time / step - round(time / step)) >= _ON_A_STEP for time in jumps):
            return [
                f"steps of V are placed to within one time step ({step:.3g} transits) by this model: their error falls with the "
                "step, not with the order of the scheme; the delay system of elastic slabs, and full waves with --time exact, "
                "place them exactly"
            ]
    if not jumps or solver.settings.get("time") is None:
        return []
    return [
        "no grid resolves the front of a step of V: the error of this model falls as the size of its cells, whatever its order, "
        "and the stress just behind a front, which may be the highest of a cycle, is off by a share of the front on any grid; "
        "the delay system of elastic slabs has no such error"
    ]

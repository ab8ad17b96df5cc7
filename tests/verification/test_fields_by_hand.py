"""Recorded fields obey the equations of motion with each slab's own constants, and every entry of the energy ledger: one that
closes may still be wrong by a factor.

Energies per unit area in sigma L, so powers are stress x velocity on the friction clock. A slab of impedance eps and one-way
travel time T = r/2 weighs eps T and yields T/eps; depth is counted in travel time.
"""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

import slipwave
from slipwave.scene.drive import Drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, MachineFace, Slab, StandardLinearViscosity
from tests.field_window import record_field
from validation.models.build import build
from validation.models.by_name import explicit_time

PAPER = slipwave.read("paper")
E, R = PAPER.upper.epsilon, PAPER.upper.round_trip
RAMP = Drive((0.0, 4.25, 9.5, 12.0), (100.0, 100.0, 160.0, 70.0))
GRIP, MACHINE = GripFace(2.0, 1.5), MachineFace(2.0, 1.5, 0.4)
SCENES = {
    "alike": (Slab(E, R), Slab(E, R)),
    "unlike": (Slab(E, R), Slab(3.0 * E, 1.7 * R)),
    "grip below": (Slab(2.0 * E, 1.3 * R), Slab(E, R, GRIP)),
    "machine below": (Slab(2.0 * E, 1.3 * R), Slab(E, R, MACHINE)),
    "kelvin-voigt": (Slab(E, R, viscosity=KelvinVoigtViscosity(0.05 * R)),) * 2,
    "standard linear": (Slab(E, R), Slab(E, 1.7 * R, viscosity=StandardLinearViscosity(0.5 * R, 0.6))),
}
FAMILIES = {"fd": 64, "sbp:6": 32, "dg:7": 4, "fem:6 exact": 4}
END = 15.0


def over(x, values):
    """Integral of samples, by a spline through them."""
    return float(CubicSpline(x, values).integrate(x[0], x[-1]))


def heat(slab, data, clock):
    """What viscosity takes: eps time (dw/dx)^2 of a Kelvin-Voigt slab; q^2/(eps_1 time) of a standard linear one, whose memory
    stress q' = eps_1 dw/dx - q/time, eps_1 = eps ratio/(1 + ratio), is integrated here. x is travel time."""
    if slab.viscosity is None:
        return 0.0
    one_way, places, time = 0.5 * slab.round_trip, np.linspace(0.0, 1.0, 401), slab.viscosity.time
    shearing = CubicSpline(data.depth, data.velocity, axis=1).derivative()(places) / one_way
    if isinstance(slab.viscosity, KelvinVoigtViscosity):
        density = slab.epsilon * time * shearing**2
    else:
        branch = slab.epsilon * slab.viscosity.ratio / (1.0 + slab.viscosity.ratio)
        fading = np.exp(clock / time)[:, None]
        memory = cumulative_simpson(fading * branch * shearing, x=clock, axis=0, initial=0.0) / fading
        density = memory**2 / (branch * time)
    return one_way * over(clock, np.trapezoid(density, places, axis=1))


def by_hand(chosen, field):
    """Every entry from a field record; `stored` only of elastic slabs."""
    clock = field.time * chosen.transit
    half_drive = 0.5 * np.interp(field.time, chosen.drive.times, chosen.drive.velocities)
    upper, lower = field.upper, field.lower or dataclasses.replace(field.upper, velocity=-field.upper.velocity)
    slip_rate = upper.velocity[:, 0] - lower.velocity[:, 0]
    found = dict.fromkeys(("input", "radiated", "viscous", "stored"), 0.0)
    found["friction"] = over(clock, upper.stress[:, 0] * slip_rate)
    for slab, data, sign in ((chosen.upper, upper, 1.0), (chosen.lower, lower, -1.0)):
        top = sign * data.velocity[:, -1]
        pull = data.stress[:, -1]
        if isinstance(slab.face, MachineFace):
            mass = slab.face.mass * slab.epsilon * slab.round_trip
            pull = pull + mass * CubicSpline(clock, top).derivative()(clock)
            found["stored"] += 0.5 * mass * (top[-1] ** 2 - top[0] ** 2)
        if isinstance(slab.face, GripFace | MachineFace):
            slip = half_drive - top
            resistance, spring = slab.face.impedance * slab.epsilon, slab.face.stiffness * slab.epsilon / slab.round_trip
            found["radiated"] += over(clock, resistance * slip**2)
            loads = np.array([pull[0], pull[-1] - resistance * slip[-1]])  # of the spring alone
            found["stored"] += 0.5 * (loads[1] ** 2 - loads[0] ** 2) / spring
        found["input"] += over(clock, pull * half_drive)
        found["viscous"] += heat(slab, data, clock)
        weight, softness = 0.5 * slab.round_trip * slab.epsilon, 0.5 * slab.round_trip / slab.epsilon
        energy = [over(data.depth, 0.5 * weight * data.velocity[k] ** 2 + 0.5 * softness * data.stress[k] ** 2) for k in (0, -1)]
        found["stored"] += energy[1] - energy[0]
    return found


CASES = [(name, family) for name in SCENES for family in FAMILIES if name != "kelvin-voigt" or family in ("fd", "fem:6 exact")]


@pytest.mark.parametrize(("name", "family"), CASES)
def test_every_entry(name, family):
    """Measured: 7e-6 of input, friction and stored energy (6e-4 for the leapfrog's second order); of what the grip's dashpot and
    viscosity take, a thousandth of the whole, 1.2e-3 and 6e-4. What does not close: 5e-10, rounding for the leapfrog."""
    upper, lower = SCENES[name]
    chosen = dataclasses.replace(PAPER, upper=upper, lower=lower, drive=RAMP)
    model, _, time = family.partition(" ")
    solver = build(model, chosen, cells=FAMILIES[family], time=time or explicit_time(model))
    solver.keep_ledger()
    field, _ = record_field(solver, 0.0, END, 1.0 / 64.0)
    ledger, wanted = solver.energy(), by_hand(chosen, field)
    allowed = 5e-3 if family == "fd" else 1e-4
    assert ledger.input == pytest.approx(wanted["input"], rel=allowed)
    assert ledger.friction == pytest.approx(wanted["friction"], rel=allowed)
    assert ledger.radiated == pytest.approx(wanted["radiated"], rel=1e-2)
    assert ledger.viscous == pytest.approx(wanted["viscous"], rel=6e-3)
    assert abs(ledger.residual) < (1e-14 if family == "fd" else 5e-9) * ledger.input
    if not (upper.viscosity or lower.viscosity):
        assert ledger.stored == pytest.approx(wanted["stored"], rel=allowed)


PLAIN = Slab(3.0 * E, 1.7 * R)
SOLID = Slab(2.0 * E, R, viscosity=KelvinVoigtViscosity(0.05 * R))
ZENER = Slab(2.0 * E, 1.3 * R, viscosity=StandardLinearViscosity(0.3 * R, 0.8))
MATERIALS = {
    "plain above plain": (Slab(E, R), PLAIN),
    "solid above Zener": (SOLID, ZENER),
    "Zener above solid": (ZENER, SOLID),
    "solids": (SOLID, SOLID),
    "Zeners": (ZENER, ZENER),
}


def misfits(slab, data, time, sign):
    """Relative misfit (root mean square), inside the record, of the balance of momentum, eps T w_t = s_x, and of the material:

        elastic            s_t = (eps/T) w_x
        Kelvin-Voigt       s_t = (eps/T) (w_x + time w_xt)
        standard linear    s_t + (s - s_0)/time = (eps/T) (w_x + u_x/((1 + ratio) time))

    x in [0, 1] is depth in travel time T = r/2, w the velocity in the slab's own direction, u its integral over time, s_0 the
    stress of steady sliding, with which all began."""
    one_way, eps = 0.5 * slab.round_trip, slab.epsilon
    w, s = sign * data.velocity, data.stress
    x, inside = np.linspace(0.05, 0.95, 61), slice(8, -8)

    def by_time(values):
        return CubicSpline(time, values, axis=0).derivative()(time)[inside]

    def by_depth(values):
        return CubicSpline(data.depth, values, axis=1).derivative()(x)

    at_x = CubicSpline(data.depth, s, axis=1)(x)
    momentum = eps * one_way * by_time(CubicSpline(data.depth, w, axis=1)(x)), by_depth(s)[inside]
    shear = by_depth(w)
    viscosity = slab.viscosity
    if isinstance(viscosity, StandardLinearViscosity):
        strain = cumulative_simpson(shear, x=time, axis=0, initial=0.0)
        law = (
            by_time(at_x) + (at_x - at_x[0])[inside] / viscosity.time,
            (eps / one_way * (shear + strain / ((1.0 + viscosity.ratio) * viscosity.time))[inside]),
        )
    elif isinstance(viscosity, KelvinVoigtViscosity):
        law = by_time(at_x), eps / one_way * (shear[inside] + viscosity.time * by_time(shear))
    else:
        law = by_time(at_x), eps / one_way * shear[inside]
    return [float(np.linalg.norm(left - right) / np.linalg.norm(right)) for left, right in (momentum, law)]


ALL = [(pair, family) for pair in MATERIALS for family in ("fd", "sbp:6", "dg:7") if not ("solid" in pair and family == "dg:7")]


@pytest.mark.parametrize(("pair", "family"), ALL)
def test_every_slab_moves_by_its_own_laws(pair, family):
    """Measured: 9e-4 of the momentum and 3e-5 of the stress rates, by splines across the joints of elements."""
    upper, lower = MATERIALS[pair]
    chosen = dataclasses.replace(PAPER, upper=upper, lower=lower)
    field, _ = record_field(build(family, chosen, cells=FAMILIES[family]), 0.0, 9.0, 1.0 / 64.0)
    time = field.time * chosen.transit
    parts = [misfits(upper, field.upper, time, 1.0)]
    parts += [misfits(lower, field.lower, time, -1.0)] if field.lower is not None else []
    assert (field.lower is None) == (upper == lower)
    assert (np.array(parts) < [1e-2, 3e-4]).all()

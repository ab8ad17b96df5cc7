"""Scenes in which any two abilities meet: rows of a table that covers every allowed pair, and the runs that they are held to."""

import itertools
import json
import math
from typing import Any, NamedTuple

import numpy as np

from slipwave import read
from slipwave.solve import FieldSolver, State
from slipwave.solve.checkpoint import Checkpoints
from validation.commands.run import RunResult
from validation.models.build import prepare
from validation.models.by_name import family_of
from validation.models.outlook import Length
from validation.models.run import Records, simulate

Row = tuple[str, ...]

ON_GRIDS = ("dg:3 exact 3", "dg:3 explicit 3", "sbp:4 explicit 11", "fem:2 exact 3", "fd - 16")
FACTORS = {
    "model": ("delay", "kelvin-voigt", "quasidynamic", "fitted:4", "modal:2", *ON_GRIDS),
    "slabs": ("alike", "commensurate", "irrational", "layered"),
    "face": ("rigid", "grip", "reflection", "machine"),
    "drive": ("constant", "ramp", "hold", "step after ramp"),
    "viscosity": ("none", "kelvin-voigt", "standard-linear"),
    "start": ("nudge", "jump", "orbit"),
    "units": ("none", "SI"),
}
NAMES = tuple(FACTORS)
KNOTS = {
    "constant": [(0.0, 100.0)],
    "ramp": [(0.0, 100.0), (8.3, 100.0), (13.7, 160.0)],
    "hold": [(0.0, 100.0), (8.0, 100.0), (8.0, 0.0), (12.3, 0.0), (12.3, 100.0)],
    "step after ramp": [(0.0, 100.0), (7.0, 100.0), (10.5, 140.0), (10.5, 70.0)],
}
INTERFACE = {"law": "ageing", "a_star": 0.369, "a": 0.0349, "b": 0.0489}
EPSILON, R = 2.8e-5, 0.00276
SIGMA, LENGTH, PACE, SPEED = 1e6, 1e-5, 1e-6, 2500.0
"""Normal stress (Pa), L (m), V* (m/s), and the wave speed (m/s) of the slabs in SI."""


def pairwise_rows(rows, seed):
    """Some of `rows` that cover every pair of levels that any of them has; greedy, in an order that `seed` gives."""
    rows = [rows[k] for k in np.random.default_rng(seed).permutation(len(rows))]
    numbers = {pair: k for k, pair in enumerate(dict.fromkeys(pair for row in rows for pair in pairs_of(row)))}
    has = np.zeros((len(rows), len(numbers)), dtype=np.float32)
    for row, marks in zip(rows, has, strict=True):
        marks[[numbers[pair] for pair in pairs_of(row)]] = 1.0
    new, chosen = np.ones(len(numbers), dtype=np.float32), []
    while new.any():
        best = int(np.argmax(has @ new))
        new[has[best] > 0.0] = 0.0
        chosen.append(rows[best])
    return chosen


def pairs_of(row):
    return list(itertools.combinations(enumerate(row), 2))


def rows_allowed():
    """All rows of the table that no rule refuses: units never matter, and V only where it changes."""
    told = {}
    allowed = []
    for row in itertools.product(*FACTORS.values()):
        kind = (*row[:3], "constant" if row[3] == "constant" else "hold", *row[4:6], "none")
        if kind not in told:
            told[kind] = not refusal(kind)
        if told[kind]:
            allowed.append(row)
    return allowed


def refusal(row):
    """The line with which a row is refused before anything is computed; empty if it is not."""
    chosen = dict(zip(NAMES, row, strict=True))
    if chosen["start"] == "orbit" and chosen["drive"] != "constant":
        return "needs a constant drive.velocity"
    family = family_of(chosen["model"].split()[0])
    assert family is not None
    return family.refusal(scene_of(row))


def scene_of(row, units=None):
    """The scene of a row, with or without `units` (default: as the row says)."""
    chosen = dict(zip(NAMES, row, strict=True))
    in_si = (units or chosen["units"]) == "SI"
    upper = slab(chosen, 1.0, 1.0, in_si)
    ratio, weight = {"commensurate": (2.0, 3.0), "irrational": (2.0**0.5, 3.0)}.get(chosen["slabs"], (1.0, 1.0))
    interface = INTERFACE | ({"normal_stress": SIGMA, "memory_length": LENGTH, "reference_velocity": PACE} if in_si else {})
    return read(
        {
            "name": "pair",
            "interface": interface,
            "upper": upper,
            "lower": slab(chosen, ratio, weight, in_si),
            "drive": {"velocity": [[time_of(t, in_si), f"{v * PACE!r} m/s" if in_si else v] for t, v in KNOTS[chosen["drive"]]]},
            "start": {"kind": chosen["start"], "size": 0.05 if chosen["start"] == "jump" else 0.5},
        }
    )


def time_of(transits, in_si):
    """As a scene file gives it."""
    return f"{transits * R * LENGTH / PACE!r} s" if in_si else transits


def slab(chosen, ratio, weight, in_si):
    """The table of a slab of `ratio` times the round trip and `weight` times the impedance."""
    epsilon, r = EPSILON * weight, R * ratio
    table = {"epsilon": epsilon, "r": r}
    unit = SIGMA / PACE  # of impedance
    if in_si:
        density = epsilon * unit / SPEED
        table = {"density": density, "shear_modulus": density * SPEED**2, "thickness": 0.5 * r * LENGTH / PACE * SPEED}
    if chosen["slabs"] == "layered":
        table["layers"] = [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 2.0}]
    if chosen["viscosity"] != "none":
        time = 0.02 * R
        table["viscosity"] = {"kind": chosen["viscosity"], "time": f"{time * LENGTH / PACE!r} s" if in_si else time}
        if chosen["viscosity"] == "standard-linear":
            table["viscosity"]["ratio"] = 0.4
    faces = {
        "grip": {"stiffness": 10.0, "impedance": 3.0},
        "reflection": {"coefficient": 0.999},
        "machine": {"stiffness": 10.0, "impedance": 0.5, "mass": 0.5},
    }
    if chosen["face"] != "rigid":
        face = dict(faces[chosen["face"]])
        if in_si and chosen["face"] == "machine":
            sizes = {
                "stiffness": epsilon / r * unit * PACE / LENGTH,
                "impedance": epsilon * unit,
                "mass": epsilon * r * unit * LENGTH / PACE,
            }
            face = {key: value * sizes[key] for key, value in face.items()}
        table["face"] = {"kind": chosen["face"], **face}
    return table


class Played(NamedTuple):
    """A run to its end: the state of the solver when it `begun` (only where it was put somewhere first), the JSON of
    `slipwave run` but for wall time, the final state of solver and observers."""

    begun: State | None
    text: str
    state: State
    solver: Any

    @property
    def facts(self):
        return dict(json.loads(self.text))


class At:
    """A mark that does a deed as soon as a time of `dates` is reached; advances end there."""

    def __init__(self, dates, deed=lambda: None):
        self.dates, self.deed = list(dates), deed

    @property
    def due(self):
        return self.dates[0] if self.dates else math.inf

    def act(self):
        self.deed()
        self.dates.pop(0)


def built(row, begun=None, units=None):
    """The solver of a row, with the ledger kept; from the state `begun` of another one if it is given."""
    model, time, cells = [*row[0].split(), "-", "-"][:3]
    options = {"time": time if time != "-" else None, "cells": int(cells) if cells != "-" else None}
    solver = prepare(model, scene_of(row, units), begun is not None, **options).solver
    if isinstance(solver, FieldSolver):
        solver.keep_ledger()
    if begun is not None:
        solver.restore(begun)
    return solver


def play(solver, until, folder=None, dates=(), chunk=math.inf, resume=None):
    """Run `solver` to `until` (transits) as `slipwave run` does, in chunks of `chunk` transits, from the checkpoint `resume`;
    checkpoints of some `dates` go into a `folder`."""
    begun = solver.state() if solver.scene.start.kind == "orbit" else None
    records = Records(solver, Length(until=until))
    parts = {"events": records.watch, "envelope": records.envelope}
    if records.protocol is not None:
        parts["protocol"] = records.protocol
    saving = At(dates, lambda: Checkpoints(solver, parts, folder / f"{len(saving.dates)}.npz", math.inf, 1.0).save())
    marks = [At(np.arange(chunk, until, chunk) if math.isfinite(chunk) else ()), saving]
    if resume is not None:
        Checkpoints(solver, parts, resume, math.inf, 1.0).resume()
    done = simulate(solver, until, records.observers, watch=records.watch, marks=marks)
    assert not done.failed
    summary = RunResult(done, records, None, [], {}).summary
    del summary["wall_s"]
    state = solver.state() | {f"{label} {name}": array for label, part in parts.items() for name, array in part.state().items()}
    return Played(begun, json.dumps(summary), state, solver)

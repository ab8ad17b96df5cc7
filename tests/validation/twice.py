"""One scene, record, sweep or fit written twice, and every number that a command gives."""

import copy
import math
import re
import shlex
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import xarray

import slipwave as sw
from slipwave.errors import SceneError
from slipwave.input.assemble import to_toml
from slipwave.scene.drive import Drive
from tests.granite import GRANITE
from tests.validation.pairs import KNOTS, LENGTH, NAMES, PACE, SIGMA, R, scene_of, slab
from validation.commands import command_line
from validation.commands.cli import main
from validation.sweep import executors

TRANSIT = R * LENGTH / PACE
"""Of the upper slab (s)."""

FASTER = 4.0
"""Another reference velocity over `PACE`."""

SIZES = {"s": TRANSIT, "Pa": SIGMA, "m_per_s": PACE, "m": LENGTH}
"""Ending of the name of a twin in SI -> the size of its unit."""

AREA = 0.01  # m2, of a face whose springs and masses are those of the whole
TEXTS = {
    "normal_stress": ("kPa", 1e3),
    "memory_length": ("um", 1e-6),
    "reference_velocity": ("mm/s", 1e-3),
    "density": ("g/cm3", 1e3),
    "shear_modulus": ("GPa", 1e9),
    "thickness": ("cm", 1e-2),
    "stiffness": ("kN/mm", 1e6 / AREA),
    "impedance": ("kN s/m", 1e3 / AREA),
    "mass": ("t", 1e3 / AREA),
}
"""Key -> a unit for it and its size in SI (per area of the face)."""

WAYS = ("own", "SI", "texts", "paced", "exchanged")
"""In own units, in SI, in SI as texts with other units, in SI over another V*, in SI with the slabs exchanged."""

SCENES = {
    "plain": (("delay", "alike", "rigid", "constant", "none", "nudge", "none"), 1.0),
    "machine": (("delay", "alike", "machine", "constant", "kelvin-voigt", "jump", "none"), 1.0),
    "heavy": (("delay", "alike", "machine", "constant", "none", "jump", "none"), 1.0),
    "unlike": (("delay", "commensurate", "rigid", "constant", "none", "jump", "none"), 1.0),
    "network": (("delay", "irrational", "reflection", "constant", "none", "jump", "none"), 1.0),
    "hold": (("delay", "alike", "rigid", "hold", "none", "nudge", "none"), 1.0),
    "steps": (("quasidynamic", "alike", "rigid", "hold", "none", "nudge", "none"), 4.0),
    "loaded": (("quasidynamic", "alike", "rigid", "constant", "none", "nudge", "none"), 4.0),
}
"""Name -> a row of `pairs`, and the impedance of its slabs over `pairs.EPSILON`."""


def tables_of(row, weight, way):
    """The tables of the scene of a row, written in one of the `WAYS`."""
    tables = copy.deepcopy(scene_of(row, "none" if way == "own" else "SI").tables)
    drive, law = tables["drive"], tables["interface"]
    if len(drive["velocity"]) == 1:
        drive["velocity"] = drive["velocity"][0][1]
    if tables["upper"] == tables["lower"]:
        del tables["upper"], tables["lower"]
        tables["slab"] = slab(dict(zip(NAMES, row, strict=True)), 1.0, weight, way != "own")
    if way == "texts":
        write_units(tables)
    if way == "paced":
        law["reference_velocity"] *= FASTER
        law["a_star"] += (law["a"] - law["b"]) * math.log(FASTER)
    if way == "exchanged" and "lower" in tables:
        tables["upper"], tables["lower"] = tables["lower"], tables["upper"]
    return tables


def write_units(table):
    """Numbers in SI as texts with units; springs, dashpots and masses of a face as those of its area."""
    for key, value in table.items():
        if isinstance(value, dict):
            write_units(value)
        elif key in TEXTS and isinstance(value, float) and table.get("kind", "machine") == "machine":
            table[key] = f"{value / TEXTS[key][1]!r} {TEXTS[key][0]}"
    if table.get("kind") == "machine":
        table["area"] = f"{AREA * 1e4!r} cm2"


def write_scenes():
    """NAME-WAY.toml for each scene."""
    for name, (row, weight) in SCENES.items():
        for way in WAYS:
            Path(f"{name}-{way}.toml").write_text(to_toml(sw.read(tables_of(row, weight, way))))


def write_table(name, columns, between=",", more=()):
    """A file of columns by their headings (none for numbers as headings), with further lines."""
    heads = [between.join(columns)] if all(isinstance(head, str) for head in columns) else []
    rows = [between.join(f"{value:.17g}" for value in row) for row in zip(*columns.values(), strict=True)]
    text = "\n".join([*heads, *rows[:90], *more, *rows[90:], ""])
    Path(name).write_text(text.replace(".", ",") if between == ";" else text)


def write_steps(rng):
    """A slide with a hold: in SI, in other units, bare, with its load point on three clocks, and with two kinds of noise."""
    found = sw.run("steps-SI.toml", "quasidynamic", until=40, interface=True, **{"start.size": 0.0}).dataset
    knots, speeds = (np.array(part) for part in zip(*KNOTS["hold"], strict=True))
    fine, noise, other = np.linspace(0.01, 1.1, 800), rng.standard_normal(400), rng.standard_normal((2, 400))
    t, friction = fine[::2], np.interp(fine, TRANSIT * found["time"], found["interface_stress"])
    f, x = friction[::2] + 1e-4 * noise, Drive(tuple(knots * TRANSIT), tuple(speeds * PACE)).travel(t)
    write_table("steps.csv", {"time [s]": t, "friction": f})
    headings = {
        "temperature [K]": other[0],
        "Time (min)": t / 60,
        "tau [kPa]": 300 * f,
        "voltage": other[1],
        "sigma_n (MPa)": 0 * t + 0.3,
    }
    write_table("steps-units.csv", headings, ";")
    missing = ["7\t1\tNaN\t8", "7\t2\t-999\t8"]
    write_table("steps-columns.txt", {0: other[0], 1: 1e3 * t, 2: 100 * f, 3: other[1]}, "\t", missing)
    write_table("load.csv", {"time [s]": t, "friction": f, "load point [m]": x})
    write_table("load-late.csv", {"time [s]": t + 100, "load point [um]": 1e6 * x + 77, "friction [%]": 100 * f})
    write_table("load-own.csv", {"time [transits]": t / TRANSIT, "load point [L]": x / LENGTH, "friction": f})
    write_table("steps-noisy.csv", {"time [s]": t, "friction": f + 3e-2 * noise})
    write_table("steps-lasting.csv", {"time [s]": fine, "friction": friction + 1e-4 * np.repeat(noise, 2)})


def write_cycles(rng):
    """Cycles from stick to stick and cut within the falls at both ends; another clock, other units; with a drift."""
    found = sw.run("plain-SI.toml", "block8", until=160, window=(100, 160), **{"drive.velocity": 4000}).dataset
    times, stress = TRANSIT * found["time"].values, found["interface_stress"].values
    t = np.arange(2.8, 4.4, 2e-4)
    f = np.interp(t, times, stress) + 1e-5 * rng.standard_normal(t.size)
    dates = times[np.flatnonzero((stress[:-1] > 0.23) & (stress[1:] <= 0.23))]
    dates = dates[(dates > t[0] + 0.05) & (dates < t[-1])]
    period, drift = np.diff(dates).mean(), 0.05 * (t - 0.5 * (dates[0] + dates[-1]))
    for name, begin, end in (("whole", 0.4, -0.4), ("cut", -0.07, 0.005)):
        part = (t > dates[0] + begin * period) & (t < dates[-1] + end * period)
        write_table(f"cycles-{name}.csv", {"time [s]": t[part], "friction": f[part]})
    write_table("cycles.csv", {"time [s]": t, "friction": f})
    bare = {0: f, 1: 1e3 * t, 2: 100.0 * f}
    write_table("cycles-bare.txt", bare, "\t", ["7\t1\tNaN", "7\t2\t-999"])
    write_table("cycles-late.csv", {"x": f, "time [ms]": 1e3 * (t + 100), "tau [kPa]": 5e3 * f, "sigma [kPa]": 5e3 + 0 * t}, " ")
    write_table("cycles-drift.csv", {"time [s]": t, "friction": f + drift})


def write_all():
    """Every file that the table of pairs names, into the working folder."""
    rng = np.random.default_rng(1)
    write_scenes()
    write_steps(rng)
    write_cycles(rng)
    slabs = {"upper": GRANITE["slab"], "lower": GRANITE["slab"] | {"thickness": 7.0}, "start": {"size": 0.0}}
    slabs |= {"start": {"kind": "jump", "size": 1.0}}
    Path("leaping.toml").write_text(to_toml(sw.read({name: one for name, one in GRANITE.items() if name != "slab"} | slabs)))
    Path("rows.csv").write_text("drive.velocity,slab.thickness\n4 mm/s,3450 cm\n4000,37.5\n5 mm/s,34.5\n5000,3750 cm\n")


@contextmanager
def here(workers):
    with ThreadPoolExecutor(1) as pool:
        yield lambda: pool


SKIPPED = re.compile(r"schema|wall|notes|reasons|scene|digest|file|source|folder|computed_now|manifest|evaluations|complete")
WORDS = re.compile(r"verdict|kind|type|stable|unit$")


def numbers_of(lines, patch):
    """Path -> every number, and word of a verdict, in the JSON and the file of the last of these commands (joined by `&&`)."""
    results = []

    def finish(result, options, files, json):
        results.append(dict(flat(result.summary)) | dict(of_file(result)))
        for one, path in files.items():
            if path:
                getattr(result, one.method)(path)
        result.close()

    patch.setattr(command_line, "_finish", finish)
    patch.setattr(executors, "processes", here)
    for line in lines.split(" && "):
        words = [*shlex.split(line), "--json"]
        words += ["--out", "run.nc"] if words[0] == "run" and "--out" not in words else []
        with redirect_stdout(StringIO()):
            assert main(words) == 0, line
    return results[-1]


def flat(value, path=""):
    """Path -> number or word, of a JSON."""
    if SKIPPED.search(path.rpartition(".")[2]):
        return
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if items is not None:
        for key, one in items:
            yield from flat(one, f"{path}.{key}" if path else str(key))
    elif not isinstance(value, str) or WORDS.search(path):
        yield path, value


def of_file(result):
    """nc.VARIABLE or nc.@ATTRIBUTE -> numbers, of the netCDF file of a result with the fields in it."""
    try:
        result.to_netcdf("numbers.nc")
    except SceneError:  # rows of `verify` are in no file
        return
    tree = xarray.open_datatree("numbers.nc", engine="netcdf4")
    for group in ("/", "/fields"):
        data = tree[group] if group in tree.groups else xarray.Dataset()
        for name, values in data.variables.items():
            if values.dtype.kind in "fib" and not SKIPPED.search(str(name)):
                yield f"nc.{group[1:]}{name}", np.asarray(values.values, dtype=float)
        yield from (
            (f"nc.@{k}", value) for k, value in data.attrs.items() if not isinstance(value, str) and not SKIPPED.search(k)
        )
    tree.close()

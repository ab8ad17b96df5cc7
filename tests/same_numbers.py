"""Shows that a change of structure changes no number of any command.

    python -m tests.same_numbers record FOLDER       # before the change: what the commands print and write, in FOLDER
    python -m tests.same_numbers compare FOLDER      # after it: each command once more, and how far it is from FOLDER

Exit status 1 where words differ (keys, columns, units, names), or numbers by more than --tolerance (relative; 0: to the bit).
"""

import argparse
import itertools
import os
import re
import shlex
import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray

from validation.commands.cli import main
from validation.models import run

QUICK = "--set drive.velocity=2000"  # the paper's cycles in four transits

RUNS = {
    "paper": f"paper {QUICK} --until 100 --every 10",
    "si": f"paper-si --model delay {QUICK} slab.thickness=0.0335 --until 100 --rate 20 --series si.csv",
    "kelvin-voigt": f"paper --model kelvin-voigt {QUICK} --until 60 --lyapunov",
    "modal": "unlike --model modal:2 --until 40 --every 20",
    "unlike": "unlike-irrational --until 30",
    "layered": "layered --model sbp:4 --tol 1e-3 --until 10",
    "gripped": f"grip --model fd --cells 24 {QUICK} --until 40",
    "viscous": f"viscous --model dg:3 --cells 4 {QUICK} --until 40",
    "fields": "paper --model fem:2 --cells 4 --time explicit --until 4 --fields fields-alone.nc",
    "machine": "steel-on-pmma --until 2ms --every 10 --events machine-events.csv",
    "regularised": "regularised --model block8 --until 60",
    "reflection": "reflection --model fitted:4 --until 20",
    "hold": "hold --model quasidynamic --until 1200s --rate 1Hz --series hold.csv",
    "steps": "velocity-steps --model quasidynamic --rate 0.2Hz --series steps.csv",
}
"""Each kind of scene, model and march, by the name of the file that it writes."""

OTHERS = (
    "run si.nc",
    f"orbit paper {QUICK} --tol 1e-6 --response",
    "orbit paper-si --model block8 --tol 1e-6 --set slab.thickness=0.0335",
    f"orbit paper --model dg:3 --cells 3 --tol 1e-4 {QUICK}",
    "branch paper --model kelvin-voigt --over log10_r=-2.72:-2.68 --tol 1e-4 --most-points 4 --out branch.nc",
    "branch paper --model block8 --over epsilon=2.5e-5:3e-5 --most-points 3",
    "curve paper --model block8 --of HB --over log10_r=-2.8:-2.5 --and V=100:120 --most-points 4 --out curve.nc",
    f"compare paper --models fd,delay,kelvin-voigt --cells 24 {QUICK} --until 200 --out compare.svg",
    f"compare paper-si --with si.csv --models delay,block8 {QUICK} slab.thickness=0.0335 --until 100 --out data.svg",
    *(f"stability {words}" for words in ("paper", "grip --model fitted:4", "unlike", "steel-on-pmma", "ramp", "layered")),
    "sweep paper --workers 1 --vary log10_r=-2.75:-2.65:3 --vary V=100:200:2 --measure stability --models delay --out onset",
    f"sweep paper --vary log10_r=-2.75:-2.65:3 {QUICK} --measure run --until 60 --out runs --workers 1 --plot runs.svg",
    "fit velocity-steps --data steps.csv --model quasidynamic --free a,b,memory_length --set interface.a=0.011 --out fit.nc",
    *("scenes", "schema", "show steel-on-pmma", "show si.nc"),
)
COMMANDS = (*(f"run {words} --out {name}.nc" for name, words in RUNS.items()), *OTHERS)
_NUMBER = re.compile(r"-?\b\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?\b")
_MASKED = re.compile(
    r"digest \w+|\bslipwave \d\S*|^.*\d%.*\n|<dc:date>.*?</dc:date>|/tmp/\S+|^# (?:history|date|commit) = .*|commit \S+",
    re.MULTILINE,
)
"""What differs by right: digests of scenes and sources, commits, versions, progress, dates, temporary places."""


def record(folder):
    """Run each command in `folder`, in print and in JSON; what it prints and says is `NUMBER.txt` and `NUMBER.json`."""
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    for number, line in enumerate(COMMANDS):
        words = shlex.split(line)
        for more in ([], ["--json"])[: 1 if words[0] in ("scenes", "schema", "show") else 2]:
            time.perf_counter, out = itertools.count(0.0, 0.25).__next__, StringIO()  # run times are the same each time,
            run.COMPILING = []  # also where code was compiled
            with redirect_stdout(out), redirect_stderr(out):
                status = main([*words, *more, *(["--anew"] if words[0] == "sweep" and more else [])])
            Path(f"{number:02d}{'.json' if more else '.txt'}").write_text(f"{out.getvalue()}exit status {status}\n")


def contents(path):
    """The words of a file, and its numbers."""
    if path.suffix != ".nc":
        text = _MASKED.sub("", path.read_text()).replace("−", "-")
        return _NUMBER.sub("#", text).splitlines(), np.array([float(one.replace(",", "")) for one in _NUMBER.findall(text)])
    words, numbers = [], [np.zeros(0)]
    with xarray.open_dataset(path, decode_times=False) as data:
        for name, one in data.variables.items():
            is_number = one.dtype.kind in "fiub"
            numbers += [one.values.astype(float).ravel()] if is_number else []
            words.append(f"{name} {one.dims} {one.shape} {one.dtype} {one.attrs} {'' if is_number else one.values.tolist()}")
    return words, np.concatenate(numbers)


def difference(old, new):
    """How far a file is from the one of before, in words, and the largest relative difference of its numbers."""
    if not (old.exists() and new.exists()):
        return "is only in one of both", np.inf
    (before, was), (after, now) = contents(old), contents(new)
    changed = [f"\n  - {a}\n  + {b}" for a, b in itertools.zip_longest(before, after) if a != b]
    if changed:
        return f"changed words in {len(changed)} lines{''.join(changed[:3])}", np.inf
    with np.errstate(invalid="ignore", divide="ignore"):
        error = np.abs(was - now) / np.maximum(np.abs(was), np.abs(now))
    same = (was == now) | (np.isnan(was) & np.isnan(now))
    worst = np.nan_to_num(np.where(same, 0.0, error), nan=np.inf).max(initial=0.0)
    return f"numbers differ by up to {worst:.2g}" if worst else "same to the bit", worst


def compare(before, after):
    """Print a line for each file of two folders; the largest relative difference of all."""
    names = sorted({one.name for folder in (before, after) for one in folder.iterdir() if one.is_file()})
    found = {name: difference(before / name, after / name) for name in names}
    for name, (line, _) in found.items():
        print(f"{name}: {line}    {COMMANDS[int(name[:2])] if name[:2].isdigit() else ''}")
    return max(worst for _, worst in found.values())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.same_numbers")
    parser.add_argument("what", choices=("record", "compare"))
    parser.add_argument("folder", type=lambda word: Path(word).absolute())
    parser.add_argument("--tolerance", type=float, default=0.0, help="allowed relative difference of a number")
    given = parser.parse_args()
    with TemporaryDirectory() as place:
        record(given.folder if given.what == "record" else Path(place))
        sys.exit(int(given.what == "compare" and compare(given.folder, Path(place)) > given.tolerance))

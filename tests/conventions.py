"""Files of results of every kind, checked by the compliance checker of IOOS, which shares nothing with slipwave.

    python -m tests.conventions [--checker PROGRAM]

Exit status 0 if it has nothing to say against any of them. `make cf` installs it. One of its checks is left out: it takes every
dimension called `time` for a calendar date.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import slipwave as sw
from slipwave.files import CONVENTIONS

SCENES = ("paper", "paper-si")
LEFT_OUT = "check_spatiotemporal_dims_have_coordinate_vars"
PROTOCOL = {"drive.velocity": [[0.0, 100.0], [2.0, 100.0], [2.0, 120.0]]}


def quick_results(scene):
    """A result with every variable that takes little time: history, orbit, branch, stability, stages with fields."""
    yield sw.run(scene, "block8", until=100, interface=True, every=5)
    yield sw.orbit(scene, "block8", tol=1e-4)
    yield sw.branch(scene, "V=100:110", "block8", tol=1e-4, most_points=2)
    yield sw.stability(scene)
    yield sw.run(scene, "dg:3", cells=2, until=4, **PROTOCOL, **{"run.record": ["events", "fields"]})


def further_results(scene):
    """The others: a motion that never repeats, a curve, a comparison, run times."""
    yield sw.run(scene, until=4000, **{"slab.log10_r": -2.3} if scene == "paper" else {"slab.thickness": "60 cm"})
    yield sw.curve(scene, "HB", "log10_r=-2.72:-2.68", "V=100:101", "block8", tol=1e-4)
    yield sw.compare(scene, ["delay", "block8"], until=1000)
    yield sw.bench(scene, until=200, **{"drive.velocity": 2000 if scene == "paper" else "2 mm/s"})


def written(folder):
    paths = []
    for scene in SCENES:
        for number, result in enumerate([*quick_results(scene), *further_results(scene)]):
            paths.append(folder / f"{scene}-{number}-{type(result).__name__}.nc")
            result.to_netcdf(paths[-1])
    sw.run("paper", "dg:3", cells=2, until=4, fields=True).write_fields(folder / "fields.nc")
    return [*paths, folder / "fields.nc"]


def main():
    """Write the files, and show what the checker says if it is not content."""
    parser = argparse.ArgumentParser(prog="python -m tests.conventions", description="Check files of results.")
    parser.add_argument("--checker", default=str(Path(sys.executable).with_name("compliance-checker")), metavar="PROGRAM")
    checker = parser.parse_args().checker
    with tempfile.TemporaryDirectory() as folder:
        paths = written(Path(folder))
        options = [f"--test={CONVENTIONS.lower().replace('-', ':')}", "--criteria", "strict", "--skip-checks", LEFT_OUT]
        ended = subprocess.run([checker, *options, *map(str, paths)], capture_output=True, text=True, check=False)
    if ended.returncode:
        print(ended.stdout + ended.stderr)
    print(f"{len(paths)} files: {'the checker has remarks' if ended.returncode else 'nothing to say against any'}")
    return ended.returncode


if __name__ == "__main__":
    sys.exit(main())

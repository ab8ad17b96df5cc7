"""What works without the libraries of the extras, and what to install; threads of BLAS sleep during runs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from slipwave.extras import EXTRAS, OF_THE_REPORT
from slipwave.threads import VARIABLES

HIDDEN = sorted(name for modules in EXTRAS.values() for name in (*modules, "pandas"))
SCRIPT = f"""
import contextlib, io, json, sys
from importlib.abc import MetaPathFinder

class Hides(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name.partition(".")[0] in {HIDDEN}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hides())
import slipwave
from validation.commands.cli import main

found = {{}}
for line in sys.stdin.read().splitlines():
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(line.split())
    found[line] = status, out.getvalue(), err.getvalue()
motion = slipwave.run("paper", model="block8", until=5)
try:
    motion.dataset
except slipwave.SceneError as error:
    found["dataset"] = str(error)
print(json.dumps(found))
"""
WORK = {
    "run paper --model block8 --until 60 --json": ("events", 1),
    "stability paper --json": ("unstable_roots", 2),
    "compare paper --models block8,kelvin-voigt --until 5 --json": ("reference", "block8"),
    "orbit paper --model block8 --tol 1e-3 --json": ("period", pytest.approx(76.610300, rel=1e-6)),
}
NO_FILES = "needs xarray and netCDF4 and meshio: pip install 'slipwave[files]'"
REFUSED = {
    "run paper --plot run.png": "--plot = 'run.png': needs matplotlib: pip install 'slipwave[plot]'",
    "run paper --model dg:3 --fields last.vtu": f"--fields = 'last.vtu': {NO_FILES}",
    "run run.nc": f"SCENE = 'run.nc': {NO_FILES}",
    "run paper --model fem:4": "model = 'fem:4': needs skfem: pip install 'slipwave[fem]'",
    "compare paper --models delay,fd": "--out = 'compare.png': needs matplotlib: pip install 'slipwave[plot]'",
    "report --quick": f"the report: needs {' and '.join(name for extra in OF_THE_REPORT for name in EXTRAS[extra])}: "
    "pip install 'slipwave[report]'",
}


def test_a_light_install_runs_and_says_what_it_lacks(tmp_path):
    words = "\n".join([*WORK, *REFUSED])
    done = subprocess.run([sys.executable, "-c", SCRIPT], input=words, capture_output=True, text=True, check=True, cwd=tmp_path)
    found = json.loads(done.stdout)
    for line, (key, value) in WORK.items():
        status, out, err = found[line]
        assert status == 0, err
        assert json.loads(out)[key] == value
    for line, told in REFUSED.items():
        assert found[line] == [2, "", f"slipwave: {told}\n"]
    assert found["dataset"] == f"a dataset: {NO_FILES}"
    assert list(tmp_path.iterdir()) == []


_COUNT = """
import sys
from pathlib import Path
from threading import get_native_id

import numpy as np

import slipwave as sw

work = {
    "run": lambda: [sw.run("paper", model, until=400) for model in ("delay", "quasidynamic")],
    "orbit": lambda: sw.orbit("layered"),
}[sys.argv[1]]


def waits():
    others = [path for path in Path("/proc/self/task").iterdir() if path.name != str(get_native_id())]
    return sum(int((path / "status").read_text().split("\\nvoluntary_ctxt_switches:")[1].split()[0]) for path in others)



work()  # loads and compiles
before = waits()
work()
after = waits()
np.ones((400, 400)) @ np.ones((400, 400))
print(after - before, waits() - after)
"""


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts of thread switches are read from Linux's /proc")
@pytest.mark.parametrize("work", ["run", "orbit"])
def test_threads_of_blas_sleep_while_a_command_of_python_computes(work):
    free = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    free["OPENBLAS_THREAD_TIMEOUT"] = "4"  # idle threads sleep at once
    done = subprocess.run([sys.executable, "-c", _COUNT, work], env=free, capture_output=True, text=True, check=True)
    woken, by_a_product = map(int, done.stdout.split())
    if not by_a_product:
        pytest.skip("BLAS has one thread here")
    assert woken == 0

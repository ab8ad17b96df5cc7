"""Python sets no limit on BLAS: its threads sleep during runs and orbits."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from slipwave.threads import VARIABLES

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

"""The compile cache: warm when nothing changed, never shared by name between two processes that write at once."""

import os
import subprocess
import sys
from pathlib import Path

PROGRAM = """
import sys
import numpy as np
from reduced.step_guess import first_guess
from scene.friction import LAWS
law = LAWS[sys.argv[1]].parameters(0.369, 0.0349, 0.0489)
guess = np.empty(3)
first_guess(law, 1.4e-5, np.full(3, 0.3), -4.6, 1.0, guess)
print(guess[0].hex(), sum(first_guess.stats.cache_hits.values()))
"""


def start(law: str, folder: Path) -> subprocess.Popen[str]:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder)}
    return subprocess.Popen([sys.executable, "-c", PROGRAM, law], env=environment, stdout=subprocess.PIPE, text=True)


def test_processes_that_fill_one_cache_at_once_never_swap_code(tmp_path: Path) -> None:
    together = {law: start(law, tmp_path) for law in ("ageing", "slip")}
    first = {law: process.communicate()[0].split()[0] for law, process in together.items()}
    written = [path.name for path in tmp_path.rglob("*first_guess*.nbc")]
    assert len(written) == len(set(written)) == 2
    for law, answer in first.items():
        again, _ = start(law, tmp_path).communicate()[0].split()
        assert again == answer


def test_an_unchanged_tree_starts_warm(tmp_path: Path) -> None:
    hits = [int(start("ageing", tmp_path).communicate()[0].split()[1]) for _ in range(2)]
    assert hits == [0, 1]

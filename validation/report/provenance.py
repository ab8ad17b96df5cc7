"""Where a report comes from: version, commit, machine, libraries."""

import platform
import subprocess
from importlib import metadata
from pathlib import Path

import slipwave
from slipwave.sources import ROOT, source_digest
from validation.run.timing import cores


def machine_facts() -> dict[str, str]:
    """Facts for the page's head, in the order in which they are shown."""
    return {
        "slipwave": metadata.version("slipwave"),
        "commit": commit(),
        "solver sources": source_digest(),
        "scene paper": slipwave.read("paper").digest,
        "platform": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": str(cores()),
        "Python": platform.python_version(),
        "numpy": metadata.version("numpy"),
        "scipy": metadata.version("scipy"),
        "numba": metadata.version("numba"),
    }


def commit() -> str:
    """Short hash of the checkout the code runs from, with "+" if it was edited since; "unknown" outside a checkout."""
    try:
        head = _git("rev-parse", "--short=10", "HEAD")
        edited = _git("status", "--porcelain", "--untracked-files=no")
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return head + ("+" if edited else "")


def _git(*words: str) -> str:
    done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"

"""Provenance of a report: version, commit, machine, libraries."""

import platform
from importlib import metadata
from pathlib import Path

import slipwave
from slipwave.sources import commit, source_digest
from validation.models.stopwatch import cores


def machine_facts() -> dict[str, str]:
    """Facts for the top of the page, in display order."""
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


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"

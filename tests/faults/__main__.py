"""`python -m tests.faults`: exit status 0 if all planted faults are caught, 3 if any survives, 2 if nothing can be said.

The named checks run on a clean copy, where all must pass, and then each with its fault.
"""

import argparse
import json
import queue
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from slipwave.sources import cache_folder
from tests.faults.planting import ROOT, Fault, read_faults
from tests.faults.trial import Copy

RECORD = ROOT / "reports" / "baseline" / "faults.json"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description="Plant faults, and see which check catches each.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults to try (default: all)")
    parser.add_argument("--part", type=int, metavar="N", help="one N-th of them; which one, the commit decides")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="tried at a time (default: 2)")
    parser.add_argument("--record", action="store_true", help="put what was tried into the table that the report shows")
    options = parser.parse_args()
    faults = read_faults()
    unknown = set(options.names) - {fault.name for fault in faults}
    if unknown:
        parser.error(f"no fault is called {', '.join(sorted(unknown))}")
    if options.names:
        faults = [fault for fault in faults if fault.name in options.names]
    if options.part:
        command = ["git", "-C", str(ROOT), "rev-parse", "HEAD"]
        commit = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
        number = int(commit, 16) % options.part
        print(f"part {number + 1} of {options.part} (from commit {commit[:10]})")
        faults = faults[number :: options.part]
    with tempfile.TemporaryDirectory(prefix="slipwave-faults-") as folder:
        clean = Copy(Path(folder) / "clean", known=cache_folder())
        found = clean.run(sorted({check for fault in faults for check in fault.check}), "-n", str(options.jobs))
        if not found.is_green:
            print("checks fail without any fault:", found.trouble or "", *found.accidents, sep="\n  ")
            return 2
        records = try_all(faults, [Copy(Path(folder) / str(n), known=clean.cache) for n in range(options.jobs)])
    survivors = [record["name"] for record in records if not record["caught_by"]]
    print(f"{len(records) - len(survivors)} of {len(records)} planted faults caught", *survivors, sep="\nsurvives: ")
    if options.record:
        known = {record["name"]: record for record in (*json.loads(RECORD.read_text(encoding="utf-8"))["faults"], *records)}
        rows = [known[fault.name] for fault in read_faults() if fault.name in known]
        RECORD.write_text(json.dumps({"faults": rows}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return 3 if survivors else 0


def try_all(faults: list[Fault], copies: list[Copy]) -> list[dict[str, str]]:
    """The record of each fault, tried one at a time in each of the `copies`."""
    free: queue.Queue[Copy] = queue.Queue()
    for copy in copies:
        free.put(copy)

    def one(fault: Fault) -> dict[str, str]:
        copy = free.get()
        try:
            return try_fault(fault, copy)
        finally:
            free.put(copy)

    with ThreadPoolExecutor(len(copies)) as pool:
        return list(pool.map(one, faults))


def try_fault(fault: Fault, copy: Copy) -> dict[str, str]:
    """What a fault is and which test of its check notices it, empty if none does; printed with what the test says."""
    with copy.with_text(fault.file, fault.planted((copy.tree / fault.file).read_text(encoding="utf-8"))):
        found = copy.run(fault.check, "--maxfail=3")
    if found.caught_by:
        print(f"caught   {fault.name}  {found.caught_by}\n         {found.says}", flush=True)
    else:
        why = found.trouble or "; ".join(found.accidents)
        said = f"by accident only: {why}" if why else "its check stays green"
        print(f"SURVIVES {fault.name}  {fault.where}: {fault.what}\n         {said}", flush=True)
    return {"name": fault.name, "where": fault.where, "what": fault.what, "user": fault.user, "caught_by": found.caught_by}


if __name__ == "__main__":
    sys.exit(main())

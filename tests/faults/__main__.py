"""`python -m tests.faults`: exit status 0 if all planted faults are caught, 3 if any survives, 2 if a name is unknown."""

import argparse
import json
import subprocess
import sys
from functools import partial
from pathlib import Path

from tests.faults.planting import ROOT, read_faults
from tests.faults.programme import Record, Store, run_all, try_fault

RESULT = ROOT / "reports" / "faults.json"
BASELINE = ROOT / "reports" / "baseline" / "faults.json"


def main() -> int:
    """Run the programme of planted faults."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description="Plant faults, and see which check catches each.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults to try (default: all)")
    parser.add_argument("--part", type=int, metavar="N", help="one N-th of them; which one, the commit decides")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="tried at a time (default: 2)")
    parser.add_argument("--named", action="store_true", help="run the named checks only, never the whole suite")
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
    work = partial(try_fault, whole=not options.named)
    records = run_all(faults, work, options.jobs, Store(RESULT, "faults"))
    survivors = [record["name"] for record in records if not record["caught"]]
    print(
        f"{len(records) - len(survivors)} of {len(records)} planted faults caught",
        *(f"survives: {s}" for s in survivors),
        sep="\n",
    )
    if options.record:
        recorded(records, BASELINE)
    return 3 if survivors else 0


def recorded(records: list[Record], table: Path) -> None:
    """Put `records` into the `table`, in the order of the faults; those of faults that are planted no more are removed."""
    known = {record["name"]: record for record in json.loads(table.read_text(encoding="utf-8"))["faults"]}
    known |= {record["name"]: {key: value for key, value in record.items() if key != "key"} for record in records}
    rows = [known[fault.name] for fault in read_faults() if fault.name in known]
    table.write_text(json.dumps({"faults": rows}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())

"""Try every planted fault and say which check caught it: `make faults`, or `python -m tests.faults [NAME ...]`.

The named check is run on the clean copy (it must be green), then with the fault; the whole suite only if that stays green. Of a
survivor it is said whether its check runs the changed code at all.
"""

import hashlib
import json
import queue
import tempfile
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from slipwave.compiled.cache import cache_folder
from tests.faults.planting import ROOT, Fault
from tests.faults.trial import WHOLE_SUITE, Copy

CHECK_SECONDS, SUITE_SECONDS = 600.0, 3600.0
Record = dict[str, Any]


def try_fault(fault: Fault, copy: Copy, whole: bool = True) -> Record:
    """The record of one fault, as the report shows it: what it is, whether and by what it was caught, what the check says.

    `whole`: the whole suite is run where the named check stays green.
    """
    text = (copy.tree / fault.file).read_text(encoding="utf-8")

    def told(caught: bool, says: str, seconds: float = 0.0, **more: Any) -> Record:
        facts = {"name": fault.name, "room": fault.room, "where": fault.where, "what": fault.what, "user": fault.user}
        return facts | {"caught": caught, "says": says, "seconds": round(seconds, 1)} | more

    clean = copy.run_clean(fault.check, CHECK_SECONDS)
    if not clean.is_green:
        return told(False, f"its check is not green without it: {clean.trouble or clean}")
    with copy.with_text(fault.file, fault.planted(text)):
        found = copy.run(fault.check, CHECK_SECONDS)
        named = found.caught is not None
        if not named and whole:
            found = copy.run(WHOLE_SUITE, SUITE_SECONDS)
    if found.caught:
        return told(True, found.caught["says"], found.seconds, caught_by=found.caught["test"], by_its_check=named)
    by_accident = found.trouble or "; ".join(f"{a['kind']} in {a['test']}" for a in found.accidents[:2])
    if by_accident:
        return told(False, f"by accident only: {by_accident}", found.seconds)
    with copy.with_text(fault.file, fault.tripwire(text)):
        reached = not copy.run(fault.check, CHECK_SECONDS).is_green
    said = "its check runs the changed code and stays green" if reached else "its check never runs the changed code"
    return told(False, said, found.seconds)


def run_all(items: Iterable[Any], work: Callable[[Any, Copy], Record], jobs: int, store: "Store") -> list[Record]:
    """Work on `items`, `jobs` at a time, each job with a copy of its own; what `store` knows is not tried again. An item has a
    `name` and the files it is `decided_by`: its record is of use until one of these changes."""
    items = list(items)
    keys = {item.name: key_of(item, item.decided_by) for item in items}  # of the files as they are copied
    copies: queue.Queue[Copy] = queue.Queue()
    with tempfile.TemporaryDirectory(prefix="slipwave-faults-") as folder, ThreadPoolExecutor(jobs) as pool:
        for number in range(jobs):
            copies.put(Copy(Path(folder) / str(number), cache=cache_folder()))

        def one(item: Any) -> Record:
            key = keys[item.name]
            if (known := store.known(item.name, key)) is not None:
                return known
            copy = copies.get()
            try:
                return store.add(work(item, copy) | {"key": key})
            finally:
                copies.put(copy)

        return list(pool.map(one, items))


class Store:
    """Records on disk as they come, so that an interrupted programme goes on; each is of use as long as its `key` is the same."""

    def __init__(self, path: Path, title: str) -> None:
        self._path, self._title = path, title
        self._lock = threading.Lock()
        kept = json.loads(path.read_text(encoding="utf-8"))[title] if path.exists() else []
        self._records: dict[str, Record] = {record["name"]: record for record in kept}

    def known(self, name: str, key: str) -> Record | None:
        """The record of an earlier run, if it is still of use."""
        record = self._records.get(name)
        return record if record and record["key"] == key else None

    def forget_survivors(self) -> None:
        """They are to be tried again, by more tests."""
        self._records = {name: record for name, record in self._records.items() if record["caught"]}

    def add(self, record: Record) -> Record:
        """Keep and print a record."""
        with self._lock:
            self._records[record["name"]] = record
            self._path.parent.mkdir(parents=True, exist_ok=True)
            part = self._path.with_suffix(".part")
            part.write_text(json.dumps({self._title: list(self._records.values())}, indent=1) + "\n", encoding="utf-8")
            part.replace(self._path)
            print(line_of(record), flush=True)
        return record


def key_of(item: Any, files: Iterable[str], root: Path = ROOT) -> str:
    """Digest of what is to be tried and of the files that decide it."""
    digest = hashlib.sha256(repr(item).encode())
    for file in files:
        digest.update((root / file).read_bytes())
    return digest.hexdigest()[:16]


def line_of(record: Record) -> str:
    """One record as a line of the table."""
    if not record["caught"]:
        return f"SURVIVES {record['name']}  {record['where']}: {record['what']}\n         {record['says']}"
    named = "" if record.get("by_its_check", True) else "  (not by the check it names)"
    return f"caught   {record['name']}  {record['seconds']:.0f} s  {record['caught_by']}{named}\n         {record['says']}"

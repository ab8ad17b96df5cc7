"""Removes everything that depends on run times from a report: two reports of one commit agree in the rest.

python -m tests.validation.without_times reports        # the digest of what is left of report.json, the page and the tables
"""

import hashlib
import json
import re
import sys
from pathlib import Path

from validation.report import RUN_TIMES
from validation.report.record import NAME

_WORDS = re.compile(r"~\{(?:[^{}]|\{[^{}]*\})*\}")
_MARKED = re.compile(r'<(\w+)[^>]*\bclass="(?:[^"]* )?time(?: [^"]*)?"[^>]*>.*?</\1>', re.DOTALL)


def lasting_digest(out: Path) -> str:
    """Digest of the report in the folder `out` without run times."""
    report = json.loads((out / NAME).read_text(encoding="utf-8"))
    del report["times"]
    timed = {verdict["id"] for verdict in report["verdicts"] if verdict["unit"] in RUN_TIMES}
    report["verdicts"] = [one | ({"found": None} if one["id"] in timed else {}) for one in report["verdicts"]]
    report["figures"] = [figure for figure in report["figures"] if not figure["timed"]]
    for table in report["tables"]:
        kept = [not column["timed"] for column in table["columns"]]
        table["rows"] = [[cell for cell, keep in zip(row, kept, strict=True) if keep] for row in table["rows"]]
    for models in report["model_tables"]:
        for row in models["table"]["rows"]:
            del row["costs"]
    record = json.loads(_WORDS.sub("~{}", json.dumps(report, ensure_ascii=False)))
    tables = [table["csv"] for table in record["tables"] if not any(column["timed"] for column in table["columns"])]
    digest = hashlib.sha256(json.dumps(record, sort_keys=True).encode())
    digest.update(_MARKED.sub(r"<\1 time>", (out / "index.html").read_text(encoding="utf-8")).encode())
    for file in (*tables, *(file for figure in record["figures"] for file in figure["files"])):
        digest.update((out / file).read_bytes())
    return digest.hexdigest()


if __name__ == "__main__":
    print(lasting_digest(Path(sys.argv[1])))

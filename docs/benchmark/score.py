"""How many digits of your numbers are right: python score.py THEIRS.csv [DIGITS]

THEIRS.csv has the columns id,value and ids of benchmark.csv, which lies beside this file; ids may be missing. Exit status 0: each
row has DIGITS right (6 if not given), or all in which the two programs of the benchmark agree; 3: a row misses; 2: wrong input.
"""

import csv
import math
import sys
from pathlib import Path


def rows_of(path):
    """The number of each id. Raises ValueError, with the line, for one that has none, for an id twice, and without any row."""
    found = {}
    with open(path, encoding="utf-8-sig", newline="") as stream:
        lines = csv.reader(stream, skipinitialspace=True)
        if [cell.strip() for cell in next(lines, [])] != ["id", "value"]:
            raise ValueError("line 1: must be id,value")
        for cells in filter(None, lines):
            where, (name, *values) = f"line {lines.line_num}", [cell.strip() for cell in cells]
            if len(values) != 1:
                raise ValueError(f"{where}: must be an id and one number, with a decimal point and no comma")
            if name in found:
                raise ValueError(f"{where}: {name} is there twice")
            try:
                found[name] = float(values[0])
            except ValueError:
                found[name] = math.nan
            if not math.isfinite(found[name]) or "_" in values[0]:
                raise ValueError(f"{where}: {values[0] or 'nothing'} is no number")
    if not found:
        raise ValueError("no row")
    return found


def digits(theirs, known, bar):
    """Significant digits that are right, and those in which the two programs agree: no more can be."""
    most = math.floor(-math.log10(bar / abs(known)))
    off = abs(theirs / known - 1.0)
    return most if abs(theirs - known) <= bar else max(0, min(most, math.floor(-math.log10(off)))), most


if __name__ == "__main__":
    try:
        if len(sys.argv) not in (2, 3):
            raise ValueError("give a file, and a number of digits if not 6")
        theirs, wanted, missed = rows_of(sys.argv[1]), max(1, int((*sys.argv, "6")[2])), 0
    except (ValueError, OSError, csv.Error) as error:
        print(f"score.py THEIRS.csv [DIGITS]: {error}", file=sys.stderr)
        sys.exit(2)
    with Path(__file__).with_name("benchmark.csv").open(encoding="utf-8", newline="") as table:
        known = {row["id"]: (float(row["value"]), float(row["bar"])) for row in csv.DictReader(table)}
    for name, value in theirs.items():
        right, most = digits(value, *known[name]) if name in known else (0, 0)
        missed += right < min(wanted, most) or not most
        print(f"{name:20} {value!r:>20}  " + (f"{right} of {most} digits" if most else "is not in the benchmark"))
    print(f"{len(theirs) - missed} of {len(theirs)} rows have {wanted} digits right, or all in which the two programs agree")
    sys.exit(3 if missed else 0)

"""How many digits of your numbers are right: python score.py FILE [FILE ...] [DIGITS]

A FILE is a table with the columns id,value (or name,value) and ids of benchmark.csv, which lies beside this file; rows may be
missing. Or it is a station file of a run in the page's SI values: columns t, slip, slip_rate, shear_stress, state (s, m, m/s, Pa,
s), by spaces or commas, # before comments. Several files are runs at halved steps, the coarsest first: then orders are given,
and extrapolated values are judged. Exit status 0: each row has DIGITS right (6 if not given), or all in which the two programs of
the benchmark agree; 3: a row misses; 2: wrong input.
"""

import csv
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
TRANSIT = 10.0**-2.68  # s: h/c in the page's SI values
STAGES = {
    "jump start": "jump",
    "smooth start": "smooth",
    "orbit": "orbit multiplier",
    "unlike slabs": "unlike unlike-irrational",
    "layered slabs": "layered",
    "reflecting faces": "reflection-0.5 reflection-0.9",
    "other laws": "slip cutoff",
    "irregular motion": "irregular",
    "points of the branch": "onset fold torus doubling",
}
FIRST_ORDER = "order 1: friction takes the slip rate half a step late, or the state is updated once a step"
NEARER = 0.2  # a mistake is named if rows are so much nearer to its values than to the right ones


def group_of(name):
    """The part of an id that names its start, scene or kind of point."""
    return name.split(".psi.")[0] if ".psi." in name else name.partition(".")[0]


def table_of(name):
    """Rows of a file of the benchmark."""
    with (HERE / name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def number_of(cell, where):
    """A finite number. Raises ValueError, with the line, for anything else."""
    try:
        found = math.nan if "_" in cell else float(cell)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise ValueError(f"{where}: {cell or 'nothing'} is no number")
    return found


def rows_of(path, known):
    """The number of each id of a table or a station file. Raises ValueError, with the line, for a wrong one."""
    found, series, columns = {}, [], None
    with open(path, encoding="utf-8-sig", newline="") as stream:
        for number, text in enumerate(stream, 1):
            line, where = text.strip(), f"line {number}"
            if not line or line.startswith("#"):
                continue
            cells = [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))] if "," in line else line.split()
            if columns is None:
                columns = cells
                if columns not in (["id", "value"], ["name", "value"]) and not {"t", "state"} <= set(columns):
                    raise ValueError(f"{where}: must be id,value, or the columns t, slip, slip_rate, shear_stress, state")
            elif "t" in columns:
                if len(cells) != len(columns):
                    raise ValueError(f"{where}: must have {len(columns)} numbers")
                series.append([number_of(cell, where) for cell in cells])
            else:
                name, *values = cells
                if len(values) != 1:
                    raise ValueError(f"{where}: must be an id and one number, with a decimal point and no comma")
                if name in found:
                    raise ValueError(f"{where}: {name} is there twice")
                found[name] = number_of(values[0], where)
    if series:
        found = psi_of(series, columns, known)
    if not found:
        raise ValueError("no row")
    return found


def psi_of(series, columns, known):
    """psi = ln(state V*/L) of a station at the times of the start that it is nearest to, by cubics through four lines."""
    time, state = ([row[columns.index(name)] for row in series] for name in ("t", "state"))
    if min(state) <= 0.0 or len(time) < 4 or any(time[k + 1] <= time[k] for k in range(len(time) - 1)):
        raise ValueError("a station needs four lines or more, times that rise, and states above 0")
    found = {}
    for name in (name for name in known if group_of(name) in ("smooth", "jump")):
        at = float(name.rpartition(".")[2]) * TRANSIT
        if time[0] <= at <= time[-1]:
            k = min(max(sum(t < at for t in time) - 2, 0), len(time) - 4)
            near = range(k, k + 4)
            weights = [math.prod((at - time[j]) / (time[i] - time[j]) for j in near if j != i) for i in near]
            found[name] = sum(weights[i - k] * math.log(state[i]) for i in near)
    nearest = min(found, key=lambda name: abs(found[name] - known[name][0]), default="")
    return {name: value for name, value in found.items() if group_of(name) == group_of(nearest)}


def digits(theirs, known, bar):
    """Significant digits that are right, and those in which the two programs agree: no more can be."""
    most = math.floor(-math.log10(bar / abs(known)))
    off = abs(theirs / known - 1.0)
    return most if abs(theirs - known) <= bar else max(0, min(most, math.floor(-math.log10(off)))), most


def refined(values):
    """(order, extrapolated value) of runs at halved steps; (NaN, the last value) if they tell no order."""
    steps = [values[k + 1] - values[k] for k in range(-3, -1)] if len(values) > 2 else []
    if len(steps) < 2 or steps[1] == 0.0 or (ratio := steps[0] / steps[1]) <= 1.0:
        return math.nan, values[-1]
    order = math.log2(ratio)
    power = 2.0 ** (round(order) if abs(order - round(order)) < 0.1 else order)
    return order, values[-1] + (values[-1] - values[-2]) / (power - 1.0)


def causes(judged, orders, known):
    """What it usually means: mistakes to which the two rows that feel them most are near, and order 1."""
    felt = {}
    for row in (row for row in table_of("mistakes.csv") if row["id"] in judged):
        right, wrong, theirs = known[row["id"]][0], float(row["value"]), judged[row["id"]]
        felt.setdefault(row["mistake"], []).append((abs(wrong - right), abs(theirs - wrong) < NEARER * abs(theirs - right)))
    yield from (f"as if {words}" for words, rows in felt.items() if all(near for _, near in sorted(rows)[-2:]))
    smooth = sorted(one for name, one in orders.items() if group_of(name) != "jump" and one == one)
    if smooth and abs(smooth[len(smooth) // 2] - 1.0) < 0.3:
        yield FIRST_ORDER


def main(words):
    """Print the score; returns the exit status."""
    known = {row["id"]: (float(row["value"]), float(row["bar"])) for row in table_of("benchmark.csv")}
    try:
        wanted = max(1, int(words.pop())) if words[1:] and words[-1].isdecimal() else 6
        if not words:
            raise ValueError("give a file, or several at halved steps, and a number of digits if not 6")
        files = [rows_of(word, known) for word in words]
    except (ValueError, OSError, csv.Error) as error:
        print(f"score.py FILE [FILE ...] [DIGITS]: {error}", file=sys.stderr)
        return 2
    found = {name: refined([file[name] for file in files if name in file]) for name in files[-1]}
    judged, right = {name: value for name, (_, value) in found.items()}, {}
    for name, (order, value) in found.items():
        good, most = digits(value, *known[name]) if name in known else (0, 0)
        right[name] = bool(most) and good >= min(wanted, most)
        said = f"{good} of {most} digits" if most else "is not in the benchmark"
        print(f"{name:24} {value!r:>20}  {said}" + (f", extrapolated at order {order:.2f}" if order == order else ""))
    for stage, groups in STAGES.items():
        rows = [right[name] for name in judged if group_of(name) in groups.split()]
        if rows:
            print(f"{stage}: {'passes' if all(rows) else 'misses'} ({sum(rows)} of {len(rows)} rows)")
    for cause in causes(judged, {name: order for name, (order, _) in found.items()}, known):
        print(f"this usually means: {cause}")
    print(f"{sum(right.values())} of {len(right)} rows have {wanted} digits right, or all in which the two programs agree")
    return 0 if all(right.values()) else 3


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

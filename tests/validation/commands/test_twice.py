"""Every command gives the same numbers for one scene, record, sweep or fit that is written a second way (`twice`)."""

import math
import re
from typing import Any, NamedTuple

import numpy as np
import pytest

import slipwave as sw
from tests.validation.twice import FASTER, SIZES, TRANSIT, numbers_of, write_all
from validation.commands.cli import COMMANDS
from validation.commands.options import options_of

WITHOUT_NUMBERS = {"report", "scenes", "schema", "show"}
"""Commands that compute nothing on a scene of a user's."""

Rules = tuple[tuple[Any, ...], ...]
"""(pattern of a path, factor or function of the number or None where it is not compared[, other name]); the first that is found
holds."""

PACED: Rules = (
    (r"reference_velocity_m_per_s", FASTER),
    (r"against_data|smoothing|\.n$|unstable_roots", 1.0),
    (r"_m_per_s$|(^|\.)si\.", 1.0),
    (r"ln_v$", lambda x: x - math.log(FASTER)),
    (r"psi$", lambda x: x + math.log(FASTER)),
    (r"log10_r_c$", lambda x: x + math.log10(FASTER)),
    (r"epsilon|@r$|friction_time|period_time", FASTER),
    (r"v_(max|min)|velocity$|rate$|@V$|final[._]v$|\.V$|omega|root|abscissa|angular|axes\.0\.(from|to)|_second$", 1.0 / FASTER),
)
EXCHANGED: Rules = (
    (r"@|transit_s|error|defect|residual$", None),
    (r"_s$|_Pa$|_m_per_s$|period_time", 1.0),
    (r"period|until|time$", 0.5),
    (r"epsilon_c$", 3.0),
    (r"log10_r_c$", lambda x: x + math.log10(2.0)),
    (r"thickness_m$", 2.0),
)
"""The other slab's round trip is twice as long, its impedance three times as large."""

UNITS: Rules = ((r"^axes.*(from|to|unit)$|^nc\.(drive_velocity|slab_thickness)$", None),)
SECOND: Rules = ((r"^nc\.(?!drive|slab|@)", lambda x: x[1]), (r"^nc\.", 1.0), (r"", None))
ROW: Rules = ((r"^models\.1\.(?!error)", 1.0, "models.0."), (r"^nc\.(?!error|@)", lambda x: x[1:]), (r"", None))
VALUES: Rules = ((r"^parameters|^data.*(measured|events)$|samples$", 1.0), (r"", None))
CYCLE: Rules = ((r"b.value$|period.measured|events$", 1.0), (r"", None))
MIRROR = 34.5 * 2.8e11  # thickness times shear modulus of the start: friction knows their ratio alone
MIRRORED: Rules = (
    (r"slab\.thickness\.(value|start)$", lambda x: MIRROR / x, r"slab.shear_modulus.\1"),
    (r"slab\.thickness\.low$", lambda x: MIRROR / x, "slab.shear_modulus.high"),
    (r"slab\.thickness\.high$", lambda x: MIRROR / x, "slab.shear_modulus.low"),
    (r"memory_length\.(value|low|high)$|residual", 1.0),
    (r"", None),
)


class Pair(NamedTuple):
    """Commands, joined by &&; what is written otherwise in them, or all of it; how numbers change; their largest difference."""

    words: str
    otherwise: dict[str, str] | str
    rules: Rules = ()
    near: float = 1e-9
    slow: bool = False

    @property
    def other(self) -> str:
        words = self.words if isinstance(self.otherwise, dict) else self.otherwise
        for old, new in self.otherwise.items() if isinstance(self.otherwise, dict) else ():
            assert old in words, old
            words = words.replace(old, new)
        return words


FAST = "--set V=4000"
RUN = f"run plain-SI.toml {FAST} --until 200 --window 150.3:160.3 --every 3"
ODD_LAYERS = "'upper.layers=[{fraction=0.41421356,impedance=1.0},{fraction=0.58578644,impedance=1.0}]'"
NETWORK = f"run network-own.toml {FAST}"
FIELDS = f'run plain-own.toml {FAST} \'run.record=["events","fields"]\' --model fd --cells 16'
LEAPING = "run leaping.toml --tol 1e-6"
ORBIT = f"orbit plain-SI.toml {FAST}"
BRANCH = "branch plain-SI.toml --model block8 --tol 1e-4 --most-points 4 --over slab.thickness=30:40"
CURVE = "curve plain-SI.toml --model block8 --tol 1e-4 --most-points 3 --of LP --over slab.thickness=12:60 --and V=100:120"
BOTH = f"compare plain-SI.toml {FAST} --until 200 --models delay,block8"
SWEEP = "sweep plain-SI.toml --until 200 --vary V=4000,5000 --vary slab.thickness=34.5,37.5"
MAP = f"{SWEEP} --models delay,block8 --out a && map a"
STEPS = "fit steps-SI.toml --set start.size=0 --data steps.csv --free a,b,memory_length"
LOAD = "fit loaded-SI.toml --set start.size=0 --data load.csv --free a,b,memory_length --window 0.1:0.9"
OTHER_COLUMNS = "steps-columns.txt --columns _,time,friction,_ --units _,ms,%,_ --missing nan,-999"
COLUMNS = f"{STEPS.replace('steps.csv', OTHER_COLUMNS)} --window 0.1:0.9"
CYCLES = f"fit plain-SI.toml {FAST} --model block8 --data cycles.csv --free b,memory_length,level"
BESIDE = f"compare plain-SI.toml {FAST} --models block8 --until 200 --with cycles.csv"

SI, PACE = {"own": "SI"}, {"SI": "paced", "V=4000": "V=1000"}
TEXTS = {"SI": "texts", "V=4000": "'V=4 mm/s'"}
AXES = {"SI": "texts", "V=4000,5000": "'V=4 mm/s,5 mm/s'", "slab.thickness=34.5,37.5": "'thickness=3450 cm,3750 cm'"}

PAIRS = {
    "run, own units": Pair(RUN.replace("SI", "own"), SI),
    "run, texts": Pair(
        f"{RUN} --checkpoint a.npz --checkpoint-every 50",
        TEXTS
        | {
            "--until 200": "--until 5.52s",
            "150.3:160.3": "'4148.28 ms:4424.28 ms'",
            "a.npz": "b.npz",
            "-every 50": "-every 1.38s",
        },
    ),
    "run, other V*": Pair(RUN, PACE, PACED),
    "run, faces of an area": Pair(f"run machine-SI.toml {FAST} --until 40", TEXTS),
    "run, a rate": Pair(f"run plain-SI.toml {FAST} --until 200 --rate 2", {"--rate 2": "--rate 72.463768115942Hz"}),
    "run, protocol": Pair("run hold-own.toml --until 40", "run hold-SI.toml --until 40"),
    "run, protocol, texts": Pair("run hold-SI.toml --until 40", {"SI": "texts", "40": "1104ms"}),
    "run, protocol, other V*": Pair("run hold-SI.toml --until 40", {"SI": "paced"}, PACED),
    "run, exchanged": Pair(
        f"run unlike-SI.toml {FAST} --until 200 --window 20:30",
        {"SI": "exchanged", "until 200": "until 5.52s", "20:30": "10:15"},
        EXCHANGED,
    ),
    "run, a mass with a jump by a network": Pair(
        f"run heavy-own.toml {FAST} --until 20", {"--until": f"{ODD_LAYERS} --until"}, ((r"@|^faces", None),), 1e-6
    ),
    "run, layers that are none": Pair(
        f"run plain-own.toml {FAST} --until 60",
        {"V=4000": "V=4000 'slab.layers=[{fraction=0.3,impedance=1.0},{fraction=0.7,impedance=1.0}]'"},
        (),
        1e-7,
    ),
    "run, in two parts": Pair(
        f"{NETWORK} --until 60",
        f"{NETWORK} --until 30 --checkpoint c.npz --checkpoint-every 7 && {NETWORK} --until 60 --checkpoint c.npz",
    ),
    "run, leaps in two parts": Pair(
        # a run that ends at 38000 cuts no leap; one that is cut is right to the tolerance only
        f"{LEAPING} --until 40000",
        f"{LEAPING} --until 38000 --checkpoint d.npz --checkpoint-every 500 && {LEAPING} --until 40000 --checkpoint d.npz",
    ),
    "run, a later window of fields": Pair(
        f"{FIELDS} --until 150",
        f"{FIELDS} --until 110 --checkpoint e.npz --checkpoint-every 7 && {FIELDS} --until 150 --checkpoint e.npz",
    ),
    "run, of a file": Pair(RUN, f"{RUN} --out first.nc && run first.nc"),
    "orbit, texts": Pair(f"{ORBIT} --near-period 3", TEXTS | {"period 3": "period '82.8 ms'"}),
    "orbit, other V*": Pair(ORBIT, PACE, PACED),
    "orbit, exchanged": Pair(
        f"orbit unlike-SI.toml {FAST} --tol 1e-6", {"SI": "exchanged"}, ((r"nc.(time|interface)", None), *EXCHANGED), 1e-7
    ),
    "orbit, of a file": Pair(ORBIT, f"{ORBIT} --out first.nc && orbit first.nc"),
    "stability, own units": Pair("stability plain-own.toml", SI, ((r"^si", None),)),
    "stability, texts": Pair("stability machine-SI.toml", {"SI": "texts"}),
    "stability, other V*": Pair("stability plain-SI.toml", {"SI": "paced"}, PACED),
    "stability, exchanged": Pair("stability unlike-SI.toml", {"SI": "exchanged"}, EXCHANGED),
    "branch, texts": Pair(BRANCH, {"SI": "texts", "30:40": "'3000 cm:40 m'"}),
    "branch, other V*": Pair(BRANCH, {"SI": "paced"}, PACED),
    "branch, in two parts": Pair(BRANCH, f"{BRANCH.replace('points 4', 'points 2')} --out b.nc && {BRANCH} --resume b.nc"),
    "branch, of a file": Pair(BRANCH, f"{BRANCH} --out first.nc && branch first.nc"),
    "curve, texts": Pair(  # a multiplier of 7e-4 is known as well as that of 1: to 2e-10
        CURVE, {"SI": "texts", "12:60": "'1200 cm:60 m'", "100:120": "'0.1 mm/s:120 um/s'"}, (), 1e-6
    ),
    "curve, other V*": Pair(CURVE, {"SI": "paced", "100:120": "25:30"}, PACED, 1e-7),
    "curve, in two parts": Pair(CURVE, f"{CURVE.replace('points 3', 'points 2')} --out c.nc && {CURVE} --resume c.nc"),
    "curve, of a file": Pair(CURVE, f"{CURVE} --out first.nc && curve first.nc", slow=True),
    "compare, texts": Pair(BOTH, TEXTS | {"until 200": "until 5.52s"}),
    "compare, other V*": Pair(BOTH, PACE, PACED),
    "compare, one model alone": Pair(BOTH, {"delay,": ""}, ROW),
    "compare, record of another clock": Pair(BESIDE, TEXTS | {"cycles.csv": "cycles-late.csv"}, (), 1e-7),
    "compare, record without a heading": Pair(
        BESIDE, {"cycles.csv": "cycles-bare.txt --columns _,time,friction --units _,ms,% --missing nan,-999"}, (), 1e-7
    ),
    "compare, record cut within its falls": Pair(
        BESIDE.replace("cycles.", "cycles-whole."), {"whole": "cut"}, ((r"noise", None),), 1e-6
    ),
    "compare, record over other V*": Pair(BESIDE, PACE, PACED),
    "bench, texts": Pair(f"bench plain-SI.toml {FAST} --until 100", TEXTS | {"until 100": "until 2.76s"}, slow=True),
    "sweep, own units": Pair(
        f"{SWEEP.replace('SI', 'own').replace('slab.thickness=34.5,37.5', 'r=0.00276,0.003')} --out a",
        SI | {"r=0.00276,0.003": "slab.thickness=34.5,37.5", "--out a": "--out b"},
        ((r"^nc\.r$", 12500.0, "nc.slab_thickness"), (r"^axes.1.(from|to)", 12500.0)),
    ),
    "sweep, texts": Pair(f"{SWEEP} --measure run --out a", AXES | {"--out a": "--out b"}, UNITS),
    "sweep of stability, texts": Pair(f"{SWEEP} --measure stability --out a", AXES | {"--out a": "--out b"}, UNITS),
    "sweep of orbits, texts": Pair(f"{SWEEP} --measure orbit --out a", AXES | {"--out a": "--out b"}, UNITS),
    "sweep, time with a unit": Pair(
        SWEEP.replace("slab.thickness=34.5,37.5", "a=0.0349,0.035") + " --measure cycles --out a",
        {"until 200": "until 5.52s", "--out a": "--out b"},
    ),
    "sweep, other V*": Pair(f"{SWEEP} --out a", {"SI": "paced", "4000,5000": "1000,1250", "--out a": "--out b"}, PACED),
    "sweep, axes exchanged and reversed": Pair(
        f"{SWEEP} --out a",
        "sweep plain-SI.toml --until 200 --vary slab.thickness=37.5,34.5 --vary V=5000:4000:2 --out b",
        ((r"^nc\.(drive|slab)", lambda x: x[::-1]), (r"^nc\.(?!@)", lambda x: x.T[::-1, ::-1]), (r"^axes", None)),
    ),
    "sweep, table of scenes": Pair(
        f"{SWEEP} --out a",
        "sweep plain-SI.toml --until 200 --rows rows.csv --out b",
        ((r"^nc\.(drive|slab)|^axes", None), (r"^nc\.(?!@)", np.ravel)),
    ),
    "sweep, refined": Pair(
        "sweep plain-own.toml --set V=100 --measure stability --vary log10_r=-2.8:-2.5:5 --vary V=50:200:5 --out a",
        {"--out a": "--refine 1 --out b"},
        ((r"^done$|^audit|^refused$", None),),
    ),
    "sweep, one model alone": Pair(f"{SWEEP} --models delay,block8 --out a", {"delay,": "", "--out a": "--out b"}, SECOND),
    "map, texts": Pair(MAP, AXES | {" a &&": " b &&", "map a": "map b"}, UNITS),
    "map, gathered": Pair(f"{MAP} --plain", {"map a": "sweep a --gather && map a/sweep.nc"}),
    "map, differences of exchanged models": Pair(
        f"{MAP} --plain --against block8".replace("delay", "block12"),
        {"block12,block8": "block8,block12", " a &&": " b &&", "map a": "map b"},
    ),
    "fit, units of headings": Pair(STEPS, {"steps.csv": "steps-units.csv"}, (), 1e-6),
    "fit, columns without a heading": Pair(STEPS, {"SI": "texts", "steps.csv": OTHER_COLUMNS}, (), 1e-6),
    "fit, other V*": Pair(
        f"{STEPS},a_star", {"SI": "paced"}, ((r"a_star|^nc\.(value|low|high|correlation)", None), *PACED), 1e-6
    ),
    "fit, own units": Pair(
        STEPS.replace(",memory_length", " --window 3.6231884:32.608696")
        .replace("steps.csv", "load-own.csv")
        .replace("SI", "own"),
        {"own.toml": "SI.toml", "load-own.csv": "steps.csv", "3.6231884:32.608696": "0.1:0.9"},
        ((r"record_time", TRANSIT),),
        1e-6,
    ),
    "fit, record of a load point on another clock": Pair(
        LOAD, {"load.csv": "load-late.csv", "0.1:0.9": "'100100ms:100.9s'"}, (), 1e-6
    ),
    "fit, record in own units": Pair(LOAD, {"load.csv": "load-own.csv", "0.1:0.9": "'100ms:0.9s'"}, (), 1e-6),
    "fit, a drive or the load point": Pair(LOAD, {"loaded": "steps"}, VALUES, 1e-3),
    "fit, mirrored": Pair(
        f"{STEPS.replace('steps.csv', 'steps-noisy.csv').replace('a,b', 'slab.thickness')} --model quasistatic",
        {"slab.thickness": "slab.shear_modulus"},
        MIRRORED,
        1e-4,
    ),
    "fit, noise that lasts": Pair(STEPS, {"steps.csv": "steps-lasting.csv"}, ((r"(value|low|high)$", 1.0), (r"", None)), 1e-4),
    "fit of cycles, another clock": Pair(CYCLES, TEXTS | {"cycles.csv": "cycles-late.csv"}, (), 1e-5),
    "fit of cycles, cut within their falls": Pair(
        CYCLES.replace("cycles.", "cycles-whole."), {"whole": "cut"}, ((r"level", None), *VALUES), 1e-4
    ),
    "fit of cycles, drifting": Pair(CYCLES.replace("b,memory_length,level", "b"), {"cycles.": "cycles-drift."}, CYCLE, 1e-4),
    "fit, of a file": Pair(COLUMNS, f"{COLUMNS} --out first.nc && fit first.nc", ((r"start$", None),), 1e-6),
    "verify, texts": Pair("verify plain-SI.toml --model dg:3", {"SI": "texts"}),
    "verify, other V*": Pair("verify plain-SI.toml --model dg:3", {"SI": "paced"}, (), 1e-6),
}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("twice")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        write_all()
    return folder


@pytest.mark.parametrize("name", [pytest.param(k, marks=[pytest.mark.slow] * pair.slow) for k, pair in PAIRS.items()])
def test_what_is_written_twice_has_the_same_numbers(name, written, tmp_path, monkeypatch):
    for path in written.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)
    pair = PAIRS[name]
    one, other = (numbers_of(words, monkeypatch) for words in (pair.words, pair.other))
    assert differences(one, other, pair) == []
    assert len(one) > 5


def differences(one, other, pair):
    """Paths whose numbers are not those expected, with both."""
    found, rest = [], dict(other)
    computed = np.asarray(other.get("nc.status", 0)) == 0
    for path, value in one.items():
        pattern, convert, *name = next((rule for rule in pair.rules if re.search(rule[0], path)), ("", 1.0))
        if convert is None:
            continue
        path = re.sub(pattern, name[0], path) if name else path
        theirs = rest.pop(path, "nothing")
        expected = value if value is None or isinstance(value, str) else convert(value) if callable(convert) else convert * value
        near = max(pair.near, 1e-3) if re.search(r"std|error|defect|residual$", path) else pair.near
        if not same(expected, theirs, near, computed):
            found.append((path, expected, theirs))
    skipped = [pattern for pattern, convert, *_ in pair.rules if convert is None]
    for path, value in rest.items():
        if not any(re.search(pattern, path) for pattern in skipped) and not same(twin(path, other), value, 1e-12):
            found.append((path, "nothing", value))
    return found


def same(expected, got, near, computed=True):
    """Whether words are equal, and numbers where they were `computed`, relative to their largest."""
    if isinstance(expected, str) or isinstance(got, str) or expected is None or got is None:
        return type(expected) is type(got) and expected == got
    expected, got = np.asarray(expected, dtype=float), np.asarray(got, dtype=float)
    if expected.shape != got.shape:
        return False
    chosen = computed if np.shape(computed) == got.shape else np.ones(got.shape, dtype=bool)
    size = np.nanmax(np.abs(expected[chosen]), initial=0.0) if np.isfinite(expected[chosen]).any() else 0.0
    return np.allclose(expected[chosen], got[chosen], rtol=near, atol=near * size + 1e-12, equal_nan=True)


def twin(path, numbers):
    """The number in SI that follows from the one in own units, for a path that ends in an SI unit."""
    ending = next((one for one in ("m_per_s", "Pa", "s", "m") if path.endswith(f"_{one}")), None)
    own = re.sub(r"\bsi\.", "", path.removesuffix(f"_{ending}"))
    spread = re.sub(r"_(std|mean)$", r".\1", own)
    names = (own, f"{own}.mean", spread, f"margins.{own.removesuffix('_margin')}")
    base = next((numbers[name] for name in names if name in numbers), 1.0)
    grown = numbers.get("nc.slab_thickness", 34.5) / 34.5 if ending == "s" and np.shape(base) else 1.0  # of the transit
    return None if ending is None or base is None else np.asarray(base) * SIZES[ending] * grown


def test_every_command_and_every_option_with_a_unit_is_in_the_table():
    for name in COMMANDS.keys() - WITHOUT_NUMBERS:
        words = " ".join(f"{pair.words} {pair.other}" for label, pair in PAIRS.items() if label.startswith(name))
        assert f"{name} " in words, f"{name} is in no pair"
        kind = getattr(sw, name).__wrapped__.__annotations__["options"]
        takes_units = re.compile(r"TIME|RATE|FROM:|VALUES|A:B|BEGIN:|time,|time=|nan|\.csv")
        needed = [one.flag for one in options_of(kind).values() if takes_units.search(one.metavar or "")]
        assert [flag for flag in needed if flag not in words] == [], name


def test_the_sum_of_squares_has_risen_alike_at_both_ends_of_an_asymmetric_interval(written, monkeypatch):
    """As the other parameter is at its best there. Ends that are interchanged miss by 2e-2."""
    monkeypatch.chdir(written)
    noisy = "fit steps-SI.toml --model quasistatic --data steps-noisy.csv --set start.size=0 {} --free {}memory_length"
    whole = numbers_of(noisy.format("", "slab.thickness,"), monkeypatch)
    ends = [f"slab.thickness={whole[f'parameters.slab.thickness.{end}']!r}" for end in ("low", "high")]
    low, high = (numbers_of(noisy.format(end, ""), monkeypatch)["residual.rms"] for end in ends)
    assert low == pytest.approx(high, rel=1e-3)
    assert low > 1.002 * whole["residual.rms"]

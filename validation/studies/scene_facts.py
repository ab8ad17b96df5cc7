"""What is being simulated: two slabs, one interface, and the few dimensionless groups that matter."""

import math

import slipwave
from slipwave.scene import Scene
from validation.references.onset import CriticalValues, onset_of
from validation.study import EXACT, PAPER, Budget, Cell, Figure, Number, StudyResult, Table, Verdict, claim, table
from validation.study.drawing import Axes, Drawing, canvas
from validation.study.known import rounding

NAME = "scene-facts"
QUESTION = "What slides, and which numbers govern it?"
SCENES = ("paper", "paper-si", "rock")
SECONDS = (0.5, 0.5)

_OPERATIONS = 4  # two roundings, twice in each of ε and r
_EPSILON_WITHIN = 5e-3 * 2.8e-5  # half a per cent
_TABLE_1 = {"density": 800.0, "shear_modulus": 1e6, "epsilon": 2.8e-5}


def run(budget: Budget) -> StudyResult:
    """Read the scenes and tabulate their groups."""
    scenes = [slipwave.read(name) for name in SCENES]
    paper = scenes[0]
    onset = _onset(paper)
    ratio = paper.transit / onset.r_delay
    return StudyResult(
        answer=_answer(ratio),
        figures=(Figure("slabs", _CAPTION, _draw),),
        tables=(_groups(scenes), _dimensional(scenes[1:])),
        verdicts=_verdicts(paper, scenes[1]),
        notes=(
            "Two clocks are in use. The *friction clock* counts time in L/V*, the *transit clock* t~ = t/r in round trips of a "
            "wave through one slab. Periods are in transits unless stated otherwise; stress is in units of σ, so that stress and "
            "friction coefficient are one number; rates are in units of V*.",
        ),
        numbers={
            "r_c delay": Number(onset.r_delay, 1e-12),
            "r_c kelvin-voigt": Number(onset.r_kelvin_voigt, 1e-12),
            "omega_c": Number(onset.omega_c, 1e-12),
        },
    )


def _answer(ratio: float) -> str:
    """`ratio`: r over the critical r."""
    side = "beyond" if ratio > 1.0 else "short of"
    return (
        "Two numbers, the impedance ratio ε and the round trip r, with the drive V and the friction law: the paper’s "
        f"scene lies {100 * abs(ratio - 1):.1f} % {side} the onset of stick-slip."
    )


def _onset(chosen: Scene) -> CriticalValues:
    return onset_of(chosen.law, chosen.upper.epsilon, chosen.velocity)


def _groups(scenes: list[Scene]) -> Table:
    rows = [
        ("*a*_{∗}", "friction at V*", *(s.law.a_star for s in scenes)),
        ("*a*", "direct effect", *(s.law.a for s in scenes)),
        ("*b*", "evolution effect", *(s.law.b for s in scenes)),
        ("V", "drive, V*", *(s.velocity for s in scenes)),
        ("ε = ρc V*/σ", "slab impedance over frictional impedance", *(s.upper.epsilon for s in scenes)),
        ("r = (h/c)/(L/V*)", "wave round trip over state relaxation", *(s.transit for s in scenes)),
        ("log_{10} r", "", *(math.log10(s.transit) for s in scenes)),
        ("ε/r", "stiffness of both slabs", *(s.upper.epsilon / s.transit for s in scenes)),
        ("r_{∗}", "quasi-static onset (22)", *(_onset(s).r_quasistatic for s in scenes)),
        ("r_{c}, exact", "onset of stick-slip (39)", *(_onset(s).r_delay for s in scenes)),
        ("r_{c}, Kelvin–Voigt", "the same in the paper’s ODE (27)", *(_onset(s).r_kelvin_voigt for s in scenes)),
        ("ω_{c}", "frequency at onset, V*/L (20)", *(_onset(s).omega_c for s in scenes)),
        ("r/r_{c}", "how far beyond onset", *(s.transit / _onset(s).r_delay for s in scenes)),
    ]
    caption = (
        "The scenes in dimensionless groups. L: slip over which friction’s state renews itself; V*: reference rate; σ: normal "
        "stress; ρ, c: density and shear-wave speed of the slabs; h: thickness of both together."
    )
    return table("groups", caption, " | ".join(["symbol | meaning", *(f"{s.name} .6g" for s in scenes)]), rows)


def _dimensional(scenes: list[Scene]) -> Table:
    pairs = [(s, s.units) for s in scenes if s.units is not None]
    units = [u for _, u in pairs]
    rows: list[tuple[Cell, ...]] = [
        ("L", "memory length", "m", *(u.memory_length for u in units)),
        ("V*", "reference rate", "m/s", *(u.reference_velocity for u in units)),
        ("σ", "normal stress", "Pa", *(u.normal_stress for u in units)),
        ("V V*", "drive", "m/s", *(s.velocity * u.reference_velocity for s, u in pairs)),
        ("ρc", "impedance of a slab", "Pa s/m", *(s.upper.epsilon * u.normal_stress / u.reference_velocity for s, u in pairs)),
        ("L/V*", "unit of the friction clock", "s", *(u.time for u in units)),
        ("r L/V*", "one transit", "s", *(s.transit * u.time for s, u in pairs)),
    ]
    heading = " | ".join(["symbol | meaning | unit", *(f"{s.name} .6g" for s in scenes)])
    return table("si", "The scenes that are given in SI units.", heading, rows)


def _verdicts(paper: Scene, same: Scene) -> tuple[Verdict, Verdict]:
    gap = max(abs(same.upper.epsilon / paper.upper.epsilon - 1), abs(same.transit / paper.transit - 1))
    printed = math.sqrt(_TABLE_1["density"] * _TABLE_1["shear_modulus"]) * 1e-6 / 1e3
    title = "Table 1’s paper material has the ε that the paper computes with"
    remark = "ρ = 800 kg/m³ as printed gives 1 % more; the scenes here use ε = 2.8 · 10^{-5}, that is ρ = 784 kg/m³"
    return (
        claim("SI input and (ε, r) input give the same scene", EXACT, gap, rounding(_OPERATIONS)),
        claim(title, PAPER, 1e5 * printed, 1e5 * _EPSILON_WITHIN, remark, near=1e5 * _TABLE_1["epsilon"], unit="· 10^{−5}"),
    )


_CAPTION = (
    "Two elastic slabs, each h/2 thick, are pressed together by σ and sheared by moving their outer faces at ±V/2. Slip at rate "
    "v at the interface sends shear waves into both; they come back from the driven faces after one transit h/c, and meet the "
    "friction that sent them out."
)


def _draw() -> Drawing:
    figure = canvas(height=2.5)
    axes = figure.add_subplot()
    axes.set_axis_off()
    axes.set(xlim=(0, 10), ylim=(-1.75, 1.75))
    for bottom, shade in ((0.03, "#eceae2"), (-1.03, "#dfe5e8")):
        axes.fill([1, 9, 9, 1], [bottom, bottom, bottom + 1, bottom + 1], facecolor=shade, edgecolor="#1b1b1a", linewidth=1.0)
    for sign in (1, -1):
        _arrow(axes, (5 - sign * 0.8, sign * 1.22), (5 + sign * 0.8, sign * 1.22))
        axes.text(5 + sign * 1.0, sign * 1.22, "$V/2$", ha="left" if sign > 0 else "right", va="center")
        axes.plot([2.6, 3.3, 4.0], [0.05 * sign, 1.0 * sign, 0.05 * sign], color="#0072b2", linewidth=1.2, linestyle=(0, (5, 2)))
        _arrow(axes, (8.35, sign * 1.7), (8.35, sign * 1.1))
        axes.annotate("", (1.25, sign * 0.05), (1.25, sign * 1.0), arrowprops={"arrowstyle": "<->", "linewidth": 0.8})
        axes.text(1.4, sign * 0.52, "$h/2$", va="center")
    axes.text(8.5, 1.4, r"$\sigma$", va="center")
    axes.text(4.05, 0.52, "out and back: one transit $h/c$", color="#0072b2", va="center")
    axes.text(9.12, 0.0, "friction $F(v,\\phi)$", va="center", ha="left")
    axes.text(6.9, -0.52, r"$\rho,\ c$", va="center")
    return figure


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "linewidth": 1.2, "color": "#1b1b1a"})

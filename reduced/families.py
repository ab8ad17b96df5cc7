"""The facts of every model without a grid, cheapest first. To add a reduction, write its file and add its entry here.

A function (scene, name) -> `reduced.impedance.reduction.Reduction` makes a reduction; it is called only for scenes that the
family honours.
"""

from slipwave.family import ANYTHING, NOTHING, Exact, Family, PlotStyle

MOST_MODES = 64
_MODES = range(MOST_MODES + 1)
_HOMOGENEOUS = NOTHING | {"unlike"}
_LOSSLESS = _HOMOGENEOUS | {"layers"}
_ELASTIC = _LOSSLESS | {"grip", "reflection", "mass"}
_WITH_A_SPRING = ANYTHING - {"reflection"}

DELAY = Family(
    "delay",
    "reduced.delay.system:delay_system",
    "the exact wave physics of elastic slabs as a delay system",
    "the tolerance (default 1e-9)",
    _ELASTIC,
    Exact.TO_TOLERANCE,
    styles={None: PlotStyle("#111111", "-", "o", 2.0)},
)

REDUCTIONS = [
    Family(
        "quasistatic",
        "reduced.impedance.reduce:quasistatic",
        "no waves, no inertia: runs away when unstable",
        honours=_WITH_A_SPRING,
        styles={None: PlotStyle("#b9b9b9", (0, (1, 1)), "x")},
    ),
    Family(
        "quasidynamic",
        "reduced.impedance.reduce:quasidynamic",
        "no waves, radiation damping",
        honours=_WITH_A_SPRING,
        styles={None: PlotStyle("#8a8a8a", (0, (8, 2, 1.5, 2)), "P")},
    ),
    Family(
        "block8",
        "reduced.impedance.reduce:block8",
        "spring and block of mass rho h/8",
        honours=_HOMOGENEOUS,
        styles={None: PlotStyle("#009e73", (0, (6, 2)), "^")},
    ),
    Family(
        "block12",
        "reduced.impedance.reduce:block12",
        "spring and block of mass rho h/12",
        honours=_LOSSLESS,
        styles={None: PlotStyle("#009e73", (0, (2, 1.5)), "v")},
    ),
    Family(
        "kelvin-voigt",
        "reduced.impedance.reduce:kelvin_voigt",
        "the paper's ODE, one Kelvin-Voigt element",
        honours=_HOMOGENEOUS,
        styles={None: PlotStyle("#0072b2", "-", "D")},
    ),
    Family(
        "modal:N",
        "reduced.impedance.reduce:modal",
        "the first N exact modes of the slabs",
        "of the model, falls with N",
        _LOSSLESS,
        numbers=_MODES,
        default=2,
        styles={
            1: PlotStyle("#cc4f8a", (0, (5, 1.5)), "<"),
            2: PlotStyle("#cc4f8a", (0, (1.2, 1.2)), ">"),
            4: PlotStyle("#cc4f8a", "-", "x"),
            8: PlotStyle("#8d2f5e", (0, (3, 1, 1, 1)), "*"),
        },
    ),
    Family(
        "fitted:N",
        "reduced.impedance.reduce:fitted",
        "a passive rational fit of the exact impedance",
        "of the model, falls with N",
        ANYTHING,
        numbers=_MODES,
        default=4,
    ),
]
FAMILIES = (DELAY, *REDUCTIONS)
"""Those of slipwave; a user's own reductions are in `REDUCTIONS` alone."""

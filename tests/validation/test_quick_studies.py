"""Quick runs of the studies: which verdicts there are, that all but known findings pass within limits near what is measured, that
a displaced model turns them red (`shown.quick`), and their most important numbers."""

import re
from typing import NamedTuple

import pytest
from shown import quick, too_roomy

from validation.study import Outcome


class Expected(NamedTuple):
    """How many verdicts, the first words of the findings among them, and (value, relative tolerance) of some numbers."""

    verdicts: int
    findings: tuple[str, ...] = ()
    numbers: dict[str, tuple[float, float]] = {}  # noqa: RUF012


ERRORS = {"kelvin-voigt": -3.7290e-2, "block8": 4.2715e-2, "modal:1": 5.809e-4, "modal:2": -5.53e-6}
DELAY = {"period": 73.4721449, "stress_drop": 0.1739634, "elastic_stress_drop": 0.1547375, "v_max": 4412.3205, "v_min": 2.860302}
PERIODS = {"kelvin-voigt": 70.7323450, "block8": 76.6102996, "block12": 77.8685694}
MODAL = {"modal:1": 73.5148, "modal:2": 73.4717, "modal:8": 73.4721}
REGIMES = {"quasidynamic": (82.6, 0.02), "block12": (34.5, 0.05)}

STUDIES = {
    "one-cycle": Expected(
        10,
        (),
        {f"delay {name}": (value, 5e-7) for name, value in DELAY.items()}
        | {f"{model} period": (value, 1e-8) for model, value in PERIODS.items()}
        | {f"{model} period": (value, 8e-7) for model, value in MODAL.items()},
    ),
    "partial-reflection": Expected(
        4, (), {"grip 1, Z_{g}/ε = 1: T": (185.5406, 1e-5), "grip 10, Z_{g}/ε = 1: T": (114.2073, 1e-5)}
    ),
    "beyond-one-scene": Expected(6, (), {"rock: kelvin-voigt error of T at 1.02": (-3.144e-2, 1e-2)}),
    "which-model": Expected(19, (), {f"{model} error of T at -2.68": (value, 2e-3) for model, value in ERRORS.items()}),
    "bifurcation": Expected(
        6,
        ("P14",),
        {
            "delay LP 1": (-2.700251703, 2e-9),
            "delay NS 1": (-2.657545713, 2e-9),
            "delay NS 1 T": (78.263260, 2e-8),
            "kelvin-voigt PD 1": (-2.595727667, 2e-9),
            "kelvin-voigt PD 1 T": (78.994716174, 3e-10),
        },
    ),
    "snaking": Expected(
        13, (), {f"T at -2.66, orbit {n}": (T, 2e-9) for n, T in enumerate((77.46265115, 77.78897533, 78.08866464), 1)}
    ),
    "period-against-delay": Expected(6),
    "special-curves": Expected(3, (), {"delay LP at V = 100": (-2.7002517033, 2e-9)}),
    "period-doubling": Expected(5, (), {"T": (79.09, 1e-4)}),
    "laboratory": Expected(
        11, ("Gualandi", "Leeman"), {"ageing 14 MPa period, 6 samples": (9.4, 0.1), "rise time, drop 0.19 MPa": (18.89, 1e-3)}
    ),
    "claims": Expected(21, ("P11", "P12", "P5", "P6")),
    "regime-map": Expected(1, (), {f"{model} other regime, 17 x 9 points": near for model, near in REGIMES.items()}),
    "asymmetry-map": Expected(1),
    "manufactured": Expected(24),
    "slip-event": Expected(3, (), {"largest slip rate": (4412.3, 1e-3)}),
    "stability-boundaries": Expected(
        11, (), {"log10 r_c, quasistatic": (-2.698970004336, 1e-11), "error of (27) at V = 1e4": (-0.07672436, 1e-6)}
    ),
}


def held(name):
    """The study's quick run, which must be what is expected of it."""
    result, expected = quick(name), STUDIES[name]
    told = [(verdict.claim, verdict.outcome) for verdict in result.verdicts]
    assert [one for one in told if one[1] is Outcome.FAIL] == []
    assert sorted({title.split()[0] for title, outcome in told if outcome is Outcome.FINDING}) == sorted(expected.findings)
    assert len(told) == expected.verdicts
    assert too_roomy(result.verdicts) == []
    assert [o.what for o in result.omissions if re.search(r"\d", o.what + o.why) and not o.claims] == []
    for number, (value, tolerance) in expected.numbers.items():
        assert result.numbers[number].value == pytest.approx(value, rel=tolerance), number
    assert all(number.value == number.value for number in result.numbers.values())
    return result


ELSEWHERE = {"which-model", "period-against-delay", "slip-event", "claims"}
"""Studies that a test file of their own runs, once."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name.endswith("-map") or name in ("laboratory", "manufactured")))
        for name in STUDIES
        if name not in ELSEWHERE
    ],
)
def test_a_quick_run_holds_within_near_limits(name):
    held(name)

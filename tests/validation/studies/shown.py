"""A study's quick run, as the tests hold it: its progress, the scenes that it read, that each of its figures can be drawn, and
that counterfeit figures of a model turn it red."""

import itertools
import math

import numpy as np
import pytest
from counterfeit import green, tapes_of

from slipwave.input import source
from validation.chart.draw import draw, styled
from validation.measure.orders import ALMOST
from validation.models import stopwatch
from validation.report import Budget, Evidence, Verdict
from validation.report.names import by_claim
from validation.report.registered import study_called
from validation.report.sources import sources_of

ROOMY, ROUNDING = 30.0, 1e-10
"""A limit of more than this many times the measured size lets faults pass. Below `ROUNDING` machines may differ by more."""


def too_roomy(verdicts):
    """Claims whose limit lies more than `ROOMY` times above what was measured in the worst of its cases, and above rounding."""
    limited = [v for v in by_claim("", verdicts) if v.size is not None and v.limit is not None and not none_is_nearer(v)]
    roomy = [v for v in limited if v.limit > max(ROOMY * v.size, ROUNDING)]
    return [f"{v.claim}: {v.ours} ({v.remark}), {v.expected}" for v in roomy]


def none_is_nearer(verdict):
    """Whether the limit is that none of so many is missed, half of the last digit that a paper prints, or what an order of
    convergence may be off by, which chance can put on the declared one."""
    power = math.log10(2.0 * verdict.limit) if verdict.limit else 0.5
    printed = verdict.evidence is Evidence.PAPER and abs(power - round(power)) < 1e-9
    of_order = verdict.limit is not None and verdict.limit >= ALMOST and "order" in verdict.claim
    return printed or of_order or (verdict.size, verdict.limit) == (0.0, 1.0)


def quick(name):
    """A study's quick run by a clock of its own: the n-th reading is n^2 ms, so that run times are the same on every machine.

    The shares of its work that it reports on the way must rise to 1 at most, its figures must draw, and a verdict must fail for
    every counterfeit of `counterfeit.PLACES`.
    """
    shares, scenes, study, tapes = list[float](), set[str](), study_called(name), tapes_of(name)
    with pytest.MonkeyPatch.context() as patch:
        readings = itertools.count()
        patch.setattr(stopwatch, "processor_seconds", lambda: 1e-3 * next(readings) ** 2)
        patch.setattr(source, "load_tables", watched(source.load_tables, scenes))
        for tape in tapes:
            tape.record(patch)
        result = study.run(Budget(quick=True, report=shares.append))
    assert all(before < after for before, after in itertools.pairwise([0.0, *shares, 1.0 + 1e-9])), shares
    assert scenes <= {path.stem for path in sources_of(study) if path.suffix == ".toml"}
    with styled():
        for figure in result.figures:
            panels = draw(figure.draw()).axes
            curves = [np.asarray(line.get_ydata(), dtype=float) for panel in panels for line in panel.get_lines()]
            assert any(panel.get_xlabel() or panel.texts for panel in panels), figure.name
            assert all(np.isfinite(curve).any() for curve in curves if curve.size), figure.name
    assert list(green(study, tapes)) == []
    return result


def watched(read, scenes):
    """`read` (`slipwave.input.source.load_tables`), which notes the gallery scenes it is asked for in `scenes`."""

    def reading(name, *rest):
        scenes.update({str(name)} & set(source.gallery_names()))
        return read(name, *rest)

    return reading


def outcomes(found):
    """The outcomes of one verdict or of several, in words."""
    return " ".join(verdict.outcome.value for verdict in ([found] if isinstance(found, Verdict) else found))


def judged(found, expected):
    """Whether verdicts are as expected: their outcomes in words, or how many fail."""
    return (outcomes(found).split().count("fail") if isinstance(expected, int) else outcomes(found)) == expected

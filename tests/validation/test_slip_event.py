"""The picture of one slip event: its study passes, and its check of the characteristics can fail."""

from dataclasses import replace

from validation.report.drawing import styled
from validation.studies import slip_event
from validation.study import Budget, Outcome


def test_study_passes_and_draws():
    result = slip_event.run(Budget(quick=True))
    assert {verdict.outcome for verdict in result.verdicts} == {Outcome.PASS}
    assert 4400.0 < result.numbers["largest slip rate"].value < 4420.0
    with styled():
        assert len(result.figures[0].draw().axes) == 4


def test_characteristics_notice_a_wrong_wave_speed():
    field = slip_event._record(8).field
    stretched = replace(field, upper=replace(field.upper, depth=1.05 * field.upper.depth))
    assert slip_event.characteristics(field) < 1e-3
    assert slip_event.characteristics(stretched) > 1e-2

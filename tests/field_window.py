"""The fields of one window of a march."""

from fullwave.fields.record import INTERVAL, FieldRecord
from slipwave.solve import follow


def record_field(solver, start, end, interval=INTERVAL, observers=()):
    """March to `end` and keep the fields of a window; returns the record and the interface's state at `end`."""
    record = FieldRecord(solver, start, end, interval)
    final = follow(solver, end, observers, marks=[record])
    return record.field, final

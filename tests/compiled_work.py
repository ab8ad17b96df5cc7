"""What solvers hand to compiled code, counted: a measure of the work of a run that no busy machine can change."""

from typing import NamedTuple

import fullwave.finite_difference
import fullwave.lines.explicit
from fullwave.leapfrog import kernel
from fullwave.leapfrog.media import MarchedSlab
from fullwave.lines.system import SCALARS


class Call(NamedTuple):
    """One go of compiled code: how many steps it took, and of how many values."""

    steps: int
    values: int


def count_calls(monkeypatch):
    calls = []
    march, leapfrog = fullwave.lines.explicit._march_lines, fullwave.finite_difference.march_leapfrog

    def counted_march(*arguments):
        begin, end, values = arguments[4:7]
        calls.append(Call(end - begin, values[0].size - SCALARS))
        return march(*arguments)

    def counted_leapfrog(*arguments):
        *_, upper, lower, _, first, pieces = arguments
        media = [side.medium for side in (upper, lower) if isinstance(side, MarchedSlab)]
        steps = kernel.STEPS_PER_PIECE * pieces.time.size + (first < 0)
        calls.append(Call(steps, sum(medium.velocity.size + medium.stress.size for medium in media)))
        return leapfrog(*arguments)

    monkeypatch.setattr(fullwave.lines.explicit, "_march_lines", counted_march)
    monkeypatch.setattr(fullwave.finite_difference, "march_leapfrog", counted_leapfrog)
    return calls

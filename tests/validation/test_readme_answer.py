"""The README's answer, how far each reduction is from the wave physics, holds the numbers of the last accepted full report."""

import json
from pathlib import Path

from reduced.stability import analyse
from validation.registry.families import one_port_of
from validation.studies.which_model.measured import MODELS, SHORT, SHOWN, onset_of_damped
from validation.study.over_r import scene_at

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BASELINE = json.loads((ROOT / "reports" / "baseline" / "which-model.json").read_text(encoding="utf-8"))


def shown(error: float) -> str:
    """An error of a thousandth or more in per cent, a smaller one as a power of ten."""
    if abs(error) >= 1e-3:
        return f"{100 * error:+.1f} %"
    size, power = f"{error:+.0e}".split("e")
    return f"{size}e{int(power)}"


def cells(model: str) -> str:
    numbers = [BASELINE[f"{model} error of {what} at {log10_r}"]["value"] for log10_r in SHOWN for what in ("T", "drop")]
    return f"| `{model}` | {' | '.join(map(shown, numbers))} |"


def test_the_table_of_errors_is_that_of_the_report() -> None:
    table = README.split("## The answer")[1].split("## ")[0]
    rows = [line.rsplit("|", 3)[0] + "|" for line in table.splitlines() if line.startswith("| `")]
    assert rows[1:] == [cells(model) for model in MODELS]


def test_the_radii_are_those_of_the_scene() -> None:
    onset = analyse(scene_at(-2.68), one_port_of("delay")).log10_r_c
    assert onset is not None
    for log10_r in SHOWN:
        assert f"r = {10 ** (log10_r - onset):.2f} r<sub>c</sub>" in README
    low, high = SHORT
    damped = f"From {10 ** (onset_of_damped() - onset):.2f} r<sub>c</sub> on `quasidynamic` sticks and slips too"
    assert f"{damped}, with a period {100 * low:.0f} to {100 * high:.0f} % short" in README

"""`slipwave bench`: run time against error, every model that can do the scene, at several settings each."""

from typing import Any

import slipwave
from validation.commands.options import Json, Law, SceneName, Settings, Until, Yes, most_seconds
from validation.output import conclude, figures, print_json, print_table

EXAMPLES = ("slipwave bench paper --until 1000",)


def bench(
    source: SceneName, until: Until = None, settings: Settings = None, law: Law = None, yes: Yes = False, json: Json = False
) -> None:
    """Time every model against its error in period and stress drop; the reference is the delay system at a tight tolerance."""
    from validation.door.result import delivered

    result, failed, stopped = delivered(
        lambda: slipwave.bench(source, until=until, settings=settings or (), most_seconds=most_seconds(yes))
    )
    if json:
        print_json(result.summary)
    else:
        _print(result.summary)
    conclude(failed, [], stopped)


def _print(summary: dict[str, Any]) -> None:
    from validation.results.wording import errors_of, remarks

    heading = ["model", "setting", "wall s", "error T", "error drop"]
    table = [
        [
            row["model"],
            ", ".join(f"{name} {value:g}" for name, value in row["setting"].items()) or "-",
            figures(row["wall_s"], 3),
            *errors_of(row),
        ]
        for row in summary["models"]
    ]
    print_table(heading, table)
    against = f"relative errors of the second half's mean against {summary['reference']} (tight)"
    print(f"\n{summary['until']:g} transits; {against}")
    for line in remarks(summary):
        print(line)

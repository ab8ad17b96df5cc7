"""`slipwave schema`: the table of scene keys as a JSON Schema."""

import json

EXAMPLES = ("slipwave schema > scene.schema.json",)


def schema() -> None:
    """Print the JSON Schema of scene files, with which an editor completes and checks them."""
    from slipwave.input.schema import json_schema

    print(json.dumps(json_schema(), indent=2))

"""The command line: `slipwave`, or `python -m slipwave`."""

import sys
from importlib import import_module

from slipwave.rooms import hidden
from slipwave.threads import one_thread_unless_told


def main() -> int:
    """Run the command of the process; the exit status is 2 if a file of the user's own hides one of our packages."""
    line = hidden()
    if line:
        print(f"slipwave: {line}", file=sys.stderr)
        return 2
    one_thread_unless_told()
    return int(import_module("validation.cli").main())


if __name__ == "__main__":
    sys.exit(main())

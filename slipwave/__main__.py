"""The command line: `slipwave`, or `python -m slipwave`."""

import gc
import signal
import sys
from importlib import import_module

_OBJECTS_BEFORE_COLLECTION = 1_000_000
_INTERRUPTED = 130


def main() -> int:
    """Run the command of the process; the exit status is 2 if a file of the user hides one of our packages."""
    for name in {"SIGTERM", "SIGHUP"} & {*dir(signal)}:  # from `timeout`, a terminal that closes: as Ctrl-C, results are kept
        if signal.getsignal(getattr(signal, name)) is signal.SIG_DFL:
            signal.signal(getattr(signal, name), signal.default_int_handler)
    try:
        return _run()
    except KeyboardInterrupt:  # while the command line was still imported, as little as possible of it before this function
        print("slipwave: interrupted", file=sys.stderr)
        return _INTERRUPTED


def _run() -> int:
    from slipwave.hidden import hidden_package
    from slipwave.threads import one_thread_by_default

    line = hidden_package()
    if line:
        print(f"slipwave: {line}", file=sys.stderr)
        return 2
    one_thread_by_default()
    # the process is the command's own; collections at Python's rate would take a tenth of the time of compiling
    gc.set_threshold(_OBJECTS_BEFORE_COLLECTION)
    status = int(import_module("validation.commands.cli").main())
    gc.freeze()  # the process ends: its last collections would take a quarter of the time of a short run, and free what ends too
    return status


if __name__ == "__main__":
    sys.exit(main())

"""The command line in a process of its own, with something done to it when the solver has come to a given time."""

import signal
import subprocess
import sys

import pytest

_SCRIPT = """
import resource, signal, sys, time
from validation.run import progress

due, deed, size = float(sys.argv[1]), sys.argv[2], int(sys.argv[3])


def hooked(self, done):
    global due
    if done >= due:
        due = float("inf")
        if deed == "wait":
            print("waiting", file=sys.stderr, flush=True)
            while True:  # a signal that comes just before a pause without end would never be heard
                time.sleep(0.05)
        else:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


progress._Meter.__call__ = hooked
from validation.cli import main
sys.exit(main(sys.argv[4:]))
"""


def interrupted(words, at, folder, by=signal.SIGINT):
    """`slipwave words` in `folder`, interrupted (Ctrl-C), or stopped `by` another signal, once it has come to t = `at`."""
    process = subprocess.Popen(
        [sys.executable, "-c", _SCRIPT, str(at), "wait", "0", *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # may be ignored where tests are run
    )
    with process:
        assert process.stderr is not None
        said = []
        for line in process.stderr:
            said.append(line)
            if line == "waiting\n":
                process.send_signal(by)
                break
        else:
            pytest.fail("".join(said))
        out, err = process.communicate()
    return subprocess.CompletedProcess(words, process.returncode, out, err)


def on_small_disk(words, size, folder, at=0.0):
    """`slipwave words` in `folder`, where from t = `at` no file can become larger than `size` bytes."""
    script = [sys.executable, "-c", _SCRIPT, str(at), "limit", str(size), *words]
    return subprocess.run(script, cwd=folder, capture_output=True, text=True)

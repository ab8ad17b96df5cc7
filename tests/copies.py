"""Work in a copy of this process, which has imported and loaded everything already: it may be killed, interrupted or limited."""

import ctypes
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from concurrent.futures import ThreadPoolExecutor

from slipwave.__main__ import main as main_of_process
from validation.commands.cli import main
from validation.models import progress


def in_a_copy(work, heard=lambda line, copy: None):
    """How a copy ends and what it prints. `work` gives its exit status; `heard` gets each line of its stderr, and its number."""
    (printed, out), (said, err) = os.pipe(), os.pipe()
    copy = os.fork()
    if copy == 0:
        _end_with(work, out, err)
    os.close(out)
    os.close(err)
    with ThreadPoolExecutor(1) as reader, open(printed) as all_printed, open(said) as all_said:
        text, lines = reader.submit(all_printed.read), []
        for line in all_said:
            lines.append(line)
            heard(line, copy)
        status = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
        return subprocess.CompletedProcess([], status, text.result(), "".join(lines))


def _end_with(work, out, err):
    """Do the work with these ends of pipes as stdout and stderr; the copy ends here."""
    status = 1
    try:
        os.dup2(out, 1)
        os.dup2(err, 2)
        sys.stdout, sys.stderr = (os.fdopen(number, "w", buffering=1) for number in (1, 2))
        signal.signal(signal.SIGINT, signal.default_int_handler)  # may be ignored where tests are run
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        status = work()
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(status)


def _hooked(words, folder, at, deed):
    """`slipwave words` in `folder`, which does a deed once when its solver has come to t = `at`."""
    due = [deed]

    def hooked(meter, done):
        if done >= at and due:
            due.pop()()

    os.chdir(folder)
    progress._Meter.__call__ = hooked
    sys.argv = ["slipwave", *words]
    return main_of_process()


def interrupted(words, at, folder, by=signal.SIGINT):
    """`slipwave words` in `folder`, interrupted (Ctrl-C), or stopped `by` another signal, once it has come to t = `at`."""

    def wait():
        print("waiting", file=sys.stderr)
        while True:  # a signal that comes just before a pause without end would never be heard
            time.sleep(0.05)

    return in_a_copy(lambda: _hooked(words, folder, at, wait), lambda line, copy: line != "waiting\n" or os.kill(copy, by))


def interrupted_within_a_callback(words, at, folder):
    """As `interrupted`, but Ctrl-C falls into a callback of a library, which loses it, as numba's does where it loads code."""
    deed = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))
    return in_a_copy(lambda: _hooked(words, folder, at, deed))


def on_small_disk(words, size, folder):
    """`slipwave words` in `folder`, where no file can become larger than `size` bytes once the solver has begun."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return in_a_copy(lambda: _hooked(words, folder, 0.0, limit))


def killed(words, home, name, count):
    """`slipwave words`, killed as it calls the function `name` of the module or class `home` for the time `count`."""
    function, left = getattr(home, name), iter(range(count - 1))

    def mortal(*arguments):
        if next(left, None) is None:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(*arguments)

    def work():
        setattr(home, name, mortal)
        return main([*words])

    assert in_a_copy(work).returncode == -signal.SIGKILL

"""Synthetic studies for the tests of the report's machinery."""

import importlib
import math
import sys
import textwrap
import types

import slipwave.sources
from validation.chart import Chart, Look, Panel, Scale, Trace
from validation.report import (
    Evidence,
    Figure,
    Number,
    Omission,
    Outcome,
    StudyResult,
    Verdict,
    registered,
    sources,
    table,
)


def draw(height=1):
    bare = Scale(ticks={0.0: "0"})  # each tick takes time
    return Chart([Panel("", bare, bare, [Trace("curve", [0, 1], [0, height], Look("#1f77b4"))])], 2.0)


def answered(text="", verdicts=(), **parts):
    claims = dict.fromkeys(verdict.claim for verdict in verdicts)
    return StudyResult(
        {
            text: tuple(claims),
        },
        verdicts=tuple(verdicts),
        **parts,
    )


def result():
    return answered(
        "One <mode> is 6 · 10^{-4} off.",
        tables=(table("t", "Periods *T*.", "model | T [transits] .8g", (("delay", 73.4721449), ("x", math.nan))),),
        figures=(Figure("overlay", "One cycle.", draw, lead=True),),
        verdicts=(
            Verdict("T is right", Evidence.WITNESS, "73.47", "73.48", Outcome.PASS),
            Verdict("T is right", Evidence.PAPER, "73.5", "80", Outcome.FINDING),
            Verdict("T is printed", Evidence.PAPER, "73.5", "73.5", Outcome.PASS),
        ),
        notes=("Clock: transits.",),
        numbers={"T": Number(73.4721449, 1e-6), "void": Number(math.nan)},
        omissions=(Omission("P8", "needs continuation"),),
    )


class Fake:
    """Registers studies for one test and counts how often each runs."""

    def __init__(self, monkeypatch, tmp_path):
        self.patch, self.folder, self.runs = monkeypatch, tmp_path / "sources", []
        self.folder.mkdir()
        monkeypatch.setattr(registered, "STUDIES", {})

    def add(self, name, run=lambda budget: result()):
        module = types.ModuleType(f"validation.studies.{name}")
        source = self.folder / f"{name}.py"
        source.write_text(f"# {name}")
        module.NAME, module.QUESTION, module.SCENES, module.SECONDS = name, f"Does {name} work?", (), (1.0, 1.0)
        module.__file__ = str(source)

        def counted(budget):
            self.runs.append(name)
            return run(budget)

        module.run = counted
        self.patch.setitem(sys.modules, module.__name__, module)
        registered.STUDIES[name] = name
        return module

    def edit(self, module, text):
        """Put `text` at the end of a study's file, as a later process would find it."""
        with open(module.__file__, "a") as source:
            source.write(text)
        read_once = (slipwave.sources._read, slipwave.sources._imported_files, sources._words, sources._called)
        for function in read_once:  # by each process
            function.cache_clear()

    def write(self, name, body, timed=False):
        """A study in a file of its own, which other processes can import too; `body` is the text of `run`."""
        source = self.folder / f"written_{name}.py"
        lines = ["import os", "from pathlib import Path", "from validation.report import *", f"HERE = Path({str(self.folder)!r})"]
        lines += [f"NAME, QUESTION, SCENES, SECONDS, TIMED = {name!r}, 'Does {name} work?', (), (1.0, 1.0), {timed}"]
        source.write_text("\n".join([*lines, "def run(budget):", textwrap.indent(textwrap.dedent(body), "    ")]))
        self.patch.syspath_prepend(self.folder)
        sys.modules.pop(source.stem, None)  # an earlier test's
        module = importlib.import_module(source.stem)
        self.patch.setitem(sys.modules, f"validation.studies.{name}", module)
        registered.STUDIES[name] = name

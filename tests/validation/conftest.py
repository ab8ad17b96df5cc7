"""Fixtures: synthetic studies for the report's tests, and what the commands of `slipwave` say."""

import json
from functools import partial
from typing import ClassVar

import jinja2
import pytest
from fake_studies import Fake

from validation.commands.cli import INPUT_WRONG, main


class Compiled(jinja2.BytecodeCache):
    """Templates that this process has compiled already: a test writes many pages, a report one."""

    kept: ClassVar[dict[str, bytes]] = {}

    def load_bytecode(self, bucket):
        if bucket.key in self.kept:
            bucket.bytecode_from_string(self.kept[bucket.key])

    def dump_bytecode(self, bucket):
        self.kept[bucket.key] = bucket.bytecode_to_string()


@pytest.fixture
def fake(monkeypatch, tmp_path):
    """Synthetic studies instead of the report's, run in this process unless a test asks for several."""
    monkeypatch.setattr(jinja2, "Environment", partial(jinja2.Environment, bytecode_cache=Compiled()))
    monkeypatch.setattr("validation.report.build.cores", lambda: 1)
    return Fake(monkeypatch, tmp_path)


@pytest.fixture
def printed(capsys):
    def printed(*words):
        capsys.readouterr()
        assert main([*words]) == 0
        return capsys.readouterr().out

    return printed


@pytest.fixture
def answer(printed):
    return lambda *words: json.loads(printed(*words, "--json"))


@pytest.fixture
def refused(capsys):
    """What a command says on stderr: one line, beside notes and the model it chose; its status; nothing on stdout."""

    def refused(*words, status=INPUT_WRONG):
        capsys.readouterr()
        assert main([*words]) == status
        out, err = capsys.readouterr()
        assert out == ""
        *before, line = err.splitlines()
        assert status != INPUT_WRONG or all(one.startswith(("model auto: ", "note: ")) for one in before)
        assert line.startswith("slipwave: ")
        return line

    return refused

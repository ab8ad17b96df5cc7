"""What a file of the house imports, and digests that cover the program and not its comments."""

import pytest

from slipwave import sources
from slipwave.sources import ROOT, import_closure, program


def closure(file, packages=True):
    return {path.relative_to(ROOT).as_posix() for path in import_closure([ROOT / file], packages)}


def test_imports_are_followed_through_modules_packages_and_functions():
    found = closure("slipwave/friction/interface.py", packages=False)
    assert {
        "slipwave/friction/interface.py",
        "slipwave/compiled/functions.py",
        "slipwave/friction/__init__.py",
        "slipwave/friction/slip.py",
    } <= found
    assert "slipwave/friction/check.py" in found  # imported within `register`
    assert not found & {"slipwave/__init__.py", "slipwave/input/source.py", "slipwave/scene/scene.py"}


@pytest.mark.parametrize(
    ("other", "same"),
    [
        ('"""Other."""\n\n\n# a comment\ndef f(x):\n    """Told."""\n    return x + 1\n', True),
        ("def f(x):\n    return (x +\n            1)\n", True),
        ("def f(x):\n    return x + 2\n", False),
        ("def f(x):\n    return x - 1\n", False),
        ("def f(y):\n    return y + 1\n", False),
        ("def f(x=0):\n    return x + 1\n", False),
    ],
)
def test_a_digest_sees_the_program_only(other, same, tmp_path):
    texts = "def f(x):\n    return x + 1\n", other
    for number, text in enumerate(texts):
        (tmp_path / f"{number}.py").write_text(text)
    assert (program(tmp_path / "0.py") == program(tmp_path / "1.py")) is same


@pytest.mark.parametrize("room", ["slipwave", "reduced", "fullwave"])
def test_the_digest_of_the_solvers_sees_each_of_their_rooms(room, monkeypatch):
    digest = sources.source_digest.__wrapped__  # not the one that this process keeps
    before, read = digest(), sources.program
    edited = min((ROOT / room).rglob("*.py"))
    monkeypatch.setattr(sources, "program", lambda path: read(path) + "edited" * (path == edited))
    assert digest() != before

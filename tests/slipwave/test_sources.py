"""What a file of the house imports, and digests that cover the program and not its comments."""

import pickle

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


@pytest.fixture
def started_again(tmp_path, monkeypatch):
    """Forgets what this process has read, as at the start of another one; its files are kept in a folder of this test."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.setattr(sources, "_NEW", {})

    def forget():
        sources._read.cache_clear()
        sources._kept.cache_clear()

    forget()
    yield forget
    forget()


def test_a_text_is_parsed_once_for_all_processes_and_again_when_it_is_edited(started_again, tmp_path, monkeypatch):
    path, parsed, parse = tmp_path / "program.py", [], sources._parsed
    monkeypatch.setattr(sources, "_parsed", lambda content: parsed.append(content) or parse(content))
    texts = [b"import slipwave\n", b"import slipwave\n", b"import reduced\n", b"import slipwave\n"]
    for text in texts:
        path.write_bytes(text)
        assert sources.imported_names(path) == (text.split()[1].decode(),)
        sources._keep()
        started_again()
    assert parsed == [texts[0], texts[2]]


def test_a_damaged_file_of_what_was_parsed_is_replaced(started_again, tmp_path):
    path = tmp_path / "program.py"
    path.write_text("x = 1\n")
    whole = program(path)
    sources._keep()
    (kept,) = (tmp_path / "kept").iterdir()
    kept.write_bytes(kept.read_bytes()[:-20])
    started_again()
    assert program(path) == whole
    sources._keep()
    started_again()
    assert len(sources._kept()) == 1


def test_what_another_version_has_kept_is_parsed_again(started_again, tmp_path):
    path = tmp_path / "program.py"
    path.write_text("x = 1\n")
    whole = program(path)
    sources._keep()
    (kept,) = (tmp_path / "kept").iterdir()
    kept.write_bytes(pickle.dumps({key: tuple(one) for key, one in sources._kept().items()}))
    started_again()
    assert program(path) == whole

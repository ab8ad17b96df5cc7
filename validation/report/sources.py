"""What a study's result depends on beside the solver rooms: the files it imports, its scenes, and what it says it reads."""

import ast
from collections.abc import Iterator
from pathlib import Path

import validation
from validation.study import Study

_ROOM = Path(validation.__file__).parent
_GALLERY = _ROOM.parent / "scene" / "gallery"


def sources_of(study: Study) -> list[Path]:
    """Files, sorted: the study's own, all of this room that it imports (directly or not), the room's data, its scenes, and its
    optional `FILES` (folders stand for the Python files in them)."""
    own = Path(str(getattr(study, "__file__", __file__)))
    scenes = [path for name in study.SCENES if (path := _GALLERY / f"{name}.toml").exists()]
    return [*imported(own), *sorted(_ROOM.glob("*.json")), *scenes, *_read(getattr(study, "FILES", ()))]


def imported(start: Path) -> list[Path]:
    """`start` and every file of this room that it imports, sorted."""
    found, to_read = {start}, [start]
    while to_read:
        for name in _names(to_read.pop()):
            path = _ROOM.parent.joinpath(*name.split(".")).with_suffix(".py")
            if name.startswith("validation.") and path not in found and path.exists():
                found.add(path)
                to_read.append(path)
    return sorted(found)


def _names(path: Path) -> Iterator[str]:
    """Modules that a file imports anywhere in it; for `from a import b` both a and a.b."""
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names)


def _read(paths: tuple[Path, ...]) -> Iterator[Path]:
    for path in paths:
        yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]

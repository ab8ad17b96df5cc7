"""Families of models that a user declares in a Python file."""

import hashlib
import os
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from fullwave.families import FullWave
from reduced.families import REDUCTIONS
from slipwave.errors import SceneError
from slipwave.family import Family
from slipwave.friction import LAWS
from slipwave.friction.own import LAW_FILES, load_laws, own_law
from slipwave.packages import OwnFile, kept_if_wrong, own_file, run_file
from slipwave.solve import FieldSolver
from validation.models.by_name import FAMILIES, GRIDS, add_family, family_of

_OWN: dict[Path, list[Family]] = {}
_HOUSE = ("fullwave", "reduced")


def own_files() -> list[Path]:
    """The loaded files of families; processes that are started later load them too."""
    return list(_OWN)


def load_families(path: Path) -> list[Family]:
    """Run the Python file `path` and register every `Family` that it declares as a variable (docs/extending.md); returns them. A
    file that is loaded again replaces its families.

    Raises SceneError if the file cannot be run or declares none, for a name that is taken, and as `require_members`."""
    path, label = Path(os.path.realpath(path)), f"--family = {str(path)!r}"
    name = f"own_family_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    lists: tuple[list[Any], ...] = (FAMILIES, GRIDS, REDUCTIONS)
    with kept_if_wrong(name, *lists):
        module = run_file(path, name, label)
        from reduced.stability.characteristic import characteristic  # imported here to keep the start of runs fast
        from reduced.stability.spectrum import certified, spectrum

        for known_by_name in (characteristic, spectrum, certified):  # of the families before
            known_by_name.cache_clear()
        for known in lists:
            known[:] = [entry for entry in known if entry not in _OWN.get(path, [])]
        of_others = {id(family) for family in FAMILIES}
        declared = [value for value in vars(module).values() if isinstance(value, Family) and id(value) not in of_others]
        if not declared:
            hint = 'NAME = FullWave("name", f"{__name__}:Class", ...), see docs/extending.md'
            raise SceneError(f"{label}: declares no family of models: {hint}")
        for family in declared:
            _require_members(family, label)
            add_family(family, label)
    own_file(module)  # its digest is that of the text that was run
    _OWN[path] = declared
    return declared


def load_own(laws: Iterable[Path], families: Iterable[Path] = ()) -> None:
    """Load those of the user's files that this process has not loaded. Raises SceneError as `load_laws` and `load_families`."""
    for path in laws:
        if path not in LAW_FILES:
            load_laws(path)
    for path in families:
        if path not in _OWN:
            load_families(path)


def own_family(model: str) -> OwnFile | None:
    """The file of the family of `model`, if that is a user's own."""
    family = family_of(model)
    return None if family is None or family.module.partition(".")[0] in _HOUSE else own_file(import_module(family.module))


def digests(laws: Iterable[str], models: Iterable[str], measure: Callable[..., Any] | None = None) -> dict[str, str]:
    """Role and name -> digest, of the user's files among those of these laws, models and this measure: what they compute must not
    be mixed with what was computed before a change."""
    roles = [("law", own_law(name)) for name in laws] + [("family", own_family(name)) for name in models]
    roles.append(("measure", own_file(measure) if measure else None))
    return {f"{role} {own.path.name}": own.digest for role, own in roles if own}


def require_files(label: str, files: Mapping[str, str]) -> None:
    """Raises SceneError, which begins with `label`, unless the user's files with these `digests` are loaded as they were; a
    measure and a family may be absent."""
    loaded = digests(LAWS, [family.example for family in FAMILIES])
    for role, digest in files.items():
        kind, _, name = role.partition(" ")
        known = digest if digest in loaded.values() else loaded.get(role, "")
        if kind == "law" and not known:
            raise SceneError(f"{label}: needs the friction law of the file {name} (digest {digest}): give --law FILE.py")
        if known and known != digest:
            raise SceneError(f"{label}: was computed with another {role}: digest {digest}; that of --{kind} is {known}")


def _require_members(family: Family, label: str) -> None:
    """Raises SceneError, in one line, if the class or function that makes the members of `family` is missing or lacks a
    method."""
    text = f"{label}: family {family.name!r}"
    try:
        made = family.maker()
    except (ImportError, AttributeError, ValueError):
        hint = 'no such class or function; write f"{__name__}:Class"'
        raise SceneError(f"{text}: made_by = {family.made_by!r}: {hint}") from None
    if not isinstance(family, FullWave):
        return
    needed = {name for base in FieldSolver.__mro__ for name in vars(base) if not name.startswith("_")}
    needed = {name for name in needed if callable(getattr(FieldSolver, name))}  # others may be set when a member is made
    needed |= {name for base in getattr(made, "__mro__", ()) for name in getattr(base, "__abstractmethods__", ())}
    unfinished = getattr(made, "__abstractmethods__", ())
    absent = [name for name in sorted(needed) if name in unfinished or not callable(getattr(made, name, None))]
    if absent:
        raise SceneError(f"{text}: class {made.__name__} lacks the methods {', '.join(absent)}")
    if getattr(made, "family", family) is not family:
        raise SceneError(f"{text}: {made.__name__}.family is another one: it must be the variable that declares the family")

"""All that could change the result of a study: the files from which it is computed, and the packages that these import."""

import ast
import platform
import re
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import metadata
from pathlib import Path

import slipwave
import validation
from slipwave.friction import LAWS
from slipwave.friction.own import own_law
from slipwave.sources import ROOT, import_closure, imported_names, inside
from validation.chart import render as rendering
from validation.models import by_name
from validation.report import Study

_PACKAGE = Path(validation.__file__).parent
_GALLERY = _PACKAGE.parent / "slipwave" / "gallery"
_MODELS = Path(by_name.__file__)
_DRAWN_BY = Path(rendering.__file__)
"""The file that renders every study's figures."""
_SOLVERS = [ROOT.joinpath(*family.module.split(".")).with_suffix(".py") for family in by_name.FAMILIES]
"""Files that `models.by_name` imports by name: only its facts mention them, no import statement does."""

_COMMANDS = {name: place for name, place in slipwave._PLACES.items() if place.startswith("validation.")}
_PUBLIC = {name: ROOT.joinpath(*place.split(".")).with_suffix(".py") for name, place in _COMMANDS.items()}
"""Files of the public functions, which `slipwave` imports by name too."""

_READ = (".py", ".toml", ".json", ".csv")


def sources_of(study: Study) -> list[Path]:
    """The study's own file and its optional `FILES` (folders stand for their contents), all that these import from our packages
    or call of its public functions, the data of this package, and the gallery's scenes named in `SCENES` or in any of these
    programs of this package.

    A package's `__init__.py` counts where the package itself is imported: `validation.report.text` does not need all that the
    report's own entrance imports."""
    read = list(_read(getattr(study, "FILES", ())))
    own = Path(str(getattr(study, "__file__", __file__)))
    starts = [own, _DRAWN_BY, *(path for path in read if path.suffix == ".py")]
    programs = import_closure(starts, packages=False)
    starts += [_PUBLIC[name] for path in programs if path.is_relative_to(_PACKAGE) or path == own for name in _called(path)]
    programs = import_closure(starts, packages=False)
    if _MODELS in programs:
        programs = import_closure([*starts, *_SOLVERS], packages=False)
    words = set(study.SCENES).union(*(_words(path) for path in programs if path.is_relative_to(_PACKAGE) or path == own))
    scenes = [path for path in sorted(_GALLERY.glob("*.toml")) if path.stem in words]
    return [*programs, *(path for path in read if path.suffix != ".py"), *sorted(_PACKAGE.rglob("*.json")), *scenes]


def packages_of(files: Iterable[Path]) -> list[str]:
    """Python and the installed packages that `files` import, with their versions."""
    names = {name.partition(".")[0] for path in files if path.suffix == ".py" for name in imported_names(path)}
    packages = {package for name in names for package in _packages().get(name, ()) if package != "slipwave"}
    return [f"python {platform.python_version()}", *(f"{package} {metadata.version(package)}" for package in sorted(packages))]


def laws_of(files: Iterable[Path]) -> list[str]:
    """The loaded friction laws of the user's own that are named in a study's `files`, other than those of the solvers."""
    own = [name for name in LAWS if own_law(name)]
    texts = [path.read_text(encoding="utf-8") for path in files if own and (path.is_relative_to(_PACKAGE) or not inside(path))]
    return [name for name in own if any(name in text for text in texts)]


@cache
def _packages() -> dict[str, list[str]]:
    return dict(metadata.packages_distributions())


@cache
def _words(path: Path) -> frozenset[str]:
    """Strings in a program, as this process first read it."""
    tree = ast.walk(ast.parse(path.read_bytes()))
    return frozenset(node.value for node in tree if isinstance(node, ast.Constant) and isinstance(node.value, str))


@cache
def _called(path: Path) -> frozenset[str]:
    """The public functions that a program calls as attributes of `slipwave`, as `sw.run`."""
    return frozenset(_PUBLIC).intersection(re.findall(r"\b(?:sw|slipwave)\.(\w+)\(", path.read_text(encoding="utf-8")))


def _read(paths: Iterable[Path]) -> Iterator[Path]:
    for path in paths:
        files = path.rglob("*") if path.is_dir() else [path]
        yield from sorted(file for file in files if file.suffix in _READ and file.is_file())

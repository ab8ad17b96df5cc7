"""The key of a stored result: it changes with everything that the result depends on, and with nothing else."""

from importlib import metadata
from pathlib import Path

import pytest
from shown import READ, quick

from slipwave.sources import ROOT, import_closure, program
from validation.report import sources, store
from validation.studies import STUDIES, study_called

READ_BYTES = Path.read_bytes


def changes(monkeypatch, study, path):
    """Whether an edit of the file `path` changes the study's key."""
    before = store.study_key(study, False)
    with monkeypatch.context() as patch:
        patch.setattr(sources, "program", lambda file: "edited" if file == path else program(file))
        patch.setattr(Path, "read_bytes", lambda file: b"edited" if file == path else READ_BYTES(file))
        return store.study_key(study, False) != before


@pytest.mark.parametrize(
    ("path", "followed"),
    [
        ("slipwave/friction/ageing.py", True),
        ("slipwave/friction/__init__.py", True),
        ("slipwave/gallery/paper.toml", True),
        ("reduced/impedance/fit.py", True),
        ("fullwave/finite_element.py", True),
        ("validation/measure/settle.py", True),
        ("validation/references/published.json", True),
        ("validation/studies/claims/__init__.py", True),
        ("validation/cli.py", False),
        ("validation/report/page.py", False),
        ("validation/studies/energy/__init__.py", False),
        ("README.md", False),
    ],
)
def test_a_key_follows_each_file_of_each_room_that_the_study_uses(monkeypatch, path, followed):
    assert (ROOT / path).exists()
    assert changes(monkeypatch, study_called("claims"), ROOT / path) == followed


@pytest.mark.parametrize("name", STUDIES)
def test_all_that_a_study_imports_and_all_data_are_in_its_key(name):
    study = study_called(name)
    files = set(sources.sources_of(study))
    assert set(import_closure([Path(study.__file__)], packages=False)) <= files
    assert set((ROOT / "validation").rglob("*.json")) <= files
    assert {ROOT / "slipwave" / "gallery" / f"{scene}.toml" for scene in study.SCENES} <= files


def test_all_scenes_that_a_study_reads_are_in_its_key(monkeypatch):
    """`quick` demands it of every study."""
    quick("scene-facts")
    assert {"rock", "paper-si"} <= READ["scene-facts"]
    monkeypatch.setattr("shown.sources_of", lambda study: [path for path in sources.sources_of(study) if path.stem != "rock"])
    with pytest.raises(AssertionError):
        quick("scene-facts")


def test_a_key_follows_every_package_and_python(monkeypatch):
    study = study_called("claims")
    before = store.study_key(study, False)
    packages = [line.split()[0] for line in sources.packages_of(sources.sources_of(study))[1:]]
    assert {"numpy", "scipy", "numba", "llvmlite", "scikit-fem", "pydantic", "matplotlib"} <= set(packages)
    true = metadata.version
    for changed in packages:
        with monkeypatch.context() as patch:
            patch.setattr(sources.metadata, "version", lambda name, changed=changed: "0" if name == changed else true(name))
            assert store.study_key(study, False) != before, changed
    monkeypatch.setattr(sources.platform, "python_version", lambda: "3.0.0")
    assert store.study_key(study, False) != before


def test_a_key_follows_the_settings_and_the_format(monkeypatch):
    study = study_called("claims")
    assert store.study_key(study, False) == store.study_key(study, False) != store.study_key(study, True)
    before = store.study_key(study, False)
    monkeypatch.setattr(store, "_FORMAT", 0)
    assert store.study_key(study, False) != before


def test_a_key_follows_the_files_that_a_study_reads(fake, tmp_path):
    module = fake.add("first")
    module.FILES = (tmp_path, tmp_path / "missing")
    keys = set()
    for name, text in (("a.py", "x = 1"), ("b.toml", "x = 1"), ("b.toml", "x = 2"), ("c.json", "1")):
        (tmp_path / name).write_text(text)
        keys.add(store.study_key(module, False))
    assert len(keys) == 4


def test_a_key_follows_the_scenes_that_a_program_names(fake):
    module = fake.add("first")
    before = store.study_key(module, False)
    module.SCENES = ("rock",)
    declared = store.study_key(module, False)
    module.SCENES = ()
    fake.edit(module, "\nnamed = 'rock'")
    names = [path.stem for path in sources.sources_of(module) if path.suffix == ".toml"]
    assert names == ["rock"]
    assert declared != before

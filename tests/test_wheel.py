"""The installed package: complete, and independent of the files in the working folder."""

import subprocess

import pytest

from tests import wheel


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    return wheel.install(tmp_path_factory.mktemp("wheel"))


@pytest.fixture
def place(tmp_path):
    return wheel.working_folder(tmp_path)


@pytest.mark.parametrize("module", ["slipwave", "reduced.delay.system", "fullwave.adapt", "slipwave.observe"])
def test_no_file_of_the_user_is_imported(programs, place, module):
    where = wheel.use(programs, place, "python", "-c", f"import {module}; print({module}.__file__)")
    assert where.startswith(str(programs.parent))


def test_the_command_runs_beside_such_files(programs, place):
    assert "paper" in wheel.use(programs, place, "slipwave", "scenes")


def test_a_file_of_a_rooms_own_name_does_stop_it(programs, place):
    (place / "reduced.py").write_text("raise SystemExit('Python itself takes the nearest')\n")
    with pytest.raises(subprocess.CalledProcessError):
        wheel.use(programs, place, "python", "-c", "import reduced.delay.system")


def test_the_face_and_the_facts_are_light(programs, place):
    modules = "slipwave, reduced.families, fullwave.families"
    code = f"import sys, {modules}; slipwave.read; print(sorted({{'numba', 'numpy'}} & set(sys.modules)))"
    assert wheel.use(programs, place, "python", "-c", code).strip() == "[]"

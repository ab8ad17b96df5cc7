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


def test_no_file_of_the_user_is_imported(programs, place):
    modules = "slipwave, slipwave.observe, reduced.delay.system, fullwave.adapt"
    code = f"import {modules}; print(*(one.__file__ for one in ({modules})), sep='\\n')"
    found = wheel.use(programs, place, "python", "-c", code).splitlines()
    assert [path for path in found if not path.startswith(str(programs.parent))] == []


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

"""The package as a user has it: a wheel, installed into a fresh environment and used from a folder of the user's own.

    python -m tests.wheel [--quick-report]

Nothing is downloaded: the packages that slipwave needs are those of the environment that runs this.
"""

import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
USERS_FILES = ("scene.py", "drive.py", "validation.py", "friction.py", "observe.py", "families.py", "tests.py")
"""What may lie in the folder in which somebody works."""
COMMANDS = (
    "scenes",
    "run paper --until 40",
    "run unlike --model dg:3 --until 20 --out run.nc --fields last.vtu",
    "stability paper",
    "sweep paper --vary V=50,100 --measure stability --workers 2 --out map",
    "report --quick --only checks energy",
)


def install(folder):
    """Build the wheel, install it into an environment in `folder`, and return that environment's folder of programs."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    source = folder / "source"  # setuptools leaves a build folder beside what it builds
    files = subprocess.run(["git", "-C", ROOT, "ls-files", "-z"], capture_output=True, text=True, check=True).stdout
    for name in filter(None, files.split("\0")):
        if (ROOT / name).is_file() and not name.startswith(("tests/", "reports/")):
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    subprocess.run([*pip, "wheel", "--no-index", "--no-deps", "--no-build-isolation", "-w", folder, source], check=True)
    venv.create(folder / "fresh", with_pip=False)
    programs = folder / "fresh" / "bin"
    (wheel,) = folder.glob("*.whl")
    subprocess.run([*pip, "--python", programs / "python", "install", "--no-index", "--no-deps", wheel], check=True)
    site = Path(sysconfig.get_path("purelib", vars={"base": str(folder / "fresh")}))
    (site / "needed.pth").write_text(sysconfig.get_path("purelib") + "\n")  # its own .pth files, as of a checkout, are not read
    return programs


def use(programs, folder, *words):
    """What a program of the environment prints when it is started in `folder`; CalledProcessError if it fails."""
    free = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run(
        [programs / words[0], *words[1:]], cwd=folder, env=free, stdout=subprocess.PIPE, text=True, check=True
    ).stdout


def working_folder(folder):
    """A folder with files of a user's own, each of which would stop a program that imports it."""
    place = folder / "work"
    place.mkdir()
    for name in USERS_FILES:
        (place / name).write_text(f"raise SystemExit('{name} of the working folder was imported')\n")
    return place


def main(words):
    """Use every command of the installed package; exit status 1 at the first that fails."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        programs, place = install(folder), working_folder(folder)
        for command in (*COMMANDS, *(["report --quick"] if "--quick-report" in words else [])):
            print(f"slipwave {command}", flush=True)
            use(programs, place, "slipwave", *command.split())
        swept = json.loads(use(programs, place, "slipwave", "sweep", "map", "--gather", "--json"))
        assert (swept["done"], swept["failed"]) == (2, 0)
        report = json.loads((place / "reports" / "report.json").read_text(encoding="utf-8"))
        assert {study["name"] for study in report["studies"]} >= {"checks", "energy"}
        assert not [study["error"] for study in report["studies"] if study["error"]]
        print("the wheel does what the checkout does")


if __name__ == "__main__":
    main(sys.argv[1:])

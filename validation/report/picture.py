"""The picture on the README's front: the report's opening figure, small.

python -m validation.report.picture reports        # writes docs/one-cycle.png from the stored report
"""

import sys
from pathlib import Path

import validation
from slipwave.errors import SceneError

TARGET = Path(validation.__file__).resolve().parent.parent / "docs" / "one-cycle.png"
LARGEST = 200_000
"""Bytes that the repository is willing to carry for it."""


def readme_picture(out: Path, target: Path = TARGET) -> Path:
    """Copy the overlay of one cycle, as `slipwave report` stored it under `out`, to `target`.

    Raises SceneError if there is no stored overlay or if it is larger than LARGEST bytes.
    """
    source = out / "data" / "one-cycle" / "overlay.png"
    if not source.exists():
        raise SceneError(f"{source}: not there; run slipwave report --out {out} first")
    content = source.read_bytes()
    if len(content) > LARGEST:
        raise SceneError(f"{source}: {len(content)} bytes, more than {LARGEST}")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)
    return target


if __name__ == "__main__":
    print(readme_picture(Path(sys.argv[1])))

# ruff: noqa: I001
# what `import slipwave` offers, read by type checkers and by __init__.py; commands in the order of `slipwave --help`
from slipwave.errors import NumericsError as NumericsError
from slipwave.errors import SceneError as SceneError
from slipwave.input.assemble import read as read
from slipwave.input.assemble import read_scene as read_scene
from slipwave.scene import Scene as Scene
from validation.commands.run import run as run
from validation.commands.orbit import orbit as orbit
from validation.commands.branch import branch as branch
from validation.commands.curve import curve as curve
from validation.commands.stability import stability as stability
from validation.commands.compare import compare as compare
from validation.commands.bench import bench as bench
from validation.commands.fit import fit as fit
from validation.commands.sweep import sweep as sweep
from validation.commands.map import map as map
from validation.verification.command import verify as verify
from validation.commands.listing import scenes as scenes
from validation.commands.listing import show as show
from validation.commands.listing import models as models

_PLACES: dict[str, str]
__version__: str
__all__: list[str]

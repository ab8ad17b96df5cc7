from slipwave.errors import NumericsError as NumericsError
from slipwave.errors import SceneError as SceneError
from slipwave.input.assemble import read as read
from slipwave.input.assemble import read_scene as read_scene
from slipwave.scene import Scene as Scene
from validation.commands.bench import bench as bench
from validation.commands.branch import branch as branch
from validation.commands.compare import compare as compare
from validation.commands.curve import curve as curve
from validation.commands.fit import fit as fit
from validation.commands.listing import models as models
from validation.commands.listing import scenes as scenes
from validation.commands.listing import show as show
from validation.commands.map import map as map
from validation.commands.orbit import orbit as orbit
from validation.commands.run import run as run
from validation.commands.stability import stability as stability
from validation.commands.sweep import sweep as sweep
from validation.verification.command import verify as verify

_PLACES: dict[str, str]
__version__: str
__all__: list[str]

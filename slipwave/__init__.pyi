from slipwave.errors import NumericsError as NumericsError
from slipwave.errors import SceneError as SceneError
from slipwave.input import read as read
from slipwave.input import read_scene as read_scene
from validation.fit.command import fit as fit
from validation.results.bench import bench as bench
from validation.results.branch import branch as branch
from validation.results.compare import compare as compare
from validation.results.curve import curve as curve
from validation.results.listing import models as models
from validation.results.listing import scenes as scenes
from validation.results.listing import show as show
from validation.results.orbit import orbit as orbit
from validation.results.run import run as run
from validation.results.stability import stability as stability
from validation.sweep.command import sweep as sweep
from validation.sweep.map_command import map as map
from validation.verification.command import verify as verify

__version__: str
__all__: list[str]

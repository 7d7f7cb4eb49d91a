"""Public names of `rolling`, which `__init__.py` imports when they are first used."""

from rolling import check as check
from rolling import plot as plot
from rolling.contact import closed_forms as closed_forms
from rolling.contact.half_space import HalfSpace as HalfSpace
from rolling.contact.march import march as march
from rolling.contact.solver import ContactError as ContactError
from rolling.contact.solver import solve_contact as solve_contact
from rolling.interface import SweepError as SweepError
from rolling.interface import live as live
from rolling.interface import open_run as open_run
from rolling.interface import save_run as save_run
from rolling.interface import simulate as simulate
from rolling.interface import simulate_sweep as simulate_sweep
from rolling.scene.bodies import Plate as Plate
from rolling.scene.bodies import Sphere as Sphere
from rolling.scene.file import read_scene as read_scene
from rolling.scene.laws import SurfaceFault as SurfaceFault
from rolling.scene.messages import SceneError as SceneError
from rolling.scene.scene import Scene as Scene
from rolling.scene.sections import Dynamics as Dynamics
from rolling.scene.sections import Numerics as Numerics
from rolling.scene.sections import Recovery as Recovery
from rolling.scene.sections import Rolling as Rolling
from rolling.scene.sections import Sound as Sound
from rolling.scene.surfaces import BallHeightFile as BallHeightFile
from rolling.scene.surfaces import Gaussian as Gaussian
from rolling.scene.surfaces import GaussianBall as GaussianBall
from rolling.scene.surfaces import GradedBall as GradedBall
from rolling.scene.surfaces import HeightFile as HeightFile
from rolling.scene.surfaces import SelfAffine as SelfAffine
from rolling.scene.surfaces import Smooth as Smooth
from rolling.scene.surfaces import SmoothBall as SmoothBall
from rolling.surface.measured import HeightArray as HeightArray
from rolling.surface.parameters import surface_parameters as surface_parameters
from rolling.terminal.files import FolderError as FolderError

__version__: str

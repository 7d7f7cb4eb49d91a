"""Contact noise of a sphere that rolls over a rough surface.

A scene goes in; the released energy and its sound come out.

Public names are imported when they are first used, so `import rolling` and `rolling --help` are
instant.

Scenes
    read_scene, Scene and its sections Sphere, Plate, Gaussian, Smooth, HeightFile, Rolling,
    Numerics, Recovery, Dynamics, Sound; surfaces of the sphere GaussianBall, SmoothBall,
    GradedBall, BallHeightFile; SurfaceFault; check (module), SceneError
Runs
    simulate, simulate_sweep, open_run, save_run, plot (module), ContactError, SweepError,
    FolderError
Contact
    HalfSpace, solve_contact, march, closed_forms (module)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rolling import _own_acoustics

__version__ = "0.3.0"

if TYPE_CHECKING:  # for editors and mypy; at run time `__getattr__` imports
    from rolling import check, plot
    from rolling.contact import closed_forms
    from rolling.contact.half_space import HalfSpace
    from rolling.contact.march import march
    from rolling.contact.solver import ContactError, solve_contact
    from rolling.interface import SweepError, open_run, save_run, simulate, simulate_sweep
    from rolling.scene.balls import BallHeightFile, GaussianBall, GradedBall, SmoothBall
    from rolling.scene.bodies import Plate, Sphere
    from rolling.scene.faults import SurfaceFault
    from rolling.scene.file import read_scene
    from rolling.scene.messages import SceneError
    from rolling.scene.scene import Scene
    from rolling.scene.sections import Dynamics, Numerics, Recovery, Rolling, Sound
    from rolling.scene.surfaces import Gaussian, HeightFile, Smooth
    from rolling.terminal.files import FolderError

_SECTIONS, _SURFACES = "rolling.scene.sections", "rolling.scene.surfaces"
_BALLS, _BODIES = "rolling.scene.balls", "rolling.scene.bodies"
_RUNS = "rolling.interface"
_PLACES = {  # module and name in it; None stands for the module itself
    "read_scene": ("rolling.scene.file", "read_scene"),
    "Scene": ("rolling.scene.scene", "Scene"),
    "Sphere": (_BODIES, "Sphere"),
    "Plate": (_BODIES, "Plate"),
    "Gaussian": (_SURFACES, "Gaussian"),
    "Smooth": (_SURFACES, "Smooth"),
    "HeightFile": (_SURFACES, "HeightFile"),
    "GaussianBall": (_BALLS, "GaussianBall"),
    "SmoothBall": (_BALLS, "SmoothBall"),
    "GradedBall": (_BALLS, "GradedBall"),
    "BallHeightFile": (_BALLS, "BallHeightFile"),
    "SurfaceFault": ("rolling.scene.faults", "SurfaceFault"),
    "Rolling": (_SECTIONS, "Rolling"),
    "Numerics": (_SECTIONS, "Numerics"),
    "Recovery": (_SECTIONS, "Recovery"),
    "Dynamics": (_SECTIONS, "Dynamics"),
    "Sound": (_SECTIONS, "Sound"),
    "SceneError": ("rolling.scene.messages", "SceneError"),
    "check": ("rolling.check", None),
    "simulate": (_RUNS, "simulate"),
    "simulate_sweep": (_RUNS, "simulate_sweep"),
    "open_run": (_RUNS, "open_run"),
    "SweepError": (_RUNS, "SweepError"),
    "save_run": (_RUNS, "save_run"),
    "FolderError": ("rolling.terminal.files", "FolderError"),
    "plot": ("rolling.plot", None),
    "HalfSpace": ("rolling.contact.half_space", "HalfSpace"),
    "solve_contact": ("rolling.contact.solver", "solve_contact"),
    "ContactError": ("rolling.contact.solver", "ContactError"),
    "march": ("rolling.contact.march", "march"),
    "closed_forms": ("rolling.contact.closed_forms", None),
}

__all__ = [
    "BallHeightFile",
    "ContactError",
    "Dynamics",
    "FolderError",
    "Gaussian",
    "GaussianBall",
    "GradedBall",
    "HalfSpace",
    "HeightFile",
    "Numerics",
    "Plate",
    "Recovery",
    "Rolling",
    "Scene",
    "SceneError",
    "Smooth",
    "SmoothBall",
    "Sound",
    "Sphere",
    "SurfaceFault",
    "SweepError",
    "check",
    "closed_forms",
    "march",
    "open_run",
    "plot",
    "read_scene",
    "save_run",
    "simulate",
    "simulate_sweep",
    "solve_contact",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if message := _own_acoustics.fault():
        raise ImportError(message, name="acoustics")
    module, attribute = _PLACES[name]
    if not module.startswith("rolling.contact"):
        _bind_check()
    value = (
        import_module(module) if attribute is None else getattr(import_module(module), attribute)
    )
    globals()[name] = value
    return value


def _bind_check() -> None:
    """Give scenes the method `check`, whose module stands above theirs."""
    scene = import_module("rolling.scene.scene").Scene
    scene.check = import_module("rolling.check.findings").check_scene


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*__all__, "__version__"])

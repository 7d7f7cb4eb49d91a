"""Contact noise of a sphere that rolls over a rough surface.

A scene goes in; the released energy and its sound come out.

Public names are imported when they are first used, so `import rolling` and `rolling --help` are
instant.

Scenes
    read_scene, Scene and its sections Sphere, Plate, Gaussian, SelfAffine, Smooth, HeightFile,
    Rolling, Numerics, Recovery, Dynamics, Sound; surfaces of the sphere GaussianBall, SmoothBall,
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

__version__ = "0.4.0.dev0"

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
    from rolling.scene.surfaces import Gaussian, HeightFile, SelfAffine, Smooth
    from rolling.terminal.files import FolderError

_SUBMODULES = {"check": "check", "closed_forms": "contact.closed_forms", "plot": "plot"}
_MODULES = {
    "contact.half_space": ("HalfSpace",),
    "contact.march": ("march",),
    "contact.solver": ("ContactError", "solve_contact"),
    "interface": ("SweepError", "open_run", "save_run", "simulate", "simulate_sweep"),
    "scene.balls": ("BallHeightFile", "GaussianBall", "GradedBall", "SmoothBall"),
    "scene.bodies": ("Plate", "Sphere"),
    "scene.faults": ("SurfaceFault",),
    "scene.file": ("read_scene",),
    "scene.messages": ("SceneError",),
    "scene.scene": ("Scene",),
    "scene.sections": ("Dynamics", "Numerics", "Recovery", "Rolling", "Sound"),
    "scene.surfaces": ("Gaussian", "HeightFile", "SelfAffine", "Smooth"),
    "terminal.files": ("FolderError",),
}
_PLACES = _SUBMODULES | {name: module for module, names in _MODULES.items() for name in names}

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
    "SelfAffine",
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
    module = _PLACES[name]
    if not module.startswith("contact."):
        _bind_check()
    value = import_module(f"{__name__}.{module}")
    if name not in _SUBMODULES:
        value = getattr(value, name)
    globals()[name] = value
    return value


def _bind_check() -> None:
    """Give scenes the method `check`, whose module stands above theirs."""
    scene = import_module("rolling.scene.scene").Scene
    scene.check = import_module("rolling.check.findings").check_scene


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*__all__, "__version__"])

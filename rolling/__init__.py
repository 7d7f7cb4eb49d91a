"""Contact noise of a sphere that rolls over a rough surface.

A scene goes in; the released energy and its sound come out.

Public names are imported when they are first used, so `import rolling` and `rolling --help` are
instant. The stub `__init__.pyi` lists them.

Scenes
    read_scene, Scene and its sections Sphere, Plate, Gaussian, SelfAffine, Smooth, HeightFile,
    Rolling, Numerics, Recovery, Dynamics, Sound; HeightArray; surfaces of the sphere GaussianBall,
    SmoothBall, GradedBall, BallHeightFile; SurfaceFault; SoundChannel; check (module), SceneError;
    surface_parameters
Bearings
    BearingScene and its sections Bearing, BearingSurfaces, HousingPlate, BearingNumerics,
    BearingSound; BearingRun, BearingNumbers
Kinds
    register, Kind, March, MarchStore
Runs
    simulate, simulate_sweep, choose, sensitivities, coarsest_below, open_run,
    save_run, live, plot (module), ContactError, SweepError, FolderError
Objects that functions return
    Run, Runs, Choice, Difference, Sensitivities, Limit, ContactSound, Vibration, Channel,
    Listening; BearingChoice; Findings, Finding; Contact, ContactState
Contact
    HalfSpace, solve_contact, WarmStart, march, RollingContact, closed_forms (module)
"""

import ast
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from rolling import _own_acoustics

__version__ = "0.9.0.dev0"

_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_MODULES = {
    alias.name: node.module
    for node in _STUB.body
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
}

_SUBMODULES = ("check", "closed_forms", "plot")

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _MODULES:
        text = f"module {__name__!r} has no attribute {name!r}"
        # Python suggests the nearest name where it knows the module.
        raise AttributeError(text, name=name, obj=sys.modules[__name__])
    if message := _own_acoustics.fault():
        raise ImportError(message, name="acoustics")
    module = _MODULES[name]
    if not module.startswith("rolling.contact"):
        # Scenes get the method `check`, whose module stands above theirs.
        scene = import_module("rolling.scene.scene").Scene
        scene.check = import_module("rolling.check.findings").check_scene
        import_module("rolling.terminal.notebook").shorten_tracebacks(
            import_module("rolling.scene.messages").SceneError,
            import_module("rolling.terminal.files").FolderError,
            import_module("rolling.contact.solver").ContactError,
        )
        import_module("rolling.scene.bearing_scene").BearingScene.check = _check_bearing
    if name in _SUBMODULES:
        value = import_module(f"{module}.{name}")
    else:
        value = getattr(import_module(module), name)
    globals()[name] = value
    return value


def _check_bearing(scene: Any) -> Any:
    """Judge all runs of the scene of a bearing, as `bearing_check.check_bearing` does."""
    return import_module("rolling.bearing_contacts.bearing_check").check_bearing(scene)


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*__all__, "__version__"])

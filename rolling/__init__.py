"""Contact noise of a sphere that rolls over a rough surface.

A scene goes in; the released energy and its sound come out.

Public names are imported when they are first used, so `import rolling` and `rolling --help` are
instant. The stub `__init__.pyi` lists them for editors and type checkers.

Scenes
    read_scene, Scene and its sections Sphere, Plate, Gaussian, SelfAffine, Smooth, HeightFile,
    Rolling, Numerics, Recovery, Dynamics, Sound; HeightArray; surfaces of the sphere GaussianBall,
    SmoothBall, GradedBall, BallHeightFile; SurfaceFault; SoundChannel; check (module), SceneError;
    surface_parameters
Bearings
    BearingScene and its sections Bearing, BearingOil, BearingSurfaces, HousingPlate,
    BearingNumerics, BearingSound; BearingBall, Raceway, Roundness; BearingRun, BearingNumbers
Kinds
    register, PlainKind, PlainScene, March
Runs
    simulate, simulate_sweep, choose, sensitivities, coarsest_below, design, open_run,
    save_run, live, plot (module), ContactError, SweepError, FolderError
Objects that functions return
    Run, Runs, Choice, Difference, Sensitivities, Limit, Design, ContactSound, Vibration, Channel,
    Listening; Findings, Finding; Contact, ContactState
Contact
    HalfSpace, solve_contact, WarmStart, march, RollingContact, closed_forms (module)
"""

import sys
from importlib import import_module
from typing import Any

from rolling import _own_acoustics

__version__ = "0.13.0"

# Public names by the module that has them.
_NAMES = {
    "rolling.bearing_kind.bearing_run": ("BearingRun",),
    "rolling.plain_kind.plain_kind": ("PlainKind",),
    "rolling.check.finding": ("Finding",),
    "rolling.check.findings": ("Findings",),
    "rolling.choice.choice": ("Choice",),
    "rolling.choice.design": ("Design",),
    "rolling.choice.difference": ("Difference",),
    "rolling.choice.limit": ("Limit",),
    "rolling.choice.sensitivity": ("Sensitivities",),
    "rolling.contact.half_space": ("HalfSpace",),
    "rolling.contact.march": ("march",),
    "rolling.contact.single_contact": ("Contact", "WarmStart", "solve_contact"),
    "rolling.contact.solver": ("ContactError",),
    "rolling.contact.state": ("ContactState", "RollingContact"),
    "rolling.in_si.measured": ("HeightArray",),
    "rolling.interface.choices": ("choose", "coarsest_below", "design", "sensitivities"),
    "rolling.interface.runs": ("live", "open_run", "save_run", "simulate", "simulate_sweep"),
    "rolling.kinds.needed_marches": ("March",),
    "rolling.kinds.reading": ("read_scene",),
    "rolling.kinds.registry": ("register",),
    "rolling.numbers.ball_numbers": ("RunNumbers",),
    "rolling.numbers.bearing_numbers": ("BearingNumbers",),
    "rolling.numbers.doubt": ("Doubt",),
    "rolling.numbers.quantity": ("BandQuantity", "Quantity"),
    "rolling.results.channels": ("Channel",),
    "rolling.results.run_result": ("Run",),
    "rolling.run.sweep_runs": ("Runs", "SweepError"),
    "rolling.scene.bearing_scene": ("BearingScene",),
    "rolling.scene.bearing_sections": (
        "Bearing",
        "BearingNumerics",
        "BearingSound",
        "BearingOil",
        "BearingSurfaces",
        "HousingPlate",
    ),
    "rolling.scene.transducers": ("SoundChannel",),
    "rolling.scene.laws": ("SurfaceFault",),
    "rolling.scene.messages": ("SceneError",),
    "rolling.scene.raceways": ("BearingBall", "Raceway", "Roundness"),
    "rolling.scene.scene": ("Scene",),
    "rolling.scene.sections": (
        "Dynamics",
        "Numerics",
        "Plate",
        "Recovery",
        "Rolling",
        "Sound",
        "Sphere",
    ),
    "rolling.scene.surfaces": (
        "BallHeightFile",
        "Gaussian",
        "GaussianBall",
        "GradedBall",
        "HeightFile",
        "SelfAffine",
        "Smooth",
        "SmoothBall",
    ),
    "rolling.scene.swept": ("PlainScene",),
    "rolling.sound.contact_sound": ("ContactSound",),
    "rolling.sound.long_listening": ("Listening",),
    "rolling.sound.vibration_sound": ("Vibration",),
    "rolling.surface.parameters": ("surface_parameters",),
    "rolling.terminal.whole_files": ("FolderError",),
}
_SUBMODULES = {
    "check": "rolling.check",
    "plot": "rolling.plot",
    "closed_forms": "rolling.contact.closed_forms",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}

__all__ = sorted([*_HOMES, *_SUBMODULES])


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _HOMES and name not in _SUBMODULES:
        text = f"module {__name__!r} has no attribute {name!r}"
        # Python suggests the nearest name where it knows the module.
        raise AttributeError(text, name=name, obj=sys.modules[__name__])
    if message := _own_acoustics.foreign_package():
        raise ImportError(message, name="acoustics")
    if name in _SUBMODULES:
        value = import_module(_SUBMODULES[name])
    else:
        value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return sorted([*__all__, "__version__"])

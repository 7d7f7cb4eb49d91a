"""Conditions of a ball on a plate in words, from its scene alone."""

from __future__ import annotations

from acoustics.numbers import bracketed, rounded
from rolling.numbers.conditions import Condition, Method
from rolling.report.assumed import surface_words
from rolling.results.description import plate_size, values_text
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT
from rolling.scene.surfaces import HeightFile, Instrument
from rolling.surface.step_words import filter_words, form_words

CLOSED = {
    "blend": "each end faded into its beginning",
    "mirror": "continued backwards at its ends",
    "none": "taken as one period",
}


def conditions(scene: Scene) -> list[Condition]:
    """Return the conditions of a scene: ball, plate, load, motion, listener and surfaces."""
    listed = [
        Condition("ball", _ball(scene)),
        Condition("plate", _plate(scene)),
        Condition("load", _load(scene)),
        Condition("speed", _speed(scene)),
        Condition("track", f"{rounded(1e3 * scene.track.distance, 4)} mm", leads=False),
        Condition("listener", _listener(scene)),
        Condition("surface", surface_words(scene), leads=False),
    ]
    if isinstance(scene.surface, HeightFile):
        words = preparation_words(scene.surface, 1e6 * scene.track.spacing)
        listed.append(Condition("preparation", words, leads=False))
    return listed


def preparation_words(surface: HeightFile, spacing_um: float) -> str:
    """Say how the heights of a file are prepared, step by step, and how far its nodes are apart.

    The steps have the names of ISO 25178-2, and the filters those of ISO 16610.
    """
    steps = []
    if surface.outliers is not None:
        steps.append(f"nodes beyond {surface.outliers:g} robust standard deviations replaced")
    if surface.unmeasured == "fill":
        steps.append("unmeasured points filled from around them")
    if surface.s_filter_um is not None:
        steps.append(f"S-filter ({filter_words(1e-6 * surface.s_filter_um)})")
    steps.append(f"F-operation ({_form(surface.level, surface.made_periodic)})")
    if surface.l_filter_um is not None:
        is_robust = surface.l_filter == "robust"
        steps.append(f"L-filter ({filter_words(1e-6 * surface.l_filter_um, is_robust)})")
    steps.append(CLOSED[surface.made_periodic])
    steps.append(f"nodes {rounded(spacing_um, 4)} µm apart")
    if surface.along == "x":
        steps.append("the track along x")
    if surface.instrument is not None:
        steps.append(_instrument(surface.instrument))
    return ", ".join(steps)


def _form(level: str, closed: str) -> str:
    """Name the form that is removed."""
    if level == "auto" and closed == "none":
        return f"{form_words(level)} if that lowers the step at the seam"
    return form_words(level)


def _instrument(instrument: Instrument) -> str:
    """Write what is stated of the instrument."""
    stated = []
    if instrument.tip_radius_um is not None:
        stated.append(f"tip radius {instrument.tip_radius_um:g} µm")
    if instrument.sampling_um is not None:
        stated.append(f"lateral period limit {2 * instrument.sampling_um:g} µm")
    if instrument.noise_nm is not None:
        stated.append(f"noise {instrument.noise_nm:g} nm rms")
    return f"instrument ({', '.join(stated)})"


def method(scene: Scene) -> Method:
    """Return how the vibration of ball and plate is computed."""
    moves = "fell onto" if scene.rolling.falls else "rolled over"
    motion = "followed in time"
    if scene.dynamics is None:
        motion = "estimated by a linear chain"
    return Method(
        motion=f"A ball {moves} a dry plate in a simulation.",
        computed=(
            "The contact of the rough surfaces was solved as an elastic half-space at each step of"
            f" the track, and the motion of ball and plate over it was {motion}. Their sound is"
            f" that in a free field at the listener, A-weighted.{_standards(scene)}"
        ),
    )


def _standards(scene: Scene) -> str:
    """Name the standards of the preparation of a scan; empty where none was read."""
    surface = scene.surface
    if not isinstance(surface, HeightFile):
        return ""
    terms = "ISO 25178-2" if surface.width_um is None else "ISO 21920-2"
    words = f" Measured heights were prepared in the order of ISO 25178-3, in the terms of {terms}"
    parts = []
    if surface.s_filter_um is not None or surface.l_filter_um is not None:
        parts.append("ISO 16610-61")
    if surface.l_filter == "robust":
        parts = [*parts, "ISO 16610-71"] if surface.s_filter_um is not None else ["ISO 16610-71"]
    return f"{words}, with filters of {' and '.join(parts)}." if parts else f"{words}."


def _ball(scene: Scene) -> str:
    """Write radius and material of the ball."""
    sphere = scene.sphere
    radius = f"R {sphere.radius_mm:g} mm"
    if sphere.radius_across_mm:
        radius = f"R {sphere.radius_mm:g} mm along, {sphere.radius_across_mm:g} mm across"
    return f"{radius}, {sphere.material or _elastic(sphere.youngs_modulus_gpa)}"


def _plate(scene: Scene) -> str:
    """Write material and size of the plate."""
    plate = scene.plate
    size = plate_size(plate)
    if plate.edges_mm is None and size:
        size = f"infinite, {size} thick"
    return f"{plate.material or _elastic(plate.youngs_modulus_gpa)}, {size or 'half-space'}"


def _elastic(youngs_modulus_gpa: float | None) -> str:
    """Write Young's modulus of a body without the name of a material."""
    return "rigid" if youngs_modulus_gpa is None else f"{youngs_modulus_gpa:g} GPa"


def _load(scene: Scene) -> str:
    """Write the load."""
    words = f"{rounded(scene.load, 4)} N"
    return f"{words}, the weight of the ball" if scene.rolling.load_n == WEIGHT else words


def _speed(scene: Scene) -> str:
    """Write the speed, or its ends where it changes, and the height of a fall."""
    slowest = scene.motion.slowest(scene.duration)
    fastest = scene.motion.fastest(scene.duration)
    words = f"{values_text([fastest])} m/s"
    if not scene.motion.is_constant(scene.duration):
        words = f"{rounded(slowest, 3)} to {words}"
    if scene.rolling.drop_mm is not None:
        words += f", after a fall of {scene.rolling.drop_mm:g} mm"
    return words


def _listener(scene: Scene) -> str:
    """Say where the listener is."""
    listeners = scene.sound.listener_mm
    if listeners is None:
        return f"{scene.sound.distance_m:g} m from the contact"
    places = "; ".join(bracketed(place) for place in _places(listeners))
    return f"at {places} mm from the corner of the plate"


def _places(listeners: object) -> list[tuple[float, ...]]:
    """Return the places of one listener or of several."""
    assert isinstance(listeners, tuple | list)
    if isinstance(listeners[0], tuple | list):
        return [tuple(place) for place in listeners]
    return [tuple(listeners)]

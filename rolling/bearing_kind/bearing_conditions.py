"""Conditions of a bearing in words, from its scene alone."""

from __future__ import annotations

from typing import Any

from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.bearing_kind.bearing_sentences import loads_words
from rolling.numbers.conditions import Condition, Method
from rolling.results.description import faults_in_words, plate_material, plate_size
from rolling.scene.bearing_scene import BearingScene


def conditions(scene: BearingScene) -> list[Condition]:
    """Return the conditions of a scene: bearing, speed, load, oil, sensor and surfaces."""
    bearing = scene.bearing
    listed = []
    if bearing.named:
        listed.append(Condition("bearing", printable(bearing.named)))
    listed += [
        Condition("geometry", _geometry(scene), leads=not bearing.named),
        Condition("load", loads_words(scene)),
        Condition(
            "speed", f"{rounded(bearing.speed_rpm, 4)} rpm, the {bearing.turning} ring turns"
        ),
        Condition("oil", _oil(scene)),
        Condition("sensor", _sensor(scene), leads=False),
    ]
    for name in ("balls", "inner", "outer"):
        words = _surface(getattr(bearing.surfaces, name))
        body = name if name == "balls" else f"{name} raceway"
        listed.append(Condition(body, words, leads=False))
    if scene.plate is not None:
        plate = f"{plate_material(scene.plate)} {plate_size(scene.plate)}".strip()
        listed.append(Condition("housing plate", plate, leads=False))
    return listed


def method(scene: BearingScene) -> Method:
    """Return how the velocity of the ring is computed."""
    ring = "inner" if scene.bearing.turning == "outer" else "outer"
    return Method(
        motion="A ball bearing turned in a simulation.",
        computed=(
            "The rough contacts of balls and raceways were solved as elastic half-spaces along"
            f" their tracks, and the {ring} ring, which does not turn, moved over all of them in"
            " time."
        ),
    )


def _geometry(scene: BearingScene) -> str:
    """Write number, size and circle of the balls."""
    bearing = scene.bearing
    return (
        f"{bearing.balls} balls of {bearing.ball_diameter_mm:g} mm on a circle of"
        f" {bearing.pitch_diameter_mm:g} mm"
    )


def _oil(scene: BearingScene) -> str:
    """Write viscosity and temperature of the oil."""
    oil = scene.bearing.oil
    if oil is None:
        return "dry"
    return f"{oil.viscosity_40_mm2_s:g} mm²/s at 40 °C, contacts at {oil.temperature_c:g} °C"


def _sensor(scene: BearingScene) -> str:
    """Say where the motion of the ring is seen."""
    given = scene.bearing.sensor_deg
    if given is None:
        return "on the ring that does not turn, mean over all places by power"
    return f"on the ring that does not turn, {given:g}° from the middle of the load zone"


def _surface(surface: Any) -> str:
    """Describe the surface of balls or of a raceway."""
    if surface is None:
        return "smooth"
    parts = []
    grade = getattr(surface, "grade", None)
    path = getattr(surface, "path", None)
    law = getattr(surface, "law", None)
    if grade is not None:
        parts.append(f"grade {grade}")
    if path is not None:
        parts.append(f"heights of {printable(path)}")
    if law is not None:
        parts.append(law.words)
    if getattr(surface, "waviness", None):
        parts.append("wavy")
    if surface.faults:
        parts.append(f"with {faults_in_words(surface.faults)}")
    return ", ".join(parts) or "smooth"

"""The drawing of a bearing with its numbers on it: rings and balls in their true proportions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from acoustics.numbers import rounded
from rolling.bearing_kind.solved_bearing import faulty_bodies
from rolling.kinds.machine import (
    PICTURE,
    Machine,
    Place,
    arc,
    around,
    arrow,
    box,
    circle,
    head,
    line,
    listener,
    square,
)
from rolling.results.description import (
    faults_in_words,
    listed,
    plate_material,
    plate_size,
    values_text,
)
from rolling.scene.bearing_scene import BearingScene
from rolling.surface.single_faults import fault_places

OUTER = 86.0  # radius of the drawn outer ring
CENTRE = (96.0, 100.0)
DOWN = math.pi / 2  # where the middle of the load zone is
EAR = (184.0, 14.0)
PLATE = 12.0  # thickness of a drawn housing plate
_AXIAL = 6.0  # radius of the sign of an axial load, an arrow that is seen from behind
MAX_MARKS = 24  # of equal faults
_BEARING = 1e-6  # of the largest load, from which on a ball is said to carry


def bearing_machine(scenes: Sequence[BearingScene]) -> Machine:
    """Return the drawing of a bearing.

    Parameters
    ----------
    scenes : sequence of BearingScene, at least one. The first is drawn; numbers that differ are
        listed.
    """
    scene = scenes[0]
    machine = Machine(title="A ball bearing, seen along its axis", height=CENTRE[1] + OUTER + 8)
    scale = OUTER / (scene.outside_diameter / 2)
    if scene.plate is not None:
        _draw_housing(machine, scenes)
    _draw_rings(machine, scenes, scale)
    _draw_balls(machine, scenes, scale)
    _draw_loads(machine, scenes, scale)
    _draw_speed(machine, scenes, scale)
    _draw_faults(machine, scene, scale)
    if scene.plate is None:
        _draw_sensor(machine, scene, scale)
    return machine


def _draw_rings(machine: Machine, scenes: Sequence[BearingScene], scale: float) -> None:
    """Draw both rings with their dimensions and the roughness of their raceways."""
    scene = scenes[0]
    geometry = scene.geometry
    outer = scale * geometry.outer.radius_m
    inner = scale * geometry.inner.radius_m
    bore = scale * scene.bore / 2
    machine.draw("body", circle(CENTRE, OUTER), circle(CENTRE, outer))
    machine.draw("body", circle(CENTRE, inner), circle(CENTRE, bore))
    machine.draw("path", circle(CENTRE, scale * geometry.pitch_radius_m))
    diameters = (1e3 * scene.outside_diameter, 1e3 * scene.bore, 1e3 * scene.width)
    sizes = " x ".join(rounded(size_mm, 4) for size_mm in diameters)
    name = f"{scene.bearing.named}: " if scene.bearing.named else ""
    place = around(CENTRE, (OUTER + outer) / 2, -0.9)
    machine.say(place, f"{sizes} mm", f"{name}outside, bore, width")
    raceways = {ring: _surface_words(scenes, ring) for ring in ("outer", "inner")}
    if raceways["outer"] == raceways["inner"]:
        machine.say(around(CENTRE, outer, -0.35), raceways["outer"], "both raceways")
        return
    machine.say(around(CENTRE, outer, -0.35), raceways["outer"], "outer raceway")
    machine.say(around(CENTRE, inner, 0.35), raceways["inner"], "inner raceway")


def _draw_balls(machine: Machine, scenes: Sequence[BearingScene], scale: float) -> None:
    """Draw the balls, each with a shade by its load at rest, and say what the largest bears."""
    scene = scenes[0]
    loads = scene.model.balance().ball_load_n  # with a ball in the middle of the load zone
    largest = float(loads.max())
    pitch = scale * scene.geometry.pitch_radius_m
    radius = scale * scene.ball_radius
    for angle, load in zip(scene.geometry.ball_angles(), loads, strict=True):
        at = around(CENTRE, pitch, DOWN - float(angle))
        machine.draw("load", circle(at, radius), share=float(load) / largest)
    diameters = listed(dict.fromkeys(f"{item.bearing.ball_diameter_mm:g}" for item in scenes))
    balls = values_text([item.bearing.balls for item in scenes])
    words = _surface_words(scenes, "balls") or "smooth"
    machine.say(_nearest_ball(scene, pitch, 0.0), f"{balls} balls of {diameters} mm", words)
    carrying = int((loads > _BEARING * largest).sum())
    words = f"most loaded of {carrying} balls" if carrying > 1 else "the one loaded ball"
    if len(scenes) > 1:
        words += ", in the first run"
    machine.say(_nearest_ball(scene, pitch, DOWN - 0.1), f"{rounded(largest, 3)} N", words)


def _nearest_ball(scene: BearingScene, pitch: float, direction: float) -> Place:
    """Return the centre of the ball that is the nearest one in a direction [rad]."""
    wanted = around(CENTRE, pitch, direction)
    places = [around(CENTRE, pitch, DOWN - float(a)) for a in scene.geometry.ball_angles()]
    return min(places, key=lambda place: math.dist(place, wanted))


def _surface_words(scenes: Sequence[BearingScene], body: str) -> str:
    """Write the roughness of a body, or its grade, as the scenes give it."""
    texts = []
    for scene in scenes:
        surface: Any = getattr(scene.bearing.surfaces, body)
        text = "smooth"
        if getattr(surface, "grade", None) is not None:
            text = f"grade {surface.grade}"
        elif getattr(surface, "path", None) is not None:
            text = "measured"
        elif getattr(surface, "finish", None) is not None:
            text = surface.finish
        elif getattr(surface, "wave_amplitude_um", None) is not None:
            text = f"Ra {surface.roughness_ra_um:g} µm"
        elif surface is not None and surface.law is not None:
            text = f"Ra {surface.law.roughness_ra_um:g} µm"
        waves = getattr(surface, "waviness", None)
        if waves:
            text = _wave_words(waves) if text == "smooth" else f"{text}, {_wave_words(waves)}"
        texts.append(text)
    return listed(dict.fromkeys(texts))


def _wave_words(waves: Mapping[int, float]) -> str:
    """Write the waves of a body: one with its order and height, several by their number."""
    if len(waves) > 1:
        return f"{len(waves)} orders of waves"
    ((order, height_um),) = waves.items()
    return f"{order} waves of {height_um:g} µm"


def _draw_loads(machine: Machine, scenes: Sequence[BearingScene], scale: float) -> None:
    """Draw radial and axial load; the radial one points to the middle of the load zone."""
    x, y = CENTRE
    bore = scale * scenes[0].bore / 2
    radial = values_text([scene.bearing.radial_load_n for scene in scenes])
    axial = values_text([scene.bearing.axial_load_n for scene in scenes])
    has_radial = any(scene.bearing.radial_load_n for scene in scenes)
    up = min(0.45 * bore, 16.0) if has_radial else 0.0
    if has_radial:
        machine.draw("arrow", arrow((x, y), (x, y + bore - 2)))
        machine.say((x, y + 0.6 * bore), f"{radial} N", "radial load")
    if any(scene.bearing.axial_load_n for scene in scenes):
        middle = (x, y - up)
        reach = _AXIAL / math.sqrt(2)
        machine.draw("arrow", circle(middle, _AXIAL))
        for turn in (-1, 1):
            first = (middle[0] - reach, middle[1] - turn * reach)
            machine.draw("arrow", line(first, (middle[0] + reach, middle[1] + turn * reach)))
        machine.say((x + _AXIAL, y - up), f"{axial} N", "axial load")


def _draw_speed(machine: Machine, scenes: Sequence[BearingScene], scale: float) -> None:
    """Draw which ring turns, and how fast."""
    turning = scenes[0].bearing.turning
    radius = OUTER + 6
    if turning == "inner":
        radius = scale * (scenes[0].bore / 2 + scenes[0].geometry.inner.radius_m) / 2
    first, last = -2.6, -1.3
    machine.draw("arrow", arc(CENTRE, radius, last, first))
    machine.draw("arrow", head(around(CENTRE, radius, first), first - math.pi / 2))
    rpm = sorted({scene.bearing.speed_rpm for scene in scenes})
    ends = dict.fromkeys((rpm[0], rpm[-1]))
    speeds = (" to " if len(rpm) > len(ends) else " and ").join(map(_thousands, ends))
    machine.say(around(CENTRE, radius, last), f"{speeds} rpm", f"{turning} ring turns")


def _thousands(rpm: float) -> str:
    """Write a speed with a comma between thousands."""
    return f"{rpm:,.0f}" if rpm >= 100 else f"{rpm:g}"


def _draw_faults(machine: Machine, scene: BearingScene, scale: float) -> None:
    """Draw the faults of raceways and balls where they are at the start."""
    geometry = scene.geometry
    pitch = scale * geometry.pitch_radius_m
    for body in faulty_bodies(scene):
        centre, radius, words = CENTRE, 0.0, f"{body} raceway"
        if body == "balls":
            angle = float(geometry.ball_angles()[scene.bearing.surfaces.fault_ball])
            centre = around(CENTRE, pitch, DOWN - angle)
            radius, words = scale * scene.ball_radius, "in a ball"
        else:
            radius = scale * getattr(geometry, body).radius_m
        faults = getattr(scene.bearing.surfaces, body).faults
        places = []
        for fault in faults:
            turn_m = scene.circumferences[body]
            for along_m, _ in fault_places(fault.in_si, turn_m, 0.0)[:MAX_MARKS]:
                angle = 2 * math.pi * along_m / turn_m
                places.append(around(centre, radius, DOWN - angle))
        for place in places:
            machine.draw("fault", circle(place, 4.0))
        machine.say(places[0], faults_in_words(faults), words)


def _draw_sensor(machine: Machine, scene: BearingScene, scale: float) -> None:
    """Draw what measures the velocity of the ring that does not turn.

    It stands opposite the middle of the load zone, where the scene does not give its angle.
    """
    radius = OUTER + 5 if scene.moving_ring == "outer" else scale * scene.bore / 2 - 5
    at = around(CENTRE, radius, DOWN - (math.pi if scene.sensor is None else scene.sensor))
    machine.draw("sensor", square(at, 5.0))
    machine.say((at[0] + 5, at[1]), "velocity", f"{scene.moving_ring} ring")


def _draw_housing(machine: Machine, scenes: Sequence[BearingScene]) -> None:
    """Draw the plate that the outside of a bearing shakes, and who hears it."""
    top = CENTRE[1] + OUTER
    machine.height = top + PLATE + 6
    machine.draw("ground", box(0.0, top, PICTURE, top + PLATE))
    machine.draw("edge", box(1.0, top, PICTURE - 1, top + PLATE))
    machine.draw("path", line((CENTRE[0], top), (EAR[0] - 5, EAR[1] + 10)))
    machine.draw("thin", *listener(EAR))
    distances = values_text([scene.sound.distance_m for scene in scenes])
    machine.say((EAR[0] + 4, EAR[1] + 2), f"{distances} m", "listener")
    plates = [scene.plate for scene in scenes if scene.plate is not None]
    sizes = listed(dict.fromkeys(plate_size(plate) for plate in plates))
    materials = listed(dict.fromkeys(plate_material(plate) for plate in plates))
    words = " ".join(f"{materials} plate of the housing".split())
    machine.say((PICTURE - 14, top + PLATE / 2), sizes, words)

"""The drawing of a ball on a plate with its numbers on it, as it rolls or falls.

Sizes are not to scale, but the thickness of a plate is drawn over the radius of the ball, and a
plate with edges is seen from above in its proportions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from acoustics.numbers import bracketed, rounded
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
    outline,
    square,
)
from rolling.results.description import (
    ball_faults,
    ball_material,
    ball_surface,
    different_words,
    finish_word,
    listed,
    plate_faults,
    plate_material,
    plate_size,
    roughness_text,
    values_text,
)
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT

GROUND = 150.0  # where the plate begins
THINNEST = 16.0  # of a drawn plate,
THICKEST = 40.0  # which is as thick as what is shown of a half-space
ENDS = (12.0, 188.0)  # of a plate with edges, seen from the side
PLAN = (156.0, 90.0)  # room of a plate that is seen from above,
PLAN_AWAY = 28.0  # so far below the plate that is seen from the side
MAX_SENSORS = 3  # that are named; more are counted
EAR = (174.0, 16.0)
TALLEST = 6.0  # half of the height of a drawn profile,
ROUGHEST_UM = 10.0  # which an Ra of so much has
SMOOTHEST_UM = 0.001  # and which is flat from here on
SOME_UM = 0.1  # of a surface whose Ra is not known before it is made
_STEP = 3.0  # along the drawn profile


class _Ball:
    """Radius and places of a drawn ball, which hangs above the plate or lies on it."""

    def __init__(self, x: float, radius: float, above: float = 0.0) -> None:
        self.radius = radius
        self.centre = (x, GROUND - above - radius)
        self.lowest = (x, GROUND - above)
        self.highest = (x, GROUND - above - 2 * radius)
        self.contact = (x, GROUND)


def rolling_machine(scenes: Sequence[Scene], numbers: Sequence[Any]) -> Machine:
    """Return the drawing of a ball that rolls over a plate.

    Parameters
    ----------
    scenes : sequence of Scene, at least one. The first is drawn; numbers that differ are listed.
    numbers : sequence of RunNumbers. Those of solved runs, which know the roughness of files.
    """
    ball = _Ball(x=84.0, radius=42.0)
    machine = Machine(title=f"{_body(scenes[0])} that rolls over a plate")
    x, level = ball.centre
    _draw_listener(machine, scenes, ball)
    _draw_plate(machine, scenes, numbers, ball)
    _draw_ball(machine, scenes, ball)
    _draw_turn(machine, ball)
    top = ball.highest[1]
    machine.draw("arrow", arrow((x, top - 34), (x, top - 3)))
    machine.say((x, top - 28), f"{_loads(scenes)} N", _load_words(scenes))
    machine.draw("arrow", arrow((x + ball.radius + 8, level), (PICTURE - 12, level)))
    machine.say((PICTURE - 22, level), f"{_speeds(scenes)} m/s", _speed_words(scenes[0]))
    return machine


def falling_machine(scenes: Sequence[Scene], numbers: Sequence[Any]) -> Machine:
    """Return the drawing of a ball that falls on a plate, bounces, and rolls on.

    Parameters
    ----------
    scenes : sequence of Scene, at least one. The first is drawn; numbers that differ are listed.
    numbers : sequence of RunNumbers. Those of solved runs, which know the roughness of files.
    """
    ball = _Ball(x=66.0, radius=22.0, above=66.0)
    machine = Machine(title=f"{_body(scenes[0])} that falls on a plate")
    x, _ = ball.centre
    rolling_level = GROUND - ball.radius
    _draw_listener(machine, scenes, ball)
    _draw_plate(machine, scenes, numbers, ball)
    machine.draw("path", _bounces(ball))
    machine.draw("arrow", head((PICTURE - 8, rolling_level), 0.0))
    machine.say((PICTURE - 12, rolling_level), f"{_speeds(scenes)} m/s", "along the plate")
    _draw_ball(machine, scenes, ball)
    machine.draw("arrow", arrow(ball.centre, (x, ball.lowest[1] + 14)))
    machine.say((x, ball.lowest[1] + 6), f"{_loads(scenes)} N", _load_words(scenes))
    beside = 24.0
    machine.draw("thin", line((beside - 6, ball.lowest[1]), ball.lowest))
    machine.draw("thin", line((beside, ball.lowest[1]), (beside, GROUND)))
    machine.draw("thin", head((beside, ball.lowest[1]), -math.pi / 2))
    machine.draw("thin", head((beside, GROUND), math.pi / 2))
    heights = values_text([scene.rolling.drop_mm for scene in scenes])
    machine.say((beside, GROUND - 30), f"{heights} mm", "height of the fall")
    return machine


def _body(scene: Scene) -> str:
    """Name the body that moves."""
    across = scene.sphere.radius_across_mm
    return "A ball" if across in (None, scene.sphere.radius_mm) else "A wheel"


# ---- ball


def _draw_ball(machine: Machine, scenes: Sequence[Scene], ball: _Ball) -> None:
    """Draw the ball with its radius, its surface and its faults."""
    machine.draw("body", circle(ball.centre, ball.radius))
    end = around(ball.centre, ball.radius, -2.5)
    machine.draw("thin", line(ball.centre, end))
    radii = values_text([scene.sphere.radius_mm for scene in scenes])
    across = [scene.sphere.radius_across_mm for scene in scenes]
    words = " ".join([listed(different_words(scenes, ball_material) or ["elastic"]), "ball"])
    if any(across):
        words = f"along, {values_text(across)} mm across the track"
    machine.say(around(ball.centre, 0.6 * ball.radius, -2.5), f"R {radii} mm", words)
    surface = ball_surface(scenes).strip(" ()")
    if not surface:
        return
    place = around(ball.centre, ball.radius, 0.55)
    faults = ball_faults(scenes[0])
    if faults:
        machine.draw("fault", circle(place, 3.0))
        machine.say(place, faults, "in the ball")
    others = surface.partition("with ")[0].strip(" ()")
    if others:
        place = around(ball.centre, ball.radius, 0.2)
        machine.say(place, others, "surface of the ball")


def _draw_turn(machine: Machine, ball: _Ball) -> None:
    """Draw how a ball turns that rolls to the right."""
    radius = 0.72 * ball.radius
    last = 0.9
    machine.draw("thin", arc(ball.centre, radius, -0.7, last))
    machine.draw("thin", head(around(ball.centre, radius, last), last + math.pi / 2))


def _bounces(ball: _Ball) -> str:
    """Return the path of the centre of a ball that falls, bounces lower and lower, and rolls."""
    x, top = ball.centre
    bottom = GROUND - ball.radius
    places = [ball.centre, (x, bottom)]
    height = bottom - top
    for _ in range(3):
        height *= 0.5
        half = 4.2 * math.sqrt(height) / 2
        for share in np.linspace(-1.0, 1.0, 13)[1:]:
            places.append((x + half * (1 + share), bottom - height * (1 - share**2)))
        x = places[-1][0]
    return line(*places, (PICTURE - 8, bottom))


def _loads(scenes: Sequence[Scene]) -> str:
    """Write the loads of the ball."""
    return values_text([scene.load for scene in scenes])


def _load_words(scenes: Sequence[Scene]) -> str:
    """Say what presses the ball."""
    return "its weight" if all(scene.rolling.load_n == WEIGHT for scene in scenes) else "load"


def _speeds(scenes: Sequence[Scene]) -> str:
    """Write the speeds of the ball."""
    if all(scene.rolling.resistance or len(scene.motion.speeds) == 1 for scene in scenes):
        return values_text([scene.motion.speeds[0] for scene in scenes])
    speeds = [speed for scene in scenes for speed in scene.motion.speeds]
    return f"{rounded(min(speeds), 3)} to {rounded(max(speeds), 3)}"


def _speed_words(scene: Scene) -> str:
    """Say how the ball moves along."""
    words = "speed"
    if scene.rolling.resistance:
        words = "speed at first, then it rolls out"
    if scene.passes > 1:
        words += f", {scene.passes} times over the same track"
    return words


# ---- plate


def _draw_plate(
    machine: Machine, scenes: Sequence[Scene], numbers: Sequence[Any], ball: _Ball
) -> None:
    """Draw the plate from the side, and one with edges from above too."""
    scene = scenes[0]
    thickness = _drawn_thickness(scene, ball)
    bottom = GROUND + thickness
    machine.height = bottom + 10.0
    left, right = (0.0, PICTURE) if scene.plate.edges_mm is None else ENDS
    profile = _profile(_mean_ra_um(scenes, numbers), left, right)
    machine.draw("ground", outline(*profile, (right, bottom), (left, bottom)))
    machine.draw("edge", line(*profile))
    if scene.plate.thickness_mm is None:
        machine.draw("thin", *_hatching(left, right, bottom))
    elif scene.plate.edges_mm is None:
        machine.draw("edge", line((left, bottom), (right, bottom)))
    else:
        machine.draw("edge", line((left, GROUND), (left, bottom), (right, bottom), (right, GROUND)))
    _say_plate(machine, scenes, numbers, (right - 16, bottom - 0.4 * thickness))
    if scene.plate.edges_mm is not None:
        _draw_plan(machine, scenes, bottom + PLAN_AWAY)
    _draw_sensors(machine, scene, ball, bottom)


def _drawn_thickness(scene: Scene, ball: _Ball) -> float:
    """Return the thickness of the drawn plate, over the drawn radius as in the scene."""
    if scene.plate.thickness_mm is None:
        return THICKEST
    ratio = scene.plate.thickness_mm / scene.sphere.radius_mm
    return min(max(ratio * ball.radius, THINNEST), THICKEST)


def _mean_ra_um(scenes: Sequence[Scene], numbers: Sequence[Any]) -> float:
    """Return the Ra [um] that the profile shows: solved, given, or some where it is not known."""
    solved = _solved_ra_um(numbers)
    if solved:
        return solved[0]
    law = scenes[0].surface.law
    if law is None and scenes[0].height_path is None:
        return 0.0
    given = (getattr(law, "roughness_ra_um", None), getattr(law, "rq_um", None))
    return next((float(value) for value in given if value is not None), SOME_UM)


def _solved_ra_um(numbers: Sequence[Any]) -> list[float]:
    """Return the Ra [um] of the plates of solved runs, without that of their balls."""
    surfaces = [run_numbers.surface for run_numbers in numbers]
    return [
        1e6 * float(surface.ra_m if surface.plate_ra_m is None else surface.plate_ra_m)
        for surface in surfaces
    ]


def _profile(ra_um: float, left: float, right: float) -> list[Place]:
    """Return a profile whose height tells Ra by decades, with its peaks below the ball's bottom."""
    decades = math.log10(ROUGHEST_UM / SMOOTHEST_UM)
    share = math.log10(max(ra_um, SMOOTHEST_UM) / SMOOTHEST_UM) / decades
    tall = TALLEST * min(share, 1.0)
    if tall == 0.0:
        return [(left, GROUND), (right, GROUND)]
    x = np.arange(left, right + _STEP, _STEP)
    depth = np.random.default_rng(1).uniform(0.0, 2.0, len(x))  # one look for all machines
    return [
        (float(min(place, right)), GROUND + tall * float(down))
        for place, down in zip(x, depth, strict=True)
    ]


def _hatching(left: float, right: float, bottom: float) -> list[str]:
    """Return short lines below a body that goes on."""
    return [line((x, bottom), (x - 8, bottom + 8)) for x in np.arange(left + 12, right + 1, 14)]


def _say_plate(
    machine: Machine, scenes: Sequence[Scene], numbers: Sequence[Any], inside: Place
) -> None:
    """Name material, thickness, roughness and faults of the plate."""
    scene = scenes[0]
    surface_at = (inside[0] - 14, GROUND + 2)
    materials = listed(
        different_words(scenes, lambda item: plate_material(item.plate)) or ["plate"]
    )
    if scene.plate.thickness_mm is None:
        value = "half-space"
        words = f"of {materials}" if materials != "plate" else "elastic"
    else:
        value = f"{values_text([item.plate.thickness_mm for item in scenes])} mm thick"
        words = f"{materials} plate" if materials != "plate" else "plate"
        if scene.plate.edges_mm is None:
            words = f"infinite {words}"
    hardness = [item.plate.cap_gpa for item in scenes if math.isfinite(item.plate.cap_gpa)]
    if hardness:
        words += f", yields at {values_text(hardness)} GPa"
    machine.say(inside, value, words)
    _say_roughness(machine, scenes, numbers, surface_at)
    faults = plate_faults(scene)
    if faults:
        at = (surface_at[0] - 30, GROUND + 3)
        machine.draw("fault", circle(at, 3.0))
        machine.say(at, faults, "in the plate")


def _say_roughness(
    machine: Machine, scenes: Sequence[Scene], numbers: Sequence[Any], place: Place
) -> None:
    """Name the roughness of the plate: as the scenes give it, or as it is where they do not."""
    finishes = different_words(scenes, finish_word)
    surface = f"{listed(finishes)} surface" if finishes else "surface"
    roughness = different_words(scenes, roughness_text)
    known = _solved_ra_um(numbers)
    if known and not any(text.startswith("Ra ") for text in roughness):
        surface = f"{surface}, {listed(roughness)}" if roughness else surface
        roughness = [f"Ra {values_text(known)} µm"] if max(known) > 0 else []
    if not roughness:
        machine.say(place, "smooth", "surface")
    elif len(roughness) > 3:
        machine.say(place, f"{len(roughness)} values", f"of the {surface}")
    else:
        machine.say(place, listed(_without_repeats(roughness)), surface)


def _without_repeats(texts: Sequence[str]) -> list[str]:
    """Write a word and unit that all texts share once: Ra 0.1 and 0.2 µm."""
    parts = [text.split(" ") for text in texts]
    if len(texts) < 2 or any(len(part) != 3 for part in parts):
        return [*texts]
    words = {(part[0], part[2]) for part in parts}
    if len(words) > 1:
        return [*texts]
    word, _, unit = parts[0]
    values = [part[1] for part in parts]
    values[0] = f"{word} {values[0]}"
    values[-1] = f"{values[-1]} {unit}"
    return values


# ---- a plate with edges from above


def _draw_plan(machine: Machine, scenes: Sequence[Scene], top: float) -> None:
    """Draw a plate with edges from above: contact, path, listeners and places of sensors."""
    scene = scenes[0]
    assert scene.plate.edges_mm is not None  # as the caller has checked
    length, width = scene.plate.edges_mm
    scale = min(PLAN[0] / length, PLAN[1] / width)
    left = (PICTURE - scale * length) / 2
    bottom = top + scale * width

    def place_of(point_mm: Sequence[float]) -> Place:
        return left + scale * point_mm[0], bottom - scale * point_mm[1]

    machine.height = bottom + 6.0
    machine.draw("ground", box(left, top, left + scale * length, bottom))
    machine.draw("edge", box(left, top, left + scale * length, bottom))
    kinds = dict.fromkeys(kind.replace("_", " ") for kind in scene.plate.edge_pair)
    sizes = different_words(scenes, lambda item: plate_size(item.plate))
    size = sizes[0].rpartition(" x ")[0] if len(sizes) == 1 else f"{len(sizes)} sizes"
    corner = (left + scale * length - 8, bottom - 6)
    machine.say(corner, f"{size} mm", f"from above, edges {' and '.join(kinds)}")
    ends = list(scene.plate.contact_ends_mm.values())
    start = place_of(ends[0])
    if len(ends) > 1:
        end = place_of(ends[1])
        direction = math.atan2(end[1] - start[1], end[0] - start[0])
        machine.draw("arrow", line(start, end), head(end, direction))
        machine.draw("arrow", head(start, direction + math.pi))
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        path_mm = rounded(math.dist(ends[0], ends[1]), 3)
        machine.say(middle, f"{path_mm} mm", "path, to and fro")
    else:
        machine.draw("dot", circle(start, 3.0))
        machine.say(start, f"{bracketed(ends[0])} mm", "the contact stays here")
    for x_mm, y_mm, _ in scene.sound.listener_mm or ():
        if 0 <= x_mm <= length and 0 <= y_mm <= width:
            machine.draw("thin", circle(place_of((x_mm, y_mm)), 4.0))
    named = [channel for channel in scene.sound.channels or () if channel.place_mm is not None]
    for number, channel in enumerate(named):
        assert channel.place_mm is not None  # as they are chosen
        at = place_of(channel.place_mm)
        machine.draw("sensor", square(at, 3.5))
        if len(named) <= MAX_SENSORS:
            words = f"at {bracketed(channel.place_mm)} mm"
            machine.say(at, channel.label.removesuffix(f" {words}"), f"{channel.quantity} {words}")
        elif number == 0:
            machine.say(at, f"{len(named)} sensors", "on the plate")


def _draw_sensors(machine: Machine, scene: Scene, ball: _Ball, bottom: float) -> None:
    """Draw the sensors of ball and contact, and those of a plate without edges."""
    named = []
    for channel in scene.sound.channels or ():
        if channel.place_mm is not None and scene.plate.edges_mm is not None:
            continue  # which the plate from above has
        if channel.of == "ball":
            at = around(ball.centre, ball.radius, -1.1)
        elif channel.place_mm is not None:
            x_mm, _ = channel.place_mm
            at = (ball.contact[0] + 70 * math.tanh(x_mm / 100), bottom)
        else:
            at = (ball.contact[0], bottom)
        named.append((at, channel.label, channel.quantity.replace("_", " ")))
    for number, (at, label, quantity) in enumerate(named):
        machine.draw("sensor", square(at, 3.5))
        if len(named) <= MAX_SENSORS:
            machine.say(at, label, "sensor" if quantity in label else quantity)
        elif number == 0:
            machine.say(at, f"{len(named)} sensors", "of ball, plate and contact")


# ---- listener


def _draw_listener(machine: Machine, scenes: Sequence[Scene], ball: _Ball) -> None:
    """Draw who listens, and how far away from the contact."""
    scene = scenes[0]
    machine.draw("path", line(ball.contact, (EAR[0] - 6, EAR[1] + 10)))
    machine.draw("thin", *listener(EAR))
    distances = values_text([item.listener_distance_m for item in scenes])
    words = "listener"
    count = len(scene.sound.listener_mm or ())
    if count > 1:
        words = f"first of {count} listeners"
    if scene.is_listener_placed and scene.listeners[0][2] < 0:
        words += ", below the plate"
    machine.say((EAR[0] + 4, EAR[1] + 2), f"{distances} m", words)

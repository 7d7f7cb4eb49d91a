"""Drawings of the machines: a ball on its plate with its listener, and a bearing with its loads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from drawn_pictures import Drawn, new_figure
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Rectangle

from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS
from rolling.bearing_kind.bearing_figures import static_loads
from rolling.contact.closed_forms import hertz_radius
from rolling.in_si.physics_of_scene import bodies_of

STEEL = "0.82"
EDGE = "0.3"
ARROW = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "linewidth": 1.6, "mutation_scale": 13}
LONGEST_LOAD = 0.34  # of the arrow of a load, over the outer radius of the bearing


def model(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the model: the contact that is solved, what moves, and what is heard."""
    scene = scenes["ball"]
    radius_m = 1e-3 * scene.sphere.radius_mm
    modulus = scene.contact_modulus
    numbers = {
        "radius": f"{scene.sphere.radius_mm:g} mm",
        "load": f"{scene.load:g} N",
        "speed": f"{scene.rolling.speed_m_s:g} m/s",
        "thickness": f"{scene.plate.thickness_mm:g} mm",
        "distance": f"{scene.listener_distance_m:g} m",
        "contact": f"{rounded(2e6 * hertz_radius(scene.load, radius_m, modulus), 2)} µm",
        "resonance": f"{rounded(1e-3 * bodies_of(scene).smooth_chain.resonance_hz, 2)} kHz",
    }
    figure = new_figure(3.9)
    ax = figure.add_subplot()
    ax.set(xlim=(0, 12.4), ylim=(0.7, 7.8), aspect="equal")
    ax.axis("off")
    _draw_contact(ax, numbers)
    _draw_motion(ax, numbers)
    _draw_sound(ax, numbers)
    for place, words in ((1.9, "1 solved"), (6.1, "2 moves"), (10.5, "3 heard")):
        ax.text(place, 7.5, words, ha="center", va="center", fontsize=12, weight="bold")
    return Drawn(figure, numbers)


def _draw_contact(ax: Axes, numbers: Mapping[str, str]) -> None:
    """Draw the rough contact, many times larger than it is, with its pressures."""
    x = np.linspace(0.1, 3.7, 181)
    rng = np.random.default_rng(3)
    waves = rng.standard_normal((9, 3))
    heights = sum(
        0.1 * size * np.sin(2 * math.pi * (number + 2) * x / 3.6 + 6 * phase) / (1 + 0.2 * number)
        for number, (size, phase, _) in enumerate(waves)
    )
    ball = 2.8 + 9.0 - np.sqrt(81.0 - (x - 1.9) ** 2)
    rough = np.minimum(2.75 + heights, ball)
    ax.fill_between(x, 0.9, rough, color=STEEL, linewidth=0)
    ax.plot(x, rough, color=EDGE, linewidth=1)
    ax.fill_between(x, ball, 5.0, color="0.92", linewidth=0)
    ax.plot(x, ball, color=EDGE, linewidth=1)
    touching = np.flatnonzero(ball - rough < 1e-9)[::3]
    pressures = 0.25 + 2.5 * (2.75 + heights - ball)[touching]  # more where more is pressed in
    ax.vlines(x[touching], rough[touching], rough[touching] + pressures, color=COLOURS[1])
    ax.text(1.9, 4.6, "ball", ha="center", va="center")
    ax.text(1.9, 1.5, f"plate; Hertz contact\n{numbers['contact']} wide", ha="center", va="center")
    ax.text(
        1.9, 5.75, "pressure of each node\nat each step", ha="center", va="center", color=COLOURS[1]
    )


def _draw_motion(ax: Axes, numbers: Mapping[str, str]) -> None:
    """Draw the ball on the spring of its contact, on the plate that gives way."""
    ax.add_patch(Circle((6.1, 4.9), 1.15, facecolor="0.92", edgecolor=EDGE))
    ax.text(6.1, 4.9, f"ball, R\n{numbers['radius']}", ha="center", va="center")
    y = np.linspace(3.75, 2.6, 60)
    ax.plot(6.1 + 0.22 * np.sin(10 * math.pi * (y - y[0]) / (y[-1] - y[0])), y, color=COLOURS[0])
    ax.text(6.45, 3.15, f"contact:\n{numbers['resonance']}", va="center", color=COLOURS[0])
    x = np.linspace(4.2, 8.0, 80)
    bend = 0.12 * np.cos(2.2 * math.pi * (x - 6.1) / 1.9) * np.exp(-np.abs(x - 6.1) / 2)
    ax.fill_between(x, 1.9 + bend, 2.45 + bend, color=STEEL, edgecolor=EDGE, linewidth=1)
    ax.text(6.1, 1.35, f"plate, {numbers['thickness']}, bends", ha="center", va="center")
    ax.annotate("", (6.1, 6.05), (6.1, 7.1), arrowprops=ARROW | {"color": "0.2"})
    ax.text(6.3, 6.65, f"load {numbers['load']}", va="center")
    ax.annotate("", (8.45, 4.9), (7.35, 4.9), arrowprops=ARROW | {"color": "0.2"})
    ax.text(7.4, 5.25, numbers["speed"], va="center")


def _draw_sound(ax: Axes, numbers: Mapping[str, str]) -> None:
    """Draw the waves that plate and ball send to the listener."""
    for radius in (1.0, 1.6, 2.2):
        ax.add_patch(
            Arc(
                (8.7, 2.6),
                2 * radius,
                2 * radius,
                theta1=5,
                theta2=75,
                color=COLOURS[2],
                linewidth=1.4,
            )
        )
    ax.add_patch(Circle((11.3, 4.9), 0.33, facecolor="0.92", edgecolor=EDGE))
    ax.add_patch(Rectangle((11.22, 3.6), 0.16, 0.97, facecolor=STEEL, edgecolor=EDGE))
    ax.text(10.7, 5.75, f"listener at {numbers['distance']}", ha="center", va="center")
    ax.text(
        10.3,
        1.35,
        "pressure in Pa:\nlevel, spectrum, WAV",
        ha="center",
        va="center",
        color=COLOURS[2],
    )


def bearing(scenes: Mapping[str, Any]) -> Drawn:
    """Draw a bearing with the loads of its balls in the static balance, and its fault."""
    scene = scenes["bearing"]
    geometry = scene.geometry
    keys = scene.bearing
    angles = 2 * math.pi * np.arange(keys.balls) / keys.balls
    loads = static_loads(scene.model, angles)
    pitch = keys.pitch_diameter_mm / 2
    ball = keys.ball_diameter_mm / 2
    bore = pitch - 1.75 * ball
    outside = pitch + 1.75 * ball
    figure = new_figure(4.6)
    ax = figure.add_subplot()
    for radius, face in (
        (outside, STEEL),
        (pitch + 0.8 * ball, "1"),
        (pitch - 0.8 * ball, STEEL),
        (bore, "1"),
    ):
        ax.add_patch(Circle((0, 0), radius, facecolor=face, edgecolor=EDGE))
    for angle, load in zip(angles, loads, strict=True):
        outwards = np.array([math.sin(angle), -math.cos(angle)])  # angle 0 is below
        middle = pitch * outwards
        share = load / loads.max()
        ax.add_patch(Circle(middle, ball, facecolor="0.95", edgecolor=EDGE))
        if load > 0:
            begin = (outside + 0.06 * outside) * outwards
            end = begin + LONGEST_LOAD * outside * share * outwards
            ax.annotate("", end, begin, arrowprops=ARROW | {"color": COLOURS[1]})
        ax.text(*middle, f"{load:.0f}", ha="center", va="center", fontsize=9.5)
    pit = np.array([0.05 * pitch, -pitch - 1.2 * ball])
    ax.plot(*pit, "v", color=COLOURS[3], markersize=10)
    numbers = {
        "bearing": f"{keys.named}",
        "balls": f"{keys.balls}",
        "heaviest": f"{loads.max():.0f} N",
        "lightest": f"{loads.min():.0f} N",
        "radial": f"{keys.radial_load_n:g} N",
        "axial": f"{keys.axial_load_n:g} N",
        "angle": f"{math.degrees(geometry.contact_angle):.1f}°",
        "outer pass": f"{scene.model.kinematics.ball_pass_outer_hz:.1f} Hz",
    }
    ax.text(0, 0, f"{keys.named}\n{keys.speed_rpm:g}/min", ha="center", va="center", fontsize=12)
    ax.set(xlim=(-2.1 * outside, 2.1 * outside), ylim=(-1.5 * outside, 1.1 * outside))
    ax.set_aspect("equal")
    ax.text(1.1 * outside, 0.75 * outside, "outer ring,\nwhich moves", va="center")
    loads_words = f"load of the shaft:\n{numbers['radial']} radial,\n{numbers['axial']} axial"
    ax.text(-2.1 * outside, -1.2 * outside, loads_words, va="center")
    line = {"arrowstyle": "-", "color": COLOURS[3]}
    at = (0.95 * outside, -1.3 * outside)
    ax.annotate("pit", pit, at, color=COLOURS[3], va="center", arrowprops=line)
    ax.axis("off")
    return Drawn(figure, numbers)

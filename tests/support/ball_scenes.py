"""Scenes of small balls with a surface, whose turn is a few hundred nodes."""

from typing import Any

from rolling.scene.file import loads
from rolling.scene.scene import Scene

SMALL_BALL = """\
name: small-ball
sphere: {radius_mm: 0.1, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850}
surface: {kind: smooth, spacing_um: 2, width_um: 32}
rolling: {load_n: 0.02, speed_m_s: 0.03, distance_mm: 0.628}
numerics: {tolerance: 1.0e-6}
"""
TURN = 314  # nodes


def small_ball(*overrides: str, **ball: Any) -> Scene:
    """Return the scene of a ball with the keys of its surface, and other keys as overrides."""
    scene = loads(SMALL_BALL, overrides)
    return scene.with_({"sphere.surface": ball}) if ball else scene

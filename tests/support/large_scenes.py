"""The text of scenes that are large: steel, a made surface, a height file, and laps of it."""

from pathlib import Path

from scene_text import BODIES

MADE = (
    "surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, "
    "spacing_um: 2, width_um: 200, seed: 3}\n"
)
FILE = "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"
LAPS = "{load_n: 0.5, speed_m_s: %s, duration_s: %s}"


def scene_of(folder: Path, surface: str, rest: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text(f"name: large\n{BODIES}{surface}rolling: {rest}\n")
    return path

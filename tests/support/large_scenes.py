"""The text of scenes that are large: steel, a made surface, a height file, and laps of it."""

from pathlib import Path

from scene_text import BODIES

FILE = "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"
LAPS = "{load_n: 0.5, speed_m_s: %s, duration_s: %s}"


def scene_of(folder: Path, surface: str, rest: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text(f"name: large\n{BODIES}{surface}rolling: {rest}\n")
    return path

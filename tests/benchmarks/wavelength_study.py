"""Falls of LAeq by the table of wavelengths against falls on surfaces without these waves.

`python tests/benchmarks/wavelength_study.py` runs small scenes, takes the loudest octave of waves
and the next off each surface, runs them again, and prints the numbers of docs/dynamics.md. It takes
about six minutes on a core.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import rolling as rc
from acoustics.arrays import Array
from rolling.in_si.scene_surface import scene_surface
from rolling.sound.wavelengths import WavelengthOctave

PLATE = {"material": "steel-100cr6", "thickness_mm": 10, "loss_factor": 0.01}
SURFACE = {"roughness_ra_um": 0.05, "correlation_length_um": 20, "spacing_um": 4, "width_um": 512}
LONG = {"kind": "gaussian", "seed": 1, "spacing_um": 8, "width_um": 512}
LONG |= {"roughness_ra_um": 0.02, "correlation_length_um": 150}
SCENES: dict[str, dict[str, object]] = {
    "vibration, 20 N, Ra 0.05 um": {},
    "vibration, 20 N, Ra 0.2 um": {"surface.roughness_ra_um": 0.2},
    "vibration with impacts, 2 N, Ra 0.5 um": {
        "rolling.load_n": 2,
        "surface.roughness_ra_um": 0.5,
    },
    "vibration of long waves, 20 N, Ra 0.02 um": {
        "rolling.speed_m_s": 6,
        "rolling.duration_s": 0.008,
        "surface": LONG,
    },
    "vibration of long waves, 5 N, Ra 0.02 um": {
        "rolling.speed_m_s": 6,
        "rolling.duration_s": 0.008,
        "rolling.load_n": 5,
        "surface": LONG,
    },
    "release, 20 N, Ra 0.05 um": {"dynamics": None},
    "release, 20 N, Ra 0.2 um": {"dynamics": None, "surface.roughness_ra_um": 0.2},
    "release that yields, 20 N, Ra 0.2 um, 1 GPa": {
        "dynamics": None,
        "surface.roughness_ra_um": 0.2,
        "plate.hardness_gpa": 1.0,
    },
}


def scene_of(changes: dict[str, object]) -> rc.Scene:
    """Return a small scene of a steel ball on a steel plate."""
    base = rc.Scene.from_dict(
        {
            "name": "wavelengths",
            "sphere": {"radius_mm": 5, "material": "steel-100cr6"},
            "plate": PLATE,
            "surface": {"kind": "gaussian", "seed": 1, **SURFACE},
            "rolling": {"load_n": 20, "speed_m_s": 0.3, "duration_s": 0.04},
            "dynamics": {"loads": 3},
        }
    )
    if "dynamics" in changes:  # a plate that bends needs it
        changes = {"plate.thickness_mm": None, "plate.loss_factor": None, **changes}
    return base.with_(changes)


def without(heights: Array, spacing_um: float, octave: WavelengthOctave) -> Array:
    """Return heights without the waves of an octave along the track."""
    lines = np.fft.rfft(heights, axis=0)
    wave_number = np.fft.rfftfreq(len(heights), spacing_um)
    inside = (wave_number > 1 / octave.to_um) & (wave_number <= 1 / octave.from_um)
    lines[inside] = 0.0
    return np.fft.irfft(lines, len(heights), axis=0)


def falls(scene: rc.Scene) -> Iterator[tuple[WavelengthOctave, float, float]]:
    """Yield the two loudest octaves, LAeq with all waves, and LAeq without the octave [dB]."""
    run = rc.simulate(scene, workers=1, progress=False)
    heights = np.asarray(scene_surface(scene).heights)
    spacing_um = scene.surface.spacing_um
    for octave in sorted(run.wavelength_octaves, key=lambda octave: octave.energy_share)[:-3:-1]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "heights.npy"
            np.save(path, without(heights, spacing_um, octave))
            surface = {"kind": "file", "path": str(path), "level": "none"}
            surface["spacing_um"] = spacing_um
            changed = rc.simulate(scene.with_(surface=surface), workers=1, progress=False)
        yield octave, run.sound.levels.laeq_db or 0.0, changed.sound.levels.laeq_db or 0.0


def main() -> None:
    """Print the table."""
    print("| scene | waves, um | share, % | follows, % | fall by the table, dB | fall, dB |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, changes in SCENES.items():
        for octave, whole, less in falls(scene_of(changes)):
            waves = f"{octave.from_um:g} to {octave.to_um:g}"
            fall = octave.fall_db if octave.fall_db is not None else np.inf
            shares = (octave.energy_share, octave.linear_share or np.nan)
            cells = (
                *(f"{100 * share:.0f}" for share in shares),
                f"{fall:.1f}",
                f"{whole - less:.1f}",
            )
            print(f"| {name} | {waves} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()

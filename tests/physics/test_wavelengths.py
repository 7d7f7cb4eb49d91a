"""Octaves of roughness wavelength: their part of the sound, and marches without their waves."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scene_sounds import sound_of_release
from scipy.signal import fftconvolve

from rolling import Scene, read_scene, simulate
from rolling.figures.origins import reading
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.in_si.scene_surface import scene_surface
from rolling.sound import wavelengths
from rolling.sound.contact_sound import ContactSound
from rolling.sound.wavelengths import WavelengthOctave

STEPS = 600
SMALL = {"rolling.duration_s": STEPS * 16e-6 / 6, "surface.spacing_um": 16}


def small() -> Scene:
    return read_scene("wavelengths").with_(SMALL)


def octaves_of(scene: Scene, sound: ContactSound) -> list[WavelengthOctave]:
    """Return the octaves of the sound of a release."""
    speed = wavelengths.mean_speed(scene.motion, sound)
    own_factor = scene.sound.gain_pa_per_w_m2 is None
    return wavelengths.wavelength_octaves(sound, speed, own_factor)


def test_a_tone_belongs_to_the_octave_of_speed_over_frequency() -> None:
    scene = small().with_({"dynamics": None, "plate.thickness_mm": None, "plate.loss_factor": None})
    energy = 1e-9 * (1 + 0.1 * np.cos(2 * np.pi * 24 * np.arange(STEPS) / STEPS))
    sound = sound_of_release(scene, energy, scene.step, closed=True)
    (octave,) = (octave for octave in octaves_of(scene, sound) if octave.energy_share > 0.999)
    # 24 waves of 400 um on 9.6 mm; 15 kHz at 6 m/s; without them nothing is left
    assert (octave.from_um, octave.to_um, octave.fall_db) == (320, 640, None)


def test_the_share_that_follows_is_one_for_the_mean_under_hertz_pressure_and_none_for_noise() -> (
    None
):
    scene = small()
    rng = np.random.default_rng(1)
    heights = rng.normal(size=(STEPS, 32))
    radius = smooth_contact_of(scene).semi_axes_m()[0] / scene.spacing
    x, y = np.meshgrid(np.arange(-6, 7), np.arange(-6, 7), indexing="ij")
    pressure = np.sqrt(np.clip(1 - (x**2 + y**2) / radius**2, 0, None))
    wrapped = np.pad(heights, ((6, 6), (0, 0)), mode="wrap")
    mean = fftconvolve(wrapped, pressure, mode="same")[6:-6, 16]
    shifted = scene.with_({"rolling.start_um": 7 * 16})
    for begins, approach, least, most in (
        (scene, mean, 1 - 1e-9, 1),
        (shifted, np.roll(mean, -7), 1 - 1e-9, 1),
        (scene, rng.normal(size=STEPS), 0, 0.5),
    ):
        shares = wavelengths.linear_shares(
            heights,
            np.append(approach, approach[0]),
            track=begins.track,
            spacing=begins.spacing,
            start=begins.start,
            semi_axes=smooth_contact_of(begins).semi_axes_m(),
        )
        # of n lines, chance leaves one over n; the octave with the fewest has 8
        assert all(least <= share <= most + 1e-9 for share in shares.values()) and len(shares) > 3


def test_without_the_waves_of_an_octave_laeq_falls_by_the_fall_of_the_table(tmp_path: Path) -> None:
    scene = small()
    run = simulate(scene, workers=1, progress=False)
    octave = max(run.wavelength_octaves, key=lambda octave: octave.energy_share)
    assert octave.linear_share is not None and octave.linear_share > 0.9
    text = reading(run)
    assert text.startswith(f"Waves of 320 to 640 µm make {100 * octave.energy_share:.0f} % of")
    assert f"falls by {octave.fall_db:.1f} dB. A wave along the track sounds at the speed" in text
    heights = np.asarray(scene_surface(scene).heights)
    lines = np.fft.rfft(heights, axis=0)
    number = np.fft.rfftfreq(STEPS, 16.0)
    lines[(number > 1 / octave.to_um) & (number <= 1 / octave.from_um)] = 0.0
    np.save(tmp_path / "less.npy", np.fft.irfft(lines, STEPS, axis=0))
    less = {"kind": "file", "path": str(tmp_path / "less.npy"), "spacing_um": 16, "level": "none"}
    changed = simulate(scene.with_(surface=less), workers=1, progress=False)
    fall = run.numbers.of_record.laeq_db - changed.numbers.of_record.laeq_db
    # tests/benchmarks/wavelength_study.py: 0 to 2 dB apart where the approach follows the waves
    assert octave.fall_db is not None and fall == pytest.approx(octave.fall_db, abs=3)
    assert fall > 6


def test_a_fall_of_a_release_is_of_its_own_factor() -> None:
    scene = small().with_({"dynamics": None, "plate.thickness_mm": None, "plate.loss_factor": None})
    waves = np.cos(2 * np.pi * np.outer((12, 24), np.arange(STEPS)) / STEPS)
    sounds = [
        sound_of_release(scene, 1e-9 * (1 + 0.1 * part), scene.step, closed=True)
        for part in (waves[0] + 0.5 * waves[1], waves[0])
    ]
    octave = next(octave for octave in octaves_of(scene, sounds[0]) if octave.from_um == 320)
    fall = sounds[0].levels.laeq_db - sounds[1].levels.laeq_db
    assert octave.fall_db == pytest.approx(fall, abs=1e-6) and not math.isclose(fall, 0)
    silent = replace(sounds[0], pressure=0 * sounds[0].pressure)
    assert not octaves_of(scene, silent)

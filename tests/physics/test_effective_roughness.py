"""Third octaves over wavelength hold the roughness of the profile."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.sound.wavelengths import wavelength_bands


@pytest.mark.law("Roughness over wavelength: a sine of 1 um rms has 0 dB in its band.")
@pytest.mark.parametrize("waves", [8, 40, 100])
def test_a_sine_lies_in_its_band(waves: int) -> None:
    x = np.arange(1000) * 2e-6
    profile = np.sqrt(2) * 1e-6 * np.sin(2 * np.pi * waves * x / 2e-3)
    wavelength, level_db = wavelength_bands(profile, 2e-6, True)
    loudest = int(np.nanargmax(level_db))
    assert level_db[loudest] == pytest.approx(0.0, abs=1e-9)
    assert abs(np.log10(wavelength[loudest] * waves / 2e-3)) <= 0.05


@pytest.mark.law("Roughness over wavelength: the bands add up to the mean square of the profile.")
def test_bands_add_up() -> None:
    rng = np.random.default_rng(1)
    profiles = rng.standard_normal((4096, 5))
    lines = np.fft.rfft(profiles, axis=0)
    lines[0] = lines[3400 // 2 :] = 0  # what no whole band holds
    profiles = np.fft.irfft(lines, 4096, axis=0)
    _, level_db = wavelength_bands(profiles, 1e-6, True)
    total = 1e-12 * np.nansum(10 ** (level_db / 10))
    assert total == pytest.approx(np.mean(profiles**2), rel=1e-9)


def test_an_open_profile_keeps_its_level_without_its_tilt() -> None:
    x = np.arange(2000) * 1e-6
    sine = np.sqrt(2) * 1e-6 * np.sin(2 * np.pi * 37.3 * x / 2e-3)
    wavelength, level_db = wavelength_bands(sine + 3e-3 * x, 1e-6, False)
    near = np.abs(np.log10(wavelength * 37.3 / 2e-3)) < 0.16
    level = 10 * np.log10(np.nansum(10 ** (level_db[near] / 10)))
    assert level == pytest.approx(0.0, abs=0.2)

"""Records and spectra with masked values: every function of arrays refuses them alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from acoustics import laps, level, radiation, resampling, sound_power, wav
from acoustics.rectangular_plate import RectangularPlate

RATE = 48_000
TONE = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(4800) / RATE)
FREQUENCY = np.array([500.0, 1000.0, 2000.0])
STEEL = radiation.ThinPlate(78.5, 18.9e3)
BALL = radiation.Ball(5e-3, 7850.0)
SHEET = RectangularPlate(78.5, 18.9e3, 0.01, length_m=0.3, width_m=0.2)

CALLS: dict[str, tuple[Callable[[Any], Any], np.ndarray]] = {
    "running_mean_square": (lambda p: level.running_mean_square(p, RATE, 0.125, True), TONE),
    "a_weighted": (lambda p: level.a_weighted(p, RATE), TONE),
    "peak_pressure": (level.peak_pressure, TONE),
    "calibrated": (lambda p: wav.calibrated(p, "comment"), TONE),
    "stereo": (lambda p: wav.calibrated(np.ma.column_stack([p, p]), "comment"), TONE),
    "listening_gain": (wav.listening_gain, TONE),
    "crossfaded_lap": (lambda p: laps.crossfaded_lap(p, 48, RATE), TONE),
    "undo_step_mean": (resampling.undo_step_mean, TONE),
    "band_limit": (lambda p: resampling.band_limit(p, RATE), TONE),
    "resample_closed": (lambda p: resampling.resample_closed(p, 4800), TONE),
    "interpolate_closed": (lambda p: resampling.interpolate_closed(p, np.arange(3)), TONE),
    "fade": (lambda p: resampling.fade(p, 10), TONE),
    "axis_transfer": (lambda f: radiation.axis_transfer(f, STEEL, 1.0), FREQUENCY),
    "pressure_on_axis": (lambda p: radiation.pressure_on_axis(p, RATE, [STEEL], 1.0), TONE),
    "mode_receptance": (SHEET.mode_receptance, FREQUENCY),
    "plate_power": (lambda f: sound_power.plate_power_per_force(f, STEEL), FREQUENCY),
    "ball_power": (lambda f: sound_power.ball_power_per_force(f, BALL), FREQUENCY),
    "band_power": (lambda p: sound_power.band_power(p, RATE, BALL), TONE),
}


@pytest.mark.parametrize("name", CALLS)
def test_masked_values_are_refused(name: str) -> None:
    call, values = CALLS[name]
    masked = np.ma.masked_array(values, np.zeros(values.shape, bool))
    call(masked)
    masked[2] = np.ma.masked
    with pytest.raises(ValueError, match="masked values"):
        call(masked)

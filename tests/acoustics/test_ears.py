"""Roughness and tones meet the reference signals of their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics.ears import roughness_asper, tones
from acoustics.radiation import P_REF_PA

RATE = 48000
TIME = np.arange(2 * RATE) / RATE


def at_level(signal: np.ndarray, level_db: float) -> np.ndarray:
    """Return a signal with a level [dB re 20 uPa]."""
    return signal * P_REF_PA * 10 ** (level_db / 20) / np.sqrt(np.mean(np.square(signal)))


@pytest.mark.law("Ears: a tone of 1 kHz and 60 dB, all modulated by 70 Hz, has 1 asper.")
def test_roughness_of_the_reference_signal() -> None:
    carrier = np.sin(2 * np.pi * 1000 * TIME)
    modulated = (1 + np.sin(2 * np.pi * 70 * TIME)) * carrier
    # mosqito 1.2.1 gives 1.02; listeners notice changes from 17 % on.
    assert roughness_asper(at_level(modulated, 60), RATE) == pytest.approx(1.0, rel=0.1)
    assert roughness_asper(at_level(carrier, 60), RATE) == pytest.approx(0.0, abs=0.05)
    assert roughness_asper(np.zeros(RATE), RATE) == 0.0
    assert roughness_asper(modulated[: RATE // 10], RATE) is None


@pytest.mark.law("Ears: the tone-to-noise ratio is the tone over its critical band of noise.")
def test_tone_in_white_noise() -> None:
    # Noise of 70 dB from 20 Hz to 20 kHz has 49.1 dB in the critical band of 162 Hz about 1 kHz.
    lines = np.fft.rfft(np.random.default_rng(1).standard_normal(len(TIME)))
    frequency = np.fft.rfftfreq(len(TIME), 1 / RATE)
    lines[(frequency < 20) | (frequency > 20000)] = 0
    noise = at_level(np.fft.irfft(lines), 70)
    found = tones(at_level(np.sin(2 * np.pi * 1000 * TIME), 60) + noise, RATE)
    assert found is not None and found.tone_to_noise is not None and found.prominence is not None
    # The level of the noise in a band of 162 Hz, 324 lines, scatters by 0.24 dB.
    expected = 60 - (70 - 10 * np.log10(19980 / 162.2))
    assert found.tone_to_noise.decibels == pytest.approx(expected, abs=0.75)
    assert found.tone_to_noise.frequency_hz == pytest.approx(1000, abs=1)
    assert found.tone_to_noise.is_prominent and found.prominence.is_prominent
    # The critical band with the tone over the mean of both neighbours, which are as wide to 15 %.
    assert found.prominence.decibels == pytest.approx(
        10 * np.log10(1 + 10 ** (expected / 10)), abs=1
    )
    alone = tones(noise, RATE)
    assert alone is not None and alone.tone_to_noise is None
    assert tones(noise[: RATE // 2], RATE) is None

"""The envelope spectrum finds how a band rises and falls."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics import envelope_spectrum, loudest_octave, modulated_octave

RATE = 48_000
T = np.arange(RATE) / RATE


def modulated(frequency_hz: float, share: float, carrier_hz: float = 2000.0) -> np.ndarray:
    beat = 1 + share * np.cos(2 * np.pi * frequency_hz * T)
    return np.asarray(beat * np.sin(2 * np.pi * carrier_hz * T))


@pytest.mark.law("Modulation: the line of a modulated tone is its degree of modulation.")
@pytest.mark.parametrize(("frequency", "closed"), [(4.0, True), (4.0, False), (4.5, False)])
def test_the_line_of_a_modulated_tone_is_its_share(frequency: float, closed: bool) -> None:
    """Between two lines a Hann window lowers it by 1.42 dB."""
    spectrum = envelope_spectrum(modulated(frequency, 0.4), RATE, closed=closed)
    lowered = 10 ** (-1.42 / 20) if frequency % 1 else 1.0
    assert spectrum.at(frequency) == pytest.approx(0.4 * lowered, rel=2e-3)
    assert spectrum.at(40.0) < 1e-3


def test_the_band_keeps_other_bands_out() -> None:
    both = modulated(4.0, 0.4) + 100 * modulated(9.0, 0.4, 200.0)
    spectrum = envelope_spectrum(both, RATE, (1500, 3000), closed=True)
    assert spectrum.at(4.0) == pytest.approx(0.4, rel=1e-6)
    assert spectrum.at(9.0) < 1e-6
    assert spectrum.frequency_hz[-1] == 1500


def test_the_loudest_octave_is_that_of_the_ear() -> None:
    """At 50 Hz the ear hears 31 dB less than at 2 kHz."""
    low, high = loudest_octave(modulated(4, 0.4) + 10 * np.sin(2 * np.pi * 50 * T), RATE)
    assert low < 2000 < high == pytest.approx(10**0.3 * low)


def test_silence_has_no_modulation_and_wrong_bands_are_refused() -> None:
    assert not envelope_spectrum(np.zeros(100), RATE).modulation.any()
    for band in ((500.0, 500.0), (-1.0, 10.0)):
        with pytest.raises(ValueError, match="band_hz"):
            envelope_spectrum(T, RATE, band)
    with pytest.raises(ValueError, match="signal: got"):
        envelope_spectrum(np.zeros(0), RATE)


def test_clicks_are_found_beside_a_louder_band_of_noise() -> None:
    """Clicks of 6 kHz, 20 dB below noise about 16 kHz, stand out in their own octave only."""
    random = np.random.default_rng(1).standard_normal(RATE)
    lines = np.fft.rfft(random)
    lines[:12_000] = 0
    clicks = np.sin(2 * np.pi * 6000 * T) * (T % 0.1 < 0.002)
    clicks *= 0.1 * np.std(np.fft.irfft(lines)) / np.std(clicks)
    record = np.fft.irfft(lines) + clicks + 1e-4 * random
    low, high = modulated_octave(record, RATE, 10.0, closed=True)
    assert low < 6000 < high < 13_000
    found = envelope_spectrum(record, RATE, (low, high), True)
    loudest = envelope_spectrum(record, RATE, closed=True)
    assert found.prominence(10.0) > 10 > 4 > loudest.prominence(10.0)

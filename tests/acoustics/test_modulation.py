"""The envelope spectrum finds how a band rises and falls."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics import envelope_spectrum, loudest_octave, modulated_octave
from acoustics.resampling import fade

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


# ---- pulses that repeat in short records


def ticking(turns: float, pulse: float, texture: float = 0.0, seed: int = 1) -> np.ndarray:
    """Return noise of some turns of 30 ms, with a ringing pulse and a texture in each of them."""
    random = np.random.default_rng(seed)
    count = round(turns * 0.03 * RATE)
    turn = round(0.03 * RATE)
    time = np.arange(turn) / RATE
    ring = np.where(time < 0.01, 0.0, np.exp(-(time - 0.01) / 5e-4)) * np.sin(3e4 * time)
    once_per_turn = pulse * ring + texture * random.standard_normal(turn)
    return np.asarray(random.standard_normal(count) + np.resize(once_per_turn, count))


def judged(record: np.ndarray, closed: bool = False, gain: np.ndarray | None = None) -> float:
    band = modulated_octave(record, RATE, 1 / 0.03, closed, gain)
    found = envelope_spectrum(record, RATE, band, closed, gain).prominence(1 / 0.03)
    assert found is not None
    return found


@pytest.mark.law("Modulation: pulses stand out of noise from two periods on, whole or not.")
@pytest.mark.parametrize("turns", [2, 2.4, 2.9997, 3, 3.5, 4.2, 5.5, 8])
def test_pulses_stand_out_of_short_open_records(turns: float) -> None:
    """A Hann window would fill the gaps between the lines of fewer than six turns.

    Each pulse is 20 times the noise. Noise alone, and noise that repeats in each turn, stand out up
    to sevenfold in 700 records of 2 to 8 turns.
    """
    assert judged(ticking(turns, 20.0)) > 10
    assert judged(ticking(turns, 0.0)) < 7
    assert judged(ticking(turns, 0.0, texture=10.0)) < 7
    assert judged(ticking(turns, 100.0, texture=2.0)) > 10


def test_a_fade_that_is_known_does_not_hide_pulses() -> None:
    record = ticking(2.5, 20.0)
    gain = fade(np.ones(len(record)), len(record) // 10)
    assert judged(gain * record, gain=gain) == pytest.approx(judged(record), rel=0.5)
    assert judged(gain * record, gain=gain) > 1.5 * judged(gain * record)


def test_some_samples_do_not_move_the_octave() -> None:
    record = ticking(3.01, 20.0)
    octaves = {modulated_octave(record[: len(record) - k], RATE, 1 / 0.03) for k in range(0, 30, 3)}
    assert len(octaves) == 1


def test_what_is_too_short_or_too_narrow_to_tell_has_no_prominence() -> None:
    record = ticking(1.9, 20.0)
    assert envelope_spectrum(record, RATE).prominence(1 / 0.03) is None
    long = ticking(8, 20.0)
    assert envelope_spectrum(long, RATE, (1000, 1190)).prominence(1 / 0.03) is None
    assert envelope_spectrum(long, RATE, (1000, 1210)).prominence(1 / 0.03) is not None
    assert envelope_spectrum(0 * long, RATE, (1000, 2000)).prominence(1 / 0.03) == 0
    for gain in (np.ones(3), -np.ones(len(long)), np.zeros(len(long))):
        with pytest.raises(ValueError, match=r"gain: got .*, allowed"):
            envelope_spectrum(long, RATE, gain=gain)

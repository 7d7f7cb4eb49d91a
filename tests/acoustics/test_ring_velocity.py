"""Velocity in the bands of ISO 15242-1, and lines of narrow spectra."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics import narrow_spectrum, squared_envelope_spectrum, velocity_bands

RATE = 48_000
T = np.arange(RATE) / RATE


def tone(frequency_hz: float, rms: float) -> np.ndarray:
    return np.asarray(np.sqrt(2) * rms * np.sin(2 * np.pi * frequency_hz * T + 0.4))


@pytest.mark.law("Bearing bands: a tone of known velocity has it in its band and nowhere else.")
@pytest.mark.parametrize(
    ("frequency", "name"), [(92.19, "low"), (294.0, "low"), (307.3, "medium"), (2500.0, "high")]
)
def test_a_tone_has_its_velocity_in_its_band(frequency: float, name: str) -> None:
    """Six lines beyond an edge the windows leave less than 3e-5 of the power."""
    bands = velocity_bands(tone(frequency, 1e-5), RATE)
    assert bands.rms_m_s.pop(name) == pytest.approx(1e-5, rel=2e-3)
    assert max(bands.rms_m_s.values()) < 5e-3 * 1e-5
    assert bands.uncertainty_db[name] < 0.05


@pytest.mark.law("Bearing bands: the uncertainty is the scatter between records of noise.")
def test_the_uncertainty_is_the_scatter_of_records() -> None:
    """A scatter of eight parts is itself uncertain by a quarter, and a mean of 40 by a tenth."""
    random = np.random.default_rng(5)
    records = [velocity_bands(random.standard_normal(24_000), RATE) for _ in range(40)]
    for name in ("low", "medium"):
        levels = [20 * np.log10(bands.rms_m_s[name]) for bands in records]
        stated = [bands.uncertainty_db[name] for bands in records]
        assert np.mean(stated) == pytest.approx(np.std(levels), rel=0.35)


def test_a_ring_at_rest_and_odd_records() -> None:
    rest = velocity_bands(np.zeros(4800), RATE)
    assert set(rest.rms_m_s.values()) == {0.0} == set(rest.uncertainty_db.values())
    with pytest.raises(ValueError, match="at least 128"):
        velocity_bands(np.zeros(100), RATE)
    with pytest.raises(ValueError, match="at least 20000"):
        velocity_bands(np.zeros(1000), 10_000)


@pytest.mark.parametrize("frequency", [92.0, 92.19, 92.5])
def test_a_line_has_the_rms_of_its_tone(frequency: float) -> None:
    """Four lines hold all but 0.2 % of the power of a tone between two lines."""
    noise = 1e-6 * np.random.default_rng(2).standard_normal(RATE)
    spectrum = narrow_spectrum(3.0 + tone(frequency, 1e-3) + noise, RATE)
    assert spectrum.line_rms(frequency) == pytest.approx(1e-3, rel=2e-3)
    assert spectrum.line_height(frequency) > 1000
    assert spectrum.line_height(frequency + 50) < 4
    assert spectrum.line_rms(30_000) == 0.0


@pytest.mark.law("Envelope: pulses have lines at their rate, side bands at that of their strength.")
def test_pulses_of_changing_strength_have_side_bands() -> None:
    rate, turn = 147.8, 30.0
    strength = 1 + 0.6 * np.cos(2 * np.pi * turn * T)
    pulses = strength * np.exp(-3000 * (T % (1 / rate))) * np.sin(2 * np.pi * 4000 * T)
    noise = 0.05 * np.random.default_rng(3).standard_normal(RATE)
    spectrum = squared_envelope_spectrum(pulses + noise + tone(100, 50), RATE)
    for frequency in (rate - turn, rate, rate + turn, 2 * rate):
        assert spectrum.line_height(frequency) > 10
    assert spectrum.line_height(rate + 1.5 * turn) < 5
    assert spectrum.frequency_hz[-1] == 8200
    with pytest.raises(ValueError, match="band_hz"):
        squared_envelope_spectrum(pulses, RATE, (3000, 2000))

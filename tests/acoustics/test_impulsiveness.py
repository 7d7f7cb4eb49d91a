"""Peak, crest factor and kurtosis by band, the kurtogram, and velocities from accelerations."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics import band_pulses, kurtogram, squared_envelope_spectrum, velocity_bands, velocity_of
from acoustics.resampling import band_limit

RATE = 48_000
T = np.arange(RATE) / RATE
BANDS = {"low": (50.0, 300.0), "medium": (300.0, 1800.0), "high": (1800.0, 10000.0)}


def knocks(resonance_hz: float, rate_hz: float, height: float = 1.0) -> np.ndarray:
    """Return a resonance that rings up once in each period."""
    since = T % (1 / rate_hz)
    return np.asarray(height * np.exp(-2000 * since) * np.sin(2 * np.pi * resonance_hz * since))


def noise(seed: int, samples: int = RATE) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(samples)


@pytest.mark.law("Impulsiveness: noise has a kurtosis of 3 in each band, within its uncertainty.")
def test_noise_has_a_kurtosis_of_three() -> None:
    """Twelve numbers, of which one may be beyond two standard uncertainties."""
    beyond = 0
    for seed in range(4):
        for pulses in band_pulses(noise(seed), RATE, BANDS).values():
            assert pulses.kurtosis is not None and pulses.kurtosis_uncertainty is not None
            beyond += abs(pulses.kurtosis - 3) > 2 * pulses.kurtosis_uncertainty
            assert pulses.crest_factor == pytest.approx(pulses.peak / pulses.rms)
    assert beyond <= 1


def test_knocks_show_in_the_band_of_their_resonance_alone() -> None:
    record = knocks(4000, 90) + 0.05 * noise(1)
    found = band_pulses(record, RATE, BANDS)
    assert found["high"].kurtosis > 6 > 4 > found["low"].kurtosis
    assert found["high"].crest_factor > found["medium"].crest_factor


def test_a_strong_tone_of_another_band_is_no_knock() -> None:
    """It is 100 dB above them."""
    faint = 1e-5 * knocks(4000, 20)
    tone = np.sin(2 * np.pi * 177.3 * T + 0.3)
    alone = band_pulses(faint, RATE, BANDS)["high"]
    both = band_pulses(tone + faint, RATE, BANDS)["high"]
    assert both.peak == pytest.approx(alone.peak, rel=1e-3)
    assert both.kurtosis == pytest.approx(alone.kurtosis, rel=1e-3) and both.kurtosis > 6


def test_ends_that_do_not_meet_are_no_knock() -> None:
    """A drift jumps by 200 times the noise where a transform closes the record."""
    record = 0.01 * noise(2) + 2 * T
    assert band_pulses(record, RATE, BANDS)["high"].kurtosis < 3.3
    whole = kurtogram(record, RATE, (500, 20000), 500)
    assert whole.kurtosis < 2 * whole.chance


@pytest.mark.law(
    "Kurtogram: the band of knocks holds their resonance, and its envelope their line."
)
@pytest.mark.parametrize("resonance", [1500.0, 4000.0, 8300.0])
def test_the_kurtogram_finds_the_resonance(resonance: float) -> None:
    """Noise of another band hides the knocks in the whole record."""
    hum = 5 * band_limit(noise(3), RATE, (500, 700))
    record = knocks(resonance, 90) + 0.3 * noise(4) + hum
    found = kurtogram(record, RATE, (500, 20000), 500)
    low, high = found.band_hz
    assert low < resonance < high and high - low < 6000
    assert found.stands_out
    in_band = squared_envelope_spectrum(record, RATE, found.band_hz).read_line(90.0).height
    in_all = squared_envelope_spectrum(record, RATE, (500, 20000)).read_line(90.0).height
    assert in_band > 2 * in_all


def test_the_kurtogram_has_the_bands_of_its_tree() -> None:
    found = kurtogram(noise(5), RATE, (0, 12000), 1000)
    widths, counts = np.unique(np.round(found.high_hz - found.low_hz), return_counts=True)
    assert dict(zip(widths.tolist(), counts.tolist(), strict=True)) == {
        1000: 12,
        1500: 8,
        2000: 6,
        3000: 4,
        4000: 3,
        6000: 2,
        12000: 1,
    }


def test_noise_and_silence_have_no_band_that_stands_out() -> None:
    assert sum(kurtogram(noise(s), RATE, (500, 20000), 500).stands_out for s in range(6)) <= 1
    silent = kurtogram(np.zeros(RATE), RATE, (500, 20000), 500)
    assert not silent.stands_out
    assert band_pulses(np.zeros(RATE), RATE, BANDS)["low"].kurtosis is None


def test_a_knock_in_a_band_of_rounding_does_not_count() -> None:
    """It is 120 dB below the record, as the onset of a motion may be."""
    faint = 1e-6 * knocks(8000, 10)
    tones = sum(np.sin(2 * np.pi * hz * T) for hz in (700.0, 760.0))
    low, high = kurtogram(tones + faint, RATE, (500, 20000), 500).band_hz
    assert low < 760 < high


def test_odd_records_and_bands_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 128"):
        band_pulses(np.zeros(100), RATE, BANDS)
    with pytest.raises(ValueError, match="two edges that rise"):
        kurtogram(noise(1), RATE, (500, 30_000)[::-1], 100)
    with pytest.raises(ValueError, match="least_width_hz"):
        kurtogram(noise(1), RATE, (500, 20000), 0)


@pytest.mark.law("Velocity of an acceleration: that of its tones, in the bands of a bearing.")
def test_the_velocity_of_tones() -> None:
    """Tones of 3, 2 and 1 m/s2 rms; a drift leaves nothing in the bands."""
    tones = {"low": (120.0, 3.0), "medium": (900.0, 2.0), "high": (4000.0, 1.0)}
    t = np.arange(5 * RATE) / RATE
    record = sum(np.sqrt(2) * a * np.sin(2 * np.pi * hz * t) for hz, a in tones.values())
    found = velocity_bands(velocity_of(record + 5 * t, RATE), RATE).rms_m_s
    for name, (hz, acceleration) in tones.items():
        assert found[name] == pytest.approx(acceleration / (2 * np.pi * hz), rel=0.01)


def test_bands_end_where_a_record_ends() -> None:
    """A record of 12 kHz has a high band up to 6 kHz, and refuses the whole one."""
    with pytest.raises(ValueError, match="at least 20000"):
        velocity_bands(noise(1), 12_000)
    cut = {"low": (50.0, 300.0), "high": (1800.0, 6000.0)}
    found = velocity_bands(noise(1), 12_000, cut)
    assert found.rms_m_s["high"] == pytest.approx(np.sqrt(4200 / 6000), rel=0.02)
    assert set(found.rms_m_s) == set(cut)

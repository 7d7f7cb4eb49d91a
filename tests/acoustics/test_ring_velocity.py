"""Velocity in the bands of ISO 15242-1, and lines of narrow spectra."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics import narrow_spectrum, squared_envelope_spectrum, velocity_bands
from acoustics.tone_window import REACH, SEPARATED, SIDE_LOBES, lobe, tone_window

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
    """The lobe of the window says what a line has of a tone beside it."""
    noise = 1e-6 * np.random.default_rng(2).standard_normal(RATE)
    spectrum = narrow_spectrum(3.0 + tone(frequency, 1e-3) + noise, RATE)
    assert spectrum.read_line(frequency).rms == pytest.approx(1e-3, rel=2e-3)
    assert spectrum.read_line(frequency).height > 1000
    assert spectrum.read_line(frequency + 50).height < 4
    assert spectrum.read_line(30_000).rms == 0.0


def test_the_lobe_is_the_transform_of_the_window() -> None:
    count = 256
    window = tone_window(count)
    fine = np.abs(np.fft.rfft(window, 32 * count)) / window.sum()
    lines = np.arange(len(fine)) / 32
    near = lines < 12
    assert np.abs(lobe(lines[near]) - fine[near]).max() < 1e-4
    assert fine[lines >= REACH].max() < SIDE_LOBES


SHORT_RATE = 4800
SHORT_T = np.arange(SHORT_RATE) / SHORT_RATE  # a record of 1 s, whose lines are 1 Hz apart
APART = (0.1, 0.3, 0.5, 1.0, 1.5, 2.0, 2.4, 3.0, 3.4, 3.8, 4.0, 4.2, 4.6, 5.0, 8.0, 20.0)


def short_tone(frequency_hz: float, rms: float, phase: float) -> np.ndarray:
    return np.asarray(np.sqrt(2) * rms * np.cos(2 * np.pi * frequency_hz * SHORT_T + phase))


@pytest.mark.law("Lines: beside a tone no line is claimed that is not there.")
@pytest.mark.parametrize("noise", [0.0, 1e-3, 3e-2])
@pytest.mark.parametrize("apart", APART)
def test_no_line_is_claimed_beside_a_tone(noise: float, apart: float) -> None:
    """The tone lies between two lines of the spectrum, and itself keeps its level."""
    random = np.random.default_rng(int(10 * apart))
    for side in (-apart, apart):
        at = 400 + random.uniform()
        record = short_tone(at, 1.0, random.uniform(0, 7))
        record = record + noise * random.standard_normal(len(record))
        spectrum = narrow_spectrum(record, SHORT_RATE)
        absent = spectrum.read_line(at + side, [at])
        assert absent.rms is None or absent.height < 5
        assert spectrum.read_line(at, [at + side]).rms == pytest.approx(1.0, rel=0.01)


@pytest.mark.law("Lines: two tones are read within 5 %, or the length that separates them is told.")
@pytest.mark.parametrize("ratio", [1.0, 0.3, 0.1, 0.01, 1e-3])
@pytest.mark.parametrize("apart", [apart for apart in APART if apart >= 1.5])
def test_two_tones_keep_their_levels(apart: float, ratio: float) -> None:
    random = np.random.default_rng(int(10 * apart))
    for side in (-apart, apart):
        at = 400 + random.uniform()
        record = short_tone(at, 1.0, random.uniform(0, 7))
        record += short_tone(at + side, ratio, random.uniform(0, 7))
        spectrum = narrow_spectrum(record, SHORT_RATE)
        for frequency, other, rms in ((at, at + side, 1.0), (at + side, at, ratio)):
            reading = spectrum.read_line(frequency, [other])
            if reading.rms is None:
                assert apart < SEPARATED
                assert reading.resolving_s == pytest.approx(SEPARATED / apart, rel=0.1)
            else:
                assert reading.rms == pytest.approx(rms, rel=0.05)
        assert apart < SEPARATED or spectrum.read_line(at + side, [at]).rms is not None


def test_the_length_that_is_told_resolves_a_line() -> None:
    """A line of a tenth, two lines beside a tone, is hidden in 1 s."""
    record = short_tone(400.3, 1.0, 0.0) + short_tone(402.3, 0.1, 1.0)
    hidden = narrow_spectrum(record, SHORT_RATE).read_line(402.3)
    assert hidden.rms is None and hidden.resolving_s is not None
    t = np.arange(round(hidden.resolving_s * SHORT_RATE)) / SHORT_RATE
    longer = np.cos(2 * np.pi * 400.3 * t) + 0.1 * np.cos(2 * np.pi * 402.3 * t + 1)
    found = narrow_spectrum(longer, SHORT_RATE).read_line(402.3)
    assert found.rms == pytest.approx(0.1 / np.sqrt(2), rel=0.05)


@pytest.mark.law("Lines: the flank of tones that make one peak is no line.")
@pytest.mark.parametrize("apart", [1.6, 1.9, 2.2])
def test_the_flank_of_two_tones_is_no_line(apart: float) -> None:
    """Two tones in one lobe make a wider flank than a tone would."""
    for phase in np.arange(0, 6, 0.5):
        record = short_tone(400.3, 1.0, 0.0) + short_tone(400.3 + apart, 0.7, phase)
        spectrum = narrow_spectrum(record, SHORT_RATE)
        for beyond in (1.0, 1.8, 2.5, 3.0, 3.5):
            reading = spectrum.read_line(400.3 + apart + beyond)
            assert reading.rms is None or reading.height < 5, (phase, beyond)


def test_a_tone_that_may_be_either_of_two_lines_is_none_of_them() -> None:
    """A faint tone in noise, between two lines that are half a line apart."""
    noise = np.random.default_rng(4).standard_normal(SHORT_RATE)
    spectrum = narrow_spectrum(short_tone(400.05, 0.2, 0.3) + 0.2 * noise, SHORT_RATE)
    assert spectrum.read_line(400.0).rms == pytest.approx(0.2, rel=0.1)
    reading = spectrum.read_line(400.0, [400.1])
    assert reading.rms is None and reading.resolving_s == pytest.approx(SEPARATED / 0.1)


def test_a_hidden_line_asks_for_a_longer_record() -> None:
    """Places beside crowded tones of a record of half a second, on flanks of several of them."""
    random = np.random.default_rng(70)
    seconds = np.arange(2400) / 4800
    asked = list[float]()
    for _ in range(6):
        hz, phase = random.uniform(20, 400, (30, 1)), random.uniform(0, 6, (30, 1))
        tones = 10 ** random.uniform(-2, 0, (30, 1)) * np.sin(2 * np.pi * hz * seconds + phase)
        spectrum = narrow_spectrum(tones.sum(axis=0), 4800)
        readings = [spectrum.read_line(float(place)) for place in random.uniform(20, 400, 30)]
        asked += [found.resolving_s for found in readings if found.resolving_s is not None]
    assert len(asked) > 50
    assert min(asked) > 0.5


@pytest.mark.law("Envelope: pulses have lines at their rate, side bands at that of their strength.")
def test_pulses_of_changing_strength_have_side_bands() -> None:
    rate, turn = 147.8, 30.0
    strength = 1 + 0.6 * np.cos(2 * np.pi * turn * T)
    pulses = strength * np.exp(-3000 * (T % (1 / rate))) * np.sin(2 * np.pi * 4000 * T)
    noise = 0.05 * np.random.default_rng(3).standard_normal(RATE)
    spectrum = squared_envelope_spectrum(pulses + noise + tone(100, 50), RATE)
    for frequency in (rate - turn, rate, rate + turn, 2 * rate):
        assert spectrum.read_line(frequency).height > 10
    assert spectrum.read_line(rate + 1.5 * turn).height < 5
    assert spectrum.frequency_hz[-1] == 8200
    with pytest.raises(ValueError, match="band_hz"):
        squared_envelope_spectrum(pulses, RATE, (3000, 2000))

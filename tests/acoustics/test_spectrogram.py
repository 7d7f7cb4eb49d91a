"""Spectrograms keep known densities, tones, chirps and energies, wherever a loop is cut."""

import numpy as np
import pytest

from acoustics.bands import EDGES_HZ
from acoustics.radiation import P_REF_PA
from acoustics.resampling import band_limit
from acoustics.spectrum import ROW_EDGES_HZ, spectrogram

RATE = 48000
WIDTHS = np.diff(ROW_EDGES_HZ)


def noise(seed, n):
    return np.random.default_rng(seed).standard_normal(n)


def density(found):
    """Return the density in Pa^2/Hz, 0 where there is none."""
    return np.nan_to_num(10.0 ** (found.level_db / 10.0) * P_REF_PA**2)


def test_rows_are_quarters_of_third_octaves():
    np.testing.assert_allclose(ROW_EDGES_HZ[::4], EDGES_HZ, rtol=1e-14)


def test_white_noise_is_flat():
    found = spectrogram(noise(1, 10 * RATE), RATE)
    # Mean over 10 s: relative spread 1/sqrt(B T) with B no less than the noise bandwidth of a line,
    # 30 Hz: 6 % and less above; neighbours of a narrow row are the same line. Four of these.
    mean = density(found).mean(axis=1) * RATE / 2.0
    allowed = 4.0 / np.sqrt(np.maximum(WIDTHS, found.enbw_hz) * 10.0)
    assert np.all(np.abs(mean - 1.0) < allowed)
    # A single frame of Hann has the effective length T/2.08: so many lines of a row spread in time.
    top = WIDTHS > 500.0
    spread = density(found)[top].std(axis=1) / density(found)[top].mean(axis=1)
    np.testing.assert_allclose(
        spread, np.sqrt(2.08 / (WIDTHS[top] * found.frame_s)), rtol=0.2
    )  # 400 frames: 4 %, 5 of these


@pytest.mark.parametrize(
    ("seconds", "frame_s", "frames"), [(0.5, 0.04, 200), (0.05, 0.004, 200), (60.0, 0.3, 400)]
)
def test_frames_fit_the_record(seconds, frame_s, frames):
    found = spectrogram(noise(2, round(seconds * RATE)), RATE)
    assert found.frame_s == pytest.approx(frame_s, rel=1e-9) and found.level_db.shape == (
        124,
        frames,
    )
    assert found.hop_s <= found.frame_s / 2.0
    # Evenly over the record, as far from either end.
    assert found.time_s[0] == pytest.approx(seconds - found.time_s[-1], abs=1.0 / RATE)
    assert found.enbw_hz == pytest.approx(1.5 / found.frame_s)


@pytest.mark.law("Spectrogram: a loop keeps its energy.")
@pytest.mark.parametrize("n", [24000, 24001, 9600])
def test_a_loop_keeps_its_energy(n):
    # Frames every 16th of a Hann window weigh all samples alike (to rounding); what is left of a
    # hop at the end does not.
    record = band_limit(noise(3, n), RATE, (30.0, 20000.0))
    found = spectrogram(record, RATE)
    mean_square = (density(found) * WIDTHS[:, np.newaxis]).sum(axis=0).mean()
    # Lines of 25 Hz smear 1e-4 beyond the outer rows; the hops that do not fill the record are
    # 1/200 of it.
    assert mean_square == pytest.approx(np.mean(record**2), rel=3e-3)


def test_level_of_a_tone():
    # On a line, 1 kHz: the row of 58 Hz holds the three lines of Hann in part: 1/6, 2/3, 1/6 of the
    # mean square.
    found = spectrogram(np.sin(2.0 * np.pi * 1000.0 * np.arange(24000) / RATE), RATE)
    row = int(np.searchsorted(ROW_EDGES_HZ, 1000.0)) - 1
    rows = density(found)[row - 3 : row + 4] * WIDTHS[row - 3 : row + 4, np.newaxis]
    np.testing.assert_allclose(rows.sum(axis=0), 0.5, rtol=1e-9)  # in every frame, all around it
    # Far below, where rows are narrower than lines, 100 Hz stands as density over the noise
    # bandwidth.
    low = spectrogram(np.sin(2.0 * np.pi * 100.0 * np.arange(24000) / RATE), RATE)
    at = int(np.searchsorted(ROW_EDGES_HZ, 100.0)) - 1
    np.testing.assert_allclose(density(low)[at], 0.5 / low.enbw_hz, rtol=1e-9)


def test_ridge_of_a_chirp():
    # From 200 Hz to 12.8 kHz in 2 s, 3 octaves a second: a frame of 40 ms sweeps 0.12 octaves, so
    # one to two rows.
    t = np.arange(2 * RATE) / RATE
    rate = np.log(64.0) / 2.0
    found = spectrogram(np.sin(2.0 * np.pi * 200.0 * np.expm1(rate * t) / rate), RATE, closed=False)
    middles = np.sqrt(ROW_EDGES_HZ[1:] * ROW_EDGES_HZ[:-1])
    inner = (found.time_s > 0.1) & (found.time_s < 1.9)
    # What a row holds: densities of a chirp fall as 1/f, so the ridge is that of density times
    # width.
    ridge = middles[np.argmax(density(found)[:, inner] * WIDTHS[:, np.newaxis], axis=0)]
    octaves = np.log2(ridge / (200.0 * np.exp(rate * found.time_s[inner])))
    # Half a row is 0.042 octaves, a line at 300 Hz 0.06.
    assert np.max(np.abs(octaves)) < 0.12 and abs(np.mean(octaves)) < 0.02


def test_what_is_not_known_or_not_there_is_nan():
    record = noise(5, 4800)
    assert np.all(np.isnan(spectrogram(np.zeros(4800), RATE).level_db))
    known = spectrogram(record, RATE, highest_hz=1000.0)
    assert np.all(np.isnan(known.level_db).any(axis=1) == (ROW_EDGES_HZ[1:] > 1000.0))
    assert np.all(np.isnan(spectrogram(record, 16000.0).level_db[ROW_EDGES_HZ[1:] > 8000.0]))

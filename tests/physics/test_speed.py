"""The same release per metre at another speed is the same sound, shifted."""

from __future__ import annotations

import numpy as np
import pytest
from scene_sounds import sound_of_release
from scene_text import PLAIN

from rolling.scene.file import loads

# A lap of 2 mm takes 20 ms at 0.1 m/s.
STEP = 2e-6
STEPS = 1000
LINES = np.array([4, 9, 25, 60])  # cycles per lap: 200 Hz to 3 kHz at 0.1 m/s


@pytest.mark.law(
    "Speed: a speed times c multiplies the release power by c and every frequency of the sound "
    "by c."
)
@pytest.mark.parametrize("c", [0.5, 2, 3])
def test_speed_times_c(c: float) -> None:
    """With q and distance given, p = sqrt(rho c / rms(I')) I' follows the root of the power.

    Only rounding was measured.
    """
    phase = 2 * np.pi * np.arange(STEPS) / STEPS
    energy = 1e-9 * (1 + 0.1 * np.cos(phase[:, None] * LINES + LINES).sum(axis=1))
    base, fast = (
        sound_of_release(
            loads(
                PLAIN, [f"rolling.speed_m_s={0.1 * factor}", f"rolling.duration_s={0.02 / factor}"]
            ),
            energy,
            STEP,
            True,
        )
        for factor in (1, c)
    )
    assert fast.duration == pytest.approx(base.duration / c, rel=1e-12)
    np.testing.assert_allclose(fast.power, c * base.power, rtol=1e-12)
    assert fast.mean_power == pytest.approx(c * base.mean_power, rel=1e-12)
    lines = [np.fft.rfft(sound.pressure) / len(sound.pressure) for sound in (base, fast)]
    largest = np.abs(lines[0]).max()
    # Entry k of either spectrum stands at k / duration: c times as high.
    np.testing.assert_allclose(lines[1][LINES], np.sqrt(c) * lines[0][LINES], rtol=1e-9)
    for spectrum in lines:
        assert np.abs(np.delete(spectrum, LINES)).max() < 1e-9 * largest


@pytest.mark.parametrize("closes", [False, True])
@pytest.mark.parametrize("speed", ["0.1", "[[0, 0.1], [0.02, 0.1000001]]"], ids=["same", "changes"])
def test_faded_ends_leave_the_level_of_a_stationary_noise(speed: str, closes: bool) -> None:
    """A tenth at either end would take 0.58 dB off a record."""
    keys = ["rolling.duration_s=0.02", "sound.gain_pa_per_w_m2=1"]
    levels = []
    for seed in range(20):
        energy = 1e-9 * (1 + 0.1 * np.random.default_rng(seed).standard_normal(STEPS))
        levels += [
            sound_of_release(loads(PLAIN, [f"rolling.speed_m_s={v}", *keys]), energy, STEP, closed)
            for v, closed in ((0.1, True), (speed, closes))
        ]
    difference = [sound.levels.level_db or 0.0 for sound in levels]
    # The scatter of the mean is 0.02 dB.
    assert abs(np.mean(difference[1::2]) - np.mean(difference[::2])) < 0.1

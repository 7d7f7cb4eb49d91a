"""The stretch of a longer record that fits a shorter one, on records whose place is known."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.recordings.stretch import fitting_stretch

RATE = 48000


def coloured(seed: int, samples: int, low: float, high: float) -> np.ndarray:
    """Return noise between two frequencies [Hz]."""
    lines = np.fft.rfft(np.random.default_rng(seed).standard_normal(samples))
    frequency = np.fft.rfftfreq(samples, 1 / RATE)
    lines[(frequency < low) | (frequency > high)] = 0
    return np.fft.irfft(lines, samples)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_waveform_is_found_to_the_sample_in_noise_as_strong_as_itself(sign: int) -> None:
    run = coloured(1, RATE, 100, 5000)
    recording = run.std() * np.random.default_rng(2).standard_normal(3 * RATE)
    recording[31000 : 31000 + RATE] += sign * run
    stretch = fitting_stretch([recording], [run], 20000.0)
    assert stretch is not None and stretch.coefficient is not None
    assert (stretch.first, stretch.length) == (31000, RATE)
    assert stretch.is_reversed == (sign < 0,)


def test_other_noise_of_the_same_shape_is_found_within_a_frame_and_has_no_correlation() -> None:
    """A frame is a twelfth of the run. Noise of another surface has another waveform."""
    run = coloured(1, RATE // 2, 500, 3000)
    recording = 1e-3 * np.random.default_rng(2).standard_normal(3 * RATE)
    place = round(1.3 * RATE)
    recording[place : place + len(run)] += 5 * coloured(9, len(run), 500, 3000)
    stretch = fitting_stretch([recording], [run], 20000.0)
    assert stretch is not None and stretch.coefficient is None
    assert abs(stretch.first - place) <= len(run) / 12


def test_all_of_a_steady_record_is_compared_and_so_are_nearly_equal_lengths() -> None:
    run = coloured(1, RATE // 2, 500, 3000)
    assert fitting_stretch([coloured(9, 3 * RATE, 500, 3000)], [run], 20000.0) is None
    assert fitting_stretch([coloured(9, RATE // 2 + 900, 500, 3000)], [run], 20000.0) is None


def test_channels_of_one_recording_have_one_place() -> None:
    """The channel without the run in it does not mislead: the other one decides."""
    run = [coloured(seed, RATE, 100, 5000) for seed in (1, 2)]
    recording = [coloured(seed, 2 * RATE, 100, 5000) for seed in (3, 4)]
    recording[1][7000 : 7000 + RATE] += 3 * run[1]
    stretch = fitting_stretch(recording, run, 20000.0)
    assert stretch is not None and stretch.first == 7000

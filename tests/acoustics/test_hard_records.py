"""Extreme records give numbers, or None where there is no sound, and no warning."""

import dataclasses
import json
import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acoustics import wav
from acoustics.level import sound_levels
from acoustics.spectrum import spectrogram, welch
from acoustics.uncertainty import level_uncertainty, steady_uncertainty_db

RATE = 48000
WHOLE = ("laeq_db", "level_db", "laf_max_db", "las_max_db", "lz_peak_db")


def record(kind, n, seed):
    rng = np.random.default_rng(seed)
    t = np.arange(n) / RATE
    return {
        "silence": np.zeros(n),
        "steady": np.ones(n),
        "nearly steady": 1.0 + 1e-14 * rng.standard_normal(n),
        "tone": np.sin(2.0 * np.pi * rng.uniform(0.0, RATE / 2.0) * t),
        "nyquist": (-1.0) ** np.arange(n),
        "click": (np.arange(n) == n // 2) * 1.0,
        "noise": rng.standard_normal(n),
    }[kind]


@pytest.mark.slow
@settings(max_examples=250, deadline=None)
@given(
    kind=st.sampled_from(
        ["silence", "steady", "nearly steady", "tone", "nyquist", "click", "noise"]
    ),
    n=st.sampled_from([1, 2, 3, 5, 17, 100, 479, 2399, 4801]),
    size=st.sampled_from([1e-320, 1e-310, 1e-200, 1e-160, 1e-140, 1e-10, 1.0, 1e10, 1e37, 1e140]),
    closed=st.booleans(),
    own_factor=st.booleans(),
    highest=st.sampled_from([math.inf, 10.0, 1000.0]),
    seed=st.integers(0, 99),
)
def test_any_record(kind, n, size, closed, own_factor, highest, seed):
    pressure = size * record(kind, n, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        levels = sound_levels(pressure, RATE, highest, closed)
        stated = level_uncertainty(pressure, RATE, levels, own_factor)
        steady = steady_uncertainty_db(pressure, RATE)
        frames = spectrogram(pressure, RATE, highest, closed)
        density = welch(pressure, RATE)
        gain = wav.listening_gain(pressure)
        for bits in (16, 24):
            wav.listening(pressure, gain, "", "", bits)
    json.dumps(
        [dataclasses.asdict(levels), dataclasses.asdict(stated), steady, gain], allow_nan=False
    )
    for name in WHOLE:
        assert (getattr(levels, name) is None) == (getattr(stated, name) is None)
        assert getattr(stated, name) is None or getattr(stated, name) >= 0.0
    assert not np.any(np.isinf(frames.level_db)) and np.all(np.isfinite(density.psd))
    assert 0.0 < gain < math.inf
    if levels.laeq_db is not None and closed:  # the mean of the weighting is the mean square
        assert levels.laf_max_db >= levels.laeq_db - 1e-9
    if levels.level_db is not None:
        assert levels.lz_peak_db >= levels.level_db - 1e-9


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e-145])
def test_a_mean_square_that_is_hardly_a_number_is_silence(size):
    # Its parts would have a few digits, or none: some levels there and others not.
    levels = sound_levels(size * record("noise", 480, 1), RATE)
    assert {getattr(levels, name) for name in WHOLE} == {None}
    assert {*levels.third_octave_db.values(), *levels.third_octave_a_db.values()} == {None}


def test_the_gain_of_the_smallest_numbers_is_a_number():
    # -1 dB of full scale over 1e-320 would be 1e320.
    assert wav.listening_gain(1e-320 * record("noise", 480, 1)) == 1.0

"""Resampling and interpolation against the package's own requirements."""

from __future__ import annotations

import math

import numpy as np

from acoustics.arrays import Array
from acoustics.level import sound_levels
from acoustics.resampling import (
    band_limit,
    fade,
    interpolate_closed,
    resample_closed,
    undo_step_mean,
)
from acoustics.wav import SAMPLE_RATE_HZ
from conformance.rows import ONE_PA_DB, Row, Table, known, suppression_db

# Requirements: attenuation of an alias or an error, and ripple in the audible band.
REJECTION_DB = 80.0
RIPPLE_DB = 0.1

_FADE_S = 0.01

STEP_RATE_HZ = 50_000  # steps of 2 um at 0.1 m/s


def step_means(frequency_hz: float, samples: int, rate_hz: float) -> Array:
    """Return the means over consecutive steps of a sine of 1 Pa rms, in closed form (samples,)."""
    omega = 2.0 * np.pi * frequency_hz / rate_hz
    means: Array = -math.sqrt(2.0) / omega * np.diff(np.cos(omega * np.arange(samples + 1)))
    return means


def resampled_levels() -> Table:
    """Measure sines from step means to 48 kHz through every stage of the program."""
    rows = []
    for rate_hz, frequencies_hz in (
        (STEP_RATE_HZ, (20, 63, 200, 630, 2000, 6300, 12500, 16000, 20000)),
        (40_960, (20, 1000, 20000)),
        (52_361, (20, 1000, 20000)),
        (100_000, (20, 1000, 20000)),
        (250_000, (20, 1000, 20000)),
    ):
        for frequency_hz in frequencies_hz:
            at_steps = undo_step_mean(step_means(frequency_hz, rate_hz, rate_hz))
            record = band_limit(resample_closed(at_steps, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
            measured = known(sound_levels(record, SAMPLE_RATE_HZ).level_db) - ONE_PA_DB
            rows.append(
                Row((f"{rate_hz}", f"{frequency_hz}"), 0.0, measured, -RIPPLE_DB, RIPPLE_DB)
            )
    return Table(
        "Resampling: level of sines",
        f"the limit of {RIPPLE_DB:g} dB",
        "own requirement: ripple below 0.1 dB up to 20 kHz",
        "Does the way from steps to samples keep the level? The signals are step "
        "means of a sine of 1 Pa rms over 1 s, in closed form. They go through "
        "`resampling.undo_step_mean`, `resample_closed` to 48 kHz and `band_limit`. Computed is"
        " their level minus 93.98 dB. 50 kHz is 2 um at 0.1 m/s.",
        ("steps per s", "f Hz"),
        "dB",
        3,
        tuple(rows),
    )


def step_mean_correction() -> Table:
    """Measure the gain of `undo_step_mean` against the sinc of averaging."""
    rows = []
    for frequency_hz in (1000, 5000, 10000, 16000, 20000, 22000, 24000):
        means = step_means(frequency_hz, STEP_RATE_HZ, STEP_RATE_HZ)
        expected = float(-20.0 * np.log10(np.sinc(frequency_hz / STEP_RATE_HZ)))
        computed = float(10.0 * np.log10(np.mean(undo_step_mean(means) ** 2) / np.mean(means**2)))
        rows.append(Row((f"{frequency_hz}",), expected, computed, -RIPPLE_DB, RIPPLE_DB))
    return Table(
        "Resampling: correction of the step means",
        f"the limit of {RIPPLE_DB:g} dB",
        "own requirement: ripple below 0.1 dB up to 20 kHz",
        "Is the mean over a step undone? Averaging over a step multiplies by "
        "sinc(f/rate). Expected is -20 lg sinc(f / 50 kHz). Computed is the gain of "
        "`resampling.undo_step_mean` on the step means of a sine.",
        ("f Hz",),
        "dB",
        3,
        tuple(rows),
    )


def alias_rejection() -> Table:
    """Measure the remainder at 48 kHz of tones above 24 kHz."""
    rows = []
    for rate_hz, frequencies_hz in (
        (STEP_RATE_HZ, (24_001, 24_500, 24_999)),
        (100_000, (24_001, 25_000, 30_000, 40_000, 49_999)),
        (250_000, (24_001, 48_000, 72_000, 124_999)),
    ):
        for frequency_hz in frequencies_hz:
            # The phase is counted in whole steps of the record, so the tone is pure except for
            # rounding.
            signal = np.sin(
                2.0 * np.pi * (np.arange(rate_hz) * frequency_hz % rate_hz) / rate_hz + 0.4
            )
            left = np.mean(resample_closed(signal, SAMPLE_RATE_HZ) ** 2) / np.mean(signal**2)
            rows.append(_suppression_row((f"{rate_hz}", f"{frequency_hz}"), float(left)))
    return Table(
        "Resampling: rejection of aliases",
        f"the limit of {REJECTION_DB:g} dB",
        "own requirement: rejection above 80 dB",
        "Do tones above 24 kHz fold back into hearing? Computed is their level "
        "before, minus their level after `resampling.resample_closed` to 48 kHz.",
        ("steps per s", "f Hz"),
        "dB",
        1,
        tuple(rows),
    )


def varying_speed() -> Table:
    """Measure the error of interpolation between samples, and of a track at varying speed."""
    samples = 5000
    rows = []
    index = np.linspace(0.0, samples, 7 * samples, endpoint=False) + 0.123
    for share in (0.1, 0.25, 0.5, 0.8, 0.9):
        omega = 2.0 * np.pi * round(share * samples / 2.0) / samples
        exact = np.sin(omega * index + 0.3)
        computed = interpolate_closed(np.sin(omega * np.arange(samples) + 0.3), index)
        keys = (f"f = {share:g} of Nyquist", "everywhere")
        rows.append(
            _suppression_row(keys, float(np.mean((computed - exact) ** 2) / np.mean(exact**2)))
        )
    for top_hz in (1000, 5000, 10000, 20000):
        rows.append(
            _suppression_row(
                (f"sweep from {top_hz // 2} to {top_hz} Hz", "inner 90 %"), _sweep_error(top_hz)
            )
        )
    return Table(
        "Resampling: varying speed",
        f"the limit of {REJECTION_DB:g} dB",
        "own requirement: error below -80 dB",
        "How exact is a record of changing speed? The first signals are sines that "
        "`resampling.interpolate_closed` reads between the samples. The others are sines along "
        "a track of 2 um steps, passed at 0.1 to 0.2 m/s. They go from step means to 48 kHz as "
        "in the program, and are faded by 10 ms. Computed is the mean square of the signal over"
        " that of its error.",
        ("signal", "compared"),
        "dB",
        1,
        tuple(rows),
    )


def _sweep_error(top_hz: float) -> float:
    """Return the relative mean square error of a sine along a track at rising speed."""
    step_m = 2e-6
    slow = 0.1
    fast = 0.2
    duration_s = 0.5
    samples = round(duration_s * SAMPLE_RATE_HZ)
    oversampling = math.ceil(fast / step_m / SAMPLE_RATE_HZ)
    steps = round(0.5 * (slow + fast) * duration_s / step_m)
    waves = round(steps * step_m * top_hz / fast)

    def steps_passed(time_s: Array) -> Array:
        return (slow * time_s + 0.5 * (fast - slow) / duration_s * time_s**2) / step_m

    at_steps = undo_step_mean(step_means(waves, steps, steps))
    fine_s = np.arange(samples * oversampling) / (SAMPLE_RATE_HZ * oversampling)
    in_time = fade(
        interpolate_closed(at_steps, steps_passed(fine_s)),
        round(_FADE_S * SAMPLE_RATE_HZ * oversampling),
    )
    inner = slice(samples // 20, -samples // 20)
    computed = resample_closed(in_time, samples)[inner]
    time_s = np.arange(samples)[inner] / SAMPLE_RATE_HZ
    exact = math.sqrt(2.0) * np.sin(2.0 * np.pi * waves / steps * steps_passed(time_s))
    return float(np.mean((computed - exact) ** 2) / np.mean(exact**2))


def _suppression_row(keys: tuple[str, ...], left: float) -> Row:
    return Row(keys, math.inf, suppression_db(left), REJECTION_DB, math.inf)

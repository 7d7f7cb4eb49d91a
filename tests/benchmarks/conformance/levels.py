"""A-weighting, time weightings and levels against IEC 61672-1:2013."""

from __future__ import annotations

import math

import numpy as np

from acoustics.level import FAST_S, SLOW_S, a_weighted, level_db, running_mean_square, sound_levels
from acoustics.radiation import P_REF_PA
from acoustics.resampling import band_limit
from acoustics.wav import SAMPLE_RATE_HZ
from acoustics.weighting import a_weighting_db
from conformance import standards
from conformance.rows import ONE_PA_DB, Row, Table, known, tone

# own limit for rounding and interpolation, where no standard gives a limit
LEVEL_LIMIT_DB = 0.01


def whole_periods(frequency_hz: float, longest_s: float = 1.0) -> int:
    """Return the samples of the longest record that nearly holds a whole number of periods.

    The record is at most ``longest_s`` long.
    """
    samples = np.rint(
        np.arange(1, int(longest_s * frequency_hz) + 1) * SAMPLE_RATE_HZ / frequency_hz
    )
    periods = samples * frequency_hz / SAMPLE_RATE_HZ
    return int(samples[np.argmin(np.abs(periods - np.rint(periods)))])


def a_weighting() -> Table:
    """Measure a sine with `sound_levels` at each frequency of the standard's table."""
    rows = []
    for row in standards.A_WEIGHTING:
        frequency_hz = 10.0 ** (row.n / 10.0)
        measured = sound_levels(tone(frequency_hz, whole_periods(frequency_hz)), SAMPLE_RATE_HZ)
        computed = known(measured.laeq_db) - known(measured.level_db)
        keys = (
            f"{row.nominal_hz:g}",
            f"{frequency_hz:.2f}",
            f"{round(float(a_weighting_db(frequency_hz)), 2) + 0.0:.2f}",
        )
        rows.append(Row(keys, row.a_db, computed, row.lower_db, row.upper_db))
    return Table(
        "A-weighting",
        "class 1",
        "IEC 61672-1:2013, 5.5 and Table 3",
        "Is the A-weighting that of the standard? The signals are sines of 1 Pa rms "
        "at the exact frequencies 10^(n/10) Hz, sampled at 48 kHz. A record lasts up to 1 s, "
        "and holds nearly a whole number of periods. Computed is LAeq minus LZeq of "
        "`level.sound_levels`. *Formula* is that of annex E, `weighting.a_weighting_db`. "
        "Expected is the standard's table, rounded to 0.1 dB.",
        ("nominal Hz", "exact Hz", "formula dB"),
        "dB",
        2,
        tuple(rows),
    )


def tone_bursts() -> Table:
    """Measure maximum and exposure levels of 4 kHz bursts, minus the level of the steady tone."""
    steady_db = known(sound_levels(tone(4000.0, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ).laeq_db)
    fast = []
    slow = []
    exposure = []
    for row in standards.TONE_BURSTS:
        record = np.zeros(round(1.5 * SAMPLE_RATE_HZ))
        burst = tone(4000.0, round(row.duration_ms * 1e-3 * SAMPLE_RATE_HZ), phase=0.0)
        start = round(0.2 * SAMPLE_RATE_HZ)
        record[start : start + len(burst)] = burst
        measured = sound_levels(record, SAMPLE_RATE_HZ, closed=False)
        length = f"{row.duration_ms:g}"
        fast.append(
            _burst_row(
                "LAFmax",
                length,
                row.fast_db,
                known(measured.laf_max_db) - steady_db,
                row.fast_lower_db,
                row,
            )
        )
        if row.slow_db is not None and row.slow_lower_db is not None:
            slow.append(
                _burst_row(
                    "LASmax",
                    length,
                    row.slow_db,
                    known(measured.las_max_db) - steady_db,
                    row.slow_lower_db,
                    row,
                )
            )
        exposure_db = known(measured.laeq_db) + 10.0 * math.log10(len(record) / SAMPLE_RATE_HZ)
        exposure.append(
            _burst_row(
                "LAE", length, row.exposure_db, exposure_db - steady_db, row.fast_lower_db, row
            )
        )
    return Table(
        "Tone bursts",
        "class 1",
        "IEC 61672-1:2013, 5.9 and Table 4",
        "Are short events weighted right in time? The signals are bursts of 4 kHz in "
        "silence, which begin at a zero of the sine, sampled at 48 kHz. Computed are LAFmax and"
        " LASmax of `level.sound_levels` (record not closed), and the sound exposure level LAE "
        "= LAeq + 10 lg(T / 1 s). Each is less LAeq of the steady tone. The A-weighting has no "
        "phase here, and a short burst shows this.",
        ("level", "burst ms"),
        "dB",
        2,
        (*fast, *slow, *exposure),
    )


def _burst_row(
    name: str, length: str, expected: float, computed: float, lower: float, row: standards.BurstRow
) -> Row:
    return Row((name, length), expected, computed, lower, row.upper_db)


def decay_rates() -> Table:
    """Measure the rate at which the running levels fall after a steady tone."""
    record = np.concatenate([tone(4000.0, SAMPLE_RATE_HZ, phase=0.0), np.zeros(2 * SAMPLE_RATE_HZ)])
    weighted = a_weighted(record, SAMPLE_RATE_HZ)
    rows = []
    for row, time_constant_s in zip(standards.DECAY_RATES, (FAST_S, SLOW_S), strict=True):
        running = running_mean_square(weighted, SAMPLE_RATE_HZ, time_constant_s, closed=False)
        first = running[round(1.1 * SAMPLE_RATE_HZ)]
        last = running[round(2.1 * SAMPLE_RATE_HZ)]
        computed = known(level_db(float(first))) - known(level_db(float(last)))
        rows.append(Row((row.weighting,), row.rate_db_s, computed, row.lower_db_s, row.upper_db_s))
    return Table(
        "Decay of the time weightings",
        "class 1",
        "IEC 61672-1:2013, 5.8.2",
        "Do Fast and Slow fall at the right rate? The signal is 4 kHz for 1 s, then "
        "silence. Computed is the fall of the A-weighted level of `level.running_mean_square` "
        "from 0.1 s to 1.1 s after the end of the tone.",
        ("time weighting",),
        "dB/s",
        2,
        tuple(rows),
    )


def steady_tone() -> Table:
    """Compare the levels of a steady tone with one another."""
    steady = sound_levels(tone(1000.0, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
    limit = standards.STEADY_LIMIT_DB
    return Table(
        "Steady tone: Slow and time average against Fast",
        "class 1",
        "IEC 61672-1:2013, 5.8.3",
        "Do all weightings agree on a steady tone? The signal is 1 kHz for 1 s, "
        "closed. Computed are LASmax and LAeq, each minus LAFmax.",
        ("level",),
        "dB",
        3,
        tuple(
            Row((name,), 0.0, known(level) - known(steady.laf_max_db), -limit, limit)
            for name, level in (("LASmax", steady.las_max_db), ("LAeq", steady.laeq_db))
        ),
    )


def levels() -> Table:
    """Compare levels with amplitudes, and sums with their parts."""
    calibrator = sound_levels(tone(1000.0, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
    threshold = sound_levels(P_REF_PA * tone(1000.0, SAMPLE_RATE_HZ), SAMPLE_RATE_HZ)
    noise = band_limit(
        np.random.default_rng(1).standard_normal(SAMPLE_RATE_HZ // 2), SAMPLE_RATE_HZ
    )
    of_noise = sound_levels(noise, SAMPLE_RATE_HZ)
    rows = (
        ("sine of 1 Pa rms, 1 kHz: LZeq", ONE_PA_DB, calibrator.level_db),
        ("sine of 1 Pa rms, 1 kHz: LAeq", ONE_PA_DB, calibrator.laeq_db),
        (
            "sine of 1 Pa rms, 1 kHz: third octave 1000",
            ONE_PA_DB,
            calibrator.third_octave_db["1000"],
        ),
        (
            "sine of 1 Pa rms, 1 kHz: LZpeak",
            ONE_PA_DB + 10.0 * math.log10(2.0),
            calibrator.lz_peak_db,
        ),
        ("sine of 20 uPa rms, 1 kHz: LAeq", 0.0, threshold.laeq_db),
        (
            "noise: LZeq against the mean square in time",
            level_db(float(np.mean(noise**2))),
            of_noise.level_db,
        ),
        (
            "noise: third octaves added up against LZeq",
            of_noise.level_db,
            _sum_db(of_noise.third_octave_db),
        ),
        (
            "noise: A-weighted third octaves against LAeq",
            of_noise.laeq_db,
            _sum_db(of_noise.third_octave_a_db),
        ),
    )
    return Table(
        "Levels",
        f"the limit of {LEVEL_LIMIT_DB:g} dB",
        "own requirement: levels within 0.01 dB; Parseval's theorem",
        "Do levels add up? Computed by `level.sound_levels`. The noise is Gaussian, "
        "with 1 Pa before it is limited to 20 Hz to 20 kHz. It lasts 0.5 s and has a fixed "
        "seed.",
        ("quantity",),
        "dB",
        3,
        tuple(
            Row((quantity,), known(goal), known(level), -LEVEL_LIMIT_DB, LEVEL_LIMIT_DB)
            for quantity, goal, level in rows
        ),
    )


def _sum_db(band_levels: dict[str, float | None]) -> float:
    return 10.0 * math.log10(
        sum(10.0 ** (band / 10.0) for band in band_levels.values() if band is not None)
    )

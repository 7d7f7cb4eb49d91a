"""The difference of two sounds in the noise of a room is audible where N5 differs enough.

The program also says what to install where the package for loudness is missing.
"""

from __future__ import annotations

import numpy as np
import pytest

import acoustics
from acoustics.audibility import AUDIBLE, NOT_AUDIBLE

RATE = 48000
# Records of 0.1 s that are heard once take half as long as loops, which are judged for 1 s.
SHORT_S = 0.1
OPEN = {"closed_a": False, "closed_b": False}


def noise(laeq_db, seed, seconds=0.3):
    """Return a loop of noise from 2 to 8 kHz with an A-weighted level."""
    bands = dict.fromkeys((2000, 2500, 3150, 4000, 5000, 6300, 8000), 20.0)
    record = acoustics.room_noise(bands, 1.0, RATE, seed)[: round(seconds * RATE)]
    return record * 10.0 ** ((laeq_db - acoustics.laeq_db(record, RATE)) / 20.0)


def tone(level_db, frequency_hz=1000.0, seconds=0.3):
    amplitude = np.sqrt(2.0) * acoustics.P_REF_PA * 10.0 ** (level_db / 20.0)
    return amplitude * np.sin(2.0 * np.pi * frequency_hz * np.arange(round(seconds * RATE)) / RATE)


# ---- noise of the room


@pytest.mark.law("Room: the noise has the third octaves that are given, and no others.")
def test_noise_has_its_third_octaves():
    wanted = {20: 40.0, 63: 25.0, 1000: -10.0, 20000: 120.0}
    record = acoustics.room_noise(wanted, 1.7, RATE, seed=3)
    assert len(record) == round(1.7 * RATE)
    levels = acoustics.sound_levels(record, RATE).third_octave_db
    for frequency, level in wanted.items():
        assert levels[f"{frequency}"] == pytest.approx(level, abs=1e-6)
    # Rounding of the transform lies 200 dB and more below 120 dB.
    assert levels["500"] is None or levels["500"] < -150.0


def test_the_default_room_is_pink_noise_of_30_dba_from_50_hz_to_10_khz():
    record = acoustics.room_noise(None, 2.0)
    levels = acoustics.sound_levels(record, RATE)
    # The A-weighting changes within a band, which the mid frequency stands for.
    assert levels.laeq_db == pytest.approx(30.0, abs=0.1)
    sounding = {name: level for name, level in levels.third_octave_db.items() if level is not None}
    assert list(sounding)[:1] == ["50"] and list(sounding)[-1:] == ["10000"] and len(sounding) == 24
    assert max(sounding.values()) - min(sounding.values()) < 1e-6


@pytest.mark.law("Room: the noise is Gaussian, and another seed is independent.")
def test_noise_is_gaussian():
    first, second = (acoustics.room_noise(None, 10.0, seed=seed) for seed in (1, 2))
    kurtosis = np.mean(first**4) / np.mean(first**2) ** 2
    # Low bands of pink noise have few lines, some 100 in 10 s: 3 +- 0.1.
    assert kurtosis == pytest.approx(3.0, abs=0.2)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.05
    np.testing.assert_array_equal(first, acoustics.room_noise(None, 10.0, seed=1))


def test_no_band_is_silence_and_wrong_bands_are_refused():
    assert not np.any(acoustics.room_noise({}, 0.1))
    with pytest.raises(ValueError, match=r"got 1100 Hz.*the nearest is 1000"):
        acoustics.room_noise({1100: 20.0}, 1.0)
    with pytest.raises(ValueError, match=r"at 63 Hz: got 121, allowed: a number from -20 to 120"):
        acoustics.room_noise({63: 121}, 1.0)
    with pytest.raises(ValueError, match=r"at 10000 Hz, allowed at a sample rate of 16000 Hz"):
        acoustics.room_noise({10000: 20}, 1.0, sample_rate_hz=16000)


# ---- two sounds


@pytest.mark.slow
@pytest.mark.law("Audibility: equal sounds do not differ.")
def test_equal_sounds_do_not_differ():
    records = [noise(35.0, 1), noise(35.0, 2)]
    result = acoustics.audible_difference(records, records, RATE)
    assert result.difference_percent == result.uncertainty_percent == 0.0
    assert result.verdict == NOT_AUDIBLE
    assert result.n5_a_sone > result.n5_room_sone > 0.0


@pytest.mark.slow
@pytest.mark.law("Audibility: sounds 20 dB below the room do not differ audibly.")
def test_sounds_far_below_the_room_do_not_differ():
    room = dict.fromkeys(acoustics.default_room_db(), 40.0)
    level_db = acoustics.laeq_db(acoustics.room_noise(room, 1.0), RATE) - 20.0
    result = acoustics.audible_difference(
        [noise(level_db, 1, SHORT_S)],
        [noise(level_db - 20.0, 2, SHORT_S)],
        RATE,
        **OPEN,
        room_db=room,
    )
    assert result.verdict == NOT_AUDIBLE


@pytest.mark.slow
@pytest.mark.law("Audibility: a tone 15 dB above the band that masks it is audible.")
def test_a_tone_above_its_masking_band_is_audible_in_both_orders():
    band_db = acoustics.default_room_db()[1000]
    loud = tone(band_db + 15.0, seconds=SHORT_S)
    silence = np.zeros(len(loud))
    result = acoustics.audible_difference([loud], [silence], RATE, **OPEN)
    assert result.verdict == AUDIBLE and result.low_percent > 8.0
    assert result.n5_b_sone == pytest.approx(result.n5_room_sone, rel=1e-3)
    exchanged = acoustics.audible_difference([silence], [loud], RATE, **OPEN)
    assert exchanged.verdict == AUDIBLE
    assert exchanged.difference_percent == pytest.approx(-result.difference_percent)
    assert exchanged.low_percent == pytest.approx(-result.high_percent)
    assert exchanged.uncertainty_percent == pytest.approx(result.uncertainty_percent)


def test_a_short_knock_is_heard_in_the_middle_of_the_noise():
    knock = np.zeros(RATE // 20)
    knock[RATE // 40 : RATE // 40 + 960] = tone(60.0, seconds=0.02) * np.hanning(960)
    result = acoustics.audible_difference([knock], [0.3 * knock], RATE, **OPEN)
    assert result.verdict == AUDIBLE and result.difference_percent > 0.0


def test_records_without_a_pair_and_other_rates_are_refused():
    record = tone(40.0)
    with pytest.raises(ValueError, match="got 2 of A and 1 of B, allowed: equally many"):
        acoustics.audible_difference([record, record], [record], RATE)
    with pytest.raises(ValueError, match=r"got 44100, .* sample rate of 48000 Hz"):
        acoustics.audible_difference([record], [record], 44100)
    with pytest.raises(ValueError, match="above 120 dB"):
        acoustics.audible_difference([tone(130.0, 100.0)], [record], RATE)


@pytest.mark.slow
@pytest.mark.law("Audibility: the stated uncertainty covers the scatter over noises of the room.")
def test_uncertainty_covers_the_scatter_over_noises():
    a, b = noise(30.0, 1, SHORT_S), noise(28.0, 2, SHORT_S)
    results = [acoustics.audible_difference([a], [b], RATE, **OPEN, seed=seed) for seed in range(6)]
    differences = np.array([result.difference_percent for result in results])
    deviations = differences - differences.mean()
    within = [
        abs(deviation) <= 2.0 * result.uncertainty_percent
        for deviation, result in zip(deviations, results, strict=True)
    ]
    # 95 % are expected, and two of six outside happen in one of thirty cases.
    assert sum(within) >= 5
    assert len({result.verdict for result in results}) == 1 or np.ptp(differences) < 2.0


@pytest.mark.slow
@pytest.mark.law("Audibility: the stated uncertainty of specimens covers other specimens.")
def test_uncertainty_of_specimens_covers_other_specimens():
    def result(group):
        seeds = range(4 * group, 4 * group + 4)
        a = [noise(35.0, (1, seed), SHORT_S) for seed in seeds]
        b = [noise(34.0, (2, seed), SHORT_S) for seed in seeds]
        return acoustics.audible_difference(a, b, RATE, **OPEN, seed=group)

    results = [result(group) for group in range(6)]
    differences = np.array([one.difference_percent for one in results])
    stated = np.array([one.uncertainty_percent for one in results])
    # The standard deviation of six means, and the mean of six estimates with three degrees of
    # freedom, know the scatter within a third or so. Student's factor is 1.2.
    assert 0.5 < np.std(differences, ddof=1) / np.mean(stated) < 1.5

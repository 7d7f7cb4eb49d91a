"""A room to listen in follows Sabine's formula and ISO 9613, and leaves the direct sound alone."""

import math

import numpy as np
import pytest
from scipy import signal

import acoustics
from acoustics import room
from acoustics.radiation import SOUND_M_S

RATE = 48000
# ISO 9613-2:1996, table 2, at 20 degrees and 70 % [dB/km].
ISO_9613_2 = {63: 0.1, 125: 0.3, 250: 1.1, 500: 2.8, 1000: 5.0, 2000: 9.0, 4000: 22.9, 8000: 76.6}


def third_octave(response, mid_hz):
    """Return a third octave of a response."""
    edges = (mid_hz * 2 ** (-1 / 6), mid_hz * 2 ** (1 / 6))
    filtered = signal.butter(4, edges, "bandpass", fs=RATE, output="sos")
    return signal.sosfilt(filtered, response, axis=0)


def reverberation_s(response):
    """Return the reverberation time of a response by Schroeder's integral from -5 to -25 dB."""
    left = np.cumsum(np.square(response)[::-1])[::-1]
    level_db = 10 * np.log10(left / left[0])
    inside = (level_db < -5) & (level_db > -25)
    slope, _ = np.polyfit(np.flatnonzero(inside) / RATE, level_db[inside], 1)
    return -60 / slope


def test_the_air_attenuates_as_in_the_table_of_the_standard():
    attenuation = 1e3 * room.air_attenuation_db_m([*ISO_9613_2], 70)
    table = np.array([*ISO_9613_2.values()])
    assert np.all(np.abs(attenuation - table) < 0.05 + 0.02 * table)  # it has one decimal


@pytest.mark.parametrize("asked_s", [0.3, 2.0])
def test_sound_dies_away_in_the_reverberation_time_and_faster_at_high_frequencies(asked_s):
    response = room.diffuse_response(asked_s, 1.0, RATE, 0)
    areas = room.absorption_areas_m2(asked_s)
    for number, mid_hz in zip((0, 3, 6, 9), (1000, 2000, 4000, 8000), strict=True):
        expected = 24 * math.log(10) * room.VOLUME_M3 / (SOUND_M_S * areas[number])
        measured = [reverberation_s(third_octave(ear, mid_hz)) for ear in response.T]
        assert np.mean(measured) == pytest.approx(expected, rel=0.12), mid_hz


def test_the_diffuse_field_has_the_energy_of_sabines_formula():
    """It is 16 pi r^2 / A of the direct sound, here within 5 standard deviations of its noise."""
    near, far = (room.diffuse_response(0.5, distance, RATE, 3) for distance in (1.0, 2.0))
    assert np.allclose(far, 2 * near)
    frequency = np.fft.rfftfreq(len(near), 1 / RATE)
    power = np.square(np.abs(np.fft.rfft(near, axis=0)))
    low = power[(frequency > 100) & (frequency < 1000)].mean()
    area = 24 * math.log(10) * room.VOLUME_M3 / (SOUND_M_S * 0.5)
    assert low == pytest.approx(16 * math.pi / area, rel=0.2)
    left, right = near.T
    assert abs(np.corrcoef(left, right)[0, 1]) < 0.05


def test_the_direct_sound_stays_and_nothing_comes_before_the_first_reflection():
    record = np.random.default_rng(1).standard_normal((RATE // 4, 2))
    heard = acoustics.in_room(record, 0.4, distance_m=0.5)
    gap = round(4 * room.VOLUME_M3 ** (1 / 3) / 6 / SOUND_M_S * RATE)
    assert np.allclose(heard[:gap], record[:gap], rtol=0, atol=1e-12)
    assert not np.allclose(heard[gap : RATE // 4], record[gap:], rtol=0, atol=0.1)
    assert len(heard) == len(record) + gap + 0.4 * RATE - 1
    mono = acoustics.in_room(record[:, 0], 0.4, distance_m=0.5)
    assert np.allclose(mono[:gap], record[:gap, :1], rtol=0, atol=1e-12)
    assert np.array_equal(acoustics.in_room(record, 0.4, distance_m=0.5), heard)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"reverberation_s": 0.05}, "reverberation_s"),
        ({"reverberation_s": 11}, "reverberation_s"),
        ({"distance_m": 0}, "distance_m"),
        ({"pressure_pa": np.ones((10, 3))}, "3 channels"),
        ({"pressure_pa": [np.nan]}, "pressure_pa"),
    ],
)
def test_what_no_room_has_is_refused(change, reason):
    given = {"pressure_pa": [1.0], "reverberation_s": 0.5} | change
    with pytest.raises(ValueError, match=reason):
        acoustics.in_room(**given)

"""The ± of a bearing's bands: its parts against other motions and other surfaces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from bearings import model

import rolling
from acoustics.arrays import Array
from acoustics.continued_rows import RandomRows, drawn_lines
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import assumed_damping, band_uncertainty
from rolling.bearing.band_uncertainty import (
    LOSS_FACTOR,
    RECORD,
    WINDOW,
    BandUncertainty,
)
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, RADIAL, RingRecord, record_of
from rolling.bearing.tracks import BodyTrack, smooth_tracks
from rolling.bearing_kind.contact_doubts import contact_doubts
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.contact_uncertainty import (
    contact_uncertainty,
    roughness_powers,
    roughness_shares,
)
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.numbers.quantity import PART_WORDS, joined

RATE = 48_000


def rough(seed: int, places: int = 16384) -> BodyTrack:
    """Return a track of waves of random phase up to order 4096, some nanometres high."""
    random = np.random.default_rng(seed)
    orders = np.arange(places // 2 + 1)
    height = np.where((orders > 1) & (orders < 4096), 1e-10, 0)
    lines = height * (random.standard_normal((2, len(orders))).T @ [1, 1j])
    return BodyTrack(np.ones(1), np.fft.irfft(lines, places)[None] * places)


def rough_record(case: BearingModel) -> RingRecord:
    """Return the motion of a bearing with rough balls on the outer raceway."""
    tracks = replace(smooth_tracks(case.geometry), balls_on_outer=tuple(map(rough, range(8))))
    return record_of(move_ring(case, tracks, 0.3, RATE), case.kinematics)


# ---- loss factor


@pytest.mark.law("Bearing ±: the linear ring knows how another loss factor moves each band.")
def test_another_loss_factor_changes_the_bands_as_the_linear_ring_says() -> None:
    """The same tracks are moved with both loss factors; the resonances lie in the high band."""
    case = model(axial_load_n=100.0, radial_load_n=60.0)
    before = rough_record(case)
    after = rough_record(replace(case, contact_loss_factor=0.1))
    change = assumed_damping.band_change_db(before, case, 0.1)
    for direction in DIRECTIONS:
        for band in VELOCITY_BANDS_HZ:
            was = before.bands[direction].rms_m_s[band]
            becomes = after.bands[direction].rms_m_s[band]
            wanted = 20 * math.log10(becomes / was)
            assert change[direction][band] == pytest.approx(wanted, abs=0.4), (direction, band)
    assert change[RADIAL]["high"] < -3
    assert abs(change[RADIAL]["low"]) < 0.1  # far below the resonance stiffness rules


def test_the_part_of_a_loss_factor_is_the_rms_change() -> None:
    """A tone on a resonance falls by 20 lg of the ratio, whose rms over the logarithm is a
    1/sqrt(3) of the change at the end of the range.
    """
    case = model()
    t = np.arange(RATE) / RATE
    resonance = linear_ring(case).radial_hz
    velocity = np.zeros((RATE, 3))
    velocity[:, :2] = np.sin(2 * np.pi * resonance * t)[:, None]
    record = RingRecord(RATE, velocity, velocity, np.ones((RATE, 8)), 11.5, 0.0, 0.0)
    part = assumed_damping.loss_factor_db(record, case)
    most = 20 * math.log10(assumed_damping.LARGEST_LOSS_FACTOR / assumed_damping.LEAST_LOSS_FACTOR)
    assert part[RADIAL]["high"] == pytest.approx(most / math.sqrt(3), rel=0.03)
    assert part[AXIAL] == dict.fromkeys(VELOCITY_BANDS_HZ, 0.0)


# ---- window


@pytest.mark.law("Random rows: a weighted power scatters as so many independent lines.")
def test_drawn_lines_scatter_as_they_say() -> None:
    """Of a narrow resonance few lines of a stretch decide the power, of a wide band many.

    Thirty draws have their own scatter, 13 %, and a narrow resonance has some within its block.
    """
    count, line_hz = 1333, 93.0

    def weights(hz: Array, width_hz: float) -> Array:
        """Return the weights of a resonance at 3 kHz."""
        return np.asarray(1 / (1 + np.square((hz - 3000) / (width_hz / 2))))

    powers = []
    for seed in range(30):
        given = np.random.default_rng(seed).standard_normal((1, count))
        drawn = next(RandomRows(given, True).stretches(np.random.default_rng(seed + 1000)))
        powers.append(np.square(np.abs(np.fft.rfft(drawn[0]))))
    drawn_hz = np.arange(len(powers[0])) * line_hz * count / drawn.shape[1]
    hz = np.arange(4.0, 60_000, 4.0)
    for width_hz in (40.0, 8000.0):
        levels = 10 * np.log10(np.array(powers) @ weights(drawn_hz, width_hz))
        lines = drawn_lines(hz / line_hz, weights(hz, width_hz))
        stated = 10 / math.log(10) / math.sqrt(lines)
        assert np.std(levels, ddof=1) == pytest.approx(stated, rel=0.4)


@pytest.fixture(scope="module")
def scene() -> rolling.BearingScene:
    """Return a dry 6204 with a rigid ring, whose raceways have roughness alone, without waves."""
    rough = {"kind": "gaussian", "roughness_ra_um": 0.02, "correlation_length_um": 60}
    rough |= {"correlation_length_across_um": 10}
    raceways = {
        f"bearing.surfaces.{ring}": rough | {"seed": seed}
        for ring, seed in (("inner", 2), ("outer", 3))
    }
    balls = {"kind": "graded", "grade": "G10", "seed": 1}
    former = {"bearing.oil": None, "bearing.tilt": "held"}
    former |= {"bearing.angle": "fixed", "bearing.ring": "rigid"}
    surfaces = raceways | {"bearing.surfaces.balls": balls}
    return rolling.read_scene("bearing-6204").with_(former | surfaces)


def noise(rms_m_s: float) -> RingRecord:
    """Return a record of noise."""
    velocity = rms_m_s * np.random.default_rng(1).standard_normal((RATE // 4, 3))
    return RingRecord(RATE, velocity, velocity, np.ones((RATE // 4, 8)), 11.5, 0.0, 0.0)


@pytest.mark.law("Bearing ±: roughness moves the ring as its power and the ring's mobility say.")
def test_the_power_of_roughness_is_that_of_the_motion(scene: rolling.BearingScene) -> None:
    """Round balls leave roughness alone; two windows of 16 mm scatter by some 1 to 2 dB."""
    only = scene.with_({"bearing.surfaces.balls": None})
    plan = contact_plan(only)
    motion = move_ring(only.model, bearing_tracks(plan), 0.5, RATE)
    record = record_of(motion, only.kinematics)
    powers = roughness_powers(plan, {}, only.model)
    for direction in DIRECTIONS:
        for band in ("medium", "high"):
            whole = sum(power.of_band(direction, band).sum() for power in powers.values())
            level = 10 * math.log10(whole / record.bands[direction].rms_m_s[band] ** 2)
            assert abs(level) < 3.0, (direction, band)
    shares = roughness_shares(powers, record)
    assert sum(share[RADIAL]["high"] for share in shares.values()) > 0.5


@pytest.mark.law("Bearing ±: a short window is told, and counts by its share of each band.")
def test_a_short_window_is_a_doubt_and_a_part(scene: rolling.BearingScene) -> None:
    """16 mm leave 0.66 and 1.5 dB of the level of roughness in the high and the medium band."""
    plan = contact_plan(scene)
    quiet = contact_uncertainty(plan, {}, scene.model, noise(1e-9))  # roughness is all of it
    doubts = {doubt.key: doubt for doubt in contact_doubts(plan, {}, math.inf, quiet)}
    text = doubts["window"].text
    assert "16 mm of track" in text
    assert "0.66 dB in the high band" in text and "1.5 dB in the medium band" in text
    part = quiet.parts_db[WINDOW]
    assert doubts["window"].decibels == max(max(bands.values()) for bands in part.values())
    loud = contact_uncertainty(plan, {}, scene.model, noise(1.0))  # roughness is nothing of it
    assert max(max(bands.values()) for bands in loud.parts_db[WINDOW].values()) < 0.01


def test_a_turn_that_is_marched_whole_has_no_window(scene: rolling.BearingScene) -> None:
    smooth = {"bearing.surfaces.balls": None, "bearing.surfaces.outer": None}
    small = {"bearing.named": "608", "bearing.axial_load_n": 20, "numerics.window_mm": 40}
    whole = scene.with_({**smooth, **small})
    plan = contact_plan(whole)
    assert WINDOW not in contact_uncertainty(plan, {}, whole.model, noise(1e-9)).parts_db


# ---- parts


def test_a_part_replaces_an_earlier_one_of_its_name() -> None:
    def of_all(value: float) -> dict[str, dict[str, float]]:
        return {direction: dict.fromkeys(VELOCITY_BANDS_HZ, value) for direction in DIRECTIONS}

    uncertainty = BandUncertainty().with_part(RECORD, of_all(3.0)).with_part(WINDOW, of_all(4.0))
    assert joined(uncertainty.of_band(RADIAL, "high")) == pytest.approx(5.0)
    with_third = uncertainty.with_part(LOSS_FACTOR, of_all(12.0))
    assert joined(with_third.of_band(AXIAL, "low")) == pytest.approx(13.0)
    again = with_third.with_part(WINDOW, of_all(0.0))
    assert again.of_band(RADIAL, "low") == {RECORD: 3.0, WINDOW: 0.0, LOSS_FACTOR: 12.0}
    assert joined(BandUncertainty().of_band(RADIAL, "low")) == 0.0


def test_each_part_of_the_uncertainty_of_a_band_has_words() -> None:
    """Comparisons with recordings and sheets name the parts, those of films of oil too."""
    parts = {value for name, value in vars(band_uncertainty).items() if name.isupper()}
    assert {"film", "film_damping"} <= parts <= PART_WORDS.keys()

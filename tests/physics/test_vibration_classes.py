"""Classes of vibration by limits of makers, and accelerations and pulses as makers state them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bearing_runs import moved_as, turning

from rolling.bearing.vibration_classes import (
    ABOVE,
    LIMITS,
    ClassRange,
    Velocity,
    class_of_band,
    class_of_bands,
    limits_of_bore,
)
from rolling.bearing_kind import maker_numbers
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.bearing_kind.bearing_sentences import class_sentence, hertz, pulse_sentence

RATE = 48_000
BORE_20 = limits_of_bore(20.0)
DOCS = Path(__file__).parents[2] / "docs"


def test_limits_fall_from_class_to_class_and_rise_with_the_bore() -> None:
    for limits in LIMITS:
        assert list(limits.um_s) == ["V0", "V1", "V2", "V3", "V4"]
        assert np.all(np.diff([*limits.um_s.values()], axis=0) < 0)
    assert np.all(np.diff([[*limits.um_s.values()] for limits in LIMITS], axis=0) > 0)


def test_the_docs_have_the_same_limits() -> None:
    """The page is read by people who choose a class, so its table is that of the program."""
    text = (DOCS / "bearings.md").read_text("utf-8")
    for limits in LIMITS:
        row = re.search(rf"\|{limits.least_mm:g} to {limits.most_mm:g} mm[^|]*\|(.*)\|", text)
        assert row is not None
        cells = [tuple(map(int, cell.split(", "))) for cell in row[1].split("|")]
        assert cells == list(limits.um_s.values())


@pytest.mark.parametrize(
    ("um_s", "spread_db", "words"),
    [
        (50, 0.0, "V4"),
        (60, 0.0, "V4"),
        (61, 0.0, "V3"),
        (61, 0.5, "V3 or V4"),
        (170, 0.1, "V1"),
        (250, 1.0, "above V0 or V0"),
        (300, 0.5, ABOVE),
        (300, 6.0, "above V0 to V1"),
    ],
)
def test_a_band_has_the_classes_that_its_uncertainty_leaves(
    um_s: float, spread_db: float, words: str
) -> None:
    assert BORE_20 is not None
    assert class_of_band(BORE_20, "low", Velocity(um_s, spread_db)).words == words


def test_the_worst_band_decides() -> None:
    bands = {"low": ClassRange("V3", "V4"), "high": ClassRange(ABOVE, "V1")}
    assert class_of_bands(bands).words == "above V0 to V1"


def test_no_class_beyond_the_limits_that_have_a_source() -> None:
    assert limits_of_bore(40.0) is None is limits_of_bore(6.0)
    assert limits_of_bore(8.0) is LIMITS[0] and limits_of_bore(25.0) is BORE_20


def run_of(velocity: np.ndarray, **changes: object) -> BearingRun:
    """Return a run whose ring has a velocity along all axes [m/s]."""
    base = turning()
    acceleration = np.gradient(velocity) * RATE
    record = replace(
        base.record,
        velocity_m_s=np.stack([velocity] * 3, 1),
        acceleration_m_s2=np.stack([acceleration] * 3, 1),
        ball_load_n=np.resize(base.record.ball_load_n, (len(velocity), base.geometry.balls)),
    )
    return moved_as(base, record, base.scene.with_(changes) if changes else base.scene)


def tone(hz: float, um_s: float) -> np.ndarray:
    return np.asarray(1e-6 * np.sqrt(2) * um_s * np.sin(2 * np.pi * hz * np.arange(RATE) / RATE))


@pytest.mark.law("Bearing: a level of acceleration is that of a tone of known velocity.")
def test_the_acceleration_of_a_tone() -> None:
    """100 um/s at 1 kHz are 0.628 m/s2, 36.1 dB re 9.81e-3 m/s2."""
    run = run_of(tone(1000, 100))
    pulses = run.numbers.pulses
    assert pulses is not None and pulses.medium is not None
    assert pulses.acceleration_m_s2 == pytest.approx(0.6283, rel=0.01)
    assert pulses.acceleration_db == pytest.approx(36.13, abs=0.1)
    assert pulses.medium.peak_um_s == pytest.approx(141.4, rel=0.01)
    assert pulses.medium.crest_factor == pytest.approx(1.414, rel=0.01)
    assert pulses.kurtosis == pytest.approx(1.5, rel=0.01)
    assert "dB re 9.81e-3 m/s2 from 50 to" in pulse_sentence(run.scene, run.numbers)


def test_knocks_have_a_kurtosis() -> None:
    since = np.arange(RATE) % 400 / RATE
    knocks = 1e-4 * np.exp(-3000 * since) * np.sin(2 * np.pi * 3000 * since)
    pulses = run_of(knocks).numbers.pulses
    assert pulses is not None and pulses.kurtosis > 8
    assert pulses.high.crest_factor > 5 > pulses.low.crest_factor


def test_a_class_needs_the_standard_and_all_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ring that bends within the bands has classes of those below; another load has none."""
    waves = tone(100, 100) + tone(1000, 50) + tone(3000, 40)
    own = run_of(waves).numbers.vibration_class
    assert own is not None and own.overall is None
    assert own.by_band == {"low": "V2", "medium": "V3"}
    assert "the ring bends from 5.7 kHz on" in own.none_because
    loaded = run_of(waves, **{"bearing.axial_load_n": 200}).numbers.vibration_class
    assert loaded.by_band == {} and "200 N axial" in loaded.none_because
    stiff = run_of(waves)
    monkeypatch.setattr(
        type(stiff), "bands_below_bending_hz", maker_numbers.VELOCITY_BANDS_HZ, raising=False
    )
    whole = maker_numbers.vibration_class(stiff, stiff.numbers.velocities.radial, ())
    assert whole.overall == "V2" and whole.high == "V3" and whole.none_because is None
    numbers = replace(stiff.numbers, vibration_class=whole)
    assert "it is of class V2: V2 in the low band" in class_sentence(numbers)


def test_lines_have_five_digits() -> None:
    assert [hertz(hz) for hz in (11.3698, 20.0, 147.8765, 1478.765)] == [
        "11.370",
        "20.000",
        "147.88",
        "1478.8",
    ]

"""What plays has the level that is stated, for each kind of scene and each source of its sound.

The oracle is the level of the samples in the bytes of each file, times the factor that it states.
"""

from __future__ import annotations

import io
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import soundfile
from finished import VIBRATING, marched
from scene_text import TINY

import rolling as rc
from acoustics.level import lae_db, laeq_db, sound_levels
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.kinds.heard_sound import HeardSound
from rolling.kinds.registry import kind_of
from rolling.kinds.stated_level import StatedLevel
from rolling.report import page_sounds, text
from rolling.results.listening import listen_sounds
from rolling.results.run_doubts import doubts
from tests.support.bearing_runs import PLATE, WAVY, loads_bearing

FALLING = """\
name: fall
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1, density_kg_m3: 7850,
  thickness_mm: 10, loss_factor: 0.01}
surface: {kind: smooth, spacing_um: 5, width_um: 200}
rolling: {speed_m_s: 0.05, distance_mm: 1, drop_mm: 0.1}
dynamics: {}
"""
SMOOTH = """\
surface: {kind: smooth, spacing_um: 2, width_um: 128}
rolling: {load_n: 0.005, speed_m_s: 0.1, duration_s: 0.0005}
"""
GOES_ON = ("sound.listen_s=1",)
ENDS = ("sound.listen_s=3", "rolling.resistance=0.02")
ESTIMATED = ("dynamics=", "sound.source=", "plate.thickness_mm=", "plate.loss_factor=")
MEASURED = ("sound.source=release",)
# Scenes with changes.
SCENES: dict[str, tuple[str, tuple[str, ...]]] = {
    "estimated": (TINY, ()),
    "estimated, goes on": (VIBRATING, (*ESTIMATED, *GOES_ON)),
    "estimated, ends": (VIBRATING, (*ESTIMATED, *ENDS)),
    "estimated, open": (TINY.replace("speed_m_s: 0.1", "speed_m_s: [[0, 0.1], [0.1, 0.15]]"), ()),
    "computed": (VIBRATING, ()),
    "computed, goes on": (VIBRATING, GOES_ON),
    "computed, ends": (VIBRATING, ENDS),
    "computed, release measured": (VIBRATING, MEASURED),
    "computed, release measured, ends": (VIBRATING, (*MEASURED, *ENDS)),
    "falls": (FALLING, ()),
    "smooth": (TINY.partition("surface:")[0] + SMOOTH, ()),
}


@cache
def run_of(name: str) -> rc.Run:
    return marched(*SCENES[name])


def level_of_file(sound: HeardSound, common: float | None = None) -> tuple[float | None, float]:
    """Return the level of the bytes of a file [dB] by the factor that it states, and its peak."""
    samples, rate = soundfile.read(io.BytesIO(sound.wav(common)))
    assert rate == SAMPLE_RATE_HZ
    facts = sound.facts(common)
    first = samples if samples.ndim == 1 else samples[:, 0]
    if not hasattr(facts, "pascal_per_full_scale"):
        return laeq_db(first * facts.full_scale, rate), float(np.abs(samples).max())
    pressure = first * facts.pascal_per_full_scale
    if facts.raised is not None:
        pressure = pressure[: round(facts.raised.begin_s * rate)]
    level = lae_db if facts.measure == "LAE" else laeq_db
    return level(pressure, rate), float(np.abs(samples).max())


@pytest.mark.law("listening: a file plays at the level that it states, by its gain.")
@pytest.mark.parametrize("name", [*SCENES])
def test_a_file_plays_at_the_level_that_is_stated(name: str) -> None:
    """The level of a file is that of its quantity, unless the file says how far off it is."""
    run = run_of(name)
    if name.endswith(("goes on", "ends")):
        assert not run.numbers.listening.refused
    for sound in listen_sounds(run):
        level_db, peak = level_of_file(sound)
        facts = sound.facts()
        assert peak < 1.0
        if facts.level_db is None:
            assert level_db is None
            continue
        assert level_db == pytest.approx(facts.level_db, abs=0.05)
        assert level_of_file(sound, 1e-3 / sound.samples.max())[0] == pytest.approx(
            facts.level_db, abs=0.05
        )
        quantity = run.vibration if sound.group == "vibration" else run.released_power
        if quantity.value is not None and sound.stated.level.is_within_reach:
            assert facts.level_db == pytest.approx(quantity.value, abs=0.05)
        assert f"{facts.measure} {facts.level_db:.1f} dB(A)" in sound.words
        assert facts.how in sound.words and facts.how == quantity.how


@pytest.mark.parametrize("name", [*SCENES])
def test_the_vibration_plays_in_every_run_that_has_one(name: str) -> None:
    run = run_of(name)
    first, *others = listen_sounds(run)
    plays = "release" if name == "smooth" else "vibration"
    assert first.file == "listen.wav" and first.group == plays == run.numbers.heard.source
    assert [(sound.file, sound.group) for sound in others] == (
        [] if name == "falls" else [("released.wav", "release")]
    )
    (shown,) = page_sounds.of_runs([run])
    assert shown.stated.source == plays
    assert (shown.released is None) == (name == "falls")
    words = text.heard(run, is_alone=True)
    how = "computed" if run.scene.dynamics is not None else "estimated"
    assert (f"the vibration of ball and plate, {how}" in words) == (plays == "vibration")


def test_a_contact_that_does_not_fluctuate_says_why_the_release_plays() -> None:
    run = run_of("estimated")
    reason = "a contact that does not fluctuate within hearing moves neither ball nor plate"
    vibration = replace(run.vibration, value=None, reason=reason)
    still = replace(run, numbers=replace(run.numbers, vibration=vibration))
    words = text.heard(still, is_alone=True)
    assert "You hear the released power" in words and reason in words
    assert listen_sounds(still)[0].group == "release"


def test_the_signal_of_an_estimate_has_its_level_before_any_gain() -> None:
    """Lines have the mean square over their intervals, so what is left is the changing stiffness.

    The estimate is the mean of two chains, one of which follows the stiffness along the track; half
    of the decibels between them is a part of its ±.
    """
    run = run_of("estimated")
    level = run.stated("vibration").level
    changes_db = run.vibration.parts["stiffness_changes"]
    assert abs(level.departure_db) == pytest.approx(changes_db, abs=0.03)


@pytest.mark.parametrize("name", ["estimated, ends", "computed, release measured, ends"])
def test_a_vibration_that_ends_has_the_level_of_its_own_whole_record(name: str) -> None:
    """A release falls by other decibels, so its fall does not lead to the level of a vibration."""
    run = run_of(name)
    assert run.numbers.heard_whole is not None and not run.numbers.listening.refused
    stated = run.stated("vibration")
    listened = next(sound for sound in listen_sounds(run) if sound.group == "vibration")
    assert listened.stated.long is not None
    whole_db, _ = level_of_file(listened)
    assert whole_db == pytest.approx(run.vibration.value, abs=0.05)
    assert abs(listened.stated.level.gain_db) <= run.vibration.uncertainty
    assert whole_db < stated.level.own_db - 3
    assert "played_level" not in {doubt.key for doubt in run.numbers.doubts}


def test_the_estimated_signal_repeats_without_a_click() -> None:
    """Its lines are those of the closed track: the step over the seam is one of its own steps."""
    sound = run_of("estimated").stated().sound
    assert sound.loops
    steps = np.abs(np.diff(np.append(sound.pressure, sound.pressure[0])))
    assert steps[-1] <= steps[:-1].max()
    spectrum = np.abs(np.fft.rfft(np.tile(sound.pressure, 3)))
    assert spectrum[np.arange(len(spectrum)) % 3 != 0].max() < 1e-9 * spectrum.max()


def test_third_octaves_of_an_estimate_are_those_of_the_file_that_plays() -> None:
    run = run_of("estimated")
    samples, rate = soundfile.read(io.BytesIO(listen_sounds(run)[0].wav()))
    pressure = samples * listen_sounds(run)[0].facts().pascal_per_full_scale
    of_file = sound_levels(pressure, rate, run.sound.highest, closed=True).third_octave_a_db
    stated = run.numbers.bands.vibration_a.by_name
    loudest = max(level for level in stated.values() if level is not None)
    near = [name for name, level in stated.items() if level and level > loudest - 30]
    assert len(near) > 3
    for name in near:
        assert of_file[name] == pytest.approx(stated[name], abs=0.05)


def test_a_level_beyond_its_uncertainty_is_told_and_not_forced() -> None:
    near = StatedLevel(own_db=10.0, stated_db=10.8, spread_db=1.0)
    assert near.level_db == 10.8 and "raised by 0.8 dB to the level that is stated" in near.words
    far = StatedLevel(own_db=10.0, stated_db=8.0, spread_db=1.0)
    assert far.level_db == 10.0 and "2.0 dB above the level that is stated" in far.words
    assert StatedLevel(own_db=None, stated_db=8.0).level_db is None
    run = run_of("estimated")
    played = replace(run.numbers.heard, departure_db=-2.0, gain_db=0.0)
    numbers = replace(run.numbers, heard=played)
    keys = {doubt.key: doubt for doubt in doubts(run.scene, run.sound, numbers)}
    assert "2.0 dB above" in keys["played_level"].text
    assert "played_level" not in {doubt.key for doubt in run.numbers.doubts}


def test_a_housing_plays_at_the_level_that_is_stated() -> None:
    """Its excerpt with faded ends is brought to LAeq of the whole record."""
    run = rc.simulate(loads_bearing(WAVY + PLATE), workers=1, progress=False)
    played = [sound for sound in kind_of(run.scene).sounds(run) if sound.unit == "Pa"]
    (housing,) = played
    level_db, peak = level_of_file(housing)
    assert peak < 1.0
    assert level_db == pytest.approx(run.numbers.housing.laeq.value, abs=0.05)
    assert housing.facts().level_db == pytest.approx(level_db, abs=0.05)
    assert f"LAeq {level_db:.1f} dB(A)" in housing.words

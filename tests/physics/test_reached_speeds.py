"""Speeds that a record never reaches change nothing in it; its mean power is a mean in time."""

from __future__ import annotations

import numpy as np
import pytest
from checked import checked
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scene_sounds import sound_of_release
from scene_text import PLAIN

from rolling.contact.track import Motion
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, oversampling

STEP = 2e-6
LATER = "[[0, 0.1], [0.02, 0.1], [20, 100]]"


def sound_at(speed: str, energy: np.ndarray, closed: bool = True) -> ContactSound:
    return sound_of_release(
        loads(PLAIN, [f"rolling.speed_m_s={speed}", "rolling.duration_s=0.02"]),
        energy,
        STEP,
        closed,
    )


def noise(n: int = 1000) -> np.ndarray:
    return 1e-9 * (1 + 0.1 * np.random.default_rng(4).standard_normal(n))


def test_a_speed_after_the_end_is_not_in_the_record() -> None:
    """A record of 20 ms at 0.1 m/s ignores any later speed.

    An earlier version claimed 25 MHz, filled all bands and did not close.
    """
    plain = sound_at("0.1", noise())
    later = sound_at(LATER, noise())
    assert plain.highest == pytest.approx(25e3) and later.highest == pytest.approx(25e3)
    assert later.closed and later.constant_speed
    assert later.pressure == pytest.approx(plain.pressure, abs=1e-9 * np.abs(plain.pressure).max())
    assert later.levels.third_octave_db == pytest.approx(
        plain.levels.third_octave_db, abs=1e-6, nan_ok=True
    )


@pytest.mark.law("Speed: a speed that the record does not reach changes nothing in it.")
@settings(deadline=None, max_examples=25)
@given(
    speeds=st.lists(st.one_of(st.just(0.0), st.floats(1e-3, 2.0)), min_size=1, max_size=4),
    last=st.floats(1e-3, 2.0),
    later=st.lists(st.one_of(st.just(0.0), st.floats(1e-3, 1e5)), min_size=1, max_size=3),
)
def test_nothing_that_comes_later_counts(
    speeds: list[float], last: float, later: list[float]
) -> None:
    """Two profiles that part after the end give the same record, findings and cost."""
    times = [0.0, *(0.003 * (k + 1) for k in range(len(speeds)))]
    profile = list(zip(times, [*speeds, last], strict=True))
    end = times[-1]
    steps = int(Motion.of(profile).distance(end) / STEP * (1 - 1e-12))
    assume(steps >= 8)
    after = [(end + 2.0 + k, v) for k, v in enumerate(later)]
    scenes = [at(profile, end), at([*profile, (end + 1.0, last), *after], end)]
    sounds = [sound_of_release(scene, noise(steps), STEP, True) for scene in scenes]
    assert sounds[0].highest == sounds[1].highest and sounds[0].closed == sounds[1].closed
    assert np.array_equal(sounds[0].pressure, sounds[1].pressure)
    assert (
        sounds[0].mean_power == sounds[1].mean_power and sounds[0].power_rms == sounds[1].power_rms
    )
    assert checked(scenes[0]) == checked(scenes[1])


def at(profile: list[tuple[float, float]], end: float) -> Scene:
    data = loads(PLAIN).to_dict()
    data["rolling"] |= {"speed_m_s": [list(pair) for pair in profile], "duration_s": end}
    return Scene.from_dict(data)


def test_bands_above_the_greatest_speed_that_is_reached_are_none() -> None:
    """Bands above 14 kHz are None.

    From 0.01 towards 100 m/s at 20 s the sphere rolls at 0.11 m/s after 0.02 s, which makes 14
    kHz in steps of 4 um.
    """
    scene = loads(
        PLAIN,
        [
            "rolling.speed_m_s=[[0, 0.01], [20, 100]]",
            "numerics.step_nodes=2",
            "rolling.duration_s=0.02",
        ],
    )
    sound = sound_of_release(scene, noise(300), 2 * STEP, False)
    reached = scene.motion.fastest(sound.duration)
    assert 0.1 < reached < 0.12 and sound.highest == pytest.approx(reached / (4 * STEP))
    bands = sound.levels.third_octave_db
    assert bands["10000"] is not None  # up to 11.2 kHz
    assert [bands[name] for name in ("12500", "16000", "20000")] == [None] * 3
    # it was 521: 100 m/s on 48 kHz
    assert oversampling(scene.motion, sound.duration, 2 * STEP) == 1


@pytest.mark.law("Speed: means of the power are means over time.")
def test_means_of_the_power_are_over_time() -> None:
    """With equal energy per step, mean and rms of the power are those of the speed in time.

    From 0.1 to 0.3 m/s in 10 ms the mean is 0.2 m/s, and the rms about it 0.2/sqrt(12) m/s.
    Over distance the mean would be 0.2167 m/s, 8.3 % high.
    """
    sound = sound_at("[[0, 0.1], [0.01, 0.3]]", np.full(1000, 1e-9), closed=False)
    assert sound.duration == pytest.approx(0.01, rel=1e-9)
    assert sound.mean_power == pytest.approx(1e-9 / STEP * 0.2, rel=1e-9)
    # steps of 0.1 % of the record
    assert sound.power_rms == pytest.approx(1e-9 / STEP * 0.2 / np.sqrt(12), rel=1e-5)
    assert sound.step_duration.sum() == pytest.approx(sound.duration, rel=1e-12)
    assert np.mean(sound.power) == pytest.approx(1e-9 / STEP * 0.21667, rel=1e-4)


def test_mean_power_of_a_ball_that_accelerates_and_slows_is_energy_over_duration() -> None:
    """An earlier version was 8.4 % high."""
    energy = np.full(1250, 1e-9)
    sound = sound_at("[[0, 0.1], [0.01, 0.3], [0.015, 0.1]]", energy)
    assert sound.mean_power == pytest.approx(energy.sum() / sound.duration, rel=1e-12)
    assert np.mean(sound.power) / sound.mean_power > 1.07


def test_means_at_constant_speed_are_those_of_the_steps() -> None:
    sound = sound_at("0.1", noise())
    assert sound.mean_power == pytest.approx(sound.power.mean(), rel=1e-12)
    assert sound.power_rms == pytest.approx(sound.power.std(), rel=1e-9)

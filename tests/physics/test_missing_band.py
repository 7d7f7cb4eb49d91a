"""Sound above the Nyquist frequency of the steps, from signals and marches with shorter steps."""

from __future__ import annotations

import numpy as np
import pytest
from finished import VIBRATING, WITHOUT_DYNAMICS, marched
from scene_sounds import sound_of_release

from acoustics.arrays import Array
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound
from rolling.sound.missing_band import MissingBand, missing_band

STEP = 1e-6
STEPS = 8192
LONGER = 4
FOLDED_DB = 0.35  # what waves that long steps fold back add to the last octave


def release(power: float) -> Array:
    """Return the release of short steps whose spectrum is flat, then falls with a power.

    Long steps resolve 1,024 lines, of which the first 400 are flat.
    """
    order = np.arange(STEPS // 2 + 1)
    lines = np.exp(2j * np.pi * np.random.default_rng(5).uniform(size=len(order)))
    lines *= np.maximum(order / 400, 1.0) ** (power / 2)
    lines[0] = 0.0
    fluctuation = np.fft.irfft(lines, STEPS)
    return 1e-12 * (1 + 0.1 * fluctuation / np.std(fluctuation))


def heard(speed: object, *changes: str) -> Scene:
    words = [*WITHOUT_DYNAMICS, "surface.spacing_um=1", "rolling.distance_mm=8.192", *changes]
    return loads(VIBRATING, words).with_(speed_m_s=speed)


def missed(scene: Scene, sound: ContactSound, lap: Array, step: float) -> MissingBand | None:
    """Return what the steps of a release cut off."""
    own_factor = scene.sound.gain_pa_per_w_m2 is None
    return missing_band(sound, lap, step, scene.motion, own_factor)


@pytest.mark.law(
    "Missing band: The part that long steps cut off follows from the power law of the spectrum."
)
@pytest.mark.parametrize(
    ("power", "gain", "speed"),
    [
        (-3.0, "", 0.003),
        (-3.0, "1e3", 0.01),
        (-3.0, "", [[0, 0.0015], [1, 0.01]]),
        (-2.0, "1e3", 0.003),
        (-2.0, "", [[0, 0.0015], [1, 0.01]]),
    ],
)
def test_a_power_law_goes_on(power: float, gain: str, speed: object) -> None:
    """The level of long steps lies below that of short ones by the estimated error.

    A power of -3 is the law itself. Of -2 the estimate takes half of the way to -3.
    """
    scene = heard(speed, f"sound.gain_pa_per_w_m2={gain}")
    short = release(power)
    long = short.reshape(-1, LONGER).sum(axis=1)
    record = sound_of_release(scene, long, LONGER * STEP, closed=True)
    whole = sound_of_release(scene, short, STEP, closed=True)
    band = missed(scene, record, long, LONGER * STEP)
    assert band is not None
    true = record.levels.laeq_db - whole.levels.laeq_db
    off = band.error_db - true
    assert true < -0.2
    assert abs(off) < (FOLDED_DB if power == -3.0 else 2 * band.uncertainty_db)


def test_steps_that_resolve_hearing_miss_nothing() -> None:
    scene = heard(0.1)
    sound = sound_of_release(scene, release(-3.0), STEP, closed=True)
    assert missed(scene, sound, release(-3.0), STEP) is None


def test_a_track_of_few_steps_cannot_tell() -> None:
    scene = heard(0.02)
    few = release(-3.0)[:40]
    sound = sound_of_release(scene, few, LONGER * STEP, closed=True)
    assert missed(scene, sound, few, LONGER * STEP) is None


def test_a_run_with_long_steps_tells_what_shorter_steps_add() -> None:
    """The same surface, marched at every fourth node and at every node, at 20 mm/s."""
    slow = ["rolling.speed_m_s=0.02", "dynamics.release=false", "rolling.distance_mm=0.8"]
    long = marched(VIBRATING, [*slow, "numerics.step_nodes=4"]).numbers
    short = marched(VIBRATING, slow).numbers
    wholes = [x.of_record.laeq_db - x.errors.band_db for x in (long, short)]
    assert short.of_record.laeq_db - long.of_record.laeq_db > 3
    assert abs(wholes[0] - wholes[1]) < 2 * long.errors.band_uncertainty_db
    assert short.errors.band_uncertainty_db < long.errors.band_uncertainty_db

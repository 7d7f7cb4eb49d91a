"""Record length: levels of parts of the track, their scatter and the stated uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.bands import BAND_NAMES, reliable
from rolling._typing import Array
from rolling.accuracy.variants import Study
from rolling.sound.contact_sound import ContactSound, contact_sound

PARTS = (2, 4)  # the track is cut into halves and quarters
AIM_DB = 0.1  # standard uncertainty of LAeq for which the record's length is stated


@dataclass(frozen=True)
class PartsCheck:
    """Levels of equal parts of the track against each other and against the whole.

    Parameters
    ----------
    parts : int. Number of parts.
    duration : float, s. Duration of a part.
    shift_db : float, dB. Mean LAeq of the parts less LAeq of the whole. Shorter records lose more
        to their fades.
    scatter_db, stated_db : float, dB. Standard deviation of the parts' LAeq, and the rms of their
        stated standard uncertainties.
    bands, bands_within : int. Third octaves of all parts that are long enough to be read, and those
        that are off the mean of the parts by no more than twice the stated uncertainty.
    """

    parts: int
    duration: float
    shift_db: float
    scatter_db: float
    stated_db: float
    bands: int
    bands_within: int


@dataclass(frozen=True)
class RecordCheck:
    """The record's length against its stated uncertainty.

    Parameters
    ----------
    duration : float, s. Duration of the stretch.
    uncertainty_db : float, dB. Stated standard uncertainty of its LAeq.
    parts : list of PartsCheck. Halves and quarters.
    """

    duration: float
    uncertainty_db: float
    parts: list[PartsCheck]

    @property
    def needed_s(self) -> float:
        """Duration [s] for a standard uncertainty of `AIM_DB`, which falls with its root."""
        return self.duration * (self.uncertainty_db / AIM_DB) ** 2


def record_check(study: Study, release_energy: Array) -> RecordCheck | None:
    """Compare levels of parts of a track with those of the whole.

    The result is None for a silent record, and for a changing speed, whose parts differ.

    Parameters
    ----------
    study : Study. The scene and its stretch.
    release_energy : array (steps,), J. Release of each step of the scene as it stands.
    """
    step = study.own.step_nodes * study.scene.spacing
    scene = study.as_solved(study.own)
    whole = contact_sound(scene, release_energy, step, study.closed)
    if not whole.constant_speed or whole.uncertainty.laeq_db is None:
        return None
    checks = []
    for parts in PARTS:
        length = len(release_energy) // parts
        sounds = [
            contact_sound(scene, release_energy[k * length : (k + 1) * length], step, False)
            for k in range(parts)
        ]
        if all(sound.uncertainty.laeq_db is not None for sound in sounds):
            checks.append(_check(whole, sounds))
    return RecordCheck(whole.duration, whole.uncertainty.laeq_db, checks)


def _check(whole: ContactSound, sounds: Sequence[ContactSound]) -> PartsCheck:
    """Compare parts of a record with each other and with the whole."""
    laeq = np.array([_known(sound.levels.laeq_db) for sound in sounds])
    stated = np.array([_known(sound.uncertainty.laeq_db) for sound in sounds])
    reads = dict(zip(BAND_NAMES, reliable(sounds[0].duration), strict=True))
    within: list[bool] = []
    for name in (name for name in BAND_NAMES if reads[name]):
        levels = np.array([_known(sound.levels.third_octave_db[name]) for sound in sounds])
        spread = np.array([_known(sound.uncertainty.third_octave_db[name]) for sound in sounds])
        # deviations from a mean that holds the part itself are smaller
        off = np.abs(levels - levels.mean()) / math.sqrt(1 - 1 / len(sounds))
        if np.isfinite(off).all() and np.isfinite(spread).all():
            within += (off <= 2 * spread).tolist()
    return PartsCheck(
        parts=len(sounds),
        duration=sounds[0].duration,
        shift_db=float(laeq.mean()) - _known(whole.levels.laeq_db),
        scatter_db=float(laeq.std(ddof=1)),
        stated_db=float(np.sqrt(np.mean(np.square(stated)))),
        bands=len(within),
        bands_within=sum(within),
    )


def _known(level: float | None) -> float:
    """Replace a missing level by NaN."""
    return math.nan if level is None else level

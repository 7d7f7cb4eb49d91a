"""What the gains of rough contacts leave open in the bands of a ring's velocity.

All specimens of a choice share the gains of their marches, so more specimens do not tell how wrong
these are. The waves of a march are parted into groups, and each group is left out once (jackknife).
Contacts with the same march move together, and their part cancels in a difference.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import RADIAL
from rolling.bearing_kind.contact_gain import GROUPS, contact_gain
from rolling.bearing_kind.contact_plan import ContactPlan
from rolling.bearing_kind.contact_uncertainty import (
    STEP_HZ,
    shown_hz,
    track_length_m,
    velocity_per_approach,
)
from rolling.bearing_kind.joined_tracks import acting_rows
from rolling.run.march_files import Marches


class RoughBand(NamedTuple):
    """Mean square of the radial velocity in a band [m2/s2] by all rough contacts, as expected.

    whole : float. With all waves of the marches.
    without_groups : array (GROUPS,). Without each group of waves.
    """

    whole: float
    without_groups: Array

    def levels_db(self, mean_square: float) -> Array:
        """Return the level of a band of a mean square [m2/s2] without each group, less that with.

        What else moves the ring, such as form, stays. Shape (GROUPS,).
        """
        stays = max(mean_square - self.whole, 0.0)
        if not stays + self.whole > 0:
            return np.zeros(GROUPS)
        return np.asarray(10 * np.log10((stays + self.without_groups) / (stays + self.whole)))


def rough_bands(model: BearingModel, plan: ContactPlan, marches: Marches) -> dict[str, RoughBand]:
    """Return what the rough contacts make of each band, by linear theory of the ring.

    Parameters
    ----------
    model : BearingModel
    plan : ContactPlan
        Its contacts. Those of a measured turn are as they were marched, and have no part.
    marches : dict
        Marches by contact identity, as of `march_contacts`.

    Returns
    -------
    dict of RoughBand, by the name of the band
    """
    frequency_hz = shown_hz()
    gain = velocity_per_approach(model, frequency_hz)[RADIAL]
    whole = np.zeros_like(frequency_hz)
    without = np.zeros((GROUPS, len(frequency_hz)))
    for contact in plan.rough.values():
        if contact.scene.height_paths:
            continue
        place = contact.loads_n.index(contact.middle_load_n)
        response = contact_gain(contact, acting_rows(plan, contact, marches))
        power = response.marched_power[place]
        expected = response.power_gain()[place]
        line_hz = model.kinematics.rolling_speed_m_s / track_length_m(contact)
        waves = frequency_hz / line_hz
        factor = 2 / contact.steps**2 * STEP_HZ / line_hz * gain
        whole += factor * _between(waves, power)
        for group in range(GROUPS):
            change = response.power_gain(group)[place] / expected
            without[group] += factor * _between(waves, power * change)
    bands = {}
    for band, (low, high) in VELOCITY_BANDS_HZ.items():
        inside = (frequency_hz >= low) & (frequency_hz < high)
        bands[band] = RoughBand(float(whole[inside].sum()), without[:, inside].sum(axis=1))
    return bands


def _between(waves: Array, power: Array) -> Array:
    """Return the power between the waves 1, 2, ... of a track; beyond them it is constant."""
    return np.interp(waves, np.arange(1, len(power) + 1), power)


def gain_uncertainty_db(first: Array, second: Array) -> float:
    """Return the standard uncertainty of the difference of two levels by their gains [dB].

    Parameters
    ----------
    first, second : arrays (GROUPS,), dB
        Levels of a band of two bearings without each group, as of `RoughBand.levels_db`.
    """
    differences_db = second - first
    return float(np.sqrt((1 - 1 / GROUPS) * np.sum((differences_db - differences_db.mean()) ** 2)))

"""What the assumed values of a bearing are worth: how far other likely ones move its bands.

A linear ring is asked, on waves whose velocity is the same at all frequencies, before anything is
solved. So these are decibels of the transfer from waves to the ring, radially. Waves and roughness
that are assumed themselves have a ± by their share of what all random surfaces make.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.assumed_damping import LARGEST_LOSS_FACTOR
from rolling.bearing.assumed_surfaces import AMPLITUDE, CRESTS, OF_EXPONENT, assumptions_db
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.wave_motion import BALLS
from rolling.bearing_kind.body_forms import (
    ROUGHNESS_KEYS,
    assumed_roughness,
    assumed_surfaces,
    random_waves,
)
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.bearing_sources import assumed_keys
from rolling.scene.messages import SceneError

CONFORMITY_STEP = 0.005  # between grooves that makers grind
CLEARANCE_STEP_UM = 5.0  # a half of the range of a group of clearance, about
SIZE_SHARE = 0.02  # of a diameter of balls or of their circle
MASS_SHARE = 0.2  # of a mass that is estimated from the section of a ring
_STEPS = 400  # frequencies in a band
_LEAST_DB = 0.05  # that is worth a word
_LITTLE = "less than 0.1 dB"
_KEYS = {
    AMPLITUDE: "wave_amplitude_um",
    OF_EXPONENT: "wave_exponent",
    CRESTS: "wave_crests",
    **ROUGHNESS_KEYS,
}


class AssumedWorth(NamedTuple):
    """What an assumed value is worth.

    key : str. Its key.
    other : float. Another value that is as likely.
    change_db : dict, dB. How far it would move the radial velocity of each band.
    """

    key: str
    other: float
    change_db: dict[str, float]

    @property
    def largest_db(self) -> float:
        """Largest of the changes, without its sign."""
        return max(map(abs, self.change_db.values()))

    @property
    def words(self) -> str:
        """The key, with the changes in the three bands where they are worth a word."""
        if self.largest_db < _LEAST_DB:
            return f"{self.key} ({_LITTLE})"
        changes = ", ".join(f"{round(value, 1) + 0.0:+.1f}" for value in self.change_db.values())
        return f"{self.key} (at {rounded(self.other, 3)}: {changes} dB)"


def assumed_worth(scene: BearingScene, key: str) -> AssumedWorth | None:
    """Return what an assumed value is worth; None where the scene takes no other one."""
    for name, other in _other_values(scene):
        if name != key:
            continue
        try:
            changed = scene.with_({f"bearing.{key}": other})
            return AssumedWorth(key, other, band_changes_db(scene.model, changed.model))
        except SceneError:
            return None
    return None


def _surface_worth(scene: BearingScene) -> dict[str, tuple[float, str]]:
    """Return what assumed surfaces are worth, by key: the largest of the bands [dB], and words."""
    if not assumed_surfaces(scene):
        return {}
    keys = assumed_keys(scene)
    worth = {}
    for (body, assumption), spread_db in assumptions_db(
        [*random_waves(scene), *assumed_roughness(scene)], scene.model, VELOCITY_BANDS_HZ
    ).items():
        largest = max(spread_db.values())
        key = f"surfaces.{body}.{_KEYS[assumption]}"
        if body == BALLS and assumption == AMPLITUDE:
            key = "surfaces.balls.grade"  # which limits the form
        if largest < _LEAST_DB:
            if key in keys:
                worth[key] = largest, f"{key} ({_LITTLE})"
            continue
        bands = ", ".join(f"{value:.1f}" for value in spread_db.values())
        worth[key] = largest, f"{key} (± {bands} dB)"
    return worth


def assumed_doubt(scene: BearingScene) -> Doubt | None:
    """Name the assumed values of a scene with what they are worth, the largest first."""
    of_surfaces = _surface_worth(scene)
    words = list(of_surfaces.values())
    for key in assumed_keys(scene):
        if key in of_surfaces:
            continue
        worth = assumed_worth(scene, key)
        words.append((worth.largest_db, worth.words) if worth is not None else (0.0, key))
    if not words:
        return None
    words.sort(key=lambda pair: pair[0], reverse=True)
    beside = ""
    if words[0][0] >= _LEAST_DB:
        beside = ", with how far other likely values would move the three bands radially"
    return Doubt(
        "assumed",
        f"assumed{beside}: {', '.join(text for _, text in words)}",
        Severity.NOTE,
        advice="give those that you know",
    )


def _other_values(scene: BearingScene) -> Iterator[tuple[str, float]]:
    """Yield keys that may be assumed, each with another likely value."""
    bearing = scene.bearing
    yield "contact_loss_factor", LARGEST_LOSS_FACTOR
    yield "conformity_inner", bearing.conformity_inner + CONFORMITY_STEP
    yield "conformity_outer", bearing.conformity_outer + CONFORMITY_STEP
    yield "ring_mass_kg", (1 + MASS_SHARE) * scene.model.ring_mass_kg
    yield "ball_diameter_mm", (1 + SIZE_SHARE) * bearing.ball_diameter_mm
    yield "pitch_diameter_mm", (1 + SIZE_SHARE) * bearing.pitch_diameter_mm
    yield "radial_clearance_um", (bearing.radial_clearance_um or 0.0) + CLEARANCE_STEP_UM


def band_changes_db(
    model: BearingModel,
    other: BearingModel,
    bands_hz: Mapping[str, tuple[float, float]] = VELOCITY_BANDS_HZ,
) -> dict[str, float]:
    """Return how far another bearing moves the radial velocity of each band [dB]."""
    changes = {}
    for band, (low, high) in bands_hz.items():
        frequency_hz = np.linspace(low, high, _STEPS)
        changes[band] = _level_db(other, frequency_hz) - _level_db(model, frequency_hz)
    return changes


def _level_db(model: BearingModel, frequency_hz: Array) -> float:
    """Return the level of the radial velocity of the ring over that of waves under all balls."""
    ring = linear_ring(model)
    moved = np.linalg.solve(ring.dynamic_stiffness(frequency_hz), ring.stiffness_n_m)
    return 10 * float(np.log10(np.mean(np.square(np.abs(moved[:, 0, 0])))))

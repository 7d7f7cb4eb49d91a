"""A solved bearing: scene, motion of its ring and tracks, and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

from acoustics.ring_velocity import VELOCITY_BANDS_HZ, NarrowSpectrum
from acoustics.traps import ignoring_underflow
from rolling.bearing import lines
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.lines import BearingLine
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import RingRecord
from rolling.bearing.tracks import BearingTracks
from rolling.bearing_kind.housing import HousingSound, housing_of_scene
from rolling.kinds.run_folder import RunFolder
from rolling.scene.bearing_scene import BearingScene

HIGHEST_HZ = VELOCITY_BANDS_HZ["high"][1]
GIVEN = "the scene"
KURTOGRAM = "the kurtogram"
DEFAULT = "the high band, because no band is more impulsive than noise"


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class SolvedBearing(RunFolder):
    """Data of a bearing from which its numbers are made.

    It equals no other one, so it can be the key of a dictionary. Its fields are described at
    `BearingRun`.
    """

    MADE_ONCE = ("housing", "lines", "envelope_band", "envelope")

    scene: BearingScene
    label: str
    record: RingRecord
    tracks: BearingTracks

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone, for pickle and copies; what follows from them is made again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def model(self) -> BearingModel:
        """Geometry, speeds, masses and loads, in SI."""
        return self.scene.model

    @property
    def geometry(self) -> BearingGeometry:
        """Dimensions and Hertz contacts, in SI."""
        return self.model.geometry

    @property
    def kinematics(self) -> Kinematics:
        """Turns per second of rings, cage and balls."""
        return self.model.kinematics

    @property
    def moving(self) -> str:
        """The ring that vibrates: inner or outer."""
        return self.kinematics.moving

    @cached_property
    def housing(self) -> HousingSound | None:
        """Sound of the housing plate, None for a scene without one."""
        return housing_of_scene(self.scene, linear_ring(self.model), self.record.velocity_m_s[:, 0])

    @property
    def bands_below_bending_hz(self) -> dict[str, tuple[float, float]]:
        """Edges of the three bands [Hz], cut at the ring's first bending mode.

        A band above it has two equal edges.
        """
        return bands_below_hz(self.scene.ring_holds_hz)

    @cached_property
    def lines(self) -> list[BearingLine]:
        """Lines of the bearing below 10 kHz: of its speeds, its load and its waviness."""
        bearing = self.scene.bearing
        bearing_lines = lines.kinematic_lines(self.kinematics)
        if bearing.radial_load_n > 0:
            bearing_lines += lines.varying_compliance(self.kinematics, self.geometry.balls)
        bearing_lines += lines.wave_lines(self.model, self.waves)
        bearing_lines = [line for line in bearing_lines if 0 < line.frequency_hz < HIGHEST_HZ]
        return sorted(bearing_lines, key=lambda line: line.frequency_hz)

    @cached_property
    def envelope_band(self) -> EnvelopeBand:
        """Band in which pulses are looked for: that of the scene, or of the kurtogram."""
        return envelope_band_of(self.record, self.kinematics, self.scene.sound.envelope_hz)

    @cached_property
    def envelope(self) -> NarrowSpectrum:
        """Spectrum of the squared envelope of the velocity along x in this band."""
        return self.record.envelope(self.envelope_band.band_hz)

    @property
    def waves(self) -> dict[str, list[int]]:
        """Orders of waviness of the bodies that have some, by body."""
        waves = {}
        for body in lines.BODIES:
            surface = getattr(self.scene.bearing.surfaces, body)
            orders = getattr(surface, "waviness", None) or {}
            if orders:
                waves[body] = [int(order) for order in orders]
        return waves

    @property
    def wavy(self) -> list[str]:
        """Bodies whose surface is rough, wavy or measured: balls, inner, outer."""
        surfaces = self.scene.bearing.surfaces
        bodies = []
        for body in lines.BODIES:
            surface = getattr(surfaces, body)
            if surface is not None and (surface.kind != "smooth" or surface.has_form):
                bodies.append(body)
        return bodies

    @property
    def faulty(self) -> list[str]:
        """Bodies whose surface has single faults: balls, inner, outer."""
        return faulty_bodies(self.scene)


class EnvelopeBand(NamedTuple):
    """Band of an envelope, and why it is this one.

    band_hz : (float, float), Hz. Its edges.
    chosen_by : str. GIVEN, KURTOGRAM, or DEFAULT where no band is more impulsive than noise.
    kurtosis : float or None. Kurtosis of the envelope by the kurtogram: 0 for noise.
    """

    band_hz: tuple[float, float]
    chosen_by: str
    kurtosis: float | None = None


def envelope_band_of(
    record: RingRecord, kinematics: Kinematics, given_hz: Sequence[float] | None
) -> EnvelopeBand:
    """Return the band of the envelope of a record: a given one, or that of the kurtogram."""
    if given_hz is not None:
        low, high = given_hz
        return EnvelopeBand((low, high), GIVEN)
    passes_hz = max(
        kinematics.ball_pass_outer_hz, kinematics.ball_pass_inner_hz, 2 * kinematics.ball_spin_hz
    )
    kurtogram = record.kurtogram(HIGHEST_HZ, passes_hz)
    if not kurtogram.stands_out:
        return EnvelopeBand(VELOCITY_BANDS_HZ["high"], DEFAULT, kurtogram.kurtosis)
    return EnvelopeBand(kurtogram.band_hz, KURTOGRAM, kurtogram.kurtosis)


def bands_below_hz(bending_hz: float) -> dict[str, tuple[float, float]]:
    """Return the edges of the three bands [Hz], cut at a bending mode; equal edges above it."""
    return {
        band: (low, max(min(high, bending_hz), low))
        for band, (low, high) in VELOCITY_BANDS_HZ.items()
    }


def faulty_bodies(scene: BearingScene) -> list[str]:
    """Return the bodies of a scene whose surface has single faults: balls, inner, outer."""
    surfaces = scene.bearing.surfaces
    return [body for body in lines.BODIES if getattr(getattr(surfaces, body), "faults", None)]

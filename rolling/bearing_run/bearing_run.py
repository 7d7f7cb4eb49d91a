"""Run of a bearing: motion of its ring, its bands and lines, and the numbers of its summary."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ, LineReading, NarrowSpectrum
from acoustics.traps import ignoring_underflow
from rolling.bearing import assumed_damping, lines
from rolling.bearing.band_uncertainty import (
    LOSS_FACTOR,
    RECORD,
    BandUncertainty,
    DecibelsOfBands,
)
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.lines import BearingLine
from rolling.bearing.model import BearingModel
from rolling.bearing.moving_angle import angles_under_loads
from rolling.bearing.ring_record import (
    AXIAL,
    DIRECTIONS,
    NOTHING_UM_S,
    PLACES,
    RADIAL,
    UM_S,
    RingRecord,
)
from rolling.bearing.tracks import BearingTracks
from rolling.bearing_contacts.bearing_check import contact_angle_doubt, departures
from rolling.bearing_run import summary
from rolling.bearing_run.housing import HousingSound, housing_of_scene
from rolling.bearing_run.without_faults import WithoutFaults
from rolling.numbers.doubt import Doubt
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.bearing_sources import has_assumed_loss_factor
from rolling.scene.sweep import Value

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

LOWEST_HZ = VELOCITY_BANDS_HZ["low"][0]
HIGHEST_HZ = VELOCITY_BANDS_HZ["high"][1]
HIGHEST_PEAK_HZ = VELOCITY_BANDS_HZ["medium"][1]  # beyond it roughness leads, not waves
MAX_PEAKS = 8  # of a spectrum that are listed
LEAST_SHARE = 0.01  # of the largest peak
LEAST_HEIGHT = 5.0  # of a peak over the median of its surroundings
MAX_NEAR = 3  # lines that are named beside a peak from which they are not told apart
NO_LINE = LineReading(rms=0.0, height=0.0)


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class BearingRun:
    """A run of a bearing. It equals no other run, so it can be the key of a dictionary.

    Attributes
    ----------
    scene : BearingScene
        Scene without a sweep.
    record : RingRecord
        Motion of the ring that vibrates, and loads of the balls.
    tracks : BearingTracks
        How the heights of all bodies change the approach of their contacts.
    solved : tuple of Doubt
        Doubts about the rough contacts, from their marches.
    contacts : tuple of dict
        Numbers of the rough contacts that were marched.
    contact_uncertainty : BandUncertainty
        Parts of the uncertainty of the bands that come from the rough contacts. Default: none.
    parts_cpu_s : dict
        Processor time [s] of each part of the run, as far as it is done.
    without_faults : WithoutFaults, optional
        Numbers of the same bearing without its single faults; None where it has none.
    values : dict
        Swept values of the run, by dotted key.
    label : str
        Label that distinguishes the run from others, such as `grade G5`.
    folder : Path
        Run folder; the working directory for a run that is in memory only.

    Examples
    --------
    >>> import rolling
    >>> waves = {"inner": {"kind": "smooth", "waviness": {9: 0.1}}}
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": waves},
    ...     sound={"duration_s": 0.2, "listen_s": 0.2},
    ... )
    >>> run = rolling.simulate_bearing(scene, progress=False)
    >>> run.moving, [round(line.frequency_hz) for line in run.lines if line.name == "inner 9"]
    ('outer', [178])
    """

    scene: BearingScene
    record: RingRecord
    tracks: BearingTracks
    solved: tuple[Doubt, ...] = ()
    contacts: tuple[dict[str, Any], ...] = ()
    contact_uncertainty: BandUncertainty = field(default_factory=BandUncertainty)
    parts_cpu_s: Mapping[str, float | None] = field(default_factory=dict)
    without_faults: WithoutFaults | None = None
    values: Mapping[str, Value] = field(default_factory=dict)
    label: str = ""
    folder: Path = Path()

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
    def bands_um_s(self) -> dict[str, dict[str, float]]:
        """Velocity of the ring [um/s] by direction (radial, axial) and band (low, medium, high)."""
        return {
            direction: {name: UM_S * rms for name, rms in bands.rms_m_s.items()}
            for direction, bands in self.record.bands.items()
        }

    @cached_property
    def uncertainty(self) -> BandUncertainty:
        """Standard uncertainty of the bands, with all parts that are known."""
        record_db = {
            direction: self.record.bands[direction].uncertainty_db for direction in DIRECTIONS
        }
        parts = self.contact_uncertainty.with_part(RECORD, record_db)
        if has_assumed_loss_factor(self.scene):
            parts = parts.with_part(LOSS_FACTOR, self._loss_factor_db(VELOCITY_BANDS_HZ))
        return parts

    def _loss_factor_db(self, bands_hz: Mapping[str, tuple[float, float]]) -> DecibelsOfBands:
        """Return what an assumed loss factor leaves uncertain in bands [dB], 0 in those at rest."""
        decibels = assumed_damping.loss_factor_db(self.record, self.model, bands_hz)
        return {
            direction: {
                band: value if self.bands_um_s[direction][band] >= NOTHING_UM_S else 0.0
                for band, value in bands.items()
            }
            for direction, bands in decibels.items()
        }

    @property
    def moving(self) -> str:
        """The ring that vibrates: inner or outer."""
        return self.kinematics.moving

    @cached_property
    def housing(self) -> HousingSound | None:
        """Sound of the housing plate, None for a scene without one."""
        return housing_of_scene(self.scene, linear_ring(self.model), self.record.velocity_m_s[:, 0])

    @cached_property
    def lines(self) -> list[BearingLine]:
        """Lines of the bearing below 10 kHz: of its speeds, its load and its waviness."""
        bearing = self.scene.bearing
        found = lines.kinematic_lines(self.kinematics)
        if bearing.radial_load_n > 0:
            found += lines.varying_compliance(self.kinematics, self.geometry.balls)
        found += lines.wave_lines(self.model, self.waves)
        found = [line for line in found if 0 < line.frequency_hz < HIGHEST_HZ]
        return sorted(found, key=lambda line: line.frequency_hz)

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
        found = []
        for body in lines.BODIES:
            surface = getattr(surfaces, body)
            if surface is not None and (surface.kind != "smooth" or surface.has_form):
                found.append(body)
        return found

    @property
    def faulty(self) -> list[str]:
        """Bodies whose surface has single faults: balls, inner, outer."""
        surfaces = self.scene.bearing.surfaces
        return [body for body in lines.BODIES if getattr(getattr(surfaces, body), "faults", None)]

    @property
    def departures(self) -> list[str]:
        """What the run does otherwise than ISO 15242 asks for, in words; empty if nothing."""
        return departures(self.scene)

    @cached_property
    def angles_under_loads(self) -> tuple[float, float]:
        """Least and largest contact angle [rad] under the loads; the motion keeps the free one."""
        return angles_under_loads(
            self.geometry,
            axial_load_n=self.model.axial_load_n,
            radial_load_n=self.model.radial_load_n,
        )

    @cached_property
    def axial_doubt(self) -> Doubt | None:
        """Doubt that forbids to quote the axial velocities, None where they may be quoted."""
        return contact_angle_doubt(self.scene)

    @property
    def bands_below_bending_hz(self) -> dict[str, tuple[float, float]]:
        """Edges of the three bands [Hz], cut at the ring's first bending mode.

        A band above it has two equal edges.
        """
        bending_hz = self.scene.ring_bending_hz
        return {
            band: (low, max(min(high, bending_hz), low))
            for band, (low, high) in VELOCITY_BANDS_HZ.items()
        }

    @cached_property
    def bands_below_bending_um_s(self) -> dict[str, dict[str, float]]:
        """Velocity of the ring [um/s] in the parts of the bands below its first bending mode.

        They are by direction and band; a part has the share of the power of its band that it has in
        the narrow spectrum.
        """
        velocities: dict[str, dict[str, float]] = {}
        for direction, spectrum in self.record.spectra.items():
            velocities[direction] = {}
            square = np.square(spectrum.rms)
            for band, (low, high) in VELOCITY_BANDS_HZ.items():
                inside = (spectrum.frequency_hz >= low) & (spectrum.frequency_hz < high)
                below = spectrum.frequency_hz < self.bands_below_bending_hz[band][1]
                whole = float(square[inside].sum())
                share = float(square[inside & below].sum()) / whole if whole > 0 else 1.0
                velocities[direction][band] = math.sqrt(share) * self.bands_um_s[direction][band]
        return velocities

    @cached_property
    def below_bending_uncertainty_db(self) -> dict[str, dict[str, float]]:
        """Standard uncertainty of the bands below the first bending mode, by direction and band.

        Their parts are those of the whole bands, but for that of an assumed loss factor, which
        depends on whether a resonance is below.
        """
        parts = self.uncertainty
        if LOSS_FACTOR in parts.parts_db:
            own = self._loss_factor_db(self.bands_below_bending_hz)
            parts = parts.with_part(LOSS_FACTOR, own)
        return parts.totals_db

    @property
    def share_above_bending_db(self) -> float:
        """Part of the radial high band [dB] that lies above the ring's first bending mode.

        The level of the band falls by so much without it; infinite where all of it lies above.
        """
        whole = self.bands_um_s[RADIAL]["high"]
        below = self.bands_below_bending_um_s[RADIAL]["high"]
        if not whole > 0:
            return 0.0
        return 20 * math.log10(whole / below) if below > 0 else math.inf

    @cached_property
    def peaks(self) -> list[BearingLine]:
        """The largest peaks below 1,800 Hz, radial and axial, with the lines that they are."""
        families = lines.family_lines(
            self.model,
            wavy=self.wavy,
            faulty=self.faulty,
            highest_hz=HIGHEST_PEAK_HZ,
            apart_hz=2 * self.record.spectra[RADIAL].line_width_hz,
        )
        found = dict[str, BearingLine]()
        for direction, spectrum in self.record.spectra.items():
            known = [line for line in [*self.lines, *families] if direction in line.directions]
            peaks_hz = spectrum.peaks_hz(MAX_PEAKS, LOWEST_HZ, HIGHEST_PEAK_HZ, LEAST_HEIGHT)
            largest = 0.0
            for hz in peaks_hz:
                rms = spectrum.read_line(hz).rms or 0.0
                largest = max(largest, rms)
                if rms >= max(LEAST_SHARE * largest, NOTHING_UM_S / UM_S):
                    line = _simplest(known, hz, spectrum, direction)
                    found.setdefault(line.name, line)
        return list(found.values())

    @cached_property
    def lines_with_levels(self) -> list[dict[str, Any]]:
        """Lines and largest peaks with their velocity [um/s] and height over surroundings.

        A line has no velocity in a direction in which it does not move the ring, and none is known
        where the record does not separate it from a stronger line: `resolved_by_s` is the length of
        a record that would.
        """
        table = []
        named = {line.name: line for line in [*self.lines, *self.peaks]}
        every = sorted(named.values(), key=lambda line: line.frequency_hz)
        frequencies = {
            direction: [line.frequency_hz for line in every if direction in line.directions]
            for direction in DIRECTIONS
        }
        for line in every:
            row: dict[str, Any] = {
                "name": line.name,
                "meaning": line.meaning,
                "frequency_hz": line.frequency_hz,
            }
            for direction in DIRECTIONS:
                reading = NO_LINE
                if direction in line.directions:
                    spectrum = self.record.spectra[direction]
                    reading = spectrum.read_line(line.frequency_hz, frequencies[direction])
                um_s = None if reading.rms is None else UM_S * reading.rms
                if um_s is not None and um_s < NOTHING_UM_S:  # rounding of a ring at rest
                    reading = NO_LINE
                row[f"{direction}_um_s"] = um_s
                row[f"{direction}_height"] = reading.height
                row[f"{direction}_resolved_by_s"] = reading.resolving_s
            table.append(row)
        return table

    @cached_property
    def envelope_lines(self) -> list[dict[str, Any]]:
        """Lines of the envelope with their share of its mean, and their height.

        Of a line that the record does not separate from a stronger one, both are unknown, and
        `resolved_by_s` is the length of a record that would separate it.
        """
        table = []
        for line, reading in lines.envelope_readings(self.record.envelope, self.kinematics):
            row = {
                "name": line.name,
                "meaning": line.meaning,
                "frequency_hz": line.frequency_hz,
                "share": reading.rms,
                "height": reading.height,
                "resolved_by_s": reading.resolving_s,
            }
            table.append(row)
        return table

    @cached_property
    def mean_loads_n(self) -> Array:
        """Mean load of a ball [N] at 72 angles from the middle of the load zone on."""
        return self.record.loads_around(PLACES)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Numbers of summary.json, in the units of their names, and sentences last."""
        return summary.summarize(self)

    def to_xarray(self) -> xarray.Dataset:
        """Return the content of result.h5 as named arrays with units.

        Returns
        -------
        dataset : xarray.Dataset
            Motion of the ring and loads of the balls over time, tracks over the turns of their
            bodies, and the facts of the run in `attrs`.
        """
        from rolling.bearing_run import stored_run

        return stored_run.result_dataset(self)

    def plot(self, name: str = "spectrum", ax: Axes | None = None) -> Axes:
        """Draw a figure of the run.

        Parameters
        ----------
        name : str
            spectrum, envelope, load_distribution (on polar axes) or ball_forces.
        ax : Axes
            Axes of matplotlib. Default: new ones.

        Returns
        -------
        ax : Axes

        Raises
        ------
        ValueError
            There is no figure of this name.
        """
        from rolling.bearing_run import figures

        return figures.drawn(self, name, ax)

    def play(self) -> Any:
        """Return a player of the ring's acceleration for a notebook; a script gets the file named.

        With a housing plate its sound is played. The gain makes all runs equally loud, so levels
        are compared by their numbers.

        Returns
        -------
        player : IPython.display.Audio, or None
        """
        from rolling.bearing_run import stored_run

        return stored_run.play(self)

    def _repr_html_(self) -> str:
        """Write the sentences of a run and its bands for a notebook."""
        said = "".join(f"<p>{html.escape(text)}</p>" for text in self.summary["sentences"])
        rows = ""
        for band, words in summary.band_words(self).items():
            cells = ""
            for direction in DIRECTIONS:
                velocity = summary.velocity(self.bands_below_bending_um_s[direction][band])
                verdict = ""
                if direction == AXIAL and self.axial_doubt is not None:
                    verdict = f", {self.axial_doubt.severity.word}"
                cells += f"<td>{velocity}{verdict}</td>"
            rows += f"<tr><td>{words}</td>{cells}</tr>"
        heads = "".join(f"<th>{direction} [um/s]</th>" for direction in DIRECTIONS)
        return f"{said}<table><tr><th>band</th>{heads}</tr>{rows}</table>"

    def __repr__(self) -> str:
        bands = self.bands_below_bending_um_s[RADIAL]
        numbers = ", ".join(f"{um_s:.3g}" for um_s in bands.values())
        return f"<bearing run {self.scene.name}: radial {numbers} um/s>"


def _simplest(
    known: Sequence[BearingLine], hz: float, spectrum: NarrowSpectrum, direction: str
) -> BearingLine:
    """Return the first of known lines that a peak may be, or one that has no other name."""
    for line in known:
        if spectrum.is_at(line.frequency_hz, hz):
            return line
    near = [line.name for line in known if spectrum.hides(line.frequency_hz, hz)]
    meaning = "none of the kinematics"
    if near:
        meaning = f"not told apart from {', '.join(near[:MAX_NEAR])} by this record"
    return BearingLine(f"{hz:.1f} Hz", meaning, hz, directions=(direction,))

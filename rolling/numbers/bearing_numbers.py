"""The numbers of a run of a bearing, by subject. They are made once, after the motion of the ring.

A new number is a field here, with its unit, meaning and format, and an assignment in
`rolling.bearing_kind.bearing_run_numbers`. Tables and files follow from the fields.
"""

from __future__ import annotations

from dataclasses import dataclass

from rolling.numbers.doubt import Doubt
from rolling.numbers.fields import group, number
from rolling.numbers.quantity import BandQuantity, Quantity

RMS_VELOCITY = "rms velocity"
UM_PER_S = "um/s"
MAKERS_REFERENCE_M_S2 = 9.81e-3  # of a level of acceleration: a thousandth of gravity
MAKERS_REFERENCE = "9.81e-3 m/s2"  # the same in words
HOUSING = "housing"  # name of the level of a housing plate
AXIAL_NAMES = (
    *("axial_low", "axial_medium", "axial_high"),
    *("axial_low_below_bending", "axial_medium_below_bending", "axial_high_below_bending"),
)
"""Names of all axial velocities, for a doubt that touches them alone."""


@dataclass(frozen=True, kw_only=True)
class BandVelocities:
    """Velocity of the ring in the three bands of ISO 15242-1, in one direction.

    Values are in um/s rms. Their standard uncertainties and the parts of these are in dB.
    """

    low: Quantity = group("50 to 300 Hz", origin_in_table=False)
    medium: Quantity = group("300 to 1,800 Hz", origin_in_table=False)
    high: Quantity = group("1,800 to 10,000 Hz", origin_in_table=False)

    @property
    def by_band(self) -> dict[str, Quantity]:
        """The velocities by the names of their bands, lowest first."""
        return {"low": self.low, "medium": self.medium, "high": self.high}

    @property
    def um_s(self) -> dict[str, float | None]:
        """The values by the names of their bands [um/s]; None where one is not known."""
        return {band: velocity.value for band, velocity in self.by_band.items()}


@dataclass(frozen=True, kw_only=True)
class RingVelocities:
    """Velocity of the ring by direction and band."""

    radial: BandVelocities = group("mean over all radial directions, by power")
    axial: BandVelocities = group("along the shaft")

    @property
    def by_direction(self) -> dict[str, BandVelocities]:
        """The velocities by the names of their directions."""
        return {"radial": self.radial, "axial": self.axial}


@dataclass(frozen=True, kw_only=True)
class BandValues:
    """Velocities in the three bands without an uncertainty of their own."""

    low: float = number("50 to 300 Hz", UM_PER_S)
    medium: float = number("300 to 1,800 Hz", UM_PER_S)
    high: float = number("1,800 to 10,000 Hz", UM_PER_S)

    @property
    def by_band(self) -> dict[str, float]:
        """The velocities by the names of their bands [um/s], lowest first."""
        return {"low": self.low, "medium": self.medium, "high": self.high}


@dataclass(frozen=True, kw_only=True)
class EnvelopeHeight:
    """Height of a line of the envelope."""

    name: str = number("name of the line", "")
    height: float | None = number(
        "height over its surroundings; none where the record does not separate it from a stronger "
        "line",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class FaultlessNumbers:
    """Numbers of the same bearing as it would run without its single faults."""

    radial: BandValues = group("radial velocities")
    axial: BandValues = group("axial velocities")
    envelope: tuple[EnvelopeHeight, ...] = group("lines of the envelope")

    @property
    def heights(self) -> dict[str, float | None]:
        """Heights of the lines of the envelope by their names."""
        return {line.name: line.height for line in self.envelope}


@dataclass(frozen=True, kw_only=True)
class LineVelocity:
    """A line of the spectrum in one direction."""

    um_s: float | None = number(
        "rms velocity; none where the record does not separate the line from a stronger one, and "
        "0 where the line does not move the ring in this direction",
        UM_PER_S,
        default=None,
    )
    height: float | None = number("height over its surroundings", default=None)
    resolved_by_s: float | None = number(
        "length of a record that would separate it; none where this one does", "s", default=None
    )


@dataclass(frozen=True, kw_only=True)
class VelocityLine:
    """A line of the spectrum of the velocity: of speeds, load or waviness, or a large peak."""

    name: str = number("short name, as figures mark it", "")
    meaning: str = number("what happens at this frequency", "")
    frequency_hz: float = number("frequency", "Hz")
    radial: LineVelocity = group("radially")
    axial: LineVelocity = group("along the shaft")

    @property
    def by_direction(self) -> dict[str, LineVelocity]:
        """The velocities by the names of their directions."""
        return {"radial": self.radial, "axial": self.axial}


@dataclass(frozen=True, kw_only=True)
class EnvelopeLine:
    """A line of the spectrum of the squared envelope along x, where faults show."""

    name: str = number("short name", "")
    meaning: str = number("what happens at this frequency", "")
    frequency_hz: float = number("frequency", "Hz")
    share: float | None = number(
        "amplitude over the mean; none where the record does not separate the line from a stronger "
        "one",
        default=None,
    )
    height: float | None = number("height over its surroundings", default=None)
    resolved_by_s: float | None = number(
        "length of a record that would separate it; none where this one does", "s", default=None
    )


@dataclass(frozen=True, kw_only=True)
class EnvelopeBandNumbers:
    """Band of the envelope in which faults are looked for."""

    low_hz: float = number("lower edge", "Hz")
    high_hz: float = number("upper edge", "Hz")
    chosen_by: str = number("what chose the band", "")
    kurtosis: float | None = number(
        "kurtosis of the envelope by the kurtogram: 0 for noise; none for a given band",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class BandPulseNumbers:
    """How impulsive the velocity of the ring is in a band."""

    peak_um_s: float = number("largest velocity", UM_PER_S)
    crest_factor: float | None = number("peak over rms; none at rest", default=None)
    kurtosis: float | None = number(
        "mean fourth power over the square of the mean square: 3 for noise; none at rest",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class PulseNumbers:
    """Acceleration of the ring along x, and how impulsive it vibrates.

    All end at the first bending mode of the ring. A band that lies above this mode is none.
    """

    low: BandPulseNumbers | None = group("velocity from 50 to 300 Hz", default=None)
    medium: BandPulseNumbers | None = group("velocity from 300 to 1,800 Hz", default=None)
    high: BandPulseNumbers | None = group("velocity from 1,800 to 10,000 Hz", default=None)
    lowest_hz: float = number("frequency from which on the acceleration counts", "Hz")
    highest_hz: float = number("frequency up to which it counts", "Hz")
    acceleration_m_s2: float = number("rms acceleration", "m/s2")
    acceleration_db: float = number(
        "level of the rms acceleration, as makers state it", f"dB re {MAKERS_REFERENCE}"
    )
    crest_factor: float | None = number("peak of the acceleration over its rms", default=None)
    kurtosis: float | None = number(
        "kurtosis of the acceleration: 3 for noise, and more for pulses", default=None
    )
    kurtosis_uncertainty: float | None = number(
        "standard uncertainty of the kurtosis of noise of this spectrum and length", default=None
    )


@dataclass(frozen=True, kw_only=True)
class VibrationClass:
    """Class of vibration by the limits of makers: V0 to V4, above V0, or two that the ± leaves."""

    low: str | None = number("class of the low band", "", default=None)
    medium: str | None = number("class of the medium band", "", default=None)
    high: str | None = number("class of the high band", "", default=None)
    overall: str | None = number("class of the bearing, that of its worst band", "", default=None)
    none_because: str | None = number("why it has no class", "", default=None)
    source: str = number("whose limits these are", "", default="")

    @property
    def by_band(self) -> dict[str, str]:
        """The classes by the names of those bands that have one."""
        bands = {"low": self.low, "medium": self.medium, "high": self.high}
        return {band: name for band, name in bands.items() if name is not None}


@dataclass(frozen=True, kw_only=True)
class RingNumbers:
    """The ring that does not turn, and therefore vibrates."""

    moving: str = number("which ring vibrates: inner or outer", "")
    mass_kg: float = number("mass of the ring that vibrates", "kg")
    resonances_hz: tuple[float, ...] = number("resonances of the ring on its balls", "Hz")
    bending_hz: float = number("first bending mode, above which it is not rigid", "Hz")
    left_out_hz: float | None = number(
        "lowest mode that is left out of an elastic ring; none for a rigid one", "Hz", default=None
    )

    @property
    def holds_hz(self) -> float:
        """Frequency [Hz] up to which the ring moves as it is modelled."""
        return self.bending_hz if self.left_out_hz is None else self.left_out_hz


@dataclass(frozen=True, kw_only=True)
class MotionOfRing:
    """The record of the motion, and how well its energy balances."""

    duration_s: float = number("length of the record", "s")
    energy_error: float = number("energy that the balance lacks, over the exchanged energy")
    lost_contact_share: float = number("share of the time that a ball bears nothing")


@dataclass(frozen=True, kw_only=True)
class SpeedNumbers:
    """Turns and rates of a bearing whose balls roll without slip."""

    cage_hz: float = number("turns of the cage", "Hz")
    ball_pass_outer_hz: float = number("balls pass a place of the outer raceway: BPFO", "Hz")
    ball_pass_inner_hz: float = number("balls pass a place of the inner raceway: BPFI", "Hz")
    ball_spin_hz: float = number("turns of a ball beside its cage", "Hz")
    rolling_speed_m_s: float = number("speed of a contact along its raceway", "m/s")


@dataclass(frozen=True, kw_only=True)
class BallLoads:
    """Loads of the balls."""

    largest_n: float = number("largest load", "N")
    least_n: float = number("least load", "N")
    mean_n: float = number("mean load", "N")
    mean_at_angles_n: tuple[float | None, ...] = number(
        "mean load at equal angles around the bearing, from the middle of the load zone on; none "
        "where no ball has been",
        "N",
    )


@dataclass(frozen=True, kw_only=True)
class AngleNumbers:
    """Contact angles."""

    free_deg: float = number("angle without load, which the motion keeps if it is fixed", "degrees")
    least_under_loads_deg: float = number(
        "least angle to which the loads would turn it, or do", "degrees"
    )
    largest_under_loads_deg: float = number("largest such angle", "degrees")


@dataclass(frozen=True, kw_only=True)
class FilmNumbers:
    """Film of oil between the balls and a raceway."""

    raceway: str = number("inner or outer", "")
    thickness_m: float = number("thickness in the middle of a contact at the mean load", "m")
    ratio: float | None = number(
        "thickness over the rms roughness of both surfaces, lambda; none on smooth ones",
        default=None,
    )
    weight: float = number("weight of the film beside the dry march, 0 to 1")


@dataclass(frozen=True, kw_only=True)
class HousingNumbers:
    """Sound and motion of the housing plate."""

    laeq: Quantity = group("LAeq of the plate at the listener", origin_in_table=False)
    third_octaves: BandQuantity = group("third octaves of its sound")
    distance_m: float = number("distance of the listener", "m")
    force_n: float = number("rms of the force of the ring on the plate", "N")
    velocity_um_s: float = number("rms velocity of plate and ring together", UM_PER_S)


@dataclass(frozen=True, kw_only=True)
class MarchedContact:
    """Numbers of the march of a rough contact at its middle load."""

    name: str = number("kind of contact", "")
    load_n: float = number("load", "N")
    approach_rms_m: float = number("rms fluctuation of the approach", "m")
    linear_db: float = number("level of the linear response over that of the march", "dB")
    approach_loss: float = number("mean approach less Hertz's, over Hertz's")
    stiffness_change: float | None = number(
        "mean stiffness between the loads beside the middle one over Hertz's, less 1; none with "
        "fewer marches",
        default=None,
    )
    max_pressure_pa: float = number("maximum pressure", "Pa")
    march_cpu_s: float | None = number(
        "processor time of the marches at all loads; none for a run of 0.8.0", "s", default=None
    )


@dataclass(frozen=True, kw_only=True)
class BearingEffort:
    """How long a run of a bearing took."""

    march_cpu_s: float | None = number(
        "processor time of the rough contacts at their middle load", "s", in_table=True
    )
    parts_cpu_s: dict[str, float | None] | None = group(
        "processor time [s] of each part of the run", default=None
    )


@dataclass(frozen=True, kw_only=True)
class BearingNumbers:
    """The numbers of a run of a bearing.

    Attributes
    ----------
    name : str
        Name of the scene.
    title : str or None
        Its title.
    sentences : tuple of str
        The answer in words, the most important sentence first.
    below_bending : RingVelocities
        Velocity of the ring in the parts of the three bands below its first bending mode. These
        lead, because the ring is rigid here. A part above it is 0.
    velocities : RingVelocities
        Velocity of a ring that stays rigid, in the whole bands.
    lines, envelope_lines : tuple of VelocityLine, tuple of EnvelopeLine
        Lines of the spectrum of the velocity and of its envelope.
    envelope_band : EnvelopeBandNumbers or None
        Band of the envelope; None for a run of an earlier version, which has 1,800 to 10,000 Hz.
    pulses : PulseNumbers or None
        Acceleration of the ring, and how impulsive it vibrates; None for a ring at rest.
    vibration_class : VibrationClass or None
        Class by the limits of makers, or why there is none; None for a run of an earlier version.
    without_faults : FaultlessNumbers or None
        The same bearing without its single faults; None for one that has none.
    ring, motion, speeds, loads, angles, effort : data classes
        Numbers of the ring, of its record, of the kinematics, of the balls, of the contact angle,
        and processor times.
    housing : HousingNumbers or None
        The housing plate, if the scene has one.
    films : tuple of FilmNumbers
        Films of oil on both raceways; none in dry contacts.
    contacts : tuple of MarchedContact
        Rough contacts that were marched.
    departures : tuple of str
        What the run does otherwise than ISO 15242 asks for.
    doubts : tuple of Doubt
        All that limits the numbers.

    Examples
    --------
    >>> import rolling
    >>> waves = {"inner": {"kind": "smooth", "waviness": {9: 0.1}}}
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": waves},
    ...     sound={"duration_s": 0.2, "listen_s": 0.2},
    ... )
    >>> numbers = rolling.simulate(scene, progress=False).numbers
    >>> print(numbers.below_bending.radial.low)
    81 um/s ± 0.1 dB, computed
    """

    name: str = ""
    title: str | None = None
    sentences: tuple[str, ...] = number("the answer in words", "", default=())
    below_bending: RingVelocities = group(
        "velocity of the ring in the three bands up to its first bending mode"
    )
    velocities: RingVelocities = group("velocity of a ring that stays rigid, in the three bands")
    lines: tuple[VelocityLine, ...] = group("lines of the spectrum")
    envelope_lines: tuple[EnvelopeLine, ...] = group("lines of the envelope")
    envelope_band: EnvelopeBandNumbers | None = group("band of the envelope", default=None)
    pulses: PulseNumbers | None = group(
        "acceleration along x, peaks, crest factors and kurtosis", default=None
    )
    vibration_class: VibrationClass | None = group("class by the limits of makers", default=None)
    without_faults: FaultlessNumbers | None = group(
        "the same bearing without its single faults", default=None
    )
    ring: RingNumbers = group("the ring that vibrates")
    motion: MotionOfRing = group("the record of its motion")
    speeds: SpeedNumbers = group("turns and rates")
    loads: BallLoads = group("loads of the balls")
    angles: AngleNumbers = group("contact angles")
    housing: HousingNumbers | None = group("the housing plate", default=None)
    films: tuple[FilmNumbers, ...] = group("films of oil; none in dry contacts", default=())
    contacts: tuple[MarchedContact, ...] = group("rough contacts that were marched", default=())
    effort: BearingEffort = group("processor times")
    departures: tuple[str, ...] = number(
        "what the run does otherwise than ISO 15242 asks for", "", default=()
    )
    doubts: tuple[Doubt, ...] = group("what limits the numbers", default=())

    @property
    def axial_doubt(self) -> Doubt | None:
        """Doubt about the axial velocities alone; None where there is none."""
        axial_doubts = [doubt for doubt in self.doubts if doubt.about == AXIAL_NAMES]
        return axial_doubts[0] if axial_doubts else None

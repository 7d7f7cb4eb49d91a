"""The numbers of a run of a ball, by subject. They are made once, after the solve.

A new number is a field here, with its unit, meaning and format, and an assignment in
`rolling.results.run_numbers`. All tables, files and docs follow from the fields.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rolling.numbers.doubt import Doubt
from rolling.numbers.fields import group, number
from rolling.numbers.quantity import BandQuantity, Quantity

Source = Literal["vibration", "release"]
DB_A = "dB(A)"
DB = "dB"


@dataclass(frozen=True, kw_only=True)
class RunRecord:
    """The record that the sound files have, and what was solved for it."""

    source: Source = number("sound that the files have: vibration or release", "")
    load_n: float = number("load that presses the ball on the plate", "N")
    steps: int = number("steps of the record")
    duration_s: float = number("length of the record", "s")
    loops: bool = number("whether the record closes, so that it repeats without a click", "")
    single_event: bool = number("whether the record is a single event, which LAE describes", "")
    highest_frequency_hz: float = number(
        "Nyquist frequency of the steps, the highest that the record holds", "Hz"
    )
    laeq_db: float | None = number(
        "LAeq of the record itself; the vibration differs from it where it is the mean over a comb",
        DB_A,
        default=None,
    )
    crest_factor_db: float | None = number(
        "peak of the sound pressure over its rms, without weighting; none for a silent record",
        DB,
        word="crest factor",
        form=".1f",
        explained=(
            "the peak of the record over its rms. A sine has 3 dB, noise 12 to 14 dB, and knocks "
            "have more."
        ),
        default=None,
    )
    scatter_db: float | None = number(
        "uncertainty of LAeq, found by comparing three parts of the record",
        DB,
        default=None,
    )
    q: float | None = number(
        "share of the released power that counts as sound; none under a fixed gain, and for a "
        "vibration",
        default=None,
    )
    factor_pa_per_w_m2: float | None = number(
        "factor from the intensity of a release to sound pressure",
        "Pa/(W/m2)",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class LevelSpreads:
    """Parts of the ± of levels: length of the record; of a vibration also comb and time steps."""

    laeq_db: float | None = number("uncertainty of LAeq from the record", DB, default=None)
    level_db: float | None = number("uncertainty of LZeq from the record", DB, default=None)
    laf_max_db: float | None = number("uncertainty of LAFmax from the record", DB, default=None)
    las_max_db: float | None = number("uncertainty of LASmax from the record", DB, default=None)
    lz_peak_db: float | None = number("uncertainty of LZpeak from the record", DB, default=None)
    lae_db: float | None = number("uncertainty of LAE from the record", DB, default=None)
    steady_level_db: float | None = number(
        "uncertainty of the steady level from the record", DB, default=None
    )


@dataclass(frozen=True, kw_only=True)
class SourceLevels:
    """Levels of a sound; None where there is no sound, or where they are not known."""

    lae_db: float | None = number(
        "sound exposure level LAE (re 1 s)",
        DB_A,
        word="LAE (re 1 s)",
        form=".1f",
        holds_for="event",
        explained=(
            "the level of the event if all its energy came within one second. LAeq of an event "
            "would fall by 3 dB with each doubling of the record, so events cannot be compared by "
            "it; it is in summary.json."
        ),
        default=None,
    )
    laeq_db: float | None = number(
        "equivalent level LAeq", DB_A, word="LAeq", form=".1f", holds_for="lasting", default=None
    )
    level_db: float | None = number(
        "equivalent level LZeq, without weighting",
        DB,
        word="LZeq",
        form=".1f",
        in_table=True,
        holds_for="lasting",
        default=None,
    )
    laf_max_db: float | None = number(
        "maximum LAFmax (fast); none where the record is too short for its time weighting",
        DB_A,
        word="LAFmax",
        form=".1f",
        in_table=True,
        default=None,
    )
    las_max_db: float | None = number(
        "maximum LASmax (slow); none where the record is too short for its time weighting",
        DB_A,
        word="LASmax",
        form=".1f",
        default=None,
    )
    lz_peak_db: float | None = number(
        "peak level LZpeak", DB, word="LZpeak", form=".1f", in_table=True, default=None
    )
    steady_level_db: float | None = number(
        "level of the mean intensity of a release, which is silent",
        "dB re 1 pW/m2",
        word="steady level",
        shown_unit="dB re 1 pW/m²",
        form=".1f",
        explained=(
            "the level of the mean released power. A constant power makes no sound: it is the "
            "energy that is there, not the part that is heard."
        ),
        default=None,
    )
    spreads: LevelSpreads | None = group(
        "uncertainties from the record",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class ListenerLevels:
    """Levels of the vibration at each listener of a plate with edges."""

    at_mm: tuple[float, ...] = number("place of the listener from the corner of the plate", "mm")
    laeq_db: float | None = number("LAeq at this listener", DB_A, default=None)
    level_db: float | None = number("LZeq at this listener", DB, default=None)


@dataclass(frozen=True, kw_only=True)
class LevelNumbers:
    """Levels of both sources, and those that stand beside a vibration."""

    vibration: SourceLevels | None = group(
        "of the vibration, as far as it is computed", word="vibration", default=None
    )
    released_power: SourceLevels | None = group(
        "of the released power", word="released power", default=None
    )
    released_power_at_listener_db: float | None = number(
        "LAeq of the released power where the vibration is heard",
        DB_A,
        word="released power where the vibration is heard",
        form=".1f",
        as_measured=True,
        default=None,
    )
    released_power_z_at_listener_db: float | None = number(
        "LZeq of the released power where the vibration is heard",
        DB,
        default=None,
    )
    release_over_vibration_db: float | None = number(
        "level of the released power less that of the vibration, at the same place",
        DB,
        word="release over vibration",
        form=".1f",
        default=None,
    )
    equivalent_q: float | None = number(
        "share q at which the released power would be as loud as the vibration",
        word="q that equals them",
        form=".2g",
        explained=(
            "the share of the released power that would have to become sound for the release to "
            "be as loud as the vibration in LAeq. The two are not added: above 1 no share would do."
        ),
        default=None,
    )
    compact_source_level_db: float | None = number(
        "A-weighted level of a compact source with the power P of plate and ball, "
        "p² = rho c P/(2 pi r²)",
        DB_A,
        word="compact source of the same power",
        form=".1f",
        as_measured=True,
        default=None,
    )
    hemisphere_mean_level_db: float | None = number(
        "A-weighted mean over a half sphere around a plate with edges",
        DB_A,
        word="mean over the half sphere",
        form=".1f",
        as_measured=True,
        default=None,
    )
    plate_power_level_db: float | None = number(
        "sound power of the plate to one side; none above coincidence without a loss factor",
        "dB re 1 pW",
        word="sound power of the plate",
        form=".1f",
        in_table=True,
        holds_for="lasting",
        default=None,
    )
    ball_power_level_db: float | None = number(
        "sound power of the ball to one side",
        "dB re 1 pW",
        word="sound power of the sphere",
        form=".1f",
        holds_for="lasting",
        default=None,
    )
    listeners: tuple[ListenerLevels, ...] | None = group(
        "levels at each listener of a plate with edges",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class BandNumbers:
    """Third octaves: values by band, with their standard uncertainties where these are known."""

    vibration: BandQuantity | None = group("vibration, without weighting", default=None)
    vibration_a: BandQuantity | None = group(
        "vibration, A-weighted, unless it is computed and the release is measured", default=None
    )
    released_power: BandQuantity | None = group("released power, without weighting", default=None)
    released_power_a: BandQuantity | None = group(
        "released power, A-weighted, where it is the record that is measured",
        default=None,
    )
    released_power_at_listener: BandQuantity | None = group(
        "released power where the vibration is heard, without weighting",
        default=None,
    )
    plate_power: BandQuantity | None = group("sound power of the plate to one side", default=None)
    ball_power: BandQuantity | None = group("sound power of the ball to one side", default=None)
    force: BandQuantity | None = group("rms of the contact force", default=None)
    grid_error: BandQuantity | None = group(
        "error from the grid, with its uncertainty; positive where the stated value is too high",
        default=None,
    )
    solver_error: BandQuantity | None = group(
        "error from the solver; positive where the stated value is too high", default=None
    )
    subgrid_error: BandQuantity | None = group(
        "error from missing detail below the spacing, with its uncertainty; positive where "
        "the stated value is too high",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class ErrorNumbers:
    """Errors of the level that is measured; positive where the stated value is too high."""

    grid_db: float | None = number(
        "error of LAeq from the grid",
        DB,
        word="grid error of LAeq",
        form="+.2f",
        default=None,
    )
    grid_uncertainty_db: float | None = number(
        "standard uncertainty of the error of LAeq from the grid", DB, default=None
    )
    solver_db: float | None = number(
        "error of LAeq from the solver",
        DB,
        word="solver error of LAeq",
        form="+.2f",
        default=None,
    )
    subgrid_db: float | None = number(
        "error of LAeq from missing detail below the spacing",
        DB,
        word="error of LAeq from missing detail",
        form="+.2f",
        default=None,
    )
    subgrid_uncertainty_db: float | None = number(
        "standard uncertainty of the error of LAeq from missing detail", DB, default=None
    )
    band_db: float | None = number(
        "error of LAeq because the simulated band ends; none where the steps resolve hearing, "
        "for falls, where contact is lost, and on tracks that are too short to tell",
        DB,
        default=None,
    )
    band_uncertainty_db: float | None = number(
        "standard uncertainty of the error of LAeq because the band ends", DB, default=None
    )
    band_end_hz: float | None = number(
        "end of the simulated band at the lowest speed", "Hz", default=None
    )
    plastic_ratio_grid: float | None = number(
        "error of the plastic ratio from the grid", default=None
    )
    plastic_ratio_grid_uncertainty: float | None = number(
        "standard uncertainty of the error of the plastic ratio", default=None
    )
    grid_signal_db: float | None = number(
        "rms error of the signal from the grid over its rms fluctuation",
        DB,
        default=None,
    )
    grid_signal_uncertainty_db: float | None = number(
        "standard uncertainty of the rms error of the signal from the grid", DB, default=None
    )
    solver_signal_db: float | None = number(
        "rms error of the signal from the solver over its rms fluctuation",
        DB,
        default=None,
    )
    is_asked: bool = number("whether the scene asks for an error estimate", "", default=False)
    reason: str | None = number("why there is no error estimate", "", default=None)
    stretches: int | None = number(
        "stretches that were marched again for the error estimate", default=None
    )
    stretch_steps: int | None = number("steps of a stretch that was marched again", default=None)
    order: float | None = number("order of convergence of the grid", default=None)
    order_measured: bool | None = number(
        "whether the order of convergence was measured; if not, it is the default", "", default=None
    )
    worst_uncertainty_db: float | None = number(
        "largest uncertainty of the error of a third octave from 1 to 16 kHz",
        DB,
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class EnergyNumbers:
    """Released power, and errors of the energy ledger."""

    release_power_mean_w: float = number(
        "mean released power",
        "W",
        word="release, mean",
        shown_unit="µW",
        factor=1e6,
        in_table=True,
    )
    release_power_rms_w: float = number(
        "rms fluctuation of the released power",
        "W",
        word="release, rms",
        shown_unit="µW",
        factor=1e6,
        in_table=True,
    )
    release_power_audible_rms_w: float = number(
        "rms of the audible fluctuation of the released power", "W"
    )
    release_power_resolved_rms_w: float = number(
        "rms error of the solver within hearing; a record whose audible fluctuation is no "
        "larger is silent",
        "W",
    )
    balance_error: float = number(
        "largest defect of the energy ledger, as a share of the largest stored energy"
    )
    joint_error: float | None = number(
        "largest difference of the stored energy where pieces join, as a share of the largest "
        "stored energy",
        default=None,
    )
    moving_balance_error: float | None = number(
        "error of the energy ledger of the release under the moving load", default=None
    )
    moving_law_error_m: float | None = number(
        "error of the force law of the release under the moving load",
        "m",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class ContactNumbers:
    """Areas and pressures, as means or maxima over positions."""

    hertz_area_m2: float = number("area of the smooth elastic contact (Hertz)", "m2")
    area_mean_m2: float = number(
        "mean contact area",
        "m2",
        word="contact area",
        shown_unit="µm²",
        factor=1e12,
        in_table=True,
    )
    plastic_area_mean_m2: float = number(
        "mean area whose pressure is at the hardness, so that it yields", "m2"
    )
    plastic_ratio: float = number(
        "mean area at the hardness over the Hertz area",
        word="plastic ratio",
        form=".3f",
        in_table=True,
        explained=(
            "the area that yields at the hardness over the area of Hertz's smooth elastic contact."
        ),
    )
    max_pressure_pa: float = number(
        "maximum pressure of all positions",
        "Pa",
        word="maximum pressure",
        shown_unit="GPa",
        factor=1e-9,
        form=".3g",
        in_table=True,
    )


@dataclass(frozen=True, kw_only=True)
class EffortNumbers:
    """What the solver did, how far it went, and how long it took."""

    tolerance: float = number("tolerance of the solver")
    residual_max: float = number("largest KKT residual of a position")
    iterations_mean: float = number("mean iterations of a position")
    convolutions_mean: float = number("mean convolutions of a position: transforms or direct sums")
    step_nodes: float = number("length of a step in nodes")
    step_choice: str | None = number(
        "who chose the length of a step: the scene, or auto with its reason", "", default=None
    )
    length_choice: str | None = number(
        "who chose the length of the track: the scene, or auto with its reason", "", default=None
    )
    step_lowest_speed_m_s: float | None = number(
        "lowest speed at which the steps that auto chose may be heard anew; none at steps of "
        "one node, and for a number of the scene",
        "m/s",
        default=None,
    )
    step_ms: float | None = number("median processor time of a step", "ms", default=None)
    march_cpu_s: float | None = number(
        "processor time of the march along the track, without compilation; none in a run of "
        "version 0.8.0",
        "s",
        in_table=True,
        default=None,
    )
    parts_cpu_s: dict[str, float | None] | None = group(
        "processor time [s] of each part of the run",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class LevellingNumbers:
    """The plane that was removed from the heights of a file, and the seam that is left."""

    slope_along: float = number("slope along the track that was removed")
    slope_across: float = number("slope across the track that was removed")
    height_along_m: float = number("rise along the track that was removed", "m")
    height_across_m: float = number("rise across the track that was removed", "m")
    ra_before_m: float = number("Ra before levelling", "m")
    ra_after_m: float = number("Ra after levelling", "m")
    seam_step_m: float = number("step where the end of the heights meets their beginning", "m")
    seam_neighbours_m: float = number("steps beside this seam", "m")
    seam_stands_out: bool = number("whether the seam stands out from the steps beside it", "")
    text: str = number("plane and seam in words", "")


@dataclass(frozen=True, kw_only=True)
class PreparationStep:
    """A step of the preparation of the heights of a file."""

    step: str = number("name of the step", "")
    text: str = number("the step in words, with the roughness", "")
    before: dict[str, float] = group("Sa, Sq [m], Ssk, Sku, Sdq before")
    after: dict[str, float] = group("Sa, Sq [m], Ssk, Sku, Sdq after")
    warning: str | None = number("what to beware of in this step", "", default=None)


@dataclass(frozen=True, kw_only=True)
class MadeSurfaceNumbers:
    """How well a made surface meets its law."""

    skewness: float = number("skewness of the heights")
    kurtosis: float = number("kurtosis of the heights")
    spectrum_error_db: dict[str, float] = group(
        "mean square over that of the law [dB], by octave of wavelength [µm]"
    )
    spectrum_chance_db: dict[str, float] = group(
        "standard deviation of this error by chance [dB], by octave of wavelength [µm]"
    )


@dataclass(frozen=True, kw_only=True)
class WavelengthNumbers:
    """An octave of roughness wavelength, and how much of the sound comes from it."""

    from_um: float = number("shortest wave of the octave", "um")
    to_um: float = number("longest wave of the octave", "um")
    energy_share: float = number("share of the A-weighted energy")
    linear_share: float | None = number(
        "share of the approach that follows these waves", default=None
    )
    fall_db: float | None = number("fall of LAeq without these waves", DB, default=None)


@dataclass(frozen=True, kw_only=True)
class InstrumentOfSource:
    """What the instrument of a measurement leaves uncertain of the level of a sound."""

    error_db: float | None = number(
        "LAeq over the measurement less LAeq with the law", DB, default=None
    )
    spread_db: float | None = number(
        "error of LAeq joined with its uncertainty, the part of ±", DB, default=None
    )
    bands: BandQuantity | None = group(
        "error of the third octaves joined with its uncertainty", default=None
    )


@dataclass(frozen=True, kw_only=True)
class InstrumentNumbers:
    """What the instrument of a measurement did not see (`surface.instrument`)."""

    cutoff_m: float = number("wavelength below which the heights are not known", "m")
    limit: str = number("limit that sets this wavelength: tip, sampling or noise", "")
    tip_cutoff_m: float | None = number(
        "wavelength of the limit by the tip; none where it does not limit", "m", default=None
    )
    sampling_cutoff_m: float | None = number(
        "wavelength of the limit by sampling; none where it does not limit", "m", default=None
    )
    noise_cutoff_m: float | None = number(
        "wavelength of the limit by noise; none where it does not limit", "m", default=None
    )
    law: str | None = number("law of the spectrum below the cut-off, in words", "", default=None)
    noise_m: float | None = number("rms noise of the instrument", "m", default=None)
    noise_recognized: bool = number(
        "whether the spectrum shows the noise; if not, the scene states it", ""
    )
    noise_over_sq: float | None = number("rms noise of the instrument over Sq", default=None)
    reason: str | None = number("why the error of a level is not known", "", default=None)
    vibration: InstrumentOfSource | None = group("of the vibration", default=None)
    released_power: InstrumentOfSource | None = group("of the released power", default=None)


@dataclass(frozen=True, kw_only=True)
class SurfaceNumbers:
    """Roughness of the surface that the ball rolls over."""

    ra_m: float = number("arithmetic mean roughness Ra", "m", in_table=True)
    rq_m: float = number("rms roughness Rq", "m", in_table=True)
    skewness: float = number("skewness of the heights", in_table=True)
    kurtosis: float = number("kurtosis of the heights", in_table=True)
    rms_slope: float = number("rms gradient Sdq of the heights", in_table=True)
    highest_m: float = number("highest point, counted from the mean", "m")
    lowest_m: float = number("lowest point, counted from the mean", "m")
    plate_ra_m: float | None = number("Ra of the plate alone", "m", default=None)
    ball_ra_m: float | None = number("Ra of the ball alone", "m", default=None)
    levelling: LevellingNumbers | None = group("plane that was removed, and seam", default=None)
    preparation: tuple[PreparationStep, ...] | None = group("steps of a height file", default=None)
    made: MadeSurfaceNumbers | None = group("how well a made surface meets its law", default=None)
    ball_made: MadeSurfaceNumbers | None = group(
        "how well a made surface of the ball meets its law", default=None
    )
    wavelength_octaves: tuple[WavelengthNumbers, ...] = group(
        "octaves of wavelength that sound", default=()
    )
    instrument: InstrumentNumbers | None = group(
        "what a measuring instrument did not see", default=None
    )


@dataclass(frozen=True, kw_only=True)
class EarNumbers:
    """Loudness and its relatives, with `sound.loudness`, of the record that is measured."""

    loudness_sone: float | None = number(
        "loudness of a steady sound",
        "sone",
        word="loudness",
        form=".3g",
        in_table=True,
        default=None,
    )
    sharpness_acum: float | None = number(
        "sharpness of a steady sound",
        "acum",
        word="sharpness",
        form=".3g",
        default=None,
    )
    loudness_n5_sone: float | None = number(
        "loudness that is exceeded for 5 % of a record that changes",
        "sone",
        word="loudness N5",
        form=".3g",
        explained=(
            "the loudness that is exceeded for 5 % of the record, by which listeners judge a sound "
            "that changes."
        ),
        default=None,
    )
    loudness_max_sone: float | None = number(
        "maximum loudness of a record that changes",
        "sone",
        word="loudness, maximum",
        form=".3g",
        default=None,
    )
    roughness_asper: float | None = number(
        "roughness of a record from 0.4 s on",
        "asper",
        word="roughness",
        form=".3g",
        default=None,
    )
    tone_to_noise_db: float | None = number(
        "largest tone-to-noise ratio of a tone, of a record from 1 s on",
        DB,
        word="tone-to-noise ratio",
        form=".3g",
        default=None,
    )
    tone_to_noise_hz: float | None = number(
        "frequency of the tone with the largest tone-to-noise ratio", "Hz", default=None
    )
    tone_to_noise_prominent: bool | None = number(
        "whether ECMA-418-1 calls the tone with the largest tone-to-noise ratio prominent",
        "",
        default=None,
    )
    prominence_ratio_db: float | None = number(
        "largest prominence ratio of a tone, of a record from 1 s on",
        DB,
        word="prominence ratio",
        form=".3g",
        default=None,
    )
    prominence_ratio_hz: float | None = number(
        "frequency of the tone with the largest prominence ratio", "Hz", default=None
    )
    prominence_ratio_prominent: bool | None = number(
        "whether ECMA-418-1 calls the tone with the largest prominence ratio prominent",
        "",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class TurnNumbers:
    """Turns of a ball with a surface, and whether they are heard."""

    turns: float = number("turns that the ball rolls")
    frequency_hz: float | None = number("turns of the ball in a second", "Hz", default=None)
    modulation: float | None = number("modulation of an octave by the turns", default=None)
    prominence: float | None = number(
        "first five lines of a turn over the floor under them; noise has 1 to 3, a clear pit "
        "more than 10",
        default=None,
    )
    band_hz: tuple[float, ...] | None = number("octave that the turns modulate", "Hz", default=None)
    reason: str | None = number(
        "why the record cannot tell how a turn stands out, such as one of less than two turns",
        "",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class MotionNumbers:
    """Force, motion and linear chain of a run with `dynamics`."""

    force_rms_n: float = number(
        "rms fluctuation of the contact force", "N", word="force, rms", form=".3g", in_table=True
    )
    force_rms_ratio: float = number("rms fluctuation of the contact force over the load")
    force_max_ratio: float = number(
        "largest contact force over the load",
        word="maximum of F/W",
        form=".3f",
        in_table=True,
        explained=(
            "the largest force between sphere and plate over the load. The force fluctuates about "
            "the load; at 0 the sphere flies."
        ),
    )
    force_min_ratio: float = number(
        "least contact force over the load", word="minimum of F/W", form=".3f", in_table=True
    )
    largest_force_n: float = number("largest contact force", "N")
    impacts: int = number("returns to contact")
    impacts_yield: bool = number("whether the Hertz pressure of an impact exceeds the hardness", "")
    flight_share: float = number("share of time without contact")
    drop_mm: float | None = number("height of a fall", "mm", default=None)
    restitution: float | None = number(
        "speed after over speed before the first impact of a fall",
        word="restitution of the first impact",
        form=".3f",
        in_table=True,
        default=None,
    )
    force_law_loads: int | None = number("loads that make the force law", default=None)
    force_law_min_n: float | None = number("least load of the force law", "N", default=None)
    force_law_max_n: float | None = number("largest load of the force law", "N", default=None)
    force_law_error_n: float | None = number(
        "rms error of the force law between its loads", "N", default=None
    )
    force_law_error_db: float | None = number(
        "error of the level from the force law", DB, default=None
    )
    force_law_top_error: float | None = number(
        "error of the force law at its largest load", default=None
    )
    force_law_failure: str | None = number(
        "why loads of the force law are missing", "", default=None
    )
    force_outside_share: float = number(
        "share of time with a force beyond the loads of the force law"
    )
    comb_spread_db: float | None = number(
        "rms spread of LAeq over a comb of speeds near that of the scene; none where no "
        "narrow resonance matters",
        DB,
        default=None,
    )
    comb_mean_laeq_db: float | None = number(
        "level of the mean power over this comb", DB_A, default=None
    )
    baffle_db: float = number(
        "part of ± because a free plate is computed as in a baffle", DB, default=0.0
    )
    time_step_s: float = number("time step of the motion", "s")
    step_error_db: float | None = number(
        "error of LAeq from the time steps of the motion", DB, default=None
    )
    balance_error: float | None = number("error of the energy of the motion", default=None)
    settled: bool = number("whether the motion repeats from lap to lap", "")
    laps: float = number("laps that were moved")
    transient_s: float | None = number(
        "time in which the ringing of the start falls to a thousandth; 0 after a run-in",
        "s",
        default=None,
    )
    ball_mass_kg: float = number("mass of the ball", "kg")
    contact_stiffness_n_m: float = number("stiffness of the contact", "N/m")
    plate_mobility_s_kg: float = number("mobility of the plate", "s/kg")
    plate_modes: int | None = number("modes of a plate with edges up to 30 kHz", default=None)
    resonance_hz: float = number("resonance of the ball on its contact", "Hz", in_table=True)
    resonance_q: float | None = number(
        "quality of the resonance of the ball on its contact; none without damping", default=None
    )
    resonance_wavelength_m: float = number(
        "wavelength of roughness that excites this resonance", "m"
    )
    critical_hz: float | None = number("coincidence frequency of the plate", "Hz", default=None)
    bending_limit_hz: float | None = number(
        "frequency up to which the plate is thin", "Hz", default=None
    )
    plate_deflection_m: float = number("how far the plate sinks and rises", "m")
    contact_radius_over_thickness: float | None = number(
        "contact radius over the thickness", default=None
    )
    loss_factor: float | tuple[tuple[float, float], ...] | None = number(
        "loss factor of the plate, or pairs of frequency [Hz] and loss factor", default=None
    )


@dataclass(frozen=True, kw_only=True)
class EstimateNumbers:
    """The linear chain that estimates the vibration of a run without `dynamics`."""

    laeq_db: float | None = number(
        "LAeq of the vibration that the chain gives for the solved record", DB_A, default=None
    )
    force_ratio: float = number(
        "rms fluctuation of the force over the load; above 0.3 the estimate is too high"
    )
    bodies: str = number("ball and plate that the chain assumes", "")
    stiffness_n_m: float | None = number(
        "mean stiffness of the contact, with which the vibration plays", "N/m", default=None
    )


@dataclass(frozen=True, kw_only=True)
class ChannelNumbers:
    """Levels of a channel of `sound.channels`: a signal of plate, ball or contact."""

    name: str = number("name of the channel", "")
    of: str = number("plate, ball or contact", "")
    quantity: str = number("acceleration, velocity, displacement, force or blocked_force", "")
    unit: str = number("unit of the samples", "")
    reference: str = number("reference of the levels (ISO 1683)", "")
    positive: str = number("which sense is positive", "")
    place_mm: tuple[float, ...] | None = number(
        "place on the plate, from the contact or the corner", "mm", default=None
    )
    level_db: float | None = number("level without weighting", DB, default=None)
    rms: float = number("rms of the samples, in their unit")
    peak: float = number("largest magnitude of the samples, in their unit")
    third_octaves: BandQuantity | None = group(
        "levels of the third octaves, without weighting", default=None
    )
    octaves: BandQuantity | None = group("levels of the octaves, without weighting", default=None)
    note: str = number("what a reader of the levels must know", "")


@dataclass(frozen=True, kw_only=True)
class PassNumbers:
    """Numbers of one pass over a plate that keeps its plastic overlap."""

    vibration_laeq_db: float | None = number(
        "LAeq of the vibration of the pass, estimated",
        DB_A,
        word="LAeq of the vibration, estimated",
        default=None,
    )
    laeq_db: float | None = number(
        "LAeq of the released power of the pass",
        DB_A,
        word="LAeq of the released power (q = 1, upper bound)",
        default=None,
    )
    level_db: float | None = number("LZeq of the released power of the pass", DB, default=None)
    release_power_mean_w: float = number(
        "mean released power of the pass",
        "W",
        word="mean released power",
        shown_unit="µW",
        factor=1e6,
    )
    plastic_work_j: float = number("plastic work of the pass", "J")
    depth_um: float = number(
        "maximum depth of the track so far", "um", word="maximum depth", shown_unit="µm"
    )


@dataclass(frozen=True, kw_only=True)
class ListeningNumbers:
    """Numbers of a long record (`sound.listen_s`), or the reason why there is none."""

    refused: str | None = number("why there is no long record", "", default=None)
    seconds: float | None = number("length of the long record", "s", default=None)
    laeq_db: float | None = number("LAeq of the long record", DB_A, default=None)
    level_db: float | None = number("LZeq of the long record", DB, default=None)
    solved_mm: float | None = number("length of track that was solved", "mm", default=None)
    rolled_mm: float | None = number("length of track that is rolled", "mm", default=None)
    solved_share: float | None = number(
        "share of the record, in time, that was solved", default=None
    )
    kurtosis: float | None = number("kurtosis of the sound pressure", default=None)
    stretches: int | None = number("rare stretches that are inserted as solved", default=None)
    turn_mm: float | None = number("length of a turn of a ball with a surface", "mm", default=None)
    highest_frequency_hz: float | None = number(
        "highest frequency that the steps resolve", "Hz", default=None
    )
    lowest_frequency_hz: float | None = number(
        "frequency of the longest solved wave", "Hz", default=None
    )
    impacts: int | None = number("returns to contact", default=None)
    flight_share: float | None = number("share of time without contact", default=None)
    force_outside_share: float | None = number(
        "share of time with a force beyond the loads of the force law", default=None
    )
    limited_share: float | None = number(
        "share of the continued values that are cut at a limit", default=None
    )
    seed: int | None = number("seed of the random continuation", default=None)
    ends: bool | None = number(
        "whether it is of something that ends, such as a fall; its level is then that of the run",
        "",
        default=None,
    )
    lae_db: float | None = number("LAE of what ends (re 1 s)", DB_A, default=None)
    laf_max_db: float | None = number("LAFmax of what ends", DB_A, default=None)
    las_max_db: float | None = number("LASmax of what ends", DB_A, default=None)
    lz_peak_db: float | None = number("LZpeak of what ends", DB, default=None)
    limits: tuple[str, ...] | None = number("limits that were met, in words", "", default=None)

    def __post_init__(self) -> None:
        """Refuse a record of something that ends, whose level leads, without its length.

        Raises
        ------
        ValueError : its length or the share that is solved is missing.
        """
        if self.ends and (self.seconds is None or self.solved_share is None):
            raise ValueError("a record of what ends has its seconds and solved_share")


@dataclass(frozen=True, kw_only=True)
class HeardNumbers:
    """The sound that plays, which `listen.wav` has."""

    source: Source = number("what plays: vibration or release", "")
    level_db: float | None = number("level of the samples that play", DB_A, default=None)
    gain_db: float = number("gain that brings the record to the level that is stated", DB)
    departure_db: float = number("level that is stated over that of the record as made", DB)
    long_s: float | None = number(
        "length of a long record that plays, with `sound.listen_s`", "s", default=None
    )


@dataclass(frozen=True, kw_only=True)
class RunNumbers:
    """All numbers of a run of a ball, and the doubts about them.

    Attributes
    ----------
    name : str
        Name of the scene.
    sentence : str
        What rolls on what.
    vibration, released_power : Quantity
        The two numbers of a run.
    record, levels, bands, errors, energy, contact, effort, surface : data class
        Numbers by subject, which every run has.
    ears, turns, motion, estimate, listening, heard : data class or None
        Numbers of a subject that a run may not have.
    contact_loss_db : float, dB
        Change of the vibration by a loss factor of the contact where the scene states none.
    channels, passes : tuple of data classes, or None
        Numbers of each channel and of each pass over a plate that remembers.
    doubts : tuple of Doubt
        All that limits the numbers.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> numbers = rolling.simulate(scene, workers=1, progress=False).numbers
    >>> numbers.record.steps, numbers.contact.max_pressure_pa
    (250, 2100000000.0)
    """

    name: str = ""
    vibration: Quantity = group("what a listener would hear", word="vibration")
    released_power: Quantity = group(
        "what one would hear if all released energy were sound", word="released power"
    )
    sentence: str = number("what rolls on what", "", default="")
    record: RunRecord = group("what was solved, and the record of the sound files")
    levels: LevelNumbers = group("levels of both sources")
    bands: BandNumbers = group("third octaves")
    errors: ErrorNumbers = group("errors of the level of the record that is measured")
    energy: EnergyNumbers = group("released power, and the energy ledger")
    contact: ContactNumbers = group("areas and pressures")
    effort: EffortNumbers = group("what the solver did, and how long it took")
    surface: SurfaceNumbers = group("roughness of the surface")
    ears: EarNumbers | None = group(
        "loudness and its relatives, with `sound.loudness`", default=None
    )
    turns: TurnNumbers | None = group("turns of a ball with a surface", default=None)
    motion: MotionNumbers | None = group("force and motion, with `dynamics`", default=None)
    estimate: EstimateNumbers | None = group(
        "linear chain of a run without `dynamics`", default=None
    )
    contact_loss_db: float = number(
        "change of the vibration by a loss factor of the contact of 0.02 where the scene states "
        "none; half of it is in ±",
        DB,
        default=0.0,
    )
    channels: tuple[ChannelNumbers, ...] | None = group("levels of each channel", default=None)
    passes: tuple[PassNumbers, ...] | None = group("numbers of each pass", default=None)
    listening: ListeningNumbers | None = group(
        "the long record of what is measured, with `sound.listen_s`", default=None
    )
    heard: HeardNumbers | None = group("the sound that plays", default=None)
    doubts: tuple[Doubt, ...] = group("what limits the numbers", default=())

    def __repr__(self) -> str:
        both = f"vibration {self.vibration}; released power {self.released_power}"
        return f"RunNumbers({self.name}: {both})"

    @property
    def of_record(self) -> SourceLevels:
        """Levels of the record that is measured, that of `record.source`."""
        levels = self.levels
        own = levels.vibration if self.record.source == "vibration" else levels.released_power
        return own or SourceLevels()

    @property
    def bands_of_record(self) -> BandQuantity | None:
        """Third octaves of the record that is measured, without weighting."""
        if self.record.source == "vibration":
            return self.bands.vibration
        return self.bands.released_power

    @property
    def bands_a_of_record(self) -> BandQuantity | None:
        """A-weighted third octaves of the record that is measured."""
        if self.record.source == "vibration":
            return self.bands.vibration_a
        return self.bands.released_power_a

    @property
    def quantity_of_record(self) -> Quantity:
        """The quantity of the record that is measured."""
        return self.vibration if self.record.source == "vibration" else self.released_power

    @property
    def leading(self) -> Quantity:
        """The vibration, or the released power of a run without one."""
        return self.released_power if self.vibration.value is None else self.vibration

    @property
    def source_of_bands(self) -> Source:
        """Source of the A-weighted third octaves that lead: the vibration, if it has them."""
        return "release" if self.bands.vibration_a is None else "vibration"

    @property
    def leading_bands_a(self) -> BandQuantity | None:
        """A-weighted third octaves of that source."""
        return self.bands.vibration_a or self.bands.released_power_a

    @property
    def heard_whole(self) -> ListeningNumbers | None:
        """The long record of what ends, whose level leads; None for a run that goes on."""
        long = self.listening
        return long if long is not None and long.ends else None

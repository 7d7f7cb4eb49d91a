"""Surfaces of raceways and of balls in a bearing.

A raceway has a law of waves around, roughness with its lay, and perhaps measured roundness. Waves
of a graded ball may go on beyond its form.
"""

import math
from dataclasses import replace
from functools import cached_property
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from acoustics.numbers import rounded
from rolling.scene import library
from rolling.scene.laws import Roughness
from rolling.scene.messages import mistake, plain_number
from rolling.scene.models import Section
from rolling.scene.surfaces import (
    BallHeightFile,
    BallSurface,
    GaussianBall,
    GradedBall,
    RoundSurface,
    SmoothBall,
)
from rolling.surface.ball_form import BallForm
from rolling.surface.stylus import cut_off, read_share
from rolling.surface.wave_law import WaveLaw

WaveCrests = Literal["across", "isotropic"]
RacewayFinish = Annotated[str, library.listed("finishes", "raceway")]
# Correlation length over the cut-off, with which a stylus still reads a third of Ra.
LONGEST_ACROSS = 0.35
_WAVE_SEED = 4  # part of the seed of a raceway, so that waves are not those of its roughness


class Roundness(Section):
    """Measured waves around a raceway, as an instrument for roundness writes them.

    Attributes
    ----------
    path : str
        File of text (.csv or .txt), relative to the scene file, with a line for each order: order,
        amplitude and phase [degrees], the heights being amplitude cos(order angle + phase)
    height_unit : str
        Unit of the amplitudes in the file

    Examples
    --------
    >>> import rolling
    >>> rolling.Roundness(path="ring.csv").height_unit
    'um'
    """

    SECTION: ClassVar[str] = "roundness"

    path: str = Field(min_length=1)
    height_unit: Literal["m", "mm", "um", "nm"] = "um"


class Raceway(RoundSurface):
    """Surface of a raceway: random waves around, and roughness with its lay along the track.

    Waves of order n have the root-mean-square amplitude A n^-s, from order 2 on, and go on into the
    roughness as far as a contact follows them. The roughness has its lay along the track: it varies
    fast across, where a stylus reads its Ra.

    Attributes
    ----------
    kind : "raceway"
        Surface of a raceway by the law of its waves and by its roughness
    finish : str, optional
        Finish by name. It gives the law of the waves, Ra and correlation lengths; values beside it
        win.
    wave_amplitude_um : float
        Root-mean-square amplitude A [um] that the law of the waves has at order 1
    wave_exponent : float
        Power s by which amplitudes fall with the order [-]
    wave_crests : str
        Whether crests of the random waves lie `across` the track, as on a ring that turned about
        its axis when it was made, or the waves are `isotropic`: as long across the track as along,
        so that a contact averages short ones more.
    roughness_ra_um : float
        Ra [um] that a stylus reads across the lay, with the cut-off
    cut_off_um : float, optional
        Cut-off wavelength [um] of the stylus, beyond which waves count as waviness. Default: by Ra,
        as ISO 4288 has it.
    correlation_length_across_um : float
        Correlation length [um] of the roughness across the track
    correlation_length_um : float
        Correlation length [um] of the roughness along the track, the length of its grooves
    seed : int
        Seed of waves and heights
    roundness : Roundness, optional
        Measured waves, which take the place of the law up to their highest order

    Examples
    --------
    >>> import rolling
    >>> raceway = rolling.Raceway(finish="superfinished", seed=1)
    >>> raceway.roughness_ra_um, raceway.wave_exponent
    (0.02, 1.0)
    """

    SECTION: ClassVar[str] = "raceway"
    NAMED: ClassVar[str] = "raceway"

    kind: Literal["raceway"] = "raceway"
    finish: RacewayFinish | None = None
    wave_amplitude_um: float = Field(gt=0, le=1000)
    wave_exponent: float = Field(ge=0.5, le=4)
    wave_crests: WaveCrests = "across"
    roughness_ra_um: float = Field(gt=0, le=10)
    cut_off_um: float | None = Field(default=None, ge=25, le=10_000)
    correlation_length_across_um: float = Field(gt=0)
    correlation_length_um: float = Field(gt=0)
    seed: int = Field(default=1, ge=0)
    roundness: Roundness | None = None

    @model_validator(mode="after")
    def _is_read_by_a_stylus(self) -> Self:
        """Refuse roughness that is so long across the track that its stylus filters it out."""
        most_um = self.longest_across_um
        if self.correlation_length_across_um > most_um:
            raise mistake(
                f"got {plain_number(self.correlation_length_across_um)}, allowed: up to"
                f" {rounded(most_um, 3)} with a cut-off of {1e6 * self.cut_off_m:g} um, which"
                " filters longer waves out of Ra",
                at=".correlation_length_across_um",
                needs=[".cut_off_um"],
            )
        return self

    @property
    def longest_across_um(self) -> float:
        """Longest correlation length across [um] of which the stylus reads Ra."""
        return LONGEST_ACROSS * 1e6 * self.cut_off_m

    @property
    def cut_off_m(self) -> float:
        """Cut-off wavelength [m] of the stylus."""
        if self.cut_off_um is not None:
            return 1e-6 * self.cut_off_um
        return cut_off(1e-6 * self.roughness_ra_um)

    @cached_property
    def law(self) -> Roughness:
        """Law of the random heights, of which the stylus reads Ra after its filters."""
        share = read_share(1e-6 * self.correlation_length_across_um, self.cut_off_m)
        return Roughness(
            roughness_ra_um=self.roughness_ra_um / math.sqrt(share),
            correlation_length_um=self.correlation_length_um,
            correlation_length_across_um=self.correlation_length_across_um,
            seed=self.seed,
        )

    @property
    def waves(self) -> WaveLaw:
        """Law of the random waves around."""
        return WaveLaw(
            amplitude_m=1e-6 * self.wave_amplitude_um,
            exponent=self.wave_exponent,
            seed=(self.seed, _WAVE_SEED),
        )

    @property
    def form(self) -> BallForm:
        """Waves around the circumference in SI, without measured ones."""
        return BallForm(waves_m=self._waves_m, law=self.waves)

    @property
    def words(self) -> str:
        """Description of waves and roughness."""
        finish = f"{self.finish}, " if self.finish else ""
        law = f"waves of order n of {self.wave_amplitude_um:g} µm n^-{self.wave_exponent:g}"
        if self.roundness is not None:
            law = f"roundness of {self.roundness.path}, beyond it {law}"
        return (
            f"{finish}{law}; Ra {self.roughness_ra_um:g} µm across the lay with a cut-off of"
            f" {1e6 * self.cut_off_m:g} µm, seed {self.seed}"
        )


class BearingBall(GradedBall):
    """Surface of the balls of a bearing at the limits of a grade of ISO 3290-1.

    Attributes
    ----------
    wave_exponent : float, optional
        Power by which the amplitudes of the orders beyond 15 fall, as random waves that go on from
        those of the form. Default: there are none.
    wave_crests : str
        Whether the waves beyond order 15 are `isotropic`, as long across the track as along, or
        their crests lie `across` it. Balls are lapped and spin about changing axes, so their waves
        have no lay.

    Examples
    --------
    >>> import rolling
    >>> rolling.BearingBall(grade="G10", wave_exponent=1.0).wave_crests
    'isotropic'
    """

    SECTION: ClassVar[str] = "balls"

    wave_exponent: float | None = Field(default=None, ge=0.5, le=4)
    wave_crests: WaveCrests = "isotropic"

    @property
    def form(self) -> BallForm:
        """Waves around the circumference in SI, with those beyond the form."""
        return replace(super().form, exponent=self.wave_exponent)


BearingSurface = BallSurface | BearingBall | Raceway
BallsSurface = GaussianBall | SmoothBall | BallHeightFile | BearingBall
RacewaySurface = Raceway | GaussianBall | SmoothBall | BallHeightFile

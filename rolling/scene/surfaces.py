"""The kinds of surface of plate and sphere, each with its keys.

A sphere's surface has the spacing of the plate's, its width, and the circumference as its period.
"""

import math
import re
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from acoustics.numbers import rounded
from rolling.contact.track import MAX_NODES, MIN_NODES
from rolling.scene import library
from rolling.scene.height_files import is_array, is_instrument, is_period, takes_units
from rolling.scene.laws import Roughness, SelfAffineLaw, SurfaceFault, SurfaceKind
from rolling.scene.messages import TABLES, is_number, mistake, plain_number, quoted
from rolling.scene.models import Section
from rolling.scene.text_heights import TRIPLES
from rolling.surface.ball_form import WAVE_NODES, BallForm
from rolling.surface.instrument import InstrumentLimits
from rolling.surface.lowered_waves import PER_DECADE, band_of, nominal


class MadeSurface(SurfaceKind):
    """Surface of a given width that the program generates.

    Attributes
    ----------
    spacing_um : float
        Node spacing [um] along and across
    width_um : float
        Width across the track [um], a whole number of nodes, at least 8
    """

    SECTION: ClassVar[str] = "surface"

    spacing_um: float = Field(gt=0)
    width_um: float = Field(gt=0)

    @model_validator(mode="after")
    def _whole_width(self) -> Self:
        refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int:
        """Nodes across the track."""
        return round(self.width_um / self.spacing_um)


def refuse_width(width_um: float, spacing_um: float) -> None:
    """Raise a mistake for a width that is no whole number of nodes, too small or too large."""
    nodes = width_um / spacing_um
    if not nodes < MAX_NODES:
        raise mistake(
            f"got {plain_number(width_um)}, allowed: less than {rounded(MAX_NODES)} nodes",
            at="surface.width_um",
        )
    if round(nodes) < MIN_NODES or abs(nodes - round(nodes)) > 1e-6 * nodes:
        nearest = max(MIN_NODES, round(nodes)) * spacing_um
        raise mistake(
            f"got {plain_number(width_um)}, allowed: a whole number of nodes of {spacing_um:g} um,"
            f" at least {MIN_NODES}; nearest: {nearest:.10g}",
            at="surface.width_um",
        )


Finish = Annotated[str, library.listed("finishes")]

MOST_LOWERED_DB = 100.0  # of a wave
OFF_MIDDLE = 0.03  # of a wavelength from the middle of its third octave, relative


def _lowered(value: Any) -> Any:
    """Return by how much waves are lowered [dB], by the middle of their third octave [um]."""
    if not isinstance(value, dict) or not value:
        form = "decibels by wavelength in um, as in {100: 3, 80: 4.5}"
        raise mistake(f"got {quoted(value)}, allowed: {form}")
    lowered: dict[float, float] = {}
    bands = set[float]()
    for name, decibels in value.items():
        try:
            wavelength = float(name)
        except (TypeError, ValueError):
            wavelength = math.nan
        if not 0 < wavelength < math.inf:
            raise mistake(f"got the wavelength {quoted(name)}, allowed: a number > 0 in um")
        band = float(band_of(wavelength))
        middle = 10 ** (band / PER_DECADE)
        if abs(wavelength / middle - 1) > OFF_MIDDLE:
            raise mistake(
                f"got the wavelength {plain_number(wavelength)}, allowed: middles of third octaves;"
                f" nearest: {nominal(middle)}"
            )
        if band in bands:
            raise mistake(f"got two values for {plain_number(wavelength)}, allowed: one")
        if not (is_number(decibels) and 0 <= decibels <= MOST_LOWERED_DB):
            raise mistake(
                f"{plain_number(wavelength)}: got {quoted(decibels)}, allowed: 0 to"
                f" {MOST_LOWERED_DB:g} dB"
            )
        bands.add(band)
        lowered[wavelength] = float(decibels)
    return lowered


_DECIBELS = {"type": "number", "minimum": 0, "maximum": MOST_LOWERED_DB}
_DECIBELS_BY_WAVE = {"type": "object", "minProperties": 1, "additionalProperties": False} | {
    "patternProperties": {r"^[0-9.e+-]+$": _DECIBELS},
    "title": "decibels by wavelength",
}
Lowered = Annotated[
    dict[float, float], BeforeValidator(_lowered), WithJsonSchema(_DECIBELS_BY_WAVE)
]


class WavySurface(SurfaceKind):
    """Surface with waves along the track, which may be lowered.

    Attributes
    ----------
    lowered_db : dict, optional
        By how much waves along the track are lowered [dB], by the middle of their third octave of
        wavelength [um]. Their phases stay.
    """

    SECTION: ClassVar[str] = "surface"

    lowered_db: Lowered | None = None

    @property
    def lowered_by_m(self) -> dict[float, float]:
        """By how much waves are lowered [dB], by their wavelength [m]."""
        return {wavelength * 1e-6: db for wavelength, db in (self.lowered_db or {}).items()}


class Gaussian(Roughness, WavySurface, MadeSurface):
    """Random periodic surface with a given autocorrelation.

    Attributes
    ----------
    kind : "gaussian"
        A random surface by its autocorrelation
    finish : str, optional
        Finish by name. It gives Ra and correlation length; values beside it win.

    Examples
    --------
    >>> import rolling
    >>> rolling.Gaussian(finish="ground", spacing_um=2, width_um=512, seed=1).roughness_ra_um
    0.4
    """

    NAMED: ClassVar[str] = "surface"

    kind: Literal["gaussian"] = "gaussian"
    finish: Finish | None = None
    faults: list[SurfaceFault] | None = None


class SelfAffine(SelfAffineLaw, WavySurface, MadeSurface):
    """Random periodic surface with a self-affine spectrum.

    Attributes
    ----------
    kind : "self-affine"
        A random surface of a self-affine spectrum

    Examples
    --------
    >>> import rolling
    >>> made = {"spacing_um": 2, "width_um": 512, "seed": 1, "roughness_ra_um": 0.1}
    >>> rolling.SelfAffine(hurst=0.8, rolloff_um=100, shortest_um=10, **made).n_across
    256
    """

    kind: Literal["self-affine"] = "self-affine"
    faults: list[SurfaceFault] | None = None

    @model_validator(mode="after")
    def _holds_waves(self) -> Self:
        least = WAVE_NODES * self.spacing_um
        if self.shortest_um < least * (1 - 1e-9):
            words = f"at least {WAVE_NODES} spacings, {rounded(least, 6)}"
            raise self.not_allowed("shortest_um", words, self.shortest_um)
        if not self.shortest_um <= self.rolloff_um <= self.width_um:
            words = f"from shortest_um, {self.shortest_um:g}, to width_um, {self.width_um:g}"
            raise self.not_allowed("rolloff_um", words, self.rolloff_um)
        return self


class Smooth(MadeSurface):
    """Perfectly flat surface.

    Attributes
    ----------
    kind : "smooth"
        A perfectly flat surface

    Examples
    --------
    >>> import rolling
    >>> rolling.Smooth(spacing_um=2, width_um=512).n_across
    256
    """

    kind: Literal["smooth"] = "smooth"
    faults: list[SurfaceFault] | None = None


class Instrument(Section):
    """Instrument that measured the heights of a file: its limits at short waves.

    Attributes
    ----------
    tip_radius_um : float, optional
        Radius of the tip of a stylus [um]. Default: no stylus.
    sampling_um : float, optional
        Distance of independent points [um]: the sampling interval, or half of the lateral period
        limit (ISO 25178-600), the wave that optics transmit with half of its amplitude. Default:
        the spacing of the file.
    noise_nm : float, optional
        Rms noise of a height [nm]. Default: the noise that the spectrum shows.

    Examples
    --------
    >>> import rolling
    >>> scan = rolling.HeightFile(path="scan.sdf", instrument={"tip_radius_um": 2})
    >>> scan.instrument.tip_radius_um
    2.0
    """

    SECTION: ClassVar[str] = "surface.instrument"

    tip_radius_um: float | None = Field(default=None, ge=0.01, le=1000)
    sampling_um: float | None = Field(default=None, ge=0.001, le=10000)
    noise_nm: float | None = Field(default=None, ge=0.001, le=100000)

    @property
    def in_si(self) -> InstrumentLimits:
        """The limits in SI."""
        return InstrumentLimits(
            tip_radius_m=None if self.tip_radius_um is None else 1e-6 * self.tip_radius_um,
            sampling_m=None if self.sampling_um is None else 1e-6 * self.sampling_um,
            noise_m=None if self.noise_nm is None else 1e-9 * self.noise_nm,
        )

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.tip_radius_um is None and self.sampling_um is None and self.noise_nm is None:
            words = "at least one of tip_radius_um, sampling_um and noise_nm"
            raise mistake(f"got nothing, allowed: {words}", at=self.SECTION)
        return self


Form = Literal[
    "auto",
    "plane",
    "quadratic",
    "polynomial-3",
    "polynomial-4",
    "polynomial-5",
    "polynomial-6",
    "polynomial-7",
    "polynomial-8",
    "cylinder",
    "sphere",
    "none",
]


class HeightFile(WavySurface):
    """Surface read from a file: one period of it, or a measurement that is made periodic.

    Attributes
    ----------
    kind : "file"
        Heights from a file; the track is the file
    path : str
        File of heights, relative to the scene file: an array (.npy, .npz), a text (.csv, .txt,
        .xyz), or a format of a measuring instrument
    channel : str, optional
        Channel of a measuring instrument's file. Default: the first with heights.
    along : str, optional
        Axis of the file along the track. y (default): a row of the file lies across.
    height_unit : str, optional
        Unit of the heights of an array or a text. Default: the unit that a text names, else m.
    xy_unit : str, optional
        Unit of x and y in a text with places. Default: the unit that it names, else that of the
        heights.
    spacing_um : float, optional
        Node spacing [um]. A file with spacings of its own is resampled to it. Default: the file's
        finer spacing; an array, and a text that names none, need it.
    outliers : float, optional
        Limit beyond which a node counts as unmeasured. It is the difference from the median of the
        5 x 5 neighbours, in robust standard deviations of the heights about their plane.
    unmeasured : str, optional
        What happens to unmeasured points. refuse (default): the file is refused. fill: their
        surroundings fill them.
    s_filter_um : float, optional
        Nesting index [um] of the Gaussian S-filter, which removes shorter waves
    level : str
        Form that is removed by least squares (F-operation). plane. quadratic: a surface of second
        order. polynomial-3 to polynomial-8: one of that order. cylinder, sphere: of any radius and
        position. auto: the plane of a measurement, and that of a period where this lowers the step
        at the seam.
    l_filter_um : float, optional
        Nesting index [um] of the L-filter, which removes longer waves
    l_filter : str, optional
        Kind of the L-filter. gaussian (default): the linear one of ISO 16610-61. robust: that of
        ISO 16610-71, which pits and scratches do not pull down.
    periodic : str, optional
        How a measurement becomes one period. blend: the end of each side fades into its beginning.
        mirror: each side continues backwards. none: the file is a period. Default: none for
        .npy, .npz, .csv and .txt, otherwise blend.
    overlap_um : float, optional
        Length [um] of the blend, up to half a side. Default: a tenth of each side.
    width_um : float, optional
        Width [um] across the track that a profile of one line gets: a whole number of nodes, at
        least 8.
    instrument : Instrument, optional
        Instrument of the measurement. With it, the run states how uncertain its levels are because
        the instrument could not see short waves.

    Examples
    --------
    >>> import rolling
    >>> rolling.HeightFile(path="scan.sdf", unmeasured="fill", periodic="blend").level
    'auto'
    """

    SECTION: ClassVar[str] = "surface"

    kind: Literal["file"] = "file"
    path: str = Field(min_length=1)
    channel: str | None = None
    along: Literal["x", "y"] | None = None
    height_unit: Literal["m", "mm", "um", "nm"] | None = None
    xy_unit: Literal["m", "mm", "um", "nm"] | None = None
    spacing_um: float | None = Field(default=None, gt=0)
    outliers: float | None = Field(default=None, ge=3)
    unmeasured: Literal["refuse", "fill"] | None = None
    s_filter_um: float | None = Field(default=None, gt=0)
    level: Form = "auto"
    l_filter_um: float | None = Field(default=None, gt=0)
    l_filter: Literal["gaussian", "robust"] | None = None
    periodic: Literal["blend", "mirror", "none"] | None = None
    overlap_um: float | None = Field(default=None, gt=0)
    width_um: float | None = Field(default=None, gt=0)
    instrument: Instrument | None = None
    faults: list[SurfaceFault] | None = None

    @model_validator(mode="after")
    def _fits_format(self) -> Self:
        ending = Path(self.path).suffix.lower()
        if is_array(self.path) and self.spacing_um is None:
            raise mistake(
                "missing; files of arrays do not hold their spacing", at="surface.spacing_um"
            )
        if not is_instrument(self.path) and self.channel is not None:
            raise mistake(
                f"only goes with a file of an instrument, not {ending}", at="surface.channel"
            )
        has_own_units = is_instrument(self.path) and not takes_units(self.path)
        if has_own_units and self.height_unit not in (None, "m"):
            raise mistake(
                f"got {quoted(self.height_unit)}, but a {ending} file holds its own units",
                at="surface.height_unit",
            )
        if self.xy_unit is not None and not takes_units(self.path):
            raise mistake(
                f"only goes with a text such as .csv or {TRIPLES}, not"
                f" {ending or 'one without an ending'}",
                at="surface.xy_unit",
            )
        if self.outliers is not None and self.unmeasured != "fill":
            raise mistake(
                "only goes with surface.unmeasured fill, because outliers count as unmeasured",
                at="surface.outliers",
                needs=["surface.unmeasured"],
            )
        if self.overlap_um is not None and self.made_periodic != "blend":
            raise mistake(
                "only goes with surface.periodic blend",
                at="surface.overlap_um",
                needs=["surface.periodic"],
            )
        if self.s_filter_um and self.l_filter_um and self.s_filter_um >= self.l_filter_um:
            raise mistake(
                f"got {plain_number(self.s_filter_um)}, allowed: less than"
                f" {plain_number(self.l_filter_um)}, the L-filter",
                at="surface.s_filter_um",
            )
        if self.l_filter is not None and self.l_filter_um is None:
            raise mistake(
                "only goes with surface.l_filter_um, its nesting index",
                at="surface.l_filter",
                needs=["surface.l_filter_um"],
            )
        if self.width_um is not None and self.spacing_um is not None:
            refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def made_periodic(self) -> str:
        """Way in which the heights become periodic: blend, mirror or none."""
        if self.periodic is not None:
            return self.periodic
        return "none" if is_period(self.path) else "blend"


Surface = Annotated[Gaussian | Smooth | HeightFile | SelfAffine, Field(discriminator="kind")]


# ---- surfaces of a sphere


LARGEST_UM = 1e3  # [um] amplitude of an order


class Grade(NamedTuple):
    """Limits of a grade of balls [um]."""

    roughness_ra_um: float
    deviation_um: float  # from spherical form


GRADES = {name: Grade(*limits) for name, limits in TABLES["grades"].items()}  # of ISO 3290-1


def _grade(value: Any) -> Any:
    """Refuse a grade that is not in the table, with the nearest by its number."""
    if isinstance(value, str) and value in GRADES:
        return value
    words = f"got {quoted(value)}, allowed: {', '.join(GRADES)}"
    digits = re.sub(r"[^0-9]", "", str(value))[:9]
    if digits:
        closest = min(GRADES, key=lambda name: abs(int(name[1:]) - int(digits)))
        words += f"; nearest: {closest}"
    raise mistake(words)


def _orders(value: Any) -> Any:
    """Return the amplitudes of the waves of a circumference by their whole orders."""
    if not isinstance(value, dict) or not value:
        form = "amplitudes in um by order, as in {3: 0.05, 7: 0.02}"
        raise mistake(f"got {quoted(value)}, allowed: {form}")
    orders: dict[int, float] = {}
    for name, amplitude in value.items():
        text = str(name).strip()
        if not (text.isdecimal() and len(text) < 10 and int(text) >= 2):
            rule = "order 1 moves the centre of a sphere that stays round"
            words = "whole orders from 2 on, waves around the circumference"
            raise mistake(f"got the order {quoted(name)}, allowed: {words}; {rule}")
        if not (is_number(amplitude) and 0 < amplitude <= LARGEST_UM):
            words = f"an amplitude > 0 and <= {LARGEST_UM:g} um"
            raise mistake(f"order {text}: got {quoted(amplitude)}, allowed: {words}")
        orders[int(text)] = float(amplitude)
    return orders


_AMPLITUDE = {"type": "number", "exclusiveMinimum": 0}
_AMPLITUDES = {"type": "object", "minProperties": 1, "additionalProperties": False} | {
    "patternProperties": {r"^[0-9]+$": _AMPLITUDE},
    "title": "amplitude by order",
}
Waviness = Annotated[dict[int, float], BeforeValidator(_orders), WithJsonSchema(_AMPLITUDES)]
Grading = Annotated[
    str, BeforeValidator(_grade), WithJsonSchema({"type": "string", "enum": [*GRADES]})
]


class RoundSurface(SurfaceKind):
    """Surface of a sphere of any kind.

    Attributes
    ----------
    waviness : dict, optional
        Amplitudes [um] of waves around the circumference by their order
    """

    SECTION: ClassVar[str] = "sphere.surface"

    waviness: Waviness | None = None
    faults: list[SurfaceFault] | None = None

    @property
    def has_form(self) -> bool:
        """Whether the surface has waves around the circumference, of waviness or grade."""
        return self.form != BallForm()

    @property
    def form(self) -> BallForm:
        """Waves around the circumference in SI."""
        return BallForm(waves_m=self._waves_m)

    @property
    def _waves_m(self) -> tuple[tuple[int, float], ...]:
        """Order and amplitude [m] of the waves of the waviness."""
        waves = (self.waviness or {}).items()
        return tuple((order, amplitude_um * 1e-6) for order, amplitude_um in waves)


class GaussianBall(Roughness, RoundSurface):
    """Random surface of a sphere with a given autocorrelation.

    Attributes
    ----------
    kind : "gaussian"
        A random surface by its autocorrelation

    Examples
    --------
    >>> import rolling
    >>> rolling.GaussianBall(roughness_ra_um=0.05, correlation_length_um=20, seed=1).autocorrelation
    'gaussian'
    """

    kind: Literal["gaussian"] = "gaussian"


class SmoothBall(RoundSurface):
    """Smooth surface of a sphere, for waviness and faults alone.

    Attributes
    ----------
    kind : "smooth"
        Smooth but for waviness and faults

    Examples
    --------
    >>> import rolling
    >>> pit = rolling.SurfaceFault(kind="pit", at_mm=(10, 0), size_um=80, depth_um=3)
    >>> rolling.Sphere(radius_mm=5, surface=rolling.SmoothBall(faults=[pit])).surface.kind
    'smooth'
    """

    kind: Literal["smooth"] = "smooth"


class GradedBall(RoundSurface):
    """Surface of a sphere at the limits of a grade of ISO 3290-1.

    Roughness is random. The deviation from spherical form is the peak-to-valley height of waves of
    the orders 2 to 15, whose amplitudes fall with the order and whose phases are random.

    Attributes
    ----------
    kind : "graded"
        Roughness and form at the limits of a grade of ISO 3290-1
    grade : str
        Grade by name, with its limits of Ra and of the deviation from spherical form [um]: G3
        0.010/0.08, G5 0.014/0.13, G10 0.020/0.25, G16 0.025/0.4, G20 0.032/0.5, G24 0.040/0.6, G28
        0.050/0.7, G40 0.060/1, G60 0.080/1.5, G100 0.100/2.5, G200 0.150/5.
    correlation_length_um : float
        Correlation length of the roughness [um]. No grade states one.
    seed : int
        Seed of heights and phases

    Examples
    --------
    >>> import rolling
    >>> rolling.GradedBall(grade="G10", seed=7).law.roughness_ra_um
    0.02
    """

    kind: Literal["graded"] = "graded"
    grade: Grading
    correlation_length_um: float = Field(default=10.0, gt=0)
    seed: int = Field(default=1, ge=0)

    @cached_property
    def law(self) -> Roughness:
        """Law of the random heights."""
        return Roughness(
            roughness_ra_um=GRADES[self.grade].roughness_ra_um,
            correlation_length_um=self.correlation_length_um,
            seed=self.seed,
        )

    @property
    def form(self) -> BallForm:
        """Waves around the circumference in SI, of the grade and of the waviness."""
        return BallForm(
            deviation_m=GRADES[self.grade].deviation_um * 1e-6,
            seed=self.seed,
            waves_m=self._waves_m,
        )


class BallHeightFile(RoundSurface):
    """Surface of a sphere read from a file, which holds one turn of it.

    Attributes
    ----------
    kind : "file"
        Heights from a file of one turn; their mean and the wave of order 1 are removed
    path : str
        File of heights (.npy, .npz, .csv or .txt), relative to the scene file. Its axes are along
        the circumference and across. A single line is repeated across the width.
    height_unit : str
        Unit of the heights in the file
    spacing_um : float
        Node spacing [um], equal to that of the plate's surface

    Examples
    --------
    >>> import rolling
    >>> rolling.BallHeightFile(path="ball.npy", spacing_um=2).height_unit
    'm'
    """

    kind: Literal["file"] = "file"
    path: str = Field(min_length=1)
    height_unit: Literal["m", "mm", "um", "nm"] = "m"
    spacing_um: float = Field(gt=0)


BallSurface = GaussianBall | SmoothBall | BallHeightFile | GradedBall


def turn_nodes(radius_mm: float, spacing_um: float) -> int:
    """Return the nodes of a turn, the circumference in whole nodes."""
    return round(2e3 * math.pi * radius_mm / spacing_um)


def refuse_ball(surface: BallSurface, radius_mm: float, spacing_um: float) -> None:
    """Raise a mistake for a surface of a sphere that does not fit its circumference in nodes."""
    circumference = 2e3 * math.pi * radius_mm
    if not MIN_NODES <= circumference / spacing_um < MAX_NODES:
        raise mistake(
            f"got a circumference of {rounded(circumference, 4)} um, allowed: {MIN_NODES} to"
            f" {rounded(MAX_NODES)} nodes of {spacing_um:g} um around the sphere",
            at="sphere.surface",
        )
    highest = max(surface.waviness or {0: 0.0})
    most = turn_nodes(radius_mm, spacing_um) // WAVE_NODES
    if highest > most:
        raise mistake(
            f"got the order {highest}, allowed: up to {most}, waves of at least {WAVE_NODES} nodes",
            at="sphere.surface.waviness",
        )
    if isinstance(surface, BallHeightFile) and surface.spacing_um != spacing_um:
        raise mistake(
            f"got {plain_number(surface.spacing_um)}, allowed: {plain_number(spacing_um)}, the"
            " spacing of the plate's surface",
            at="sphere.surface.spacing_um",
        )

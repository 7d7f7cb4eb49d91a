"""Heights of a surface by law: spectrum, roughness and distribution; its single faults."""

import math
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from acoustics.numbers import rounded, rounded_down
from rolling.scene.messages import Key, mistake, plain_number
from rolling.scene.models import Section
from rolling.surface.height_law import (
    GAUSSIAN_MOMENTS,
    CorrelationLaw,
    SelfAffineSpectrum,
    self_affine_integrals,
)
from rolling.surface.single_faults import SingleFault

AUTOCORRELATIONS = {  # name: (decay, exponent) of exp(-decay * (r / L)^exponent)
    "gaussian": (1.0, 2),
    "gaussian_10pct": (2.3, 2),
    "exponential": (1.0, 1),
    "exponential_10pct": (2.3, 1),
}
Autocorrelation = Literal["gaussian", "gaussian_10pct", "exponential", "exponential_10pct"]
RA_OF_RQ = math.sqrt(2 / math.pi)  # of Gaussian heights


class Distribution(Section):
    """Distribution of random heights, and their seed.

    Attributes
    ----------
    skewness : float, optional
        Skewness of the heights, negative for a plateau with valleys. Default: 0.
    kurtosis : float, optional
        Kurtosis of the heights, above the square of the skewness plus 1. Default: 3.
    seed : int
        Seed of the random heights
    """

    skewness: float | None = Field(default=None, ge=-20, le=20)
    kurtosis: float | None = Field(default=None, ge=1, le=1000)
    seed: int = Field(ge=0)

    @model_validator(mode="after")
    def _has_distribution(self) -> Self:
        skewness, kurtosis = self.moments
        least = skewness**2 + 1
        if not kurtosis > least:
            raise self.not_allowed(
                "kurtosis",
                f"more than {rounded(least, 6)}, the square of the skewness plus 1, because no"
                f" heights have less; nearest: {math.ceil(101 * least) / 100:g}",
                kurtosis,
            )
        return self

    def not_allowed(self, key: str, allowed: str, value: float) -> Exception:
        """Make the mistake of a value of a key of this section."""
        return mistake(f"got {plain_number(value)}, allowed: {allowed}", at=f".{key}")

    @property
    def law(self) -> Self:
        """Law of the random heights."""
        return self

    @property
    def moments(self) -> tuple[float, float]:
        """Skewness and kurtosis of the heights."""
        return self.skewness or 0.0, self.kurtosis or 3.0

    @property
    def is_gaussian(self) -> bool:
        """Whether the heights have the skewness and kurtosis of Gaussian heights."""
        return self.moments == GAUSSIAN_MOMENTS

    @property
    def _moments_and_seed(self) -> str:
        """Moments other than those of Gaussian heights, and the seed, in words."""
        if self.is_gaussian:
            return f"seed {self.seed}"
        skewness, kurtosis = self.moments
        return f"skewness {skewness:g}, kurtosis {kurtosis:g}, seed {self.seed}"


class Roughness(Distribution):
    """Random heights by their autocorrelation.

    Attributes
    ----------
    autocorrelation : str
        Law of the autocorrelation over the distance r, with the correlation length L. gaussian:
        exp(-(r/L)^2). exponential: exp(-r/L). With _10pct the exponent is 2.3 times as large, so
        that the law has fallen to a tenth at L.
    roughness_ra_um : float
        Arithmetic mean roughness Ra [um]
    correlation_length_um : float
        Correlation length [um] along the track
    correlation_length_across_um : float, optional
        Correlation length [um] across the track. Default: as along.
    lay_deg : float, optional
        Angle [degrees] by which both correlation lengths are turned, from the track towards
        positive y. Default: 0.
    """

    autocorrelation: Autocorrelation = "gaussian"
    roughness_ra_um: float = Field(gt=0, le=1000)
    correlation_length_um: float = Field(gt=0)
    correlation_length_across_um: float | None = Field(default=None, gt=0)
    lay_deg: float | None = Field(default=None, ge=-180, le=180)

    @model_validator(mode="after")
    def _has_lay(self) -> Self:
        if self.lay_deg is not None and self.correlation_length_across_um is None:
            raise mistake(
                f"got {plain_number(self.lay_deg)}, allowed: none without"
                " correlation_length_across_um, because it turns two lengths",
                at=".lay_deg",
                needs=[".correlation_length_across_um"],
            )
        return self

    @property
    def in_si(self) -> CorrelationLaw:
        """The law in SI, of which heights are made."""
        first_um, second_um, angle = self._ellipse
        decay, exponent = AUTOCORRELATIONS[self.autocorrelation]
        return CorrelationLaw(
            lengths_m=(first_um * 1e-6, second_um * 1e-6),
            angle_rad=angle,
            decay=decay,
            exponent=exponent,
            ra_m=self.roughness_ra_um * 1e-6,
            moments=self.moments,
        )

    @property
    def _ellipse(self) -> tuple[float, float, float]:
        """Correlation lengths in two perpendicular directions [um], and the first's angle [rad].

        The angle of a lay along or across the track is 0.
        """
        first = self.correlation_length_um
        second = self.correlation_length_across_um or first
        angle = (self.lay_deg or 0.0) % 180
        if angle == 90:
            return second, first, 0.0
        return first, second, math.radians(angle)

    @property
    def lengths_um(self) -> tuple[float, float]:
        """Correlation lengths along and across the track [um]."""
        first, second, angle = self._ellipse
        if not angle:
            return first, second
        cosine = math.cos(angle)
        sine = math.sin(angle)
        along = 1 / math.hypot(cosine / first, sine / second)
        across = 1 / math.hypot(sine / first, cosine / second)
        return along, across

    @property
    def goes_on(self) -> bool:
        """Whether the law has waves of any length, however short."""
        return AUTOCORRELATIONS[self.autocorrelation][1] < 2

    @property
    def rq_m(self) -> float:
        """Root-mean-square height [m], from Ra as for Gaussian heights."""
        return self.in_si.rq_m

    def rms_slope(self, spacing_um: float) -> float:
        """Return the rms norm of the gradient over a spacing."""
        decay, exponent = AUTOCORRELATIONS[self.autocorrelation]
        # The mean square of a difference over one spacing is 2 (rq^2 - C(spacing)).
        ratios = [spacing_um / length for length in self.lengths_um]
        drops = [-math.expm1(-decay * ratio**exponent) for ratio in ratios]
        return self.rq_m * math.sqrt(2 * sum(drops)) / (spacing_um * 1e-6)

    @property
    def words(self) -> str:
        """Description of the heights."""
        length = f"{self.correlation_length_um:g} µm"
        if self.correlation_length_across_um:
            length += f" along, {self.correlation_length_across_um:g} µm across"
        if self.lay_deg:
            length += f", turned by {self.lay_deg:g}°"
        law = self.autocorrelation.replace("_", " ")
        return (
            f"random, Ra {self.roughness_ra_um:g} µm, correlation length {length} ({law}),"
            f" {self._moments_and_seed}"
        )


class SelfAffineLaw(Distribution):
    """Random heights of a self-affine spectrum.

    The spectrum is constant from the longest waves to the roll-off q_r, falls with the wave number
    q as q^(-2 (1 + H)) up to the shortest waves q_s, and ends there.

    Attributes
    ----------
    hurst : float
        Hurst exponent H [-]
    rolloff_um : float
        Wavelength of the roll-off [um], from shortest_um to width_um
    shortest_um : float
        Shortest wavelength [um], at least four spacings
    roughness_ra_um : float, optional
        Arithmetic mean roughness Ra [um]. Give exactly one of roughness_ra_um, rq_um and rdq.
    rq_um : float, optional
        Root-mean-square height Sq [um]
    rdq : float, optional
        Root-mean-square gradient Sdq of the waves
    """

    goes_on: ClassVar[bool] = False

    hurst: float = Field(ge=0, le=1)
    rolloff_um: float = Field(gt=0)
    shortest_um: float = Field(gt=0)
    roughness_ra_um: float | None = Field(default=None, gt=0, le=1000)
    rq_um: float | None = Field(default=None, gt=0, le=1000)
    rdq: float | None = Field(default=None, gt=0, le=100)

    @model_validator(mode="after")
    def _has_one_size(self) -> Self:
        sizes = {"roughness_ra_um": self.roughness_ra_um, "rq_um": self.rq_um, "rdq": self.rdq}
        given = [key for key, size in sizes.items() if size is not None]
        if len(given) != 1:
            got = f"got {' and '.join(given)}" if given else "missing"
            raise mistake(
                f"{got}, allowed: exactly one of {', '.join(sizes)}",
                at="surface.rq_um",
                needs=[f".{key}" for key in sizes],
            )
        return self

    @property
    def lengths_um(self) -> tuple[float, float]:
        """Approximate correlation lengths along and across the track [um]."""
        return self.rolloff_um / 4, self.rolloff_um / 4

    @property
    def in_si(self) -> SelfAffineSpectrum:
        """The law in SI, of which heights are made."""
        return SelfAffineSpectrum(
            hurst=self.hurst,
            rolloff_rad_m=self._rolloff_rad_m,
            end_ratio=self.rolloff_um / self.shortest_um,
            rq_m=self.rq_m,
            ra_m=None if self.roughness_ra_um is None else self.roughness_ra_um * 1e-6,
            rdq=self.rdq,
            moments=self.moments,
        )

    @property
    def _rolloff_rad_m(self) -> float:
        """Wave number q_r of the roll-off [rad/m]."""
        return 2e6 * math.pi / self.rolloff_um

    @property
    def gradient_m(self) -> float:
        """Sdq over Sq [1/m]."""
        heights, gradients = self_affine_integrals(self.hurst, self.rolloff_um / self.shortest_um)
        return self._rolloff_rad_m * math.sqrt(gradients / heights)

    @property
    def rq_m(self) -> float:
        """Root-mean-square height [m], from Ra as for Gaussian heights."""
        if self.rdq is not None:
            return self.rdq / self.gradient_m
        return 1e-6 * (self.rq_um or (self.roughness_ra_um or 0.0) / RA_OF_RQ)

    def rms_slope(self, spacing_um: float) -> float:
        """Return the rms norm of the gradient of the waves, the same over any spacing."""
        return self.rq_m * self.gradient_m

    @property
    def words(self) -> str:
        """Description of the heights."""
        if self.roughness_ra_um is not None:
            size = f"Ra {self.roughness_ra_um:g} µm"
        elif self.rq_um is not None:
            size = f"Sq {self.rq_um:g} µm"
        else:
            size = f"Sdq {self.rdq:g}"
        waves = f"{self.rolloff_um:g} to {self.shortest_um:g} µm with Hurst exponent {self.hurst:g}"
        return f"random, {size}, self-affine from {waves}, {self._moments_and_seed}"


HeightLaw = Roughness | SelfAffineLaw


# ---- single faults


MAX_FAULTS = 10_000  # of a count
# Maximum slope of a kind times its size over its depth.
_STEEPEST = {"pit": 4.0, "dent": 2.8, "step": math.pi / 2}
_RISING = ("bump", "dent", "step")  # kinds that rise above the surface by themselves


class SurfaceFault(Section):
    """Fault of a surface at a place, or several equal faults at random places.

    Attributes
    ----------
    kind : str
        Shape of the fault. pit: a paraboloid. dent: a hole with a raised rim, which holds the
        volume of the hole. bump: a rounded hill. scratch: a line. groove: a line across the whole
        surface. step: a rise over size_um.
    at_mm : list of float, optional
        Place (x, y) [mm]. x counts along the surface from its start, y from its middle line.
    count : int, optional
        Number of equal faults at random places, in place of at_mm
    seed : int, optional
        Seed of the random places
    size_um : float
        Diameter, or width of a scratch, groove or flank of a step [um]
    depth_um : float
        Depth, or height of a bump or step [um]
    length_um : float, optional
        Length of a scratch [um]
    angle_deg : float, optional
        Angle of a scratch to the track [degrees]. Default: 90.
    rim_height_um : float, optional
        Height of the ring of raised material around a pit [um]. Default: no rim, because no
        published height was found for eroded, drilled or spalled pits; that of a dent is always
        there.
    rim_width_um : float, optional
        Width of this ring [um], which begins at the edge of the pit

    Examples
    --------
    >>> import rolling
    >>> rolling.SurfaceFault(kind="pit", at_mm=(10, 0), size_um=80, depth_um=3).steepest
    0.15
    """

    SECTION: ClassVar[str] = "faults"

    kind: Literal["pit", "scratch", "dent", "bump", "step", "groove"]
    at_mm: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None
    count: int | None = Field(default=None, ge=1, le=MAX_FAULTS)
    seed: int | None = Field(default=None, ge=0)
    size_um: float = Field(gt=0)
    depth_um: float = Field(gt=0, le=1e4)
    length_um: float | None = Field(default=None, gt=0)
    angle_deg: float | None = Field(default=None, ge=-180, le=180)
    rim_height_um: float | None = Field(default=None, ge=0)
    rim_width_um: float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        has_place = self.at_mm is not None
        if (self.count is None) != has_place or (self.seed is None) != has_place:
            raise mistake("a fault needs either at_mm, or count and seed")
        if self.kind == "scratch" and self.length_um is None:
            raise mistake("length_um: missing; a scratch has a length")
        if self.kind != "scratch" and self.length_um is not None:
            raise mistake("length_um: only a scratch has a length")
        if self.kind != "scratch" and self.angle_deg is not None:
            raise mistake("angle_deg: only a scratch has an angle")
        return self

    @model_validator(mode="after")
    def _rim_of_a_pit(self) -> Self:
        """Refuse half a rim, one of another kind, and one that outgrows its pit."""
        given = {"rim_height_um": self.rim_height_um, "rim_width_um": self.rim_width_um}
        for key, value in given.items():
            if value is not None and self.kind != "pit":
                raise mistake("only a pit has a rim that is stated", at=f".{key}")
        if self.rim_height_um is None and self.rim_width_um is None:
            return self
        if self.rim_height_um is None:
            raise mistake("missing; a rim has a height", at=".rim_height_um")
        if self.rim_width_um is None:
            raise mistake("missing; a rim has a width", at=".rim_width_um")
        # A paraboloid holds pi R^2 d / 2, and a ring of raised cosines pi h w (R + w / 2).
        radius = self.size_um / 2
        ring = self.rim_width_um * (radius + self.rim_width_um / 2)
        highest = radius**2 * self.depth_um / 2 / ring
        if self.rim_height_um > highest:
            raise mistake(
                f"got {plain_number(self.rim_height_um)}, allowed: at most"
                f" {rounded_down(highest)}, with which the rim holds all that the pit has lost",
                at=".rim_height_um",
            )
        return self

    @property
    def in_si(self) -> SingleFault:
        """The fault in SI."""
        angle_deg = 90.0 if self.angle_deg is None else self.angle_deg
        return SingleFault(
            kind=self.kind,
            size_m=self.size_um * 1e-6,
            depth_m=self.depth_um * 1e-6,
            at_m=None if self.at_mm is None else (self.at_mm[0] * 1e-3, self.at_mm[1] * 1e-3),
            count=self.count or 0,
            seed=self.seed or 0,
            length_m=(self.length_um or 0.0) * 1e-6,
            angle_rad=math.radians(angle_deg),
            rim_height_m=(self.rim_height_um or 0.0) * 1e-6,
            rim_width_m=(self.rim_width_um or 0.0) * 1e-6 if self.rim_height_um else 0.0,
        )

    @property
    def crosses(self) -> bool:
        """Whether the fault crosses the whole surface."""
        return self.in_si.crosses

    @property
    def steepest(self) -> float:
        """Maximum slope [-]."""
        slope = _STEEPEST.get(self.kind, math.pi) * self.depth_um / self.size_um
        if self.rim_height_um is None or self.rim_width_um is None:
            return slope
        return max(slope, math.pi / 2 * self.rim_height_um / (self.rim_width_um / 2))

    @property
    def rises_um(self) -> float:
        """Height above the surface [um]; of a dent, at most."""
        return self.depth_um if self.kind in _RISING else self.rim_height_um or 0.0


class SurfaceKind(Section):
    """Surface of plate or sphere, of any kind.

    Attributes
    ----------
    faults : list of SurfaceFault, optional
        Single faults, added to the other heights of the surface
    """

    IN_FILES: ClassVar[str] = "kind"

    kind: str

    @property
    def law(self) -> HeightLaw | None:
        """Law of the random heights, None without random heights."""
        return None


def refuse_misplaced(
    faults: Sequence[SurfaceFault], length_um: float, width_um: float, spacing_um: float, at: Key
) -> None:
    """Raise a mistake for the first that lies beyond its surface, or that no node or surface holds.

    `at` is the key of the list.
    """
    for number, listed in enumerate(faults):
        if listed.size_um < spacing_um:
            raise mistake(
                f"got {plain_number(listed.size_um)}, allowed: at least a node of {spacing_um:g}"
                " um",
                at=(*at, number, "size_um"),
            )
        if listed.rim_width_um is not None and listed.rim_width_um < spacing_um:
            raise mistake(
                f"got {plain_number(listed.rim_width_um)}, allowed: at least a node of"
                f" {spacing_um:g} um",
                at=(*at, number, "rim_width_um"),
            )
        key = "size_um"
        size = listed.size_um
        if listed.length_um is not None and listed.length_um > size:
            key = "length_um"
            size = listed.length_um
        if listed.rim_width_um is not None:
            size += 2 * listed.rim_width_um
        longest = length_um if listed.crosses else min(length_um, width_um)
        if size > longest:
            raise mistake(
                f"got {plain_number(size)}, allowed: at most {rounded(longest, 6)}, the size of the"
                " surface in um",
                at=(*at, number, key),
            )
        x, y = listed.at_mm or (0.0, 0.0)
        if not 0 <= x * 1e3 < length_um or abs(y) * 2e3 > width_um:
            raise mistake(
                f"got [{plain_number(x)}, {plain_number(y)}], which is beyond the surface, allowed:"
                f" x from 0 to {rounded(length_um * 1e-3, 6)} mm, y within"
                f" {rounded(width_um * 5e-4, 6)} mm of the middle line",
                at=(*at, number, "at_mm"),
            )

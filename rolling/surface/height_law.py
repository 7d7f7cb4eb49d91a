"""Laws of random heights as numbers in SI: their spectrum, their size and their distribution."""

import math
from dataclasses import dataclass

GAUSSIAN_MOMENTS = (0.0, 3.0)  # skewness and kurtosis


@dataclass(frozen=True, kw_only=True)
class CorrelationLaw:
    """Random heights by their autocorrelation exp(-decay r^exponent).

    The lag r counts in correlation lengths, of which there are two in perpendicular directions.

    Attributes
    ----------
    lengths_m : (2,) tuple of float, m
        Correlation lengths.
    angle_rad : float, rad
        Direction of the first length, from the track towards positive y.
    decay : float
        Factor of the exponent.
    exponent : int
        2 of a Gaussian autocorrelation, 1 of an exponential one.
    ra_m : float, m
        Arithmetic mean roughness Ra, which made heights have exactly.
    moments : (2,) tuple of float
        Skewness and kurtosis of the heights.
    """

    lengths_m: tuple[float, float]
    angle_rad: float = 0.0
    decay: float = 1.0
    exponent: int = 2
    ra_m: float
    moments: tuple[float, float] = GAUSSIAN_MOMENTS

    @property
    def rq_m(self) -> float:
        """Root-mean-square height [m], from Ra as for Gaussian heights."""
        return self.ra_m * math.sqrt(math.pi / 2)

    @property
    def is_gaussian(self) -> bool:
        """Whether the heights have the skewness and kurtosis of Gaussian heights."""
        return self.moments == GAUSSIAN_MOMENTS


@dataclass(frozen=True, kw_only=True)
class SelfAffineSpectrum:
    """Random heights of a self-affine spectrum.

    The spectrum is constant up to the roll-off q_r, falls with the wave number q as
    q^(-2 (1 + H)) up to the shortest waves, and ends there.

    Attributes
    ----------
    hurst : float
        Hurst exponent H.
    rolloff_rad_m : float, rad/m
        Wave number q_r of the roll-off.
    end_ratio : float
        Wave number of the shortest waves over that of the roll-off.
    rq_m : float, m
        Root-mean-square height Sq, which made heights have exactly unless another size is given.
    ra_m : float or None, m
        Arithmetic mean roughness Ra that made heights have exactly.
    rdq : float or None
        Root-mean-square gradient Sdq that made heights have exactly.
    moments : (2,) tuple of float
        Skewness and kurtosis of the heights.
    """

    hurst: float
    rolloff_rad_m: float
    end_ratio: float
    rq_m: float
    ra_m: float | None = None
    rdq: float | None = None
    moments: tuple[float, float] = GAUSSIAN_MOMENTS

    @property
    def is_gaussian(self) -> bool:
        """Whether the heights have the skewness and kurtosis of Gaussian heights."""
        return self.moments == GAUSSIAN_MOMENTS


HeightSpectrum = CorrelationLaw | SelfAffineSpectrum


def self_affine_integrals(hurst: float, end_ratio: float) -> tuple[float, float]:
    """Return Sq^2 over C0 q_r^2/(2 pi), and Sdq^2 over C0 q_r^4/(2 pi), of a plateau C0."""
    logarithm = math.log(end_ratio)
    heights = 0.5 + _power_integral(-2 * hurst, logarithm)
    return heights, 0.25 + _power_integral(2 - 2 * hurst, logarithm)


def _power_integral(power: float, logarithm: float) -> float:
    """Return the integral of x^(power - 1) from 1 to exp(logarithm)."""
    return math.expm1(power * logarithm) / power if power else logarithm

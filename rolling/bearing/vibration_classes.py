"""Classes of vibration of deep-groove ball bearings, V0 to V4, by the limits of makers.

The limits stand in the catalogues of two manufacturers (KYK and EMS), which agree, for bores up to
35 mm. They are upper limits of the radial velocity in the three bands of ISO 15242, under its speed
and load. No source was found for larger bores.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from acoustics.ring_velocity import VELOCITY_BANDS_HZ

SOURCE = "the catalogues of two makers, KYK and EMS"
ABOVE = "above V0"


class BoreLimits(NamedTuple):
    """Limits for a range of bores.

    least_mm, most_mm : float, mm. First and last bore of the range.
    um_s : dict, um/s. Largest rms velocity in the low, medium and high band by class, V0 first.
    """

    least_mm: float
    most_mm: float
    um_s: dict[str, tuple[float, float, float]]


LIMITS = (
    BoreLimits(
        least_mm=7,
        most_mm=9,
        um_s={
            "V0": (130, 96, 80),
            "V1": (92, 66, 54),
            "V2": (72, 48, 40),
            "V3": (44, 28, 24),
            "V4": (38, 12, 12),
        },
    ),
    BoreLimits(
        least_mm=10,
        most_mm=12,
        um_s={
            "V0": (160, 120, 100),
            "V1": (120, 80, 70),
            "V2": (90, 60, 50),
            "V3": (55, 35, 30),
            "V4": (45, 14, 15),
        },
    ),
    BoreLimits(
        least_mm=15,
        most_mm=17,
        um_s={
            "V0": (210, 150, 120),
            "V1": (150, 100, 85),
            "V2": (110, 78, 60),
            "V3": (65, 46, 35),
            "V4": (52, 18, 18),
        },
    ),
    BoreLimits(
        least_mm=20,
        most_mm=25,
        um_s={
            "V0": (260, 190, 150),
            "V1": (180, 125, 100),
            "V2": (130, 100, 75),
            "V3": (80, 60, 45),
            "V4": (60, 25, 25),
        },
    ),
    BoreLimits(
        least_mm=30,
        most_mm=35,
        um_s={
            "V0": (300, 240, 190),
            "V1": (200, 150, 130),
            "V2": (150, 120, 100),
            "V3": (90, 75, 60),
            "V4": (70, 35, 40),
        },
    ),
)
_ORDER = [ABOVE, *LIMITS[0].um_s]  # from the worst class to the best


class Velocity(NamedTuple):
    """A velocity with its standard uncertainty.

    um_s : float, um/s.
    uncertainty_db : float, dB.
    """

    um_s: float
    uncertainty_db: float


class ClassRange(NamedTuple):
    """The classes that the ± of a velocity leaves: the worst and the best one."""

    worst: str
    best: str

    @property
    def words(self) -> str:
        """One class, two neighbours, or a range of classes."""
        if self.worst == self.best:
            return self.worst
        are_neighbours = _ORDER.index(self.best) - _ORDER.index(self.worst) == 1
        return f"{self.worst} {'or' if are_neighbours else 'to'} {self.best}"


def limits_of_bore(bore_mm: float) -> BoreLimits | None:
    """Return the limits for a bore; None where no source has any."""
    for limits in LIMITS:
        if limits.least_mm <= bore_mm <= limits.most_mm:
            return limits
    return None


def class_of_band(limits: BoreLimits, band: str, velocity: Velocity) -> ClassRange:
    """Return the classes of a band that the ± of its velocity leaves."""
    place = list(VELOCITY_BANDS_HZ).index(band)
    factor = 10 ** (velocity.uncertainty_db / 20)
    of_class = {name: um_s[place] for name, um_s in limits.um_s.items()}
    return ClassRange(
        worst=_class_under(of_class, velocity.um_s * factor),
        best=_class_under(of_class, velocity.um_s / factor),
    )


def class_of_bands(bands: Mapping[str, ClassRange]) -> ClassRange:
    """Return the class of a bearing, which is that of its worst band."""
    return ClassRange(
        worst=min((own.worst for own in bands.values()), key=_ORDER.index),
        best=min((own.best for own in bands.values()), key=_ORDER.index),
    )


def _class_under(limits_um_s: Mapping[str, float], um_s: float) -> str:
    """Return the best class whose limit is at least a velocity."""
    within = [name for name, limit in limits_um_s.items() if um_s <= limit]
    return within[-1] if within else ABOVE

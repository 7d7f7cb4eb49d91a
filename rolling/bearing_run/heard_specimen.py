"""What was heard of a specimen of a bearing, and how a choice keeps it."""

from __future__ import annotations

from dataclasses import dataclass

from rolling.bearing_run.band_difference import HOUSING


@dataclass(frozen=True, kw_only=True)
class HeardSpecimen:
    """Root mean squares of a specimen.

    low, medium, high : float, um/s. Radial velocity of the ring in each band.
    housing : float or None, Pa. A-weighted sound pressure of the housing plate, if there is one.
    """

    low: float
    medium: float
    high: float
    housing: float | None = None

    @property
    def by_band(self) -> dict[str, float]:
        """The root mean squares by the names of their bands, with that of a housing."""
        found = {"low": self.low, "medium": self.medium, "high": self.high}
        if self.housing is not None:
            found[HOUSING] = self.housing
        return found


@dataclass(frozen=True, kw_only=True)
class StoredSpecimens:
    """What choice.json has of the specimens that were heard.

    format, program : str. Format of the file, and the program that wrote it.
    identity : str. Digest of the bearings.
    labels : tuple of str. Their names.
    heard : tuple of tuple of HeardSpecimen. Specimens of each bearing.
    """

    format: str
    program: str
    identity: str
    labels: tuple[str, ...]
    heard: tuple[tuple[HeardSpecimen, ...], ...]

"""Linear response of a level to the waves of a surface, by third octave of wavelength."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import paired_mean
from rolling.choice.heard_specimen import Specimen

SURE_ERRORS = 2.0  # standard errors above 0 of a band and its neighbours, from which on it counts
LEAST_SHARE = 0.01  # of the largest response, below which one is not worth its decibels
LEAST_OF_WHOLE = 0.5  # of the response of all bands, that the sure ones have
NEIGHBOURS = 3  # bands by which one counts, itself among them
WIDE = 7  # bands whose mean is taken where single ones are not known


class Resolution(NamedTuple):
    """Response of a level to bands of waves, as finely as some specimens know it.

    response : (bands,) array, dB/dB. At least 0; 0 of bands that are not lowered.
    doubt : str. Sentence on what is not known; empty if each band is.
    """

    response: Array
    doubt: str


@dataclass(frozen=True, eq=False)
class PlateBands:
    """Waves of some specimens by band, and what each of them does to the level.

    Attributes
    ----------
    wavelength_m : (bands,) array, m
        Middles of the third octaves, long waves first.
    rms_m : (bands,) array, m
        Rms of profiles along the track in each band, over all specimens.
    responses : (specimens, bands) array, dB/dB
        Fall of the level of each specimen where all waves of a band are a decibel lower.
    correlation : (specimens, specimens) array or None
        Correlation of places of a scan; None, the default, where each specimen has a surface of its
        own.
    """

    wavelength_m: Array
    rms_m: Array
    responses: Array
    correlation: Array | None = None

    @property
    def response(self) -> Array:
        """Mean response over the specimens, (bands,) [dB/dB]."""
        return np.asarray(self.responses.mean(axis=0))

    @property
    def error(self) -> Array:
        """Standard error of the mean response, (bands,) [dB/dB].

        It is NaN for a single specimen, and for places of a scan that are as good as one.
        """
        return np.array([self._error_of(of_band) for of_band in self.responses.T])

    @property
    def is_known(self) -> bool:
        """Whether the response of all bands together is surely above 0.

        A single specimen has no error, so that its response counts as it is.
        """
        together = self.responses.sum(axis=1)
        return bool(together.mean() > SURE_ERRORS * np.nan_to_num(self._error_of(together)))

    def _error_of(self, values: Array) -> float:
        """Return the standard error of the mean of a value of each specimen; NaN if unknown."""
        return paired_mean(values, self.correlation, first_pairs=len(values)).error

    @property
    def resolutions(self) -> list[Resolution]:
        """The response as finely as it may be known, the finest first.

        A design begins with the first. Where marches do not confirm it, the next one follows.
        """
        finest = Resolution(self._of_sure_bands, "")
        smooth = Resolution(
            self._smooth,
            "These specimens do not tell the response of single third octaves, so"
            f" {WIDE} neighbours share their mean.",
        )
        alike = Resolution(
            np.where(self.rms_m > 0, self.response.sum() / np.count_nonzero(self.rms_m), 0.0),
            "These specimens do not tell which waves sound, so all waves are lowered alike.",
        )
        made = [smooth, alike] if smooth.response.any() else [alike]
        if finest.response.sum() >= LEAST_OF_WHOLE * self.response.sum():
            made.insert(0, finest)
        return made

    @property
    def _of_sure_bands(self) -> Array:
        """Response of the bands whose waves surely make sound, 0 for all others, (bands,).

        A band counts by the mean over itself and its neighbours, so that none is left out between
        two others by chance.
        """
        response = self.response
        together = _over_neighbours(response, NEIGHBOURS)
        error = np.sqrt(_over_neighbours(np.square(np.nan_to_num(self.error)), NEIGHBOURS))
        counts = together > SURE_ERRORS * error
        counts &= response >= LEAST_SHARE * response.max(initial=0.0)
        return np.where(counts, np.maximum(response, 0.0), 0.0)

    @property
    def _smooth(self) -> Array:
        """Response as a mean over many neighbours, (bands,); 0 where it is negative."""
        mean = _over_neighbours(self.response, WIDE) / WIDE
        return np.where(self.rms_m > 0, np.maximum(mean, 0.0), 0.0)


def _over_neighbours(values: Array, count: int) -> Array:
    """Return the sum of each value and its neighbours, of so many altogether."""
    before = count // 2
    return np.convolve(values, np.ones(count))[before : before + len(values)]


@dataclass(frozen=True)
class PlateWaves:
    """Waves of the plate of a scene, as far as they make its sound.

    has_other_sources : bool. Whether something sounds that no lower wave of the plate removes.
    bands : function. It returns the bands of solved specimens with their correlation.
    """

    has_other_sources: bool
    bands: Callable[[Sequence[Specimen], Array | None], PlateBands]

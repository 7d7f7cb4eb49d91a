"""Agreement of a run with a recording: within how many decibels, and at which frequencies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, NOMINAL_HZ
from acoustics.numbers import rounded_up
from rolling.recordings.read_vibration import figure_sentences
from rolling.recordings.recording_comparison import THIRD_OCTAVE, RecordingComparison

CLOSE_DB = 3.0  # within which third octaves agree well
FEWEST = 3  # neighbouring third octaves that are worth a sentence


class Agreement(NamedTuple):
    """Neighbouring third octaves in which run and recording differ by so many decibels at most.

    within_db : float, dB. Largest difference, without its sign.
    uncertainty_db : float, dB. Largest standard uncertainty of these differences.
    is_covered : bool. Whether no difference is larger than its own standard uncertainty.
    low_hz, high_hz : float, Hz. Nominal frequencies of the first and the last band.
    bands : int. Number of the bands.
    """

    within_db: float
    uncertainty_db: float
    low_hz: float
    high_hz: float
    bands: int
    is_covered: bool


class BandDifferences(NamedTuple):
    """Differences of third octaves, run less recording, and their ± [dB], (31,); NaN is unknown."""

    difference_db: Array
    uncertainty_db: Array

    @property
    def whole(self) -> Agreement:
        """The agreement over all bands that are compared."""
        (known,) = np.nonzero(np.isfinite(self.difference_db))
        return self._of(known)

    @property
    def close(self) -> Agreement | None:
        """The widest neighbouring bands within 3 dB; None where fewer than three are."""
        is_close = np.abs(np.nan_to_num(self.difference_db, nan=np.inf)) <= CLOSE_DB
        ends = np.flatnonzero(np.diff(np.concatenate(([False], is_close, [False]))))
        begins, lasts = ends[::2], ends[1::2]
        if not len(begins):
            return None
        widest = int(np.argmax(lasts - begins))
        bands = np.arange(begins[widest], lasts[widest])
        return self._of(bands) if len(bands) >= FEWEST else None

    def _of(self, bands: NDArray[np.intp]) -> Agreement:
        """Return the agreement in bands by their numbers."""
        return Agreement(
            within_db=float(np.abs(self.difference_db[bands]).max()),
            uncertainty_db=float(self.uncertainty_db[bands].max()),
            low_hz=float(NOMINAL_HZ[bands[0]]),
            high_hz=float(NOMINAL_HZ[bands[-1]]),
            bands=len(bands),
            is_covered=bool(
                np.all(np.abs(self.difference_db[bands]) <= self.uncertainty_db[bands])
            ),
        )


def band_differences(comparison: RecordingComparison, number: int) -> BandDifferences:
    """Return the differences of the third octaves of a pair of records, by its number."""
    rows = comparison.table[comparison.table["channel"] == comparison.pairs[number].name]
    bands = rows[rows["quantity"] == THIRD_OCTAVE].set_index("frequency_hz").reindex(NOMINAL_HZ)
    assert len(bands) == len(BAND_NAMES)  # each frequency names one band
    return BandDifferences(
        difference_db=bands["difference_db"].to_numpy(dtype=float),
        uncertainty_db=bands["difference_uncertainty_db"].to_numpy(dtype=float),
    )


def sentences(comparison: RecordingComparison) -> list[str]:
    """Say for each pair of records within how many decibels they agree, and where."""
    texts = []
    for number, pair in enumerate(comparison.pairs):
        differences = band_differences(comparison, number)
        whole = differences.whole
        text = f"within {_decibels(whole)} from {_range(whole)}"
        close = differences.close
        if close is not None and close.bands < whole.bands:
            text = f"within {_decibels(close)} from {_range(close)}, and {text}"
        texts.append(f"{pair.named('Run and recording')} agree {text}.")
        if len(comparison.figures):
            of_pair = comparison.figures[comparison.figures["channel"] == pair.name]
            texts += figure_sentences(of_pair)
    return texts


def _decibels(agreement: Agreement) -> str:
    """Write within which decibels bands agree: within their ± where it covers all differences."""
    spread = rounded_up(agreement.uncertainty_db)
    largest = f"{np.ceil(10 * agreement.within_db) / 10:.1f} dB"
    if agreement.is_covered:
        return f"the ± of each band, up to {spread} dB, and differ by up to {largest}"
    return f"{largest} (± of a band up to {spread} dB)"


def _range(agreement: Agreement) -> str:
    """Write the frequencies of the first and the last band."""
    return f"{agreement.low_hz:,.0f} to {agreement.high_hz:,.0f} Hz"

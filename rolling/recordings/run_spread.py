"""The ± of a run's levels in a comparison with a recording, from the quantities of the run.

A recording shares neither bodies nor surface nor grid with a run, so nothing of a run's uncertainty
cancels in the difference to a recording. What the compared levels cannot have is left out by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ
from rolling.numbers.quantity import BandQuantity, joined
from rolling.recordings.record_levels import Total
from rolling.recordings.recorded import PRESSURE, MeasuredQuantity
from rolling.results.run_result import Run

BAFFLE = "baffle"
BAND = "band"
RECORD = "record"
COMB = "comb"
OF_RECORD = (RECORD, COMB)  # of which the larger counts
NO_BANDS = np.zeros(len(BAND_NAMES))
BY_SHARE = ("contact_loss", BAFFLE)  # all third octaves change in the same sense
WHY_LEFT_OUT = {
    BAFFLE: "which motion and force do not feel",
    BAND: "because the third octaves beyond it are not compared",
}


@dataclass(frozen=True, eq=False)
class TotalSpread:
    """Uncertainty of the total level of the third octaves that are compared [dB].

    parts : dict. Its parts by source.
    left_out : tuple of str. Parts of the ± of the run that it does not have.
    """

    parts: dict[str, float]
    left_out: tuple[str, ...]

    @property
    def whole_db(self) -> float:
        """The uncertainty."""
        return joined(self.parts)

    @property
    def record_db(self) -> float:
        """What the length of the record leaves."""
        return math.hypot(*(self.parts.get(source, 0.0) for source in OF_RECORD))


@dataclass(frozen=True, eq=False)
class RunSpread:
    """What is uncertain of the levels of a run that are compared.

    level_parts : dict, dB. Parts of the ± of the level that the run states, by source.
    band_parts : dict of (31,) arrays, dB. Parts of the ± of its third octaves.
    known : (31,) array of bool. Third octaves whose ± the run states.
    powers : dict of (31,) arrays. Powers of its third octaves by weighting, 0 where one is unknown.
    band_end_hz : float or None, Hz. End of the simulated band; None where it is beyond hearing.
    excess : (31,) array. Variance of the third octaves of the record over that of Gaussian noise.
    is_sound : bool. Whether its sound is compared; if not, its motion or force.
    """

    level_parts: dict[str, float]
    band_parts: dict[str, Array]
    known: NDArray[np.bool_]
    powers: dict[str, Array]
    band_end_hz: float | None
    excess: Array
    is_sound: bool

    def of_stretch(self, share: float) -> RunSpread:
        """Return what is uncertain of a stretch, by its share of the record."""
        longer = 1 / math.sqrt(share)
        level_parts = dict(self.level_parts)
        band_parts = dict(self.band_parts)
        if RECORD in level_parts:
            level_parts[RECORD] *= longer
        if RECORD in band_parts:
            band_parts[RECORD] = longer * band_parts[RECORD]
        return replace(self, level_parts=level_parts, band_parts=band_parts)

    def of_bands(self, record_db: Array) -> BandSpread:
        """Return the uncertainty of third octaves.

        `record_db` (31,) is what the compared record leaves [dB]. It counts for motion and force,
        and for a third octave whose ± the run does not state.
        """
        parts = {source: part for source, part in self.band_parts.items() if source != RECORD}
        if not self.is_sound:
            parts.pop(BAFFLE, None)
        own_db = self.band_parts.get(RECORD, NO_BANDS)
        own_db = np.where(self.known & self.is_sound, own_db, record_db)
        comb_db = parts.pop(COMB, NO_BANDS)
        of_record = np.maximum(own_db, comb_db)
        squares = [np.square(part) for part in (of_record, *parts.values())]
        return BandSpread(whole_db=np.sqrt(np.sum(squares, axis=0)), record_db=of_record)

    def of_total(
        self, total: Total, compared: NDArray[np.bool_], powers: Array, record_db: float
    ) -> TotalSpread:
        """Return the uncertainty of a total level.

        The parts are those of the level of the run. Where the total has other third octaves or
        another weighting, parts that are known by band change as they do from the one to the other.

        Parameters
        ----------
        total : Total. The total.
        compared : (31,) array of bool. Its third octaves.
        powers : (31,) array. Their powers in a record of motion or force.
        record_db : float. What the compared record leaves [dB]; it counts for motion and force.
        """
        whole = self.powers["A"]
        own = self.powers[total.weighting] if self.is_sound else np.nan_to_num(powers)
        own = np.where(compared, own, 0.0)
        parts = dict(self.level_parts)
        for source in parts.keys() & self.band_parts.keys():
            if source in BY_SHARE:
                parts[source] *= _ratio(own, whole, self.band_parts[source], _by_share)
            elif source == RECORD:
                parts[source] *= _ratio(own, whole, self.band_parts[source], _by_chance)
        if not self.is_sound or not self.level_parts:
            # The lines next to a resonance are strong or weak by chance: comb and record overlap.
            is_larger = record_db > parts.get(COMB, 0.0)
            parts[RECORD] = record_db if is_larger else 0.0
            if is_larger:
                parts.pop(COMB, None)
        left_out = self._left_out(parts, compared)
        return TotalSpread(
            parts={source: part for source, part in parts.items() if source not in left_out},
            left_out=left_out,
        )

    def _left_out(self, parts: Mapping[str, float], compared: NDArray[np.bool_]) -> tuple[str, ...]:
        """Name the parts of the run's ± that a total of third octaves does not have."""
        left_out = []
        if not self.is_sound:
            left_out.append(BAFFLE)
        reaches_to_hz = EDGES_HZ[1:][compared].max(initial=0.0)
        if self.band_end_hz is not None and reaches_to_hz <= self.band_end_hz:
            left_out.append(BAND)
        return tuple(source for source in left_out if parts.get(source))


class BandSpread(NamedTuple):
    """Uncertainties of third octaves (31,) [dB]: the whole, and what the record alone leaves."""

    whole_db: Array
    record_db: Array


def _ratio(own: Array, whole: Array, part: Array, of_total: Callable[..., float]) -> float:
    """Return a part of a total over that of the whole level; 1 where the whole has none."""
    of_whole = of_total(whole, part)
    return of_total(own, part) / of_whole if of_whole > 0 else 1.0


def _by_share(powers: Array, part: Array) -> float:
    """Return a part of a total of third octaves that all change in the same sense."""
    return float(powers @ part) / float(powers.sum() or 1.0)


def _by_chance(powers: Array, part: Array) -> float:
    """Return a part of a total of third octaves, each of which changes by chance."""
    return float(np.linalg.norm(powers * part)) / float(powers.sum() or 1.0)


def run_spread(run: Run, measured: MeasuredQuantity) -> RunSpread:
    """Return what is uncertain of the levels of a run's records of a quantity.

    Motion and force have the parts of the vibration, because one linear chain carries all of them.
    """
    numbers = run.numbers
    is_sound = measured is PRESSURE
    quantity = numbers.quantity_of_record if is_sound else numbers.vibration
    bands = numbers.bands_of_record if is_sound else numbers.bands.vibration
    weighted = numbers.bands_a_of_record if is_sound else numbers.bands.vibration_a
    band_parts: dict[str, Array] = {}
    known = np.zeros(len(BAND_NAMES), dtype=bool)
    if bands is not None and bands.uncertainty is not None:
        # A run of version 0.8 does not know the parts of its third octaves.
        whole = tuple(spread or 0.0 for spread in bands.uncertainty)
        parts = bands.parts or {RECORD: whole}
        band_parts = {source: np.array(part) for source, part in parts.items()}
        known = np.array([spread is not None for spread in bands.uncertainty])
    excess = np.ones(len(BAND_NAMES))
    vibration = run.vibration_sound
    is_vibration = not is_sound or numbers.record.source == "vibration"
    if is_vibration and vibration is not None and vibration.excess is not None:
        excess = vibration.excess.third_octave
    return RunSpread(
        level_parts=dict(quantity.parts),
        band_parts=band_parts,
        known=known,
        powers={"Z": _powers(bands), "A": _powers(weighted or bands)},
        band_end_hz=numbers.errors.band_end_hz,
        excess=excess,
        is_sound=is_sound,
    )


def _powers(bands: BandQuantity | None) -> Array:
    """Return the powers of third octaves (31,), 0 where one is unknown."""
    if bands is None:
        return np.zeros(len(BAND_NAMES))
    return np.array([0.0 if level is None else 10 ** (level / 10) for level in bands.value])

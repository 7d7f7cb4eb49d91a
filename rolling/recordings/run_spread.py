"""What is uncertain of the levels of a run beside the length of its record.

A recording shares neither bodies nor surface nor grid with a run, so nothing of a run's uncertainty
cancels in the difference to a recording.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from rolling.recordings.recorded import PRESSURE, MeasuredQuantity
from rolling.results.instrument_spread import part_db, third_octave_parts_db
from rolling.results.run_result import Run
from rolling.sound.vibration_sound import joined_db

OF_RADIATION = "baffle"  # a part that sound has, and motion and force have not
BY_SHARE = ("contact_loss", OF_RADIATION)  # all bands change in the same sense
PART_WORDS = {
    "comb": "a resonance on or between the lines of the lap",
    "time_step": "time steps",
    "contact_loss": "the unknown loss of the contact",
    "baffle": "the baffle that a free plate does not have",
    "force_law": "force law",
    "grid": "grid",
    "solver": "solver",
    "subgrid": "detail below the spacing",
    "instrument": "instrument of the scan",
}


class RunSpread(NamedTuple):
    """Known parts of the uncertainty of a run's levels by their origin [dB], but for the record's.

    third_octaves : dict of (31,) arrays, dB. Of the third octaves; 0 where one is unknown.
    laeq : dict, dB. Of LAeq.
    excess : (31,) array. Variance of the third octaves of the record over that of Gaussian noise.
    """

    third_octaves: dict[str, Array]
    laeq: dict[str, float]
    excess: Array

    def of_bands(self, record_db: Array) -> Array:
        """Return the uncertainty of third octaves (31,) [dB], joined with that of their record."""
        return joined_db(record_db, self.third_octaves)

    def of_total(self, record_db: float, powers: Array) -> float:
        """Return the uncertainty [dB] of a total of third octaves, joined with that of its record.

        `powers` as in `parts_of_total`.
        """
        return float(joined_db(record_db, self.parts_of_total(powers)))

    def parts_of_total(self, powers: Array) -> dict[str, float]:
        """Return the parts of the uncertainty of a total of third octaves by their origin [dB].

        `powers` (31,) are those of the third octaves, NaN in bands that are left out of the total.
        Parts by which all bands change in the same sense are added by their share of the power.
        The others are those of LAeq.
        """
        shares = np.nan_to_num(powers) / np.nansum(powers)
        parts = dict(self.laeq)
        for name in BY_SHARE:
            if name in self.third_octaves:
                parts[name] = float(shares @ self.third_octaves[name])
        return parts


def run_spread(run: Run, quantity: MeasuredQuantity) -> RunSpread:
    """Return the parts of a run's uncertainty that hold for its records of a quantity.

    They are those that `rolling run` states beside the level, and the errors of grid, solver, force
    law and instrument where the run knows them. Motion and force have the same parts as the sound
    of the vibration, because one linear chain carries all of them.
    """
    is_sound = quantity is PRESSURE
    source = run.summary["source"] if is_sound else "vibration"
    third_octaves: dict[str, Array] = {}
    laeq: dict[str, float] = {}
    excess = np.ones(len(BAND_NAMES))
    if source == "vibration" and run.vibration_sound is not None:
        if run.vibration_sound.excess is not None:
            excess = run.vibration_sound.excess.third_octave
        third_octaves |= run.vibration_sound.band_spreads
        laeq |= run.vibration_sound.spreads
        # The law errs by a share of the fluctuation of the force, whatever its frequency.
        law_db = run.summary.get("force_law_error_db") or 0.0
        third_octaves["force_law"] = np.full(len(BAND_NAMES), law_db)
        laeq["force_law"] = law_db
    if source == run.summary["source"]:
        third_octaves |= _errors_of_bands(run.summary)
        laeq |= _errors_of_laeq(run.summary)
    third_octaves["instrument"] = _by_band(third_octave_parts_db(run.summary, source))
    laeq["instrument"] = part_db(run.summary, source) or 0.0
    laeq.pop("record", None)
    if not is_sound:
        third_octaves.pop(OF_RADIATION, None)
        laeq.pop(OF_RADIATION, None)
    return RunSpread(third_octaves=third_octaves, laeq=laeq, excess=excess)


# The errors that a summary holds, each with the keys of its addends. LAeq has `laeq_` before them.
_ERRORS = {
    "grid": ("grid_error_db", "grid_error_uncertainty_db"),
    "solver": ("solver_error_db",),
    "subgrid": ("subgrid_error_db", "subgrid_error_uncertainty_db"),
}


def _errors_of_laeq(summary: Mapping[str, Any]) -> dict[str, float]:
    """Return the errors of LAeq [dB] from grid and solver that a run knows."""
    parts = {}
    for origin, keys in _ERRORS.items():
        parts[origin] = math.hypot(*(summary.get(f"laeq_{key}") or 0.0 for key in keys))
    return parts


def _errors_of_bands(summary: Mapping[str, Any]) -> dict[str, Array]:
    """Return the errors of the third octaves (31,) [dB] from grid and solver that a run knows."""
    parts = {}
    for origin, keys in _ERRORS.items():
        addends = [_by_band(summary.get(key)) for key in keys]
        parts[origin] = np.asarray(np.sqrt(np.sum(np.square(addends), axis=0)))
    return parts


def _by_band(values: Mapping[str, float | None] | None) -> Array:
    """Return values of third octaves by name as an array, 0 where one is unknown."""
    known = values or {}
    return np.array([known.get(name) or 0.0 for name in BAND_NAMES])

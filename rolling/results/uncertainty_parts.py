"""Parts of the uncertainty of a run's levels and third octaves, by their source.

A part is found once, where its source is known, and put together here. All that states a ± of a
run takes it from these parts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from rolling.numbers.ball_numbers import (
    BandNumbers,
    InstrumentNumbers,
    InstrumentOfSource,
    MotionNumbers,
)
from rolling.numbers.quantity import BandQuantity
from rolling.results.run_errors import RunErrors, band_error_parts, error_parts
from rolling.results.solved_run import SolvedRun
from rolling.sound.missing_band import MissingBand

LevelParts = dict[str, float | None]
BandParts = dict[str, Array]
NO_PARTS: Mapping[str, float] = MappingProxyType({})


# ---- of the level


def parts_of_record(
    run: SolvedRun,
    motion: MotionNumbers | None,
    instrument: InstrumentNumbers | None,
    band: MissingBand | None,
    errors: RunErrors | None,
) -> LevelParts:
    """Return the uncertainties of the level of the record that is measured [dB] by their source."""
    of_band = {}
    if band is not None:
        of_band = {"band": float(np.hypot(band.error_db, band.uncertainty_db))}
    if run.sound.source == "vibration":
        parts = vibration_parts(run, motion, instrument, of_band)
    else:
        of_instrument = _instrument_part(None if instrument is None else instrument.released_power)
        parts = {"record": run.sound.uncertainty.laeq_db, **of_band, **of_instrument}
    return parts | error_parts(errors)


def vibration_parts(
    run: SolvedRun,
    motion: MotionNumbers | None,
    instrument: InstrumentNumbers | None,
    of_band: Mapping[str, float] = NO_PARTS,
) -> LevelParts:
    """Return the uncertainties of a computed vibration [dB], but for those of grid and solver.

    Grid, solver and the end of the band, `of_band`, are known for the record that is measured.
    """
    if run.vibration_sound is None:
        return {}
    parts: LevelParts = {**run.vibration_sound.parts}
    if motion is not None and motion.force_law_error_db is not None:
        parts["force_law"] = motion.force_law_error_db
    of_instrument = _instrument_part(None if instrument is None else instrument.vibration)
    return {**parts, **of_band, **of_instrument}


def _instrument_part(of_source: InstrumentOfSource | None) -> LevelParts:
    """Return the part of the instrument of a measurement; empty without one."""
    return {} if of_source is None else {"instrument": of_source.spread_db}


# ---- of the third octaves


def with_band_parts(
    bands: BandNumbers,
    run: SolvedRun,
    motion: MotionNumbers | None,
    instrument: InstrumentNumbers | None,
    errors: RunErrors | None,
) -> BandNumbers:
    """Return third octaves with the uncertainties of both sources, and their parts."""
    of_errors = band_error_parts(errors)
    plays = run.sound.source
    of_vibration = None
    if run.vibration_sound is not None and bands.vibration is not None:
        further: BandParts = {} if plays == "release" else dict(of_errors)
        if motion is not None and motion.force_law_error_db:
            # The law errs by a share of the fluctuation of the force, whatever its frequency.
            further["force_law"] = np.full(len(BAND_NAMES), motion.force_law_error_db)
        further |= _instrument_bands(None if instrument is None else instrument.vibration)
        of_vibration = _joined(bands.vibration, run.vibration_sound.band_parts, further)
    of_release = bands.released_power
    if plays == "release" and of_release is not None:
        further = of_errors | _instrument_bands(
            None if instrument is None else instrument.released_power
        )
        of_record = {"record": _by_band(of_release.uncertainty)}
        of_release = _joined(of_release, of_record, further)
    return replace(
        bands,
        vibration=of_vibration,
        vibration_a=_as_uncertain(bands.vibration_a, of_vibration),
        released_power=of_release,
        released_power_a=_as_uncertain(bands.released_power_a, of_release),
    )


def _joined(
    bands: BandQuantity, of_sound: Mapping[str, Array], further: Mapping[str, Array]
) -> BandQuantity:
    """Return third octaves whose uncertainties, those of their sound, have further parts.

    A source that touches no band is left out of the parts.
    """
    spreads = bands.uncertainty or (None,) * len(bands.value)
    joined = tuple(
        None if spread is None else math.hypot(spread, *(part[k] for part in further.values()))
        for k, spread in enumerate(spreads)
    )
    parts = {**of_sound, **further}
    return replace(
        bands,
        uncertainty=joined,
        parts={source: tuple(part.tolist()) for source, part in parts.items() if part.any()},
    )


def _as_uncertain(weighted: BandQuantity | None, bands: BandQuantity | None) -> BandQuantity | None:
    """Return A-weighted third octaves with the uncertainties of those without weighting."""
    if weighted is None or bands is None:
        return weighted
    return replace(weighted, uncertainty=bands.uncertainty)


def _instrument_bands(of_source: InstrumentOfSource | None) -> BandParts:
    """Return the part of the instrument of a measurement; empty without one."""
    if of_source is None or of_source.bands is None:
        return {}
    return {"instrument": _by_band(of_source.bands.value)}


def _by_band(values: tuple[float | None, ...] | None) -> Array:
    """Return values of third octaves as an array (31,), 0 where one is unknown."""
    if values is None:
        return np.zeros(len(BAND_NAMES))
    return np.array([value or 0.0 for value in values])

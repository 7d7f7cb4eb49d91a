"""What of a run is compared with a recording: its records, each with what is uncertain of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.recordings.read_vibration import VibrationMarks
from rolling.recordings.recorded import PRESSURE, MeasuredQuantity, Recording, fade_window, rms
from rolling.recordings.run_spread import RunSpread


class ComparedRecord(NamedTuple):
    """A record of a run that a recording may be compared with.

    record : Recording. Its samples in the SI unit, and their name.
    lap_s : float, s. Length of the solved track in the record.
    spread : RunSpread. What is uncertain of its levels.
    """

    record: Recording
    lap_s: float
    spread: RunSpread


class ComparedRun(NamedTuple):
    """The records of a run of a quantity.

    records : tuple of ComparedRecord. One of sound pressure; one for each channel otherwise.
    stated : str. What the levels of the run are of, with what `rolling run` states of them.
    warnings : tuple of str. What a comparison does not tell, as sentences.
    marks : VibrationMarks or None. What is read beside third octaves; None for nothing.
    """

    records: tuple[ComparedRecord, ...]
    stated: str = ""
    warnings: tuple[str, ...] = ()
    marks: VibrationMarks | None = None


def sound_alone(samples: Array, content: str, quantity: MeasuredQuantity) -> ComparedRun:
    """Return a run of which a record at 48 kHz is known, and nothing of its uncertainty."""
    record = faded_record("signal", samples, SAMPLE_RATE_HZ, SAMPLE_RATE_HZ / 2, quantity)
    return ComparedRun(
        records=(ComparedRecord(record, record.seconds, unknown_spread(quantity)),),
        stated=f"levels of the {content}, whose ± is not known",
    )


def unknown_spread(quantity: MeasuredQuantity) -> RunSpread:
    """Return the spread of a run that states no uncertainty, so that only its record counts."""
    nothing = np.zeros(len(BAND_NAMES))
    return RunSpread(
        level_parts={},
        band_parts={},
        known=np.zeros(len(BAND_NAMES), dtype=bool),
        powers={"Z": nothing, "A": nothing},
        band_end_hz=None,
        excess=np.ones(len(BAND_NAMES)),
        is_sound=quantity is PRESSURE,
    )


def faded_record(
    name: str, samples: Array, rate_hz: int, highest_hz: float, quantity: MeasuredQuantity
) -> Recording:
    """Return a record that does not close, faded at both ends, with the level that it has unfaded.

    Parameters
    ----------
    name : str
        Its name.
    samples : (n,) array, SI unit of the quantity
        Samples at 48 kHz.
    rate_hz : int, Hz
        Their rate.
    highest_hz : float, Hz
        Highest frequency that they resolve.
    quantity : MeasuredQuantity
        What they are.
    """
    window = fade_window(len(samples))
    faded = window * (samples - np.mean(samples)) / rms(window)
    return Recording(
        name=name,
        samples=np.asarray(faded, dtype=float),
        highest=highest_hz,
        seconds=len(samples) / rate_hz,
        quantity=quantity,
    )

"""What assumed losses of the contacts leave uncertain in the bands of a ring.

The loss factor decides how high a resonance of the ring stands: its power falls as one over the
loss factor. Well below a resonance the stiffness of the balls rules, well above it the mass of the
ring, and neither knows the loss factor. So a band moves as far as resonances make it. The linear
ring gives its velocity at another loss factor for the same forces, at each frequency. The viscosity
of a film of oil is as uncertain, and takes its place where there is one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.linear_ring import LinearRing, linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.oil_film import LARGEST_TIME_S, LEAST_TIME_S, TIME_S
from rolling.bearing.ring_record import AXIAL, AXIS, RADIAL, RingRecord

# Loss factors that lubricated bearings may have; all are as likely over their logarithm.
LEAST_LOSS_FACTOR = 0.02
LARGEST_LOSS_FACTOR = 0.1
_LOSS_FACTORS = 6  # between them, at which bands are computed
_SEGMENT_S = 2.0  # of a record, over which powers are averaged


def band_change_db(
    record: RingRecord,
    model: BearingModel,
    loss_factor: float | None = None,
    bands_hz: Mapping[str, tuple[float, float]] = VELOCITY_BANDS_HZ,
    film_time_s: float | None = None,
) -> dict[str, dict[str, float]]:
    """Return how far other losses would change each band [dB], by direction and band.

    Parameters
    ----------
    record : RingRecord
        Motion of the ring at the loss factor of the model.
    model : BearingModel
        Bearing.
    loss_factor : float, optional
        The other loss factor. Default: that of the model.
    bands_hz : dict, Hz
        Edges of the bands by their names. Default: the three bands of ISO 15242-1.
    film_time_s : float, s, optional
        The other viscosity of films over the stiffness. Default: that of the model.
    """
    ring = linear_ring(model)
    other = replace(
        ring,
        loss_factor=ring.loss_factor if loss_factor is None else loss_factor,
        film_time_s=ring.film_time_s if film_time_s is None else film_time_s,
    )
    count = record.velocity_m_s.shape[1]
    radial = record.radial_columns
    segment = min(len(record.velocity_m_s), round(_SEGMENT_S * record.rate_hz))
    frequency_hz = np.asarray(np.fft.rfftfreq(segment, 1 / record.rate_hz), dtype=float)
    highest_hz = VELOCITY_BANDS_HZ["high"][1]
    shown = np.flatnonzero((frequency_hz > 0) & (frequency_hz < highest_hz))
    transfer = _transfer(ring, other, frequency_hz[shown])
    before = np.zeros((len(shown), count))
    after = np.zeros((len(shown), count))
    window = np.hanning(segment)[:, None]
    for first in range(0, len(record.velocity_m_s) - segment + 1, segment):
        part = record.velocity_m_s[first : first + segment]
        lines = np.fft.rfft(window * part, axis=0)[shown]
        changed = (transfer @ lines[:, :, None])[:, :, 0]
        before += np.square(np.abs(lines))
        after += np.square(np.abs(changed))
    return {
        RADIAL: _changes(frequency_hz[shown], before[:, radial], after[:, radial], bands_hz),
        AXIAL: _changes(frequency_hz[shown], before[:, AXIS], after[:, AXIS], bands_hz),
    }


def _transfer(ring: LinearRing, other: LinearRing, frequency_hz: Array) -> Array:
    """Return what leads from the velocity of a ring to that of another one under equal forces."""
    stiffness = ring.dynamic_stiffness(frequency_hz)
    return np.asarray(np.linalg.solve(other.dynamic_stiffness(frequency_hz), stiffness))


def _changes(
    frequency_hz: Array,
    before: Array,
    after: Array,
    bands_hz: Mapping[str, tuple[float, float]],
) -> dict[str, float]:
    """Return the changes of the bands [dB] between two spectra of power, 0 for a ring at rest."""
    changes = {}
    for band, (low, high) in bands_hz.items():
        inside = (frequency_hz >= low) & (frequency_hz < high)
        was = float(before[inside].sum())
        becomes = float(after[inside].sum())
        changes[band] = 10 * np.log10(becomes / was) if min(was, becomes) > 0 else 0.0
    return changes


def loss_factor_db(
    record: RingRecord,
    model: BearingModel,
    bands_hz: Mapping[str, tuple[float, float]] = VELOCITY_BANDS_HZ,
) -> dict[str, dict[str, float]]:
    """Return what an assumed loss factor leaves uncertain [dB], by direction and band.

    It is the root mean square of the changes over the loss factors that bearings may have, about
    the stated value, which lies at the end of the range.
    """
    factors = _between(LEAST_LOSS_FACTOR, LARGEST_LOSS_FACTOR)
    return _root_mean_squares([band_change_db(record, model, each, bands_hz) for each in factors])


def film_damping_db(
    record: RingRecord,
    model: BearingModel,
    bands_hz: Mapping[str, tuple[float, float]] = VELOCITY_BANDS_HZ,
) -> dict[str, dict[str, float]]:
    """Return what the viscosity of films leaves uncertain [dB], by direction and band.

    It is the root mean square of the changes over the values that are quoted for rolling bearings.
    """
    share = model.film_time_s / TIME_S  # of a film that surfaces interrupt
    times = _between(LEAST_TIME_S * share, LARGEST_TIME_S * share)
    changes = [band_change_db(record, model, None, bands_hz, film_time_s=time) for time in times]
    return _root_mean_squares(changes)


def _between(least: float, largest: float) -> list[float]:
    """Return values between two limits, all of them as likely over their logarithm."""
    steps = (np.arange(_LOSS_FACTORS) + 0.5) / _LOSS_FACTORS
    return [float(value) for value in least * (largest / least) ** steps]


def _root_mean_squares(
    changes: Sequence[Mapping[str, Mapping[str, float]]],
) -> dict[str, dict[str, float]]:
    """Return the root mean squares of changes [dB], by direction and band."""
    return {
        direction: {
            band: float(np.sqrt(np.mean([change[direction][band] ** 2 for change in changes])))
            for band in bands
        }
        for direction, bands in changes[0].items()
    }

"""What an assumed loss factor of the contacts leaves uncertain in the bands of a ring.

The loss factor decides how high a resonance of the ring stands: its power falls as one over the
loss factor. Well below a resonance the stiffness of the balls rules, well above it the mass of the
ring, and neither knows the loss factor. So a band moves as far as resonances make it. The linear
ring gives its velocity at another loss factor for the same forces, at each frequency.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import AXIAL, AXIS, RADIAL, RingRecord

# Loss factors that lubricated bearings may have; all are as likely over their logarithm.
LEAST_LOSS_FACTOR = 0.02
LARGEST_LOSS_FACTOR = 0.1
_LOSS_FACTORS = 6  # between them, at which bands are computed
_SEGMENT_S = 2.0  # of a record, over which powers are averaged


def band_change_db(
    record: RingRecord,
    model: BearingModel,
    loss_factor: float,
    bands_hz: Mapping[str, tuple[float, float]] = VELOCITY_BANDS_HZ,
) -> dict[str, dict[str, float]]:
    """Return how far another loss factor would change each band [dB], by direction and band.

    Parameters
    ----------
    record : RingRecord
        Motion of the ring at the loss factor of the model.
    model : BearingModel
        Bearing.
    loss_factor : float
        The other loss factor.
    bands_hz : dict, Hz
        Edges of the bands by their names. Default: the three bands of ISO 15242-1.
    """
    count = record.velocity_m_s.shape[1]
    radial = record.radial_columns
    segment = min(len(record.velocity_m_s), round(_SEGMENT_S * record.rate_hz))
    frequency_hz = np.asarray(np.fft.rfftfreq(segment, 1 / record.rate_hz), dtype=float)
    highest_hz = VELOCITY_BANDS_HZ["high"][1]
    shown = np.flatnonzero((frequency_hz > 0) & (frequency_hz < highest_hz))
    transfer = _transfer(model, loss_factor, frequency_hz[shown])
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


def _transfer(model: BearingModel, loss_factor: float, frequency_hz: Array) -> Array:
    """Return what leads from a velocity to that at another loss factor under equal forces."""
    ring = linear_ring(model)
    other = replace(ring, loss_factor=loss_factor)
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
    steps = (np.arange(_LOSS_FACTORS) + 0.5) / _LOSS_FACTORS
    factors = LEAST_LOSS_FACTOR * (LARGEST_LOSS_FACTOR / LEAST_LOSS_FACTOR) ** steps
    changes = [band_change_db(record, model, float(factor), bands_hz) for factor in factors]
    return {
        direction: {
            band: float(np.sqrt(np.mean([change[direction][band] ** 2 for change in changes])))
            for band in bands_hz
        }
        for direction in (RADIAL, AXIAL)
    }

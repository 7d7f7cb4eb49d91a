"""Loss factors of bending waves, constant or given over the frequency."""

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array

# A loss factor at all frequencies, or pairs of a frequency [Hz] and the loss factor there.
LossFactor = float | tuple[tuple[float, float], ...]


def least_loss_factor(loss_factor: LossFactor) -> float:
    """Return the smallest loss factor of all frequencies."""
    if isinstance(loss_factor, float | int):
        return float(loss_factor)
    return min(loss for _, loss in loss_factor)


def loss_factor_at(loss_factor: LossFactor, frequency_hz: ArrayLike) -> Array:
    """Return a loss factor at frequencies [Hz], an array of their shape.

    Between pairs its logarithm is linear over that of the frequency, so two pairs are a power law.
    Beyond the first and the last pair it stays constant.
    """
    frequency = np.asarray(frequency_hz, dtype=float)
    if isinstance(loss_factor, float | int):
        return np.full(frequency.shape, float(loss_factor))
    given_hz, given = np.log(np.array(loss_factor)).T
    within = np.maximum(frequency, np.exp(given_hz[0]))  # a static force has no logarithm
    return np.asarray(np.exp(np.interp(np.log(within), given_hz, given)))

"""Rows along a marched stretch, continued at random around a whole turn of a body."""

import numpy as np

from acoustics.arrays import Array
from acoustics.continued_rows import ContinuedRows

MIN_POSITIONS = 16  # of the rows that are continued
MAX_BLEND = 0.25  # of the turn, over which its end fades into its beginning


def continued_turn(rows: Array, points: int, seed: int, keep_rows: bool) -> Array:
    """Continue closed rows to a whole turn, statistically like them.

    Parameters
    ----------
    rows : array (rows, n), any units
        Rows along a closed stretch, n >= 16; they stay coherent with each other.
    points : int
        Points of the turn, at the distance of the given ones.
    seed : int
        Number of the continuation. Other seeds give other turns of equal cross-spectra.
    keep_rows : bool
        Whether the turn begins with the rows as they are given.

    Returns
    -------
    array (rows, points)
        The turn, which closes, with zero mean.

    Raises
    ------
    ValueError
        If there are fewer than 16 positions.
    """
    count = rows.shape[1]
    if count < MIN_POSITIONS:
        raise ValueError(f"a continued turn needs {MIN_POSITIONS} positions or more, got {count}")
    if keep_rows and points == count:
        return np.asarray(rows - rows.mean(axis=1, keepdims=True))
    continued = ContinuedRows(rows, True, seed)
    first = 0 if keep_rows and points > count else count
    blend = int(min(count, MAX_BLEND * points))
    drawn = continued.between(first, first + points + blend).copy()
    turn = drawn[:, :points]
    mean = rows.mean(axis=1, keepdims=True)
    # What follows the end fades in at the beginning, in power: both are independent.
    angle = 0.5 * np.pi * (np.arange(blend) + 0.5) / blend
    beginning = (drawn[:, :blend] - mean) * np.sin(angle)
    beginning += (drawn[:, points:] - mean) * np.cos(angle)
    turn[:, :blend] = beginning + mean
    return np.asarray(turn - turn.mean(axis=1, keepdims=True))

"""Rows along a line, first as given, then continued at random, with rare stretches as given."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.random_rows import RandomRows

SIGMAS = 7.0  # deviations that no Gaussian row has, even if they are estimated too small
CALM = 1.5  # sigmas at which such a stretch begins and ends
LEAST_SIGMA = 0.01  # of the largest value, for single stretches in a smooth row
QUARTILES = 1.349  # distance between the quartiles of a Gaussian row in standard deviations

Stretch = tuple[int, Array, Array]  # first position, share (m,), values (rows, m)


class ContinuedRows:
    """Rows without an end: the given rows first, then random rows of equal cross-spectra.

    Stretches with a value beyond `SIGMAS` standard deviations are no part of the Gaussian rows:
    they are inserted as given, as often as they occur, at random places. With a turn, rows repeat
    after each turn as far as the given rows know it: their mean over the turns if they are at least
    a turn long, otherwise the given rows themselves, and random ones between.

    Parameters
    ----------
    rows : array (rows, n), any units. Rows along a line, n >= 16.
    closed : bool. If true, the rows are one period.
    seed : int. Number of the continuation.
    turn : int, optional. Positions after which a part of the rows repeats. Default: no part does.

    Raises
    ------
    ValueError
        If there are fewer than 16 positions.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics.continued_rows import ContinuedRows
    >>> given = np.random.default_rng(1).standard_normal((2, 500))
    >>> rows = ContinuedRows(given, True, seed=0)
    >>> bool(np.array_equal(rows.between(0, 500), given)), rows.between(500, 100_500).shape
    (True, (2, 100000))
    """

    def __init__(self, rows: Array, closed: bool, seed: int, turn: int | None = None) -> None:
        count = rows.shape[1]
        self._random = np.random.default_rng(seed)
        middle = np.median(rows, axis=1, keepdims=True)
        self._turn, self._periodic = turn, np.zeros((len(rows), 1))
        rest = rows - middle
        known = np.ones(count, dtype=bool)  # positions that differ from the repeated part
        if turn is not None and turn <= count:
            turns = -(-count // turn)
            padded = np.full((len(rows), turns * turn), np.nan)
            padded[:, :count] = rest
            self._periodic = np.nanmean(padded.reshape(len(rows), turns, turn), axis=1)
            rest = rest - self._repeated(0, count)
            if count < 2 * turn:
                known = np.arange(count) % turn < count - turn
        share, self._stretches = _rare(rest, closed, known)
        calm = 1 - np.square(share)
        left = max(float(calm.sum()), 1.0)
        mean = (rest @ calm / left)[:, None]
        self._mean = middle + mean
        # Power that the stretches lack is spread over the other positions.
        still = (rest - mean) * np.sqrt(calm * (count / left))
        process = RandomRows(still, closed)
        self._calm = left / max(len(self._stretches), 1)
        if turn is not None and turn > count:
            self._stretches = [(_window(count, count // 16), rest - mean)]
        blend = process.blend
        self.solved = count if closed else count - blend
        before = (rest - mean)[:, :blend] if closed else (rest - mean)[:, count - blend :]
        self._drawn = process.stretches(self._random, before)
        self._places = self._insertions()
        self._coming: list[Stretch] = []
        self._first, self._rows = 0, rows[:, : self.solved]
        self._last, self._starts = 0, list[int]()

    def between(self, first: int, last: int) -> Array:
        """Return the rows at positions `first` to `last - 1`, (rows, last - first).

        Neither may be less than at the call before: positions are forgotten then.
        """
        parts, end = [self._rows], self._first + self._rows.shape[1]
        while end < last:
            drawn = next(self._drawn)
            drawn = self._with_stretches(drawn, end) + self._mean
            parts.append(drawn + self._repeated(end, end + drawn.shape[1]))
            end += drawn.shape[1]
        rows = np.concatenate(parts, axis=1) if len(parts) > 1 else parts[0]
        self._rows, self._first, self._last = rows[:, first - self._first :], first, last
        return self._rows[:, : last - first]

    @property
    def inserted(self) -> int:
        """Number of stretches that were inserted in the rows read so far."""
        return sum(start < self._last for start in self._starts)

    def _repeated(self, first: int, last: int) -> Array:
        """Return the part of the rows that repeats after each turn, (rows, last - first)."""
        return self._periodic[:, np.arange(first, last) % self._periodic.shape[1]]

    def _insertions(self) -> Iterator[Stretch]:
        """Yield the stretches at their places, in ascending order."""
        place = float(self.solved)
        while self._stretches:
            share, values = self._stretches[self._random.integers(len(self._stretches))]
            if self._turn is not None and self._periodic.shape[1] == 1:
                place = (np.floor(place / self._turn) + 1) * self._turn
            else:
                place += self._random.exponential(self._calm)
            yield int(place), share, values
            place += len(share)

    def _with_stretches(self, drawn: Array, first: int) -> Array:
        """Blend the stretches into drawn rows that begin at a position."""
        last = first + drawn.shape[1]
        while self._stretches and (not self._coming or self._coming[-1][0] < last):
            self._coming.append(next(self._places))
            self._starts.append(self._coming[-1][0])
        for place, share, values in self._coming:
            begin, end = max(place, first), min(place + len(share), last)
            if begin < end:
                here, own = slice(begin - first, end - first), slice(begin - place, end - place)
                drawn[:, here] *= np.sqrt(1 - np.square(share[own]))
                drawn[:, here] += share[own] * values[:, own]
        self._coming = [stretch for stretch in self._coming if stretch[0] + len(stretch[1]) > last]
        return drawn


def _rare(
    rows: Array, closed: bool, known: NDArray[np.bool_]
) -> tuple[Array, list[tuple[Array, Array]]]:
    """Return the share (n,) of rare stretches in rows of zero median, and these stretches.

    A stretch begins and ends where the row that departs is calm; both ends are faded over half of
    its length.
    """
    count = rows.shape[1]
    low, high = np.percentile(rows[:, known] if known.any() else rows, [25, 75], axis=1)
    largest = np.abs(rows).max(axis=1)
    sigma = np.maximum((high - low) / QUARTILES, LEAST_SIGMA * largest)[:, None]
    departure = np.abs(np.divide(rows, sigma, out=np.zeros_like(rows), where=sigma > 0))
    turned = 0
    if closed:  # no stretch lies across the end
        turned = int(np.argmin(departure.max(axis=0)))
        departure, rows = np.roll(departure, -turned, axis=1), np.roll(rows, -turned, axis=1)
    # A stretch begins and ends where its row is calm, with a margin that is faded.
    rare = np.zeros(count, dtype=bool)
    for row in departure:
        moved = np.diff(row > CALM, prepend=False, append=False)
        for begin, end in np.flatnonzero(moved).reshape(-1, 2):
            if row[begin:end].max() > SIGMAS:
                margin = 8 + (end - begin) // 2
                rare[max(begin - margin, 0) : end + margin] = True
    share, stretches = np.zeros(count), []
    for begin, end in np.flatnonzero(np.diff(rare, prepend=False, append=False)).reshape(-1, 2):
        window = _window(end - begin, (end - begin) // 4)
        share[begin:end] = window
        stretches.append((window, rows[:, begin:end]))
    return np.roll(share, turned), stretches


def _window(count: int, ends: int) -> Array:
    """Return ones with raised cosines at both ends."""
    window = np.ones(count)
    window[:ends] = np.sin(0.5 * np.pi * (np.arange(ends) + 0.5) / max(ends, 1)) ** 2
    window[count - ends :] = window[:ends][::-1]
    return window

"""Rows along a line: random ones with given cross-spectra, and given ones continued at random.

The spectral matrix of the rows is smoothed over neighbouring lines with weights w. The weighted
lines X themselves are a factor of it, and no matrix is formed: with independent random phases xi

    Y(f) = sum_j sqrt(w_j) X(f_j) xi_j   has the mean   E Y Y* = sum_j w_j X(f_j) X(f_j)*

The smoothed matrix is therefore positive semidefinite in every rounding. A continuation has rare
stretches as given.
"""

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array

LINES = 25  # over which a Hann window smooths, at most
THIRD_OCTAVE = 2 ** (1 / 6) - 2 ** (-1 / 6)  # its width over its middle: the other limit
WIDER = 4  # times as many lines for the level by which the lines are divided before
FEW = 3.0  # lines to either side over which the power is averaged before its logarithm is taken
_FLOOR = 1e-26  # of the largest power of a line, below which only rounding remains
MIN_BLOCK = 2**16  # positions that are drawn at once
_TURNS = np.array([1, 1j, -1, -1j])  # phases; the sum of many lines is Gaussian


class RandomRows:
    """Stationary Gaussian process of rows with zero mean.

    A steep spectrum would leak when it is smoothed, so each row's lines are divided by their
    logarithmic mean before, and multiplied by it at their new place. Below the lowest line of the
    given rows the density is constant. Blocks of a closed length follow each other, blended by
    cosine and sine, which keeps the variance.

    Parameters
    ----------
    rows : array (rows, n), any units. Rows along a line, n >= 16.
    closed : bool. If true, the rows are one period; if false, a Hann taper avoids their ends.

    Raises
    ------
    ValueError
        If there are fewer than 16 positions.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics.continued_rows import RandomRows
    >>> given = np.random.default_rng(1).standard_normal((1, 5000))
    >>> stretch = next(RandomRows(given, True).stretches(np.random.default_rng(2)))
    >>> abs(float(np.std(stretch)) - 1) < 0.05
    True
    """

    def __init__(self, rows: Array, closed: bool) -> None:
        from scipy.fft import next_fast_len  # slow to import, for long records only

        count = rows.shape[1]
        if count < 16:
            raise ValueError(f"random rows need 16 positions or more, got {count}")
        taper = np.ones(count)
        if not closed:
            taper = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** 2 * np.sqrt(8 / 3)
        fluctuation = (rows - rows.mean(axis=1, keepdims=True)) * taper
        # A taper spreads the mean over two lines. The line at Nyquist has no phase.
        self._lowest = 1 if closed else 2
        lines = np.fft.rfft(fluctuation)[:, self._lowest : (count + 1) // 2] / count
        self.block = next_fast_len(max(count, MIN_BLOCK), True)
        self.blend = min(count, self.block) // 4
        windows = _windows_of(lines.shape[1], self._lowest, count, self.block)
        power = np.square(np.abs(lines))
        floor = np.maximum(_FLOOR * power.max(axis=1, keepdims=True), np.finfo(float).tiny)
        # Single lines may be silent where a part was subtracted.
        power = _smoothed(power, windows.few)
        power = np.log(np.maximum(power, floor))
        smooth = _smoothed(power, windows.wide)
        self._white = lines * np.exp(-0.5 * smooth)
        ratio = count / self.block
        own = np.arange(lines.shape[1], dtype=float) + self._lowest
        level = np.exp([0.5 * np.interp(windows.place, own, row) for row in smooth])
        self._level = self.block * np.sqrt(ratio) * level
        self._steps = windows.steps

    def _drawn(self, random: np.random.Generator) -> Array:
        """Draw a block, (rows, block)."""
        drawn = np.zeros(self._level.shape, dtype=complex)
        for line, root in self._steps:
            phase = _TURNS[random.integers(0, 4, len(line), dtype=np.uint8)]
            drawn += (root * phase) * self._white[:, line]
        spectrum = np.zeros((len(drawn), self.block // 2 + 1), dtype=complex)
        spectrum[:, 1 : 1 + drawn.shape[1]] = self._level * drawn
        return np.fft.irfft(spectrum, self.block)

    def stretches(
        self, random: np.random.Generator, before: Array | None = None
    ) -> Iterator[Array]:
        """Yield stretches that follow each other, without an end.

        Parameters
        ----------
        random : numpy.random.Generator. Source of the phases.
        before : array (rows, blend), optional. Values that the first stretch blends from.

        Yields
        ------
        array (rows, block - blend)
        """
        angle = 0.5 * np.pi * (np.arange(self.blend) + 0.5) / max(self.blend, 1)
        while True:
            block = self._drawn(random)
            if before is not None:
                block[:, : self.blend] *= np.sin(angle)
                block[:, : self.blend] += before * np.cos(angle)
            before = block[:, self.block - self.blend :].copy()
            yield block[:, : self.block - self.blend]


Windows = list[tuple[Array, Array]]  # indices and weights of lines, a pair for each neighbour


def _smoothed(power: Array, windows: Windows) -> Array:
    """Return the weighted mean of rows of lines over the neighbours of each line."""
    total = np.zeros((len(power), len(windows[0][0])))
    for line, weight in windows:
        total += weight * power[:, line]
    return total


def _windows(place: Array, own: Array, wider: int = 1, least: float = 0.0) -> Windows:
    """Return indices and weights of lines about places, one pair for each neighbour."""
    half = np.maximum(wider * np.minimum(LINES, THIRD_OCTAVE * place) / 2 + 0.5, least)
    reach = wider * (LINES // 2)
    weights = np.zeros((2 * reach + 1, len(place)))
    index = np.empty(weights.shape, dtype=np.intp)
    for j in range(2 * reach + 1):
        line = np.rint(place) + (j - reach)
        away = np.abs(line - place)
        inside = (away < half) & (line >= own[0]) & (line <= own[-1])
        weights[j] = np.where(inside, 1 + np.cos(np.pi * away / half), 0.0)
        index[j] = np.clip(line - own[0], 0, len(own) - 1)
    weights /= weights.sum(axis=0)
    return list(zip(index, weights, strict=True))


class _WindowsOfRows(NamedTuple):
    """Windows of random rows, which depend on their length alone.

    few, wide : list. Windows of the given lines about themselves, for power and level.
    place : array. Places of the lines of a block among the given ones.
    steps : list. Indices, and roots of weights, of the given lines about these places.
    """

    few: Windows
    wide: Windows
    place: Array
    steps: Windows


@lru_cache(maxsize=2)  # balls share them, and the raceways are as long
def _windows_of(lines: int, lowest: int, count: int, block: int) -> _WindowsOfRows:
    """Return the windows of rows of a length, which have so many lines from a lowest one on."""
    own = np.arange(lines, dtype=float) + lowest
    place = np.clip(np.arange(1, (block + 1) // 2) * (count / block), own[0], own[-1])
    about = _windows(place, own)
    return _WindowsOfRows(
        few=_windows(own, own, least=FEW),
        wide=_windows(own, own, WIDER),
        place=place,
        steps=[(line, np.sqrt(weight)) for line, weight in about if weight.any()],
    )


def drawn_lines(places: Array, power: Array) -> float:
    """Return how many independent lines of given rows the power of random rows comes from.

    A sum of powers of `RandomRows` is known as well as a mean over so many random lines: its
    relative standard deviation is one over their root.

    Parameters
    ----------
    places : array (n,)
        Places of some lines of the random rows among those of the given ones, in distances of the
        given lines.
    power : array (n,), any unit
        Power at these places, with all that weights it.

    Returns
    -------
    lines : float
        At least 1.
    """
    own = np.arange(1, max(math.ceil(places.max()), 1) + LINES, dtype=float)
    within = np.maximum(places, own[0])
    weights = np.zeros(len(own))
    for line, share in _windows(within, own):
        weights += np.bincount(line, share * power, len(own))
    squares = float(np.square(weights).sum())
    return max(float(weights.sum()) ** 2 / squares, 1.0) if squares > 0 else 1.0


SIGMAS = 7.0  # deviations that no Gaussian row has, even if they are estimated too small
CALM = 1.5  # sigmas at which such a stretch begins and ends
MIN_SIGMA = 0.01  # of the largest value, for single stretches in a smooth row
QUARTILES = 1.349  # distance between the quartiles of a Gaussian row in standard deviations


class RareStretch(NamedTuple):
    """Stretch of rows that is inserted as given."""

    share: Array  # (m,) weight of the stretch, which is faded at both ends
    values: Array  # (rows, m)


class PlacedStretch(NamedTuple):
    """Stretch at its place."""

    first: int  # position
    stretch: RareStretch

    @property
    def end(self) -> int:
        """Position behind the last one."""
        return self.first + len(self.stretch.share)


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
        self._turn = turn
        self._periodic = np.zeros((len(rows), 1))
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
            self._stretches = [RareStretch(_window(count, count // 16), rest - mean)]
        blend = process.blend
        if closed:
            self.solved = count
            before = (rest - mean)[:, :blend]
        else:
            self.solved = count - blend
            before = (rest - mean)[:, count - blend :]
        self._drawn = process.stretches(self._random, before)
        self._places = self._insertions()
        self._coming: list[PlacedStretch] = []
        self._first = 0
        self._rows = rows[:, : self.solved]
        self._last = 0
        self._starts = list[int]()

    def between(self, first: int, last: int) -> Array:
        """Return the rows at positions `first` to `last - 1`, (rows, last - first).

        Neither may be less than at the call before: positions are forgotten then.
        """
        parts = [self._rows]
        end = self._first + self._rows.shape[1]
        while end < last:
            drawn = next(self._drawn)
            drawn = self._with_stretches(drawn, end) + self._mean
            parts.append(drawn + self._repeated(end, end + drawn.shape[1]))
            end += drawn.shape[1]
        rows = parts[0]
        if len(parts) > 1:
            rows = np.concatenate(parts, axis=1)
        self._rows = rows[:, first - self._first :]
        self._first = first
        self._last = last
        return self._rows[:, : last - first]

    @property
    def inserted(self) -> int:
        """Number of stretches that were inserted in the rows read so far."""
        return sum(start < self._last for start in self._starts)

    def _repeated(self, first: int, last: int) -> Array:
        """Return the part of the rows that repeats after each turn, (rows, last - first)."""
        return self._periodic[:, np.arange(first, last) % self._periodic.shape[1]]

    def _insertions(self) -> Iterator[PlacedStretch]:
        """Yield the stretches at their places, in ascending order."""
        place = float(self.solved)
        while self._stretches:
            stretch = self._stretches[self._random.integers(len(self._stretches))]
            if self._turn is not None and self._periodic.shape[1] == 1:
                place = (np.floor(place / self._turn) + 1) * self._turn
            else:
                place += self._random.exponential(self._calm)
            yield PlacedStretch(int(place), stretch)
            place += len(stretch.share)

    def _with_stretches(self, drawn: Array, first: int) -> Array:
        """Blend the stretches into drawn rows that begin at a position."""
        last = first + drawn.shape[1]
        while self._stretches and (not self._coming or self._coming[-1].first < last):
            placed = next(self._places)
            self._coming.append(placed)
            self._starts.append(placed.first)
        for placed in self._coming:
            begin = max(placed.first, first)
            end = min(placed.end, last)
            if begin < end:
                here = slice(begin - first, end - first)
                own = slice(begin - placed.first, end - placed.first)
                share = placed.stretch.share[own]
                drawn[:, here] *= np.sqrt(1 - np.square(share))
                drawn[:, here] += share * placed.stretch.values[:, own]
        self._coming = [placed for placed in self._coming if placed.end > last]
        return drawn


def _rare(rows: Array, closed: bool, known: NDArray[np.bool_]) -> tuple[Array, list[RareStretch]]:
    """Return the share (n,) of rare stretches in rows of zero median, and these stretches.

    A stretch begins and ends where the row that departs is calm; both ends are faded over half of
    its length.
    """
    count = rows.shape[1]
    low, high = np.percentile(rows[:, known] if known.any() else rows, [25, 75], axis=1)
    largest = np.abs(rows).max(axis=1)
    sigma = np.maximum((high - low) / QUARTILES, MIN_SIGMA * largest)[:, None]
    departure = np.abs(np.divide(rows, sigma, out=np.zeros_like(rows), where=sigma > 0))
    turned = 0
    if closed:  # no stretch lies across the end
        turned = int(np.argmin(departure.max(axis=0)))
        departure = np.roll(departure, -turned, axis=1)
        rows = np.roll(rows, -turned, axis=1)
    # A stretch begins and ends where its row is calm, with a margin that is faded.
    rare = np.zeros(count, dtype=bool)
    for row in departure:
        moved = np.diff(row > CALM, prepend=False, append=False)
        for begin, end in np.flatnonzero(moved).reshape(-1, 2):
            if row[begin:end].max() > SIGMAS:
                margin = 8 + (end - begin) // 2
                rare[max(begin - margin, 0) : end + margin] = True
    share = np.zeros(count)
    stretches = []
    for begin, end in np.flatnonzero(np.diff(rare, prepend=False, append=False)).reshape(-1, 2):
        window = _window(end - begin, (end - begin) // 4)
        share[begin:end] = window
        stretches.append(RareStretch(window, rows[:, begin:end]))
    return np.roll(share, turned), stretches


def _window(count: int, ends: int) -> Array:
    """Return ones with raised cosines at both ends."""
    window = np.ones(count)
    window[:ends] = np.sin(0.5 * np.pi * (np.arange(ends) + 0.5) / max(ends, 1)) ** 2
    window[count - ends :] = window[:ends][::-1]
    return window

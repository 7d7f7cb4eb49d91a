"""Random rows along a line with the spectra and cross-spectra of given rows.

The spectral matrix of the rows is smoothed over neighbouring lines with weights w. The weighted
lines X themselves are a factor of it, and no matrix is formed: with independent random phases xi

    Y(f) = sum_j sqrt(w_j) X(f_j) xi_j   has the mean   E Y Y* = sum_j w_j X(f_j) X(f_j)*

The smoothed matrix is therefore positive semidefinite in every rounding.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from acoustics.arrays import Array

LINES = 25  # over which a Hann window smooths, at most
THIRD_OCTAVE = 2 ** (1 / 6) - 2 ** (-1 / 6)  # its width over its middle: the other limit
WIDER = 4  # times as many lines for the level by which the lines are divided before
FEW = 3.0  # lines to either side over which the power is averaged before its logarithm is taken
_FLOOR = 1e-26  # of the largest power of a line, below which only rounding remains
LEAST_BLOCK = 2**16  # positions that are drawn at once
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
    >>> from acoustics.random_rows import RandomRows
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
        self.block = next_fast_len(max(count, LEAST_BLOCK), True)
        self.blend = min(count, self.block) // 4
        own = np.arange(lines.shape[1], dtype=float) + self._lowest
        power = np.square(np.abs(lines))
        floor = np.maximum(_FLOOR * power.max(axis=1, keepdims=True), np.finfo(float).tiny)
        # Single lines may be silent where a part was subtracted.
        power = sum(weight * power[:, line] for line, weight in _windows(own, own, least=FEW))
        power = np.log(np.maximum(power, floor))
        smooth = sum(weight * power[:, line] for line, weight in _windows(own, own, WIDER))
        self._white = lines * np.exp(-0.5 * smooth)
        ratio = count / self.block
        place = np.clip(np.arange(1, (self.block + 1) // 2) * ratio, own[0], own[-1])
        level = np.exp([0.5 * np.interp(place, own, row) for row in smooth])
        self._level = self.block * np.sqrt(ratio) * level
        windows = _windows(place, own)
        self._steps = [(line, np.sqrt(weight)) for line, weight in windows if weight.any()]

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


def _windows(
    place: Array, own: Array, wider: int = 1, least: float = 0.0
) -> list[tuple[Array, Array]]:
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

"""Random waves around a circle, whose amplitudes fall with a power of their order.

Sayles and Thomas (Nature 271, 1978, 431) found the spectral density of ground and lapped surfaces
to fall with the square of the wave number over many decades of wavelength. Around a circle this is
an amplitude that falls with the order itself, an exponent of 1. The law has no end at short waves:
it goes on into what a stylus calls roughness.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array

FIRST_ORDER = 2  # order 1 moves the centre of a circle that stays round
# Mean peak-to-valley height of the waves of orders 2 to 15 over the amplitude of order 1, at an
# exponent of 1: the mean of 4,000 drawings.
ROUNDNESS_OF_AMPLITUDE = 2.21


@dataclass(frozen=True, kw_only=True)
class WaveLaw:
    """Random waves around a circle.

    Waves of order n have a mean square amplitude A_n^2 with A_n = amplitude n^-exponent. Their sine
    and cosine are independent and Gaussian, so amplitudes scatter as Rayleigh's distribution does.

    Attributes
    ----------
    amplitude_m : float, m
        Root-mean-square amplitude that the law has at order 1.
    exponent : float
        Power by which amplitudes fall.
    seed : tuple of int
        Seed of the waves. Laws of equal seeds have equal luck, whatever their amplitude.
    first : int
        Lowest order. Default: 2.
    """

    amplitude_m: float
    exponent: float
    seed: tuple[int, ...]
    first: int = FIRST_ORDER

    def amplitudes(self, orders: Array | Sequence[int]) -> Array:
        """Return the root-mean-square amplitudes of orders [m], 0 below the first one."""
        number = np.asarray(orders, dtype=float)
        falling = self.amplitude_m * np.maximum(number, 1.0) ** -self.exponent
        return np.where(number >= self.first, falling, 0.0)

    def waves(self, last: int) -> NDArray[np.complex128]:
        """Return the complex amplitudes c_n of the orders 0 to `last` [m].

        The heights are the real part of the sum of c_n exp(i n phi). More orders do not change the
        lower ones.
        """
        random = np.random.default_rng(self.seed)
        luck = random.standard_normal((last + 1, 2)) @ [1, 1j] / np.sqrt(2)
        return np.asarray(self.amplitudes(range(last + 1)) * luck)

    def heights(self, nodes: int, last: int) -> Array:
        """Return the heights [m] of the orders up to `last` at equally spaced angles of a turn."""
        spectrum = np.zeros(nodes // 2 + 1, dtype=complex)
        highest = min(last, (nodes - 1) // 2)
        spectrum[: highest + 1] = self.waves(highest) * nodes / 2
        return np.asarray(np.fft.irfft(spectrum, nodes))

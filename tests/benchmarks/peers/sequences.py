"""Rolling sequences on identical gaps for the program and the public solvers.

The module needs numpy only. Numbers are SI, and arrays are (along the track, across) on N x N
nodes. The sphere's apex is on node N / 2 along and half way across, between two nodes. At position
k the sphere has rolled on by k nodes; seen from the sphere, the plate has moved back under it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from problem import Problem

N = 256
SPACING = 2e-6
RADIUS = 5e-3
YOUNGS_MODULUS = 210e9
POISSONS_RATIO = 0.3
CONTACT_MODULUS = YOUNGS_MODULUS / (1 - POISSONS_RATIO**2)


@dataclass(frozen=True)
class Sequence:
    """A plate of this Ra [m] from this seed, with a hardness [Pa], under a load [N].

    Its heights are correlated as exp(-(r / length)^2).
    """

    ra: float
    seed: int
    load: float
    hardness: float
    length: float = 10e-6


# The solver was tuned on the first three.
TUNED = {
    "A": Sequence(0.1e-6, 1, 20.0, np.inf),
    "B": Sequence(0.1e-6, 1, 20.0, 2.1e9),
    "C": Sequence(1e-6, 2, 100.0, 2.1e9),
}
UNTUNED = {
    "D": Sequence(0.5e-6, 3, 20.0, np.inf),
    "E": Sequence(1e-6, 4, 20.0, 2.1e9),
    "F": Sequence(0.1e-6, 5, 90.0, 2.1e9, length=5e-6),
    "G": Sequence(0.02e-6, 6, 5.0, np.inf),
    "H": Sequence(0.2e-6, 7, 50.0, np.inf, length=20e-6),
    "I": Sequence(0.1e-6, 8, 5.0, 2.1e9),
    "J": Sequence(0.3e-6, 9, 60.0, 4e9),
    "K": Sequence(0.05e-6, 10, 40.0, 1.2e9, length=15e-6),
    "L": Sequence(1e-6, 11, 60.0, np.inf, length=15e-6),
    "M": Sequence(0.2e-6, 12, 10.0, 7e9, length=6e-6),
}
SEQUENCES = TUNED | UNTUNED


@lru_cache(maxsize=4)
def heights(name: str) -> np.ndarray:
    """Return periodic Gaussian heights [m] of exact Ra."""
    sequence = SEQUENCES[name]
    distance = np.minimum(np.arange(N), N - np.arange(N)) * SPACING
    law = np.exp(-((distance / sequence.length) ** 2))
    density = np.fft.rfft2(np.outer(law, law)).real.clip(min=0)
    noise = np.random.default_rng(sequence.seed).standard_normal((N, N))
    rough = np.fft.irfft2(np.fft.rfft2(noise) * np.sqrt(density), s=(N, N))
    rough -= rough.mean()
    return rough * (sequence.ra / np.abs(rough).mean())


def gap(name: str, k: int) -> np.ndarray:
    """Return the undeformed gap [m] at position k."""
    along = (np.arange(N) - N // 2) * SPACING
    across = (np.arange(N) - (N - 1) / 2) * SPACING
    return (along[:, None] ** 2 + across**2) / (2 * RADIUS) - np.roll(heights(name), -k, axis=0)


@lru_cache(maxsize=2)
def problem(name: str, steps: int) -> Problem:
    """Return a sequence of so many steps as a problem."""
    return Problem(
        gaps=np.array([gap(name, k) for k in range(steps + 1)]),
        moves=np.array([0, *[1] * steps]),
        spacing=SPACING,
        radius=RADIUS,
        contact_modulus=CONTACT_MODULUS,
        hardness=SEQUENCES[name].hardness,
        load=SEQUENCES[name].load,
    )

"""Turn of a ball with a surface, and what is known of it beyond a solved track."""

from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, short_repr


@dataclass(frozen=True, eq=False, kw_only=True)
class BallTurn:
    """Turn of a ball with a surface.

    Attributes
    ----------
    length_m : float, m
        Circumference of the ball, after which its surface repeats.
    form_m : (n,) array, m, or None
        Approach that the waves around the ball add, at n equal places of a turn from the first
        solved position on. The scene states these waves, so they are known all around the ball
        however short the solved track is. None: there are no such waves.
    """

    __repr__ = short_repr

    length_m: float
    form_m: Array | None = None

    def form_at(self, distance_m: Array) -> Array:
        """Return the approach [m] of the waves at distances [m] from the first solved position."""
        if self.form_m is None:
            return np.zeros(len(distance_m))
        places = distance_m / self.length_m % 1.0 * len(self.form_m)
        return np.asarray(
            np.interp(places, np.arange(len(self.form_m)), self.form_m, period=len(self.form_m))
        )

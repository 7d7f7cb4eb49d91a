"""Length that `rolling.duration_s: auto` or `distance_mm: auto` takes, with its reason."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from acoustics.numbers import rounded


class LengthChoice(NamedTuple):
    """Length that `auto` takes.

    seconds : float, s. Duration, at the speed of the run that needs it.
    distance_m : float, m. Distance at this speed.
    key : str. Key that stands for the length, rolling.duration_s or rolling.distance_mm.
    reason : str. What needs this length.
    """

    seconds: float
    distance_m: float
    key: str
    reason: str

    @property
    def length(self) -> float:
        """Number that its key measures: of time or of distance."""
        return self.distance_m if self.key == "rolling.distance_mm" else self.seconds

    @property
    def text(self) -> str:
        """Number and reason."""
        return (
            f"{rounded(self.seconds, 3)} s, {rounded(1e3 * self.distance_m, 4)} mm: {self.reason}"
        )

    def seconds_at(self, speed_m_s: float) -> float:
        """Return the time [s] that the length takes at a speed."""
        if self.key == "rolling.distance_mm":
            return self.distance_m / speed_m_s
        return self.seconds


def longest_choice(choices: Sequence[LengthChoice]) -> LengthChoice:
    """Return the longest of some choices by their key, the first of equal ones."""
    return max(choices, key=lambda choice: choice.length)

"""How long a choice goes on: to the wanted ±, over numbers of pairs that are fixed beforehand."""

from __future__ import annotations

import time
from typing import NamedTuple

from acoustics.pairs import FEWEST_PAIRS, MOST_PAIRS, looks
from rolling.scene.messages import SceneError, quoted
from rolling.terminal import defaults


class Budget(NamedTuple):
    """How long a choice goes on.

    within_db : float, dB. The wanted ± of a difference.
    minutes : float. Time after which no more pairs begin; the first four are always heard.
    pairs : int or None. Number of pairs, whatever the ± and the time. Default: as many as the
        wanted ± needs.
    """

    within_db: float = defaults.WITHIN_DB
    minutes: float = defaults.CHOICE_MINUTES
    pairs: int | None = None

    def looks(self, most: int, noun: str) -> list[int]:
        """Return the numbers of pairs after which the ± is looked at, of the most that there are.

        Raises
        ------
        SceneError : so many pairs are not allowed, or not there.
        """
        if self.pairs is None:
            return looks(most)
        if most == 1:
            raise SceneError(
                [
                    f"pairs: got {quoted(self.pairs)}, but nothing is random in these scenes, so"
                    " that they are compared once; leave --pairs out"
                ]
            )
        is_whole = type(self.pairs) is int
        if not is_whole or not FEWEST_PAIRS <= self.pairs <= MOST_PAIRS:
            raise SceneError(
                [
                    f"pairs: got {quoted(self.pairs)}, allowed: a whole number from"
                    f" {FEWEST_PAIRS} to {MOST_PAIRS}"
                ]
            )
        if self.pairs > most:
            raise SceneError([f"pairs: got {self.pairs}, but there are only {most} {noun}"])
        return [self.pairs]

    def why_no_more(self, noun: str) -> str:
        """Say why no more pairs are heard after the last look."""
        if self.pairs is not None:
            return f"{self.pairs} {noun} were asked for"
        return f"there are no more {noun}"

    @property
    def of_time(self) -> str:
        """Say that the time is over."""
        return f"the limit of {self.minutes:g} min was reached"


class Clock:
    """Time of a command since it began to hear pairs."""

    def __init__(self, budget: Budget) -> None:
        self._budget = budget
        self._began = time.monotonic()

    @property
    def is_over(self) -> bool:
        """Whether no more pairs may begin; a number of pairs that was asked for takes its time."""
        if self._budget.pairs is not None:
            return False
        return time.monotonic() - self._began > 60 * self._budget.minutes

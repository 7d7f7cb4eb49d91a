"""The level of the samples that play, and the gain that brings it to the level that is stated."""

from __future__ import annotations

from typing import NamedTuple

from acoustics.numbers import decibels_a

TOLD_DB = 0.05  # change of a level by its gain from which on people are told


class StatedLevel(NamedTuple):
    """Level of a record as it was made, beside the level that is stated for it.

    A record need not have the level that is stated: an estimate is a mean over the intervals of its
    lines, and a continuation is drawn at random. One gain brings it there, by no more than the ± of
    the level. A record that is further away plays as it was made, and says so.

    own_db : float or None, dB. Level of the record as it was made; None for silence.
    stated_db : float or None, dB. Level that is stated; None where none is.
    spread_db : float, dB. Standard uncertainty of this level, which is the largest gain.
    measure : str. LAeq, or LAE of what ends.
    """

    own_db: float | None
    stated_db: float | None = None
    spread_db: float = 0.0
    measure: str = "LAeq"

    @property
    def departure_db(self) -> float:
        """Level that is stated over that of the record as it was made [dB]; 0 without both."""
        if self.stated_db is None or self.own_db is None:
            return 0.0
        return self.stated_db - self.own_db

    @property
    def is_within_reach(self) -> bool:
        """Whether the gain brings the record to the level that is stated."""
        return abs(self.departure_db) <= max(self.spread_db, TOLD_DB)

    @property
    def gain_db(self) -> float:
        """Gain that brings the record to the level that is stated [dB]; 0 beyond its ±."""
        return self.departure_db if self.is_within_reach else 0.0

    @property
    def level_db(self) -> float | None:
        """Level of the samples that play [dB]; None for silence."""
        return None if self.own_db is None else self.own_db + self.gain_db

    @property
    def words(self) -> str:
        """The level of the samples that play, and what the gain did to it."""
        reference = " re 1 s" if self.measure == "LAE" else ""
        words = f"{self.measure} {decibels_a(self.level_db)}{reference}"
        size_db = abs(self.departure_db)
        if size_db < TOLD_DB:
            return words
        if self.is_within_reach:
            verb = "raised" if self.departure_db > 0 else "lowered"
            return f"{words}; {verb} by {size_db:.1f} dB to the level that is stated"
        where = "below" if self.departure_db > 0 else "above"
        return f"{words}; it lies {size_db:.1f} dB {where} the level that is stated, beyond its ±"

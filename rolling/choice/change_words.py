"""Changes of a level in words, with their ± in hundredths of a decibel."""

from __future__ import annotations

import math

from rolling.choice.heard_specimen import HeardQuantity

SHOWN_DB = 0.005  # smallest change that shows in hundredths of a decibel


def in_words(db: float | None, uncertainty_db: float | None, quantity: HeardQuantity) -> str:
    """Write a change with its sign, its ± and its unit."""
    assert db is not None
    sign = ""
    if abs(db) >= SHOWN_DB:
        sign = "-" if db < 0 else "+"
    return f"{sign}{two_digits(abs(db), uncertainty_db)} {quantity.decibels}"


def two_digits(size_db: float, uncertainty_db: float | None) -> str:
    """Write a size with its ± in hundredths of a decibel; the ± is rounded up."""
    if uncertainty_db is None:
        return f"{size_db:.2f}"
    return f"{size_db:.2f} ± {math.ceil(100 * uncertainty_db - 1e-9) / 100:.2f}"

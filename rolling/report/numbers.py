"""Numbers as the page prints them."""

from __future__ import annotations

NOTHING = "-"  # for a number that does not exist


def significant(value: float) -> str:
    """Write a number with four digits, without an exponent up to a million."""
    return f"{float(f'{value:.4g}'):g}"

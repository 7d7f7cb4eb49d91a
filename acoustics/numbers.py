"""Numbers as a person writes them."""

import math
from collections.abc import Sequence

_PLAIN = 1e-4, 1e7  # magnitudes without an exponent


def rounded(value: float, digits: int = 2) -> str:
    """Write a number with significant digits, and with an exponent only where it is far from 1.

    Examples
    --------
    >>> rounded(99.7), rounded(1234.5, 4), rounded(3.24e-7)
    ('100', '1234', '3.2e-7')
    """
    if not math.isfinite(value):
        return str(value)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    if value == 0 or _PLAIN[0] <= abs(value) < _PLAIN[1]:
        return f"{float(f'{mantissa}e{exponent}'):.15g}"
    return f"{float(mantissa):.15g}e{int(exponent)}"


def bracketed(values: Sequence[float]) -> str:
    """Write numbers in brackets, such as coordinates."""
    return f"[{', '.join(f'{value:g}' for value in values)}]"


def decibels_a(level: float | None) -> str:
    """Write an A-weighted level, or silence."""
    return "silent" if level is None else f"{level:.1f} dB(A)"

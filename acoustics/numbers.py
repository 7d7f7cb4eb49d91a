"""Numbers as a person writes them."""

import math
from collections.abc import Callable, Sequence

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


def rounded_up(value: float) -> str:
    """Write a positive number with two digits that are rounded up: a limit from below holds."""
    return _to_two_digits(value, math.ceil)


def rounded_down(value: float) -> str:
    """Write a positive number with two digits that are rounded down: a limit from above holds."""
    return _to_two_digits(value, math.floor)


def _to_two_digits(value: float, whole: Callable[[float], int]) -> str:
    """Round a number, 0 or above, to two digits by a function that returns whole numbers."""
    if value == 0:
        return "0"
    size = 10.0 ** (math.floor(math.log10(value)) - 1)
    # A number of two digits keeps its value despite its rounding error.
    return rounded(whole(round(value / size, 9)) * size, 6)


def micrometres(length: float) -> str:
    """Write a length [m] in micrometres, with four digits and without the unit."""
    return rounded(length * 1e6, 4)


def si(value: float, unit: str) -> str:
    """Write a number with three digits and a prefix of its unit; lengths have no prefix above m.

    Examples
    --------
    >>> si(6.87e-5, "m"), si(23e3, "Hz")
    ('68.7 um', '23 kHz')
    """
    prefixes = [("G", 1e9), ("M", 1e6), ("k", 1e3)] if unit != "m" else []
    for prefix, size in (*prefixes, ("", 1.0), ("m", 1e-3), ("u", 1e-6), ("n", 1e-9)):
        if abs(value) >= 0.9995 * size:
            return f"{rounded(value / size, 3)} {prefix}{unit}"
    return f"{rounded(value, 3)} {unit}"


def byte_size(value: float) -> str:
    """Write a size in bytes with two digits in TB or GB, or in whole MB."""
    for unit, size in (("TB", 1e12), ("GB", 1e9)):
        if value >= 0.995 * size:
            return f"{float(rounded(value / size)):,.15g} {unit}"
    return f"{max(value / 1e6, 1):.0f} MB"


def clock(seconds: float) -> str:
    """Write a time [s] with two digits in hours, minutes or seconds."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{rounded(seconds / size)} {unit}"
    return f"{rounded(seconds)} s"


def bracketed(values: Sequence[float]) -> str:
    """Write numbers in brackets, such as coordinates."""
    return f"[{', '.join(f'{value:g}' for value in values)}]"


def decibels_a(level: float | None) -> str:
    """Write an A-weighted level, or silence."""
    return "silent" if level is None else f"{level:.1f} dB(A)"

"""Numbers have no exponent where a person would write none."""

from __future__ import annotations

import pytest

from acoustics.numbers import rounded


@pytest.mark.parametrize("digits", [2, 3, 6])
def test_numbers_over_many_decades_read_back(digits: int) -> None:
    """A number keeps its digits (half a unit of the last), and is plain from 1e-4 to 1e7."""
    for exponent in range(-30, 31):
        for mantissa in (1.0, 2.345678, 9.96, 9.99999):
            value = mantissa * 10.0**exponent
            text = rounded(value, digits)
            assert float(text) == pytest.approx(value, rel=0.5 * 10 ** (1 - digits)), text
            assert "e+" not in text and "e0" not in text and "e-0" not in text, text
            assert ("e" in text) == (not 1e-4 <= value < 1e7), text
            assert rounded(-value, digits) == f"-{text}"


def test_special_numbers() -> None:
    assert [rounded(x) for x in (0, 99.7, 390.4, 3.24e-7)] == ["0", "100", "390", "3.2e-7"]
    assert rounded(float("nan")) == "nan"

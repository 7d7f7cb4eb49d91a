"""Scales of charts that are drawn without a script: places and ticks of an axis."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array

THIN = "\N{NARROW NO-BREAK SPACE}"  # before a prefix
_MINUS = "\N{MINUS SIGN}"
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_PLAIN_POWERS = range(-3, 6)  # of ten, of numbers that are written without a power
_STRIDES = (1, 2, 3, 6, 12)  # of named ticks
_MOST_TICKS = 200
Tick = tuple[float, str]


class Scale(NamedTuple):
    """An axis between two places of a drawing.

    low, high : float. Limits, their logarithms on a logarithmic axis.
    is_log : bool. Whether the axis is logarithmic.
    begin, end : float. Places of the limits.
    """

    low: float
    high: float
    is_log: bool
    begin: float
    end: float

    @classmethod
    def of(cls, axis: Mapping[str, Any], begin: float, end: float) -> Scale:
        """Return the scale of an axis of a chart."""
        low, high = axis["limits"]
        if axis["log"]:
            low, high = math.log10(low), math.log10(high)
        return cls(low=low, high=high, is_log=axis["log"], begin=begin, end=end)

    def places(self, values: Sequence[float | None] | Array) -> Array:
        """Return the places of values; NaN where a value is missing, or has no logarithm."""
        numbers = np.array([math.nan if x is None else x for x in values], dtype=float)
        if self.is_log:
            positive = numbers > 0
            numbers = np.log10(np.where(positive, numbers, 1.0))
            numbers[~positive] = math.nan
        share = (numbers - self.low) / ((self.high - self.low) or 1.0)
        return self.begin + share * (self.end - self.begin)

    def place(self, value: float) -> float:
        """Return the place of a value."""
        return float(self.places([value])[0])


def ticks(axis: Mapping[str, Any], room: float) -> list[Tick]:
    """Return the ticks of an axis that has room for some labels, as pairs of value and text.

    Named values, as third octaves, keep their names. Frequencies have round numbers.
    """
    low, high = sorted(axis["limits"])
    slack = 1e-9 * (high - low)
    names = [] if axis["log"] and axis["unit"] == "Hz" else axis["names"]
    named = [number for number, (x, _) in enumerate(names) if low - slack <= x <= high + slack]
    if len(named) > 1 or (named and len(named) == len(names)):
        return _named_ticks(names, named, room)
    if axis["log"] and high / low >= 10:
        values = _decades(low, high, room)
    else:
        values = _round_numbers(low, high, room / 1.6 if axis["unit"] == "Hz" else room)
    kept = [value for value in values if low - slack <= value <= high + slack]
    return [(value, _text(value, axis["unit"])) for value in kept]


def _named_ticks(names: Sequence[Tick], within: Sequence[int], room: float) -> list[Tick]:
    """Return as many of the named values as have room, evenly, that of 1 kHz among them."""
    fitting = (stride for stride in _STRIDES if len(within) / stride <= room)
    stride = next(fitting, max(1, math.ceil(len(names) / room)))
    anchor = next((k for k, (_, name) in enumerate(names) if name == "1k"), 0)
    return [names[k] for k in within if (k - anchor) % stride == 0]


def _round_numbers(low: float, high: float, room: float) -> list[float]:
    """Return multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / max(1.0, room) or 1.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = power * next(k for k in (1, 2, 5, 10) if k * power >= rough * (1 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    last = min(math.floor(high / step + 1e-9), first + _MOST_TICKS)
    return [float(f"{number * step:.12g}") for number in range(first, last + 1)]


def _decades(low: float, high: float, room: float) -> list[float]:
    """Return powers of ten, with 2 and 5 times these where there is room."""
    decades = math.log10(high / low)
    factors = (1, 2, 5) if 3 * decades <= room else (1,)
    stride = math.ceil(decades / room)
    powers = range(math.floor(math.log10(low)), math.floor(math.log10(high) + 1e-9) + 1)
    return [float(f"{k}e{power}") for power in powers if power % stride == 0 for k in factors]


def _text(value: float, unit: str) -> str:
    """Write the number of a tick, frequencies from 1 kHz on with a k."""
    if unit == "Hz" and value >= 1000:
        return f"{_number(value / 1000)}{THIN}k"
    return _number(value)


def _number(value: float) -> str:
    """Write a number, a tiny or huge one as a power of ten."""
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)) + 1e-12)
    if power in _PLAIN_POWERS:
        return f"{value:.6g}".replace("-", _MINUS)
    factor = f"{value / 10.0**power:.4g}"
    raised = f"10{str(power).translate(_SUPERSCRIPTS)}"
    text = raised if factor == "1" else f"{factor}·{raised}"
    return text.replace("-", _MINUS)

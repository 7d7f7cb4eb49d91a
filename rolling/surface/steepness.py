"""Steep surfaces, on which `numerics.subcells: auto` takes sub-cells."""

from __future__ import annotations

import math

import numpy as np

from rolling._typing import Array

# Sub-cells along the side of a cell that `auto` takes on steep surfaces.
STEEP_SUBCELLS = 2
# A surface is steep from this ratio on: half the range of heights over a cell, by its slope, over a
# node's deflection by the hardness on its own cell. Ra 0.1 um at 2.1 GPa has 1.2, Ra 1 um 12.
STEEP = 3.0
# Deflection of the centre of a square by a uniform pressure, over side times pressure over E*.
OWN = 4 * math.asinh(1) / math.pi


def auto_subcells(slope: float, contact_modulus: float, hardness: float) -> int:
    """Choose the sub-cells along the side of a cell for a surface of this slope [-].

    Sub-cells gain most where the heights vary within a cell by more than pressures can level: on
    steep surfaces that yield. Elsewhere a single node per cell finds the edge well enough, as it
    does in an elastic contact.
    """
    levelled = OWN * hardness / contact_modulus
    return STEEP_SUBCELLS if 0.5 * slope > STEEP * levelled else 1


def median_step(heights: Array) -> float:
    """Return the median change of heights [m] from node to node, along and across together."""
    if heights.min() == heights.max():  # without a copy of a large smooth plate
        return 0.0
    steps = np.hypot(np.roll(heights, -1, axis=0) - heights, np.roll(heights, -1, axis=1) - heights)
    return float(np.median(steps))


def rms_slope(median: float, spacing: float) -> float:
    """Return the rms slope of random heights with this median step [m].

    Pits and scratches, which are steep in few places, hardly change it.
    """
    return median / spacing / math.sqrt(math.log(2))

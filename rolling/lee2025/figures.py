"""The figures of the article, drawn for a reading of this study.

Each figure warns of surfaces that are too steep for half-space theory.
"""

from __future__ import annotations

from collections.abc import Iterator

from rolling.figures.picture import Picture
from rolling.lee2025 import curves, surfaces_3d
from rolling.lee2025.figure_data import Reading, Scales


def gallery(reading: Reading, on: Scales) -> Iterator[Picture]:
    """Draw all pictures of a reading that has their data: Fig. 1, 5 to 9, or correlation length."""
    if len(reading.lengths) > 1:
        yield curves.correlation_length(reading)
        return
    if reading.patches:
        yield surfaces_3d.surfaces(reading, on)
    if any(load in on.ends for _, load in reading.contacts):
        yield surfaces_3d.contact_pressure(reading, on)
        yield surfaces_3d.deflection(reading, on)
    if reading.cases:
        yield curves.plastic_ratio(reading, on)
        yield curves.spectra(reading, on)
        yield curves.maximum_level(reading, on)

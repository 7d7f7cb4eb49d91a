"""The figures of the article, drawn anew for one reading of it. Depends on sheets and curves.

Wherever a surface is too steep for half-space theory the figure says so.
"""

from __future__ import annotations

from collections.abc import Iterator

from rolling.article import curves, sheets
from rolling.article.readings import Reading, Scales
from rolling.picture import Picture


def gallery(reading: Reading, on: Scales) -> Iterator[Picture]:
    """The pictures of a reading for which there is anything: Fig. 1, 5 to 9, or those of the correlation length."""
    if len(reading.lengths) > 1:
        yield curves.correlation_length(reading)
        return
    if reading.patches:
        yield sheets.surfaces(reading, on)
    if any(load in on.ends for _, load in reading.contacts):
        yield sheets.contact_pressure(reading, on)
        yield sheets.deflection(reading, on)
    if reading.cases:
        yield curves.plastic_ratio(reading, on)
        yield curves.spectra(reading, on)
        yield curves.maximum_level(reading, on)

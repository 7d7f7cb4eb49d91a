"""How far the numbers of the study's grid (2 um, blended edges) may be from those of a fine one, as measured. Depends on nothing.

Measured on the same places of the same surfaces, refined without new detail; `docs/accuracy.md` says how. A reading that is
not named here was not measured: its verdicts are given as if its grid were exact, and nothing is said of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Range = tuple[float, float]


@dataclass(frozen=True)
class GridError:
    """What a fine grid would make of a number of the study's grid, as ranges by Ra [um] over the loads.

    plastic, deflection : factors by which plastic area and greatest deflection change.
    level_db, high_db : changes of A-weighted levels (LAeq, greatest line) and of the mean height above 5 kHz [dB], 10 lg.
    band_db : greatest change of a third octave from 500 Hz to 4 kHz, either way [dB, 10 lg].
    """

    plastic: Mapping[float, Range] = field(default_factory=dict)
    deflection: Mapping[float, Range] = field(default_factory=dict)
    level_db: Mapping[float, Range] = field(default_factory=dict)
    high_db: Mapping[float, Range] = field(default_factory=dict)
    band_db: Mapping[float, float] = field(default_factory=dict)

    def ratio(self, name: str, over: float, under: float) -> Range:
        """Return the range of factors on the ratio of a number on two roughnesses; it holds 1, and is (1, 1) if not measured."""
        ranges: Mapping[float, Range] = getattr(self, name) if name else {}
        a, b = ranges.get(over, (1.0, 1.0)), ranges.get(under, (1.0, 1.0))
        return min(1.0, a[0] / b[1]), max(1.0, a[1] / b[0])

    def shift(self, name: str, over: float, under: float, factor: int) -> Range:
        """Return the range of changes [dB] of the difference between two roughnesses; it holds 0, and is (0, 0) if not measured."""
        ranges: Mapping[float, Range] = getattr(self, name) if name else {}
        a, b = ranges.get(over, (0.0, 0.0)), ranges.get(under, (0.0, 0.0))
        return min(0.0, a[0] - b[1]) * factor / 10, max(0.0, a[1] - b[0]) * factor / 10


NONE = GridError()
MEASURED: dict[str, GridError] = {}

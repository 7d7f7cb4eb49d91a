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

# From 2 um to the finest grid solved (0.5 um where the law is exponential, else 1 um), over 5, 20 and 100 N for areas and
# deflections and 5 and 20 N for levels, and half as much again as what 1 um still lacks at order 1.4. Ranges are over the loads.
MEASURED = {
    "as-stated": GridError(
        plastic={0.1: (1.0, 1.03), 1.0: (0.99, 1.02), 5.0: (0.97, 1.03)},
        deflection={0.1: (1.0, 1.005), 1.0: (0.999, 1.001), 5.0: (0.98, 1.02)},
        level_db={0.1: (-0.1, 0.1), 1.0: (-1.2, 0.1), 5.0: (-3.0, 0.1)},
        high_db={0.01: (-1.5, 0.0)},
        band_db={0.1: 0.1, 1.0: 2.5},
    ),
    "hardness-3y-exponential": GridError(
        plastic={0.1: (1.1, 1.55), 1.0: (1.05, 1.1), 5.0: (0.97, 1.1)},
        deflection={0.1: (1.0, 1.02), 1.0: (0.98, 1.01), 5.0: (0.98, 1.02)},
        level_db={0.1: (-0.7, 0.0), 1.0: (-3.0, 0.5), 5.0: (-3.0, 0.5)},
        band_db={0.1: 2.0, 1.0: 10.0},
    ),
    "hardness-3y-gaussian": GridError(
        plastic={0.1: (0.85, 1.2), 1.0: (0.98, 1.02), 5.0: (0.97, 1.05)},
        deflection={0.1: (1.0, 1.015), 1.0: (1.0, 1.02), 5.0: (0.98, 1.02)},
        level_db={0.1: (-0.1, 0.1), 1.0: (-0.3, 0.1), 5.0: (-3.0, 0.5)},
        band_db={0.1: 0.2, 1.0: 1.5},
    ),
    "two-bodies-gaussian": GridError(plastic={0.1: (0.97, 1.1), 1.0: (0.98, 1.02), 5.0: (0.97, 1.03)}),
    "two-bodies-gaussian-10pct": GridError(plastic={0.1: (0.94, 1.0), 1.0: (0.98, 1.02), 5.0: (0.97, 1.03)}),
}

"""How far the numbers of the study's grid (2 um, blended edges) are from those of a fine one, as measured. Depends on nothing.

Measured on the same stretches of the same surfaces, refined without new detail, as `docs/accuracy.md` says. A reading, roughness
or number that is not named here was not measured: verdicts take its grid for exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Range = tuple[float, float]
Ranges = Mapping[float, Mapping[float, Range]]  # by Ra [um] and load [N]


@dataclass(frozen=True)
class GridError:
    """What a fine grid would make of a number of the study's grid, as ranges by Ra [um] and load [N].

    plastic, deflection : factors on plastic area and greatest deflection.
    level_db, line_db, high_db : changes of LAeq, of the greatest line and of the mean height above 5 kHz [dB, 10 lg].
    band_db : greatest change of a third octave from 500 Hz to 4 kHz by Ra [um], either way [dB, 10 lg].
    """

    plastic: Ranges = field(default_factory=dict)
    deflection: Ranges = field(default_factory=dict)
    level_db: Ranges = field(default_factory=dict)
    line_db: Ranges = field(default_factory=dict)
    high_db: Ranges = field(default_factory=dict)
    band_db: Mapping[float, float] = field(default_factory=dict)

    def factor(self, name: str, roughness_um: float, load_n: float) -> Range:
        """Return the range of factors on a number; (1, 1) if not measured."""
        return self._at(name, roughness_um, load_n) or (1.0, 1.0)

    def ratio(self, name: str, over: float, under: float, load_n: float) -> Range:
        """Return the range of factors on the ratio of a number on two roughnesses [um]; it holds 1."""
        a, b = self.factor(name, over, load_n), self.factor(name, under, load_n)
        return min(1.0, a[0] / b[1]), max(1.0, a[1] / b[0])

    def change_db(self, name: str, roughness_um: float, load_n: float) -> Range:
        """Return the range of changes of a level [dB, 10 lg]; (0, 0) if not measured."""
        return self._at(name, roughness_um, load_n) or (0.0, 0.0)

    def shift_db(self, name: str, over: tuple[float, float], under: tuple[float, float], factor: int) -> Range:
        """Return the range of changes [dB] of the difference of levels between two pairs of Ra [um] and load [N]; it holds 0."""
        a, b = self.change_db(name, *over), self.change_db(name, *under)
        return min(0.0, a[0] - b[1]) * factor / 10, max(0.0, a[1] - b[0]) * factor / 10

    def _at(self, name: str, roughness_um: float, load_n: float) -> Range | None:
        """Return the range of both neighbouring loads, or beyond the measured ones of the nearest."""
        ranges: Ranges = getattr(self, name) if name else {}
        loads = ranges.get(roughness_um, {})
        if not loads:
            return None
        around = {
            max((one for one in loads if one <= load_n), default=min(loads)),
            min((one for one in loads if one >= load_n), default=max(loads)),
        }
        return min(loads[one][0] for one in around), max(loads[one][1] for one in around)


NONE = GridError()

# Ranges hold what the finest grid gave with sharp and with blended edges (0.5 um in hardness-3y-exponential at Ra 0.1 and 1 um, else
# 1 um), and what order 1.4 makes of the last two grids. Levels: blended edges only. Third octaves: times 1.6, by that order.
MEASURED = {
    "as-stated": GridError(
        plastic={
            0.1: {5: (1.0, 1.01), 20: (1.0, 1.03), 100: (1.0, 1.02)},
            1.0: {5: (0.99, 1.01), 20: (0.99, 1.0), 100: (1.0, 1.02)},
            5.0: {5: (1.0, 1.01), 20: (1.0, 1.01)},
        },
        deflection={
            0.1: {5: (1.0, 1.004), 20: (1.0, 1.002), 100: (1.0, 1.001)},
            1.0: {5: (0.999, 1.0), 20: (1.0, 1.001), 100: (1.0, 1.002)},
            5.0: {5: (1.0, 1.011), 20: (1.0, 1.002)},
        },
        level_db={0.1: {5: (0.0, 0.1), 20: (0.0, 0.1)}, 1.0: {5: (-1.3, 0.0), 20: (-0.2, 0.0)}, 5.0: {5: (-3.1, 0.0)}},
        line_db={0.1: {5: (0.0, 0.0), 20: (-0.1, 0.0)}, 1.0: {5: (-0.6, 0.0), 20: (0.0, 0.2)}, 5.0: {5: (-0.2, 0.0)}},
        band_db={0.1: 0.1, 1.0: 6.5},
    ),
    "hardness-3y-exponential": GridError(
        plastic={
            0.1: {5: (1.0, 1.58), 20: (1.0, 1.29), 100: (1.0, 1.13)},
            1.0: {5: (1.0, 1.1), 20: (1.0, 1.11), 100: (1.0, 1.11)},
            5.0: {5: (1.0, 1.02), 20: (1.0, 1.04)},
        },
        deflection={
            0.1: {5: (1.0, 1.019), 20: (1.0, 1.008), 100: (1.0, 1.003)},
            1.0: {5: (0.997, 1.004), 20: (0.999, 1.002), 100: (0.999, 1.001)},
            5.0: {5: (0.995, 1.0), 20: (1.0, 1.001)},
        },
        level_db={0.1: {5: (-0.6, 0.0)}, 1.0: {5: (-3.2, 0.0), 20: (-1.8, 0.0)}},
        line_db={0.1: {5: (-0.7, 0.0)}, 1.0: {5: (-0.5, 0.0), 20: (0.0, 0.6)}},
        band_db={0.1: 2.1, 1.0: 11.0},
    ),
    "hardness-3y-gaussian": GridError(
        plastic={
            0.1: {5: (0.81, 1.06), 20: (1.0, 1.13), 100: (1.0, 1.17)},
            1.0: {5: (0.98, 1.01), 20: (0.99, 1.0), 100: (1.0, 1.02)},
        },
        deflection={
            0.1: {5: (1.0, 1.016), 20: (1.0, 1.006), 100: (1.0, 1.002)},
            1.0: {5: (1.0, 1.018), 20: (1.0, 1.006), 100: (1.0, 1.003)},
        },
        level_db={1.0: {5: (-0.3, 0.0)}},
        line_db={1.0: {5: (0.0, 0.1)}},
        band_db={1.0: 1.4},
    ),
    "two-bodies-gaussian": GridError(
        plastic={
            0.1: {5: (0.96, 1.06), 20: (1.0, 1.09), 100: (1.0, 1.1)},
            1.0: {5: (0.99, 1.01), 20: (0.99, 1.01), 100: (1.0, 1.02)},
        }
    ),
    "two-bodies-gaussian-10pct": GridError(plastic={0.1: {5: (0.93, 1.0), 20: (0.98, 1.0)}}),
}

"""Measured errors of the study's grid (2 um, blended edges) against a fine grid.

They were measured on the same stretches of the same surfaces, refined without new detail;
`docs/accuracy.md` describes the method. Readings, roughnesses or numbers without an entry were not
measured, and verdicts take their grid as exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Range = tuple[float, float]
Ranges = Mapping[float, Mapping[float, Range]]  # by Ra [um] and load [N]


@dataclass(frozen=True)
class GridError:
    """Changes of the study's numbers on a fine grid, as ranges by Ra [um] and load [N].

    Parameters
    ----------
    plastic, deflection : ranges. Factors on plastic area and maximum deflection.
    level_db, line_db, high_db : ranges, dB. Changes of LAeq, of the maximum line level and of the
        mean height above 5 kHz (10 lg).
    band_db : mapping from float to float, dB. Maximum change of a third octave from 500 Hz to 4 kHz
        by Ra [um], either way (10 lg).
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
        """Return the range of factors on the ratio of a number on two roughnesses [um]."""
        a, b = self.factor(name, over, load_n), self.factor(name, under, load_n)
        return min(1.0, a[0] / b[1]), max(1.0, a[1] / b[0])

    def change_db(self, name: str, roughness_um: float, load_n: float) -> Range:
        """Return the range of changes of a level [dB, 10 lg]; (0, 0) if not measured."""
        return self._at(name, roughness_um, load_n) or (0.0, 0.0)

    def shift_db(
        self, name: str, over: tuple[float, float], under: tuple[float, float], factor: int
    ) -> Range:
        """Return the range of changes [dB] of a level difference between two cases.

        A case is a pair of Ra [um] and load [N]. The range contains 0.
        """
        a, b = self.change_db(name, *over), self.change_db(name, *under)
        return min(0.0, a[0] - b[1]) * factor / 10, max(0.0, a[1] - b[0]) * factor / 10

    def times(self, factor: float) -> GridError:
        """Return errors that are larger by a factor of 1 or more, with no error inside."""

        def larger(ranges: Ranges, neutral: float) -> Ranges:
            return {
                roughness: {
                    load: (
                        min(neutral, neutral + factor * (low - neutral)),
                        max(neutral, neutral + factor * (high - neutral)),
                    )
                    for load, (low, high) in loads.items()
                }
                for roughness, loads in ranges.items()
            }

        return GridError(
            larger(self.plastic, 1.0),
            larger(self.deflection, 1.0),
            larger(self.level_db, 0.0),
            larger(self.line_db, 0.0),
            larger(self.high_db, 0.0),
            {roughness: factor * db for roughness, db in self.band_db.items()},
        )

    def _at(self, name: str, roughness_um: float, load_n: float) -> Range | None:
        """Return the range over both neighbouring loads, or at the nearest measured load."""
        ranges: Ranges = getattr(self, name) if name else {}
        loads = ranges.get(roughness_um, {})
        if not loads:
            return None
        around = {
            max((load for load in loads if load <= load_n), default=min(loads)),
            min((load for load in loads if load >= load_n), default=max(loads)),
        }
        return min(loads[load][0] for load in around), max(loads[load][1] for load in around)


NONE = GridError()

# Ranges reach from the finest grid, with sharp and blended edges, to the extrapolation of the last
# two grids with order 1.4. The finest grid is 0.5 um in hardness-3y-exponential at Ra 0.1 and 1 um,
# else 1 um. Levels: blended edges only. Third octaves: 1.6 times the change from 2 to 1 um.
MEASURED = {
    "as-stated": GridError(
        plastic={
            0.1: {5: (1.0, 1.01), 20: (1.014, 1.027), 100: (1.006, 1.011)},
            1.0: {5: (0.995, 1.006), 20: (0.993, 0.999), 100: (1.006, 1.013)},
            5.0: {5: (1.0, 1.001), 20: (1.0, 1.002)},
        },
        deflection={
            0.1: {5: (1.002, 1.004), 20: (1.0, 1.002), 100: (1.0, 1.001)},
            1.0: {5: (0.999, 1.0), 20: (1.0, 1.001), 100: (1.0, 1.002)},
            5.0: {5: (1.006, 1.011), 20: (1.0, 1.002)},
        },
        level_db={
            0.01: {20: (-0.03, -0.01), 50: (-0.02, 0.0)},
            0.1: {5: (-0.01, 0.01), 20: (0.02, 0.03)},
            1.0: {5: (-1.3, -0.8), 20: (-0.2, -0.1)},
            5.0: {5: (-3.1, -1.9)},
        },
        line_db={
            0.01: {20: (-0.02, 0.0), 50: (-0.03, -0.01)},
            0.1: {5: (-0.01, 0.0), 20: (-0.09, -0.05)},
            1.0: {5: (-0.6, -0.3), 20: (0.07, 0.13)},
            5.0: {5: (-0.2, -0.1)},
        },
        high_db={0.01: {20: (-0.9, -0.5), 50: (-1.4, -0.8)}},
        band_db={0.1: 0.1, 1.0: 6.5},
    ),
    "hardness-3y-exponential": GridError(
        plastic={
            0.1: {5: (1.43, 1.575), 20: (1.21, 1.282), 100: (1.102, 1.13)},
            1.0: {5: (1.069, 1.091), 20: (1.087, 1.107), 100: (1.087, 1.102)},
            5.0: {5: (1.009, 1.016), 20: (1.019, 1.032)},
        },
        deflection={
            0.1: {5: (1.013, 1.019), 20: (1.006, 1.008), 100: (1.001, 1.003)},
            1.0: {5: (0.997, 1.004), 20: (0.999, 1.002), 100: (0.999, 1.001)},
            5.0: {5: (0.995, 0.997), 20: (1.0, 1.001)},
        },
        level_db={
            0.1: {5: (-0.6, -0.3)},
            1.0: {5: (-3.2, -1.9), 20: (-1.8, -1.0)},
        },
        line_db={
            0.1: {5: (-0.7, -0.4)},
            1.0: {5: (-0.5, -0.2), 20: (0.3, 0.6)},
        },
        band_db={0.1: 2.2, 1.0: 11.5},
    ),
    "hardness-3y-gaussian": GridError(
        plastic={
            0.1: {5: (0.811, 1.055), 20: (1.004, 1.129), 100: (1.061, 1.164)},
            1.0: {5: (0.986, 1.009), 20: (0.993, 0.996), 100: (1.011, 1.02)},
        },
        deflection={
            0.1: {5: (1.009, 1.016), 20: (1.003, 1.006), 100: (1.0, 1.002)},
            1.0: {5: (1.01, 1.018), 20: (1.003, 1.006), 100: (1.001, 1.003)},
        },
        level_db={
            1.0: {5: (-0.3, -0.1)},
        },
        line_db={
            1.0: {5: (0.0, 0.01)},
        },
        band_db={1.0: 1.5},
    ),
    "two-bodies-gaussian": GridError(
        plastic={
            0.1: {5: (0.96, 1.056), 20: (1.004, 1.085), 100: (1.028, 1.097)},
            1.0: {5: (0.994, 1.007), 20: (0.999, 1.003), 100: (1.009, 1.015)},
        },
        deflection={
            0.1: {5: (1.004, 1.008), 20: (1.001, 1.003), 100: (1.0, 1.001)},
            1.0: {5: (1.003, 1.006), 20: (1.001, 1.003), 100: (1.001, 1.002)},
        },
    ),
    "two-bodies-gaussian-10pct": GridError(
        plastic={
            0.1: {5: (0.939, 0.963), 20: (0.984, 0.985)},
        },
        deflection={
            0.1: {5: (1.006, 1.012), 20: (1.003, 1.004)},
        },
    ),
}

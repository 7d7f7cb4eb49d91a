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

# Ranges reach from a grid of 1 um to the extrapolation of 2 and 1 um with order 1.4, with blended
# edges and the sub-cells of `auto` on both grids, over the first 60 to 120 steps of seed 1 (areas
# and deflections at 100 N: 12 steps). Levels follow from the rms of the release, line levels from
# 700 to 2800 Hz, high levels from 5 kHz up, third octaves from the octaves from 700 Hz to 5.6 kHz.
# The ranges of the variations belong to earlier edges; variations are not checked and count for
# nothing.
MEASURED = {
    "as-stated": GridError(
        plastic={
            0.1: {5: (0.9957, 0.9973), 20: (1.001, 1.001), 100: (1.0, 1.0)},
            1.0: {5: (1.0, 1.0), 20: (1.0, 1.0), 100: (1.0, 1.0)},
            5.0: {5: (1.0, 1.0), 20: (1.0, 1.0), 100: (1.0, 1.0)},
        },
        deflection={
            0.1: {5: (1.003, 1.004), 20: (1.001, 1.002), 100: (1.0, 1.0)},
            1.0: {5: (1.001, 1.002), 20: (1.001, 1.001), 100: (1.0, 1.0)},
            5.0: {5: (1.0, 1.001), 20: (1.0, 1.001), 100: (0.9997, 0.9998)},
        },
        level_db={
            0.01: {20: (-0.01, -0.01), 50: (-0.02, -0.01)},
            0.1: {5: (-0.02, -0.01), 20: (0.0, 0.0)},
            1.0: {5: (0.01, 0.02), 20: (0.01, 0.02)},
            5.0: {5: (0.18, 0.29), 20: (0.06, 0.09), 100: (-0.37, -0.23)},
        },
        line_db={
            0.01: {20: (-0.02, -0.01), 50: (-0.02, -0.01)},
            0.1: {5: (0.0, 0.01), 20: (0.0, 0.0)},
            1.0: {5: (0.05, 0.08), 20: (0.02, 0.03)},
            5.0: {5: (0.25, 0.40), 20: (-1.81, -1.12), 100: (-0.14, -0.09)},
        },
        high_db={
            0.01: {20: (0.01, 0.01), 50: (-0.20, -0.13)},
        },
        band_db={0.1: 0.2, 1.0: 0.4},
    ),
    "hardness-3y-exponential": GridError(
        plastic={
            0.1: {5: (1.096, 1.154), 20: (1.075, 1.12), 100: (1.054, 1.086)},
            1.0: {5: (1.008, 1.014), 20: (1.006, 1.009), 100: (1.003, 1.005)},
            5.0: {5: (1.0, 1.001), 20: (1.001, 1.001), 100: (1.0, 1.0)},
        },
        deflection={
            0.1: {5: (0.9961, 0.9976), 20: (0.9986, 0.9991), 100: (0.9997, 0.9998)},
            1.0: {5: (0.9987, 0.9992), 20: (0.9998, 0.9999), 100: (1.0, 1.0)},
            5.0: {5: (1.002, 1.003), 20: (1.0, 1.0), 100: (1.0, 1.0)},
        },
        level_db={
            0.1: {5: (-0.09, -0.06), 20: (-0.11, -0.07)},
            1.0: {5: (-0.02, -0.01), 20: (0.01, 0.01)},
            5.0: {5: (0.01, 0.01), 20: (0.05, 0.08)},
        },
        line_db={
            0.1: {5: (-0.07, -0.04), 20: (-0.11, -0.07)},
            1.0: {5: (0.0, 0.0), 20: (0.0, 0.01)},
            5.0: {5: (0.01, 0.02), 20: (0.02, 0.03)},
        },
        band_db={0.1: 0.4, 1.0: 0.1},
    ),
    "hardness-3y-gaussian": GridError(
        plastic={
            0.1: {5: (1.021, 1.034), 20: (1.04, 1.064), 100: (1.036, 1.058)},
            1.0: {5: (0.9982, 0.9989), 20: (0.999, 0.9994), 100: (0.9995, 0.9997)},
        },
        deflection={
            0.1: {5: (1.003, 1.005), 20: (1.001, 1.002), 100: (1.0, 1.001)},
            1.0: {5: (1.001, 1.002), 20: (1.001, 1.002), 100: (1.0, 1.001)},
        },
        level_db={
            0.1: {5: (-0.01, 0.0), 20: (0.01, 0.02)},
            1.0: {5: (0.03, 0.04), 20: (0.01, 0.01)},
        },
        line_db={
            0.1: {5: (0.01, 0.01), 20: (0.05, 0.09)},
            1.0: {5: (0.03, 0.05), 20: (0.02, 0.03)},
        },
        band_db={0.1: 0.3, 1.0: 0.3},
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

"""Tolerance of the solver that `numerics.tolerance: auto` takes, from the values of a scene alone.

The solver's error of the release over its fluctuation grows with tolerance times deflection over
roughness: a violation of the gap by that length shows in a fluctuation that the roughness makes.
Where a rule knows the error of the grid, the solver may come as near as 10 dB below it. The
constants were chosen on 32 scenes of `tests/benchmarks/tolerance_study.py` and 70 small random
ones, and tested on 28 others (docs/accuracy.md).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rolling.scene.grid_error import grid_signal_db, hertz_radius, law_roughness

if TYPE_CHECKING:
    from rolling.scene.values_in_si import SceneQuantities

USUAL = 1e-4
LEAST = 1e-6
MOST = 1e-3
FILE = 2e-5  # for a height file, whose roughness the scene does not know
SMOOTH = 0.1  # rms roughness over Hertz deflection, below which the usual tolerance falls
BELOW_GRID_DB = 10.0  # the solver's error of the release below the grid's
# On smooth surfaces the rms error of the release over its rms fluctuation is at most so many times
# tolerance times deflection over roughness. The exponential laws have flat cells, which meet the
# sphere as a whole.
RELEASE_FACTOR = 4.0
FLAT_FACTOR = 8.0
# Above the usual tolerance the second difference of the approach decides, which the estimated
# vibration follows. Its rms error is at most 6 % (-25 dB) of its rms where the tolerance times the
# square of the contact radius in steps, with two weaker factors, is at most this number.
APPROACH_LIMIT = 0.1


def automatic_tolerance(scene: SceneQuantities) -> float:
    """Return the tolerance [-] of `auto`, with one digit.

    It is 1e-4, and less in proportion where the rms roughness of plate and sphere together is below
    a tenth of the Hertz deflection. It rises, to 1e-3 at most, where the surface is random alone
    and no pass changes it: there the error of the grid is known by a rule. With dynamics it stays,
    because a resonance may raise a small error of the approach to 0.3 dB of the level.
    """
    if scene.height_paths:
        return FILE
    roughness = math.hypot(*(law.rq_m for law in scene.laws))
    tolerance = max(LEAST, USUAL * min(1.0, roughness / _deflection(scene) / SMOOTH))
    is_quasi_static = scene.dynamics is None and not scene.is_permanent
    if scene.laws and not scene.faults and is_quasi_static:
        tolerance = max(tolerance, _beside_grid(scene))
    digit = 10.0 ** math.floor(math.log10(tolerance) + 1e-9)
    return float(f"{math.floor(tolerance / digit + 1e-9) * digit:.0e}")


def _beside_grid(scene: SceneQuantities) -> float:
    """Return the tolerance that keeps the solver's error below the grid's; 0 without a rule."""
    grid_db = grid_signal_db(scene)
    if grid_db is None:
        return 0.0
    roughness, slope = law_roughness(scene)
    smoothness = _deflection(scene) / roughness
    flat = any(law.goes_on for law in scene.laws)
    factor = FLAT_FACTOR if flat else RELEASE_FACTOR
    of_release = 10 ** ((grid_db - BELOW_GRID_DB) / 20) / (factor * smoothness)
    # Pressures at the hardness do not follow an error of the approach.
    rough_pressure = scene.contact_modulus * slope / math.sqrt(2 * math.pi)
    smooth_pressure = scene.load / (math.pi * hertz_radius(scene) ** 2)
    yielding = max(rough_pressure, smooth_pressure) / scene.hardness
    steps = hertz_radius(scene) / scene.step
    of_approach = APPROACH_LIMIT * (1 + yielding) / (steps**2 * math.sqrt(max(1.0, smoothness)))
    return min(of_release, max(USUAL, of_approach), MOST)


def _deflection(scene: SceneQuantities) -> float:
    """Return the deflection [m] under the middle of the smooth elastic contact."""
    return hertz_radius(scene) ** 2 / math.sqrt(scene.radius * scene.radius_across)

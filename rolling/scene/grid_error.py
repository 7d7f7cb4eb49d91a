"""Error that the grid leaves in the release, estimated from the values of a scene alone.

The rule was fitted to 36 scenes and tested on 24 others (docs/accuracy.md): 60 steps of each were
marched on a grid of 2 um and on a quarter of it. On the others it is off by 3.7 dB rms, and by
10 dB at most.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rolling.surface.refined import auto_subcells

if TYPE_CHECKING:
    from rolling.scene.values_in_si import SceneQuantities

CONSTANT_DB = -7.2
PER_LENGTH_DB = -14.8
PER_AREA_DB = -4.9
# Flat cells, as exponential laws have them; the reference has them as well.
FLAT_DB = -4.4
# Sharp edges add this per decade of slope over the slope that the hardness levels.
SHARP_DB = 27.5
SHARP_FLAT_DB = 5.8
SUBCELLS_DB = -6.0  # per doubling of the sub-cells beyond the number of `auto`
PER_SPACING_DB = -PER_LENGTH_DB - 2 * PER_AREA_DB  # per decade of the spacing

# Generated heights are a little more or less steep than their law.
SLOPE_MARGIN = 1.05


def grid_signal_db(scene: SceneQuantities) -> float | None:
    """Estimate the rms error of the release from the grid over its rms fluctuation [dB].

    The numbers of nodes within rms roughness over slope and within the loaded area decide. None is
    returned for a surface that is not random or has no slope.
    """
    if not scene.laws:
        return None
    rq, slope = law_roughness(scene)
    if not slope > 0:
        return None
    flat = any(law.goes_on for law in scene.laws)
    # A rough elastic contact carries E* slope / sqrt(2 pi) on its loaded area, a smooth one Hertz's
    # mean pressure, and no area more than the hardness.
    rough = scene.contact_modulus * slope / math.sqrt(2 * math.pi)
    smooth = scene.load / (math.pi * hertz_radius(scene) ** 2)
    pressure = min(scene.hardness, max(rough, smooth))
    error = CONSTANT_DB + PER_LENGTH_DB * math.log10(rq / slope / scene.spacing)
    error += PER_AREA_DB * math.log10(scene.load / pressure / scene.spacing**2)
    error += FLAT_DB if flat else 0.0
    if has_sharp_edges(scene):
        sharp = SHARP_DB * math.log10(1 + rough / scene.hardness)
        error += min(SHARP_FLAT_DB, sharp) if flat else sharp
    if has_blended_edges(scene):
        slope_of_heights = SLOPE_MARGIN * slope
        usual = auto_subcells(slope_of_heights, scene.contact_modulus, scene.hardness)
        error += SUBCELLS_DB * math.log2(law_subcells(scene) / usual)
    return error


def hertz_radius(scene: SceneQuantities) -> float:
    """Return the radius [m] of the smooth elastic contact of a sphere of the mean curvature.

    Where the radii along and across differ, it is the geometric mean of the semi-axes
    within 3 %, up to a ratio of 4.
    """
    radius = math.sqrt(scene.radius * scene.radius_across)
    cube = 3 * scene.load * radius / (4 * scene.contact_modulus)
    return float(cube ** (1 / 3))


def law_roughness(scene: SceneQuantities) -> tuple[float, float]:
    """Estimate rms roughness [m] and rms slope [-] from the laws of a scene alone.

    The slope is the norm of the gradient over one spacing. Mean squares of plate and sphere add;
    faults and waves of the circumference are left out, but for the slope of these waves.
    """
    parts = [(law.rq_m, law.rms_slope(scene.spacing_um)) for law in scene.laws]
    roughnesses = [rq for rq, _ in parts]
    slopes = [slope for _, slope in parts]
    ball = scene.sphere.surface
    if ball is not None and ball.waviness:
        slopes += [k * a * 1e-6 / scene.radius / math.sqrt(2) for k, a in ball.waviness.items()]
    return math.hypot(*roughnesses), math.hypot(*slopes)


def law_subcells(scene: SceneQuantities) -> int:
    """Estimate the sub-cells along the side of a cell; a height file counts as gentle."""
    chosen = scene.numerics.subcells
    if chosen != "auto":
        return chosen
    if not has_blended_edges(scene) or scene.height_paths:
        return 1
    _, slope = law_roughness(scene)
    return auto_subcells(SLOPE_MARGIN * slope, scene.contact_modulus, scene.hardness)


def has_blended_edges(scene: SceneQuantities) -> bool:
    """Tell whether the edges of yielding patches are blended."""
    return scene.numerics.edges == "blended" and math.isfinite(scene.hardness)


def has_sharp_edges(scene: SceneQuantities) -> bool:
    """Tell whether yielding patches end with whole cells."""
    return scene.numerics.edges == "sharp" and math.isfinite(scene.hardness)

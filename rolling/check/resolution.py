"""Error that the grid leaves in the release, by a rule, and the spacing that would do.

The rule was fitted to 36 scenes and tested on 24 others (docs/accuracy.md): 60
steps of each were marched on a grid of 2 um and on a quarter of it. On the others it is off by 3.7
dB rms, and by 10 dB at most.
"""

from __future__ import annotations

import math

from rolling.check import cost
from rolling.check.finding import Finding
from rolling.contact import closed_forms
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian, MadeSurface
from rolling.surface import refined

KEY = "resolution"
WANTED_DB = -20.0  # rms error of the release over its rms fluctuation
# The rule warns a little earlier: it then finds every scene above -18 dB.
MARGIN_DB = 1.0
# Blended edges leave third octaves up to 16 kHz within 1 dB at this error (0.7 dB at -31.9 dB).
BANDS_DB = -32.0
CONSTANT_DB, PER_LENGTH_DB, PER_AREA_DB = -7.2, -14.8, -4.9
# Flat cells, as exponential laws have them; the reference has them as well.
FLAT_DB = -4.4
# Sharp edges add this per decade of slope over the slope that the hardness levels.
SHARP_DB = 27.5
SHARP_FLAT_DB = 5.8
SUBCELLS_DB = -6.0  # per doubling of the sub-cells beyond the number of `auto`
PER_SPACING_DB = -PER_LENGTH_DB - 2 * PER_AREA_DB  # per decade of the spacing
MOST_TRIED = 10_000  # numbers of nodes that a search for a spacing of few digits tries


def grid_signal_db(scene: Scene) -> float | None:
    """Estimate the rms error of the release from the grid over its rms fluctuation [dB].

    The numbers of nodes within rms roughness over slope and within the loaded area decide. None is
    returned for a surface that is not random or has no slope.
    """
    if not isinstance(scene.surface, Gaussian):
        return None
    rq, slope = cost.roughness(scene)
    if not slope > 0:
        return None
    flat = scene.surface.autocorrelation.startswith("exponential")
    # A rough elastic contact carries E* slope / sqrt(2 pi) on its loaded area, a smooth one Hertz's
    # mean pressure, and no area more than the hardness.
    rough = scene.contact_modulus * slope / math.sqrt(2 * math.pi)
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    pressure = min(scene.hardness, max(rough, scene.load / (math.pi * radius**2)))
    error = CONSTANT_DB + PER_LENGTH_DB * math.log10(rq / slope / scene.spacing)
    error += PER_AREA_DB * math.log10(scene.load / pressure / scene.spacing**2)
    error += FLAT_DB if flat else 0.0
    if math.isfinite(scene.hardness) and scene.numerics.edges == "sharp":
        sharp = SHARP_DB * math.log10(1 + rough / scene.hardness)
        error += min(SHARP_FLAT_DB, sharp) if flat else sharp
    if cost.has_blended_edges(scene):
        slope_of_heights = cost.SLOPE_MARGIN * slope
        usual = refined.auto_subcells(slope_of_heights, scene.contact_modulus, scene.hardness)
        error += SUBCELLS_DB * math.log2(cost.subcells(scene) / usual)
    return error


def findings(scene: Scene) -> list[Finding]:
    """Judge the spacing of a random surface by the error that it leaves."""
    error = grid_signal_db(scene)
    if error is None:
        return []
    warning = None
    if error > WANTED_DB - MARGIN_DB:
        warning = (
            f"the grid leaves an error of the release of about {error:.0f} dB of its fluctuation"
            f" (rms, by a rule that is off by some 4 dB), {WANTED_DB:g} dB are wanted:"
            f" {advice(scene, error + MARGIN_DB)}"
        )
    value = f"about {error:.0f} dB of the fluctuation"
    if warning is None and error > BANDS_DB and isinstance(scene.surface, MadeSurface):
        value += (
            f"; third octaves within 1 dB up to 16 kHz take {spacing(scene, error, BANDS_DB):g} um"
        )
    return [Finding(KEY, "error of the grid", value, warning)]


def measured(scene: Scene, error: float) -> str | None:
    """Warn of a measured error of the grid [dB]; None where it is small enough."""
    if error <= WANTED_DB:
        return None
    return (
        f"error of the grid: {error:.0f} dB of the release's fluctuation (rms, measured by the"
        f" error estimate), {WANTED_DB:g} dB are wanted: {advice(scene, error)}"
    )


def advice(scene: Scene, error: float) -> str:
    """Name the spacing that brings an error of the grid [dB] down to the wanted error.

    A file cannot choose its spacing: it needs a finer measurement.
    """
    wanted, bands = (spacing(scene, error, goal) for goal in (WANTED_DB, BANDS_DB))
    blended = ""
    if math.isfinite(scene.hardness) and scene.numerics.edges == "sharp":
        blended = "choose numerics.edges: blended, or "
    if not isinstance(scene.surface, MadeSurface):
        return f"{blended}a measurement with a spacing of at most {wanted:g} um is needed"
    return (
        f"{blended}choose a surface.spacing_um of at most {wanted:g}, or {bands:g} for third"
        " octaves within 1 dB up to 16 kHz"
    )


def spacing(scene: Scene, error: float, goal: float) -> float:
    """Return the spacing [um] that brings an error of the grid [dB] down to a goal [dB]."""
    factor = 10 ** ((goal - error) / PER_SPACING_DB)
    return fitting_spacing(scene, scene.surface.spacing_um * factor)


def fitting_spacing(scene: Scene, spacing_um: float) -> float:
    """Return the largest spacing [um] of few digits up to a limit that fits the scene's width."""
    if not isinstance(scene.surface, MadeSurface):
        return float(f"{math.floor(spacing_um * 100) / 100 or spacing_um:.2g}")
    width = scene.surface.width_um
    least = math.ceil(width / spacing_um - 1e-9)
    # Among millions of nodes no spacing of few digits need fit, and the search would take seconds.
    for nodes in range(least, min(2 * least, least + MOST_TRIED)):
        spacing = float(f"{width / nodes:.3g}")
        if abs(width / spacing - nodes) <= 1e-7 * nodes:
            return spacing
    return width / least

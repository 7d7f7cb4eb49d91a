"""Minimum fluctuation of the release that a solution resolves above its own error.

The solver stops at a tolerance, and each release carries an error in proportion to it. A record
whose fluctuation is no more than this error holds no sound of the surface: it counts as silent.
"""

from __future__ import annotations

import math

from rolling.scene.scene import Scene

# This is the rms error of the release over its mean, in tolerances. Smooth spheres that are solved
# anew at every position had 0.2 to 17 (steps of 1/2, 1/3 and 1/4 node, tolerances 1e-3 to 1e-8),
# rough surfaces of Ra 1e-12 to 1e-7 m had 2 to 12 (tolerances 1e-3 to 1e-8).
SOLVER_ERROR = 20.0
DOUBTFUL_DB = 10.0  # above the solver's error, where levels are off by up to 1.5 dB


def resolved_fluctuation(scene: Scene) -> float:
    """Return the relative rms fluctuation of the release below which it is error.

    It counts at all frequencies and is divided by the mean release.

    The error is white along the track: a band holds its share of the mean square.
    """
    return SOLVER_ERROR * scene.numerics.tolerance


def doubt(scene: Scene, audible_rms: float, resolved_rms: float) -> str | None:
    """Write that the solver's error hides a record or nearly does; otherwise return None.

    Parameters
    ----------
    audible_rms : float, W
        Fluctuation of the release power within hearing.
    resolved_rms : float, W
        Error of the solver within hearing.
    """
    tolerance = f"numerics.tolerance, {scene.numerics.tolerance:g} here"
    if scene.surface.kind == "smooth" or not resolved_rms:  # no sound could be hidden
        return None
    if audible_rms <= resolved_rms:
        return (
            f"the release fluctuates by {audible_rms:.2g} W rms within hearing, no more than the"
            f" solver's error of up to {resolved_rms:.2g} W: the record counts as silent; a lower"
            f" {tolerance}, tells whether it is"
        )
    above = 20 * math.log10(audible_rms / resolved_rms)
    if above >= DOUBTFUL_DB:
        return None
    return (
        f"the fluctuation within hearing stands {above:.2g} dB above the solver's error,"
        f" {DOUBTFUL_DB:g} dB are wanted: lower {tolerance}"
    )

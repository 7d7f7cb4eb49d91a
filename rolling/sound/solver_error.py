"""Minimum fluctuation of the release that a solution resolves above its own error.

The solver stops at a tolerance, and each release carries an error in proportion to it. A record
whose fluctuation is no more than this error holds no sound of the surface: it counts as silent.
"""

from __future__ import annotations

import math

from acoustics.numbers import rounded
from rolling.scene.scene import Scene

# This is the rms error of the release over its mean, in tolerances. Smooth spheres that are solved
# anew at every position had 0.2 to 17 (steps of 1/2, 1/3 and 1/4 node, tolerances 1e-3 to 1e-8),
# rough surfaces of Ra 1e-12 to 1e-7 m had 2 to 12 (tolerances 1e-3 to 1e-8).
SOLVER_ERROR = 20.0
DOUBTFUL_DB = 10.0  # above the solver's error, where levels are off by up to 1.5 dB


def resolved_fluctuation(scene: Scene) -> float:
    """Return the rms fluctuation of the release, over its mean, below which it is error.

    It counts at all frequencies. The error is white along the track: a band holds its share of the
    mean square.
    """
    return SOLVER_ERROR * scene.tolerance


def doubt(scene: Scene, audible_rms: float, resolved_rms: float) -> str | None:
    """Return a text that the solver's error hides a record or nearly does; otherwise None.

    The rms values [W] are the fluctuation of the release power within hearing, and the part of it
    that may be the solver's error.
    """
    if scene.is_smooth or not resolved_rms:  # no sound could be hidden
        return None
    error = f"the solver's error of up to {rounded(resolved_rms)} W rms"
    advice = f"lower numerics.tolerance, {rounded(scene.tolerance, 6)} here"
    if audible_rms <= resolved_rms:
        return f"the release fluctuates no more than {error}: the record counts as silent; {advice}"
    above = 20 * math.log10(audible_rms / resolved_rms)
    if above >= DOUBTFUL_DB:
        return None
    return f"the fluctuation within hearing stands {rounded(above)} dB above {error}: {advice}"

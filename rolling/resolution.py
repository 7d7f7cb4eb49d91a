"""Smallest fluctuation of the release that a solve tells from its own error. Depends on scenario and reference.

The solver stops at a tolerance, and each release carries an error in proportion to it. A record whose fluctuation is no more
than this error holds no sound of the surface: it counts as silent.
"""

from __future__ import annotations

from rolling import reference
from rolling.scenario import Scene

# Rms error of the release over its mean, in tolerances. Smooth spheres that are solved anew at every position left 0.2 to 17
# (steps of 1/2, 1/3 and 1/4 node, tolerances 1e-3 to 1e-8), rough surfaces of Ra 1e-12 to 1e-7 m 2 to 12 (1e-3 to 1e-8).
SOLVER_ERROR = 20.0
# Rms over the mean that the restart of every piece leaves where blended edges have not forgotten the cold start, whatever the
# tolerance: up to 2.7e-6 on smooth yielding spheres in steps of whole nodes, 4e-4 in fractions of a node.
RESTART_ERROR = 1e-5
RESTART_ERROR_BELOW_A_NODE = 1e-3


def resolved_fluctuation(scene: Scene) -> float:
    """Return the rms fluctuation of the release over its mean, at all frequencies, below which it is the solver's error.

    The error is white along the track: a band holds its share of the mean square.
    """
    return SOLVER_ERROR * scene.numerics.tolerance + _restart_error(scene)


def _restart_error(scene: Scene) -> float:
    """Return the part that does not depend on the tolerance; none where the smooth contact stays elastic."""
    yields = reference.hertz_pressure(scene.load, scene.radius, scene.contact_modulus) > scene.hardness
    if not yields or scene.numerics.edges != "blended":
        return 0.0
    return RESTART_ERROR if scene.numerics.step_nodes >= 1 else RESTART_ERROR_BELOW_A_NODE

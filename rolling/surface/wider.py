"""Generated surfaces that are wider than a scene's own, with the same asperities in the middle."""

from __future__ import annotations

import numpy as np

from rolling._typing import Array
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.surface import heights as surface


def wider_times(scene: Scene) -> int | None:
    """Return the factor on the width that keeps the sphere's line on its nodes.

    It is 2, or 3 for an odd number of nodes across. It is None for smooth plates, which have no
    width to judge, and for height files, of which nothing is known beyond their edges.
    """
    if not isinstance(scene.surface, Gaussian):
        return None
    return 2 if scene.track.n_across % 2 == 0 else 3


def wider_heights(scene: Scene, times: int) -> Array:
    """Generate the surface of a scene `times` as wide, (along, times across) [m].

    The scene's own white noise lies in the middle, between columns of other noise, and its scale is
    kept. Filtered on the wider period, the asperities in the middle differ from the
    scene's by the influence of its narrower period only.

    Raises
    ------
    SurfaceError
        The filter leaves nothing.
    """
    s, track = scene.surface, scene.track
    assert isinstance(s, Gaussian)
    sides = track.n_across * (times - 1)
    other = np.random.default_rng([s.seed, times]).standard_normal((track.n_along, sides))
    left, right = np.split(other, 2, axis=1)
    own = surface.white_noise((track.n_along, track.n_across), s.seed)
    lengths_um = s.correlation_length_um, s.correlation_length_across_um or s.correlation_length_um
    lengths = (lengths_um[0] * 1e-6, lengths_um[1] * 1e-6)
    narrow, wide = (
        surface.filtered(noise, scene.spacing, lengths, s.autocorrelation)
        for noise in (own, np.hstack([left, own, right]))
    )
    return wide * (s.roughness_ra_um * 1e-6 / float(np.abs(narrow).mean()))

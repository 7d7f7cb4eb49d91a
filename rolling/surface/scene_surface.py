"""Surface of a scene, generated or read, centred and levelled, and a wider one like it.

March, statistics and pictures take the heights from this module. The last surface is kept, because
most runs of a sweep share it, and small ones before it, so that a sweep may alternate between them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian, HeightFile
from rolling.surface import heights as surface
from rolling.surface import levelling
from rolling.surface.heights import Correlation, Statistics
from rolling.surface.levelling import Levelling
from rolling.terminal import progress


@dataclass(frozen=True, eq=False)
class SceneSurface:
    """Heights of a scene and their statistics, each computed when it is first needed."""

    __repr__ = short_repr

    heights: Array  # [m], shape (along, across)
    spacing: float  # [m]
    levelling: Levelling | None = None  # of heights from a file

    @cached_property
    def statistics(self) -> Statistics:
        """Roughness of the heights that are used."""
        with progress.step("roughness of the surface"):
            return surface.statistics(self.heights, self.spacing)

    @cached_property
    def correlations(self) -> tuple[Correlation, Correlation]:
        """Correlation of the heights along and across."""
        return surface.correlation(self.heights, self.spacing, 0), surface.correlation(
            self.heights, self.spacing, 1
        )

    @cached_property
    def form_share(self) -> float:
        """Share of the variance of the heights that a plane and a parabola make up."""
        return levelling.form_share(self.heights)

    @property
    def has_seam(self) -> bool:
        """Tell whether the step from the end of the track to its beginning stands out."""
        return self.levelling is not None and self.levelling.seams[0].stands_out


_MOST_KEPT = 16e6  # bytes of the heights of all surfaces that are kept, apart from the last

_kept: dict[tuple[Any, ...], SceneSurface] = {}  # the oldest first


def scene_surface(scene: Scene) -> SceneSurface:
    """Generate or read the surface of a scene; raise SceneError where that fails."""
    key = identity(scene)
    if key not in _kept:
        try:
            with progress.step(_making(scene)):
                fresh = _make(scene)
        except surface.SurfaceError as error:
            place = "surface.path" if scene.height_path else "surface"
            raise SceneError([f"{place}: {error}"]) from error
        _kept[key] = fresh
        while sum(other.heights.nbytes for other in _kept.values()) > _MOST_KEPT and len(_kept) > 1:
            del _kept[next(iter(_kept))]
    return _kept[key]


def heights(scene: Scene) -> Array:
    """Return the surface heights of a scene [m], shape (along, across)."""
    return scene_surface(scene).heights


def identity(scene: Scene) -> tuple[Any, ...]:
    """Return values that are equal for scenes with the same surface.

    A file that was written again counts as another file.
    """
    track, path = scene.track, scene.height_path
    try:
        stamp = path.stat() if path else None
    except OSError as error:
        raise SceneError(
            [f"surface.path: {path}: not readable ({error.strerror or error})"]
        ) from error
    return (
        scene.surface.model_dump_json(),
        scene.folder,
        track.n_along,
        track.n_across,
        (stamp.st_mtime_ns, stamp.st_size, stamp.st_ino) if stamp else None,
    )


def _making(scene: Scene) -> str:
    """Name the work of `_make` in a few words."""
    if scene.height_path:
        return f"reading the heights of {scene.height_path}"
    return f"making a surface of {scene.track.n_along:,} x {scene.track.n_across:,} nodes"


def _make(scene: Scene) -> SceneSurface:
    """Generate or read the surface of a scene, and level heights from a file."""
    s, spacing = scene.surface, scene.spacing
    if isinstance(s, HeightFile) and scene.height_path:
        read = levelling.read_heights(scene.height_path, s.height_unit, s.n_across)
        heights, plane = levelling.level(read, spacing, s.level)
        return SceneSurface(heights, spacing, plane)
    track = scene.track
    shape = track.n_along, track.n_across
    if isinstance(s, Gaussian):
        heights = surface.gaussian(
            shape, spacing, s.roughness_ra_um * 1e-6, _lengths(s), s.autocorrelation, s.seed
        )
        return SceneSurface(heights, spacing)
    return SceneSurface(surface.smooth(shape), spacing)


def has_detail(scene: Scene) -> bool:
    """Return whether a scene's surface follows a law that goes on below the spacing."""
    s = scene.surface
    return isinstance(s, Gaussian) and surface.has_detail(
        scene.spacing, _lengths(s), s.autocorrelation
    )


def continued_rows(scene: Scene, first: int, rows: int) -> Array:
    """Return rows of a generated surface at half the spacing, with the detail of its law [m]."""
    s, whole = scene.surface, heights(scene)
    assert isinstance(s, Gaussian)
    rq = s.roughness_ra_um * 1e-6 * math.sqrt(math.pi / 2)
    patch = whole[(first + np.arange(rows)) % len(whole)]
    seed = s.seed, first % len(whole), rows
    return surface.continued(patch, scene.spacing, rq, _lengths(s), s.autocorrelation, seed)


def _lengths(s: Gaussian) -> tuple[float, float]:
    """Return the correlation lengths along and across the track [m]."""
    across = s.correlation_length_across_um or s.correlation_length_um
    return s.correlation_length_um * 1e-6, across * 1e-6


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
    narrow, wide = (
        surface.filtered(noise, scene.spacing, _lengths(s), s.autocorrelation)
        for noise in (own, np.hstack([left, own, right]))
    )
    return wide * (s.roughness_ra_um * 1e-6 / float(np.abs(narrow).mean()))

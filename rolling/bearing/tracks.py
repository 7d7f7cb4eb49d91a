"""Tracks: how heights change the approach of a contact around a full turn of a body.

A track is known at some loads. Between them it is linear in s = Q^(2/3), in which a Hertz contact
is a straight line, and beyond them it is constant.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from acoustics import resampling
from acoustics.arrays import Array, short_repr
from rolling.bearing.geometry import BearingGeometry

_POINTS = 4096  # of a track of waves, at least
_POINTS_PER_WAVE = 64
Waves = Mapping[int, float | tuple[float, float]]


@dataclass(frozen=True)
class BodyTrack:
    """Change of a contact's approach around a full turn of a body, at some loads.

    A positive change is a valley: the bodies come closer under that load. A bump of height h in the
    contact is -h.
    """

    __repr__ = short_repr

    loads_n: Array  # (k,) ascending, k >= 1
    approach_m: Array  # (k, n) at n equally spaced angles of the turn

    def __post_init__(self) -> None:
        if np.any(self.loads_n <= 0) or np.any(np.diff(self.loads_n) <= 0):
            raise ValueError("loads of a track: allowed: positive and ascending")
        if self.approach_m.ndim != 2 or len(self.approach_m) != len(self.loads_n):
            raise ValueError(
                f"approach of a track: got the shape {self.approach_m.shape}, allowed: a row for"
                f" each of {len(self.loads_n)} loads"
            )

    @property
    def points(self) -> int:
        """Number of points around the turn."""
        return int(self.approach_m.shape[1])

    def at_loads(self, loads_n: Array) -> Array:
        """Return the approach at other loads [m], (loads, n)."""
        if len(self.loads_n) == 1:
            return np.repeat(self.approach_m, len(loads_n), axis=0)
        nodes = self.loads_n ** (2 / 3)
        wanted = np.clip(np.asarray(loads_n, dtype=float) ** (2 / 3), nodes[0], nodes[-1])
        above = np.clip(np.searchsorted(nodes, wanted), 1, len(nodes) - 1)
        share = (wanted - nodes[above - 1]) / (nodes[above] - nodes[above - 1])
        low = self.approach_m[above - 1]
        high = self.approach_m[above]
        return np.asarray(low + share[:, None] * (high - low))

    def resampled(self, points: int) -> "BodyTrack":
        """Return the track at another number of points; fewer points drop its shortest waves."""
        if points == self.points:
            return self
        rows = [resampling.resample_closed(row, points) for row in self.approach_m]
        return BodyTrack(loads_n=self.loads_n, approach_m=np.array(rows))

    def plus(self, other: "BodyTrack") -> "BodyTrack":
        """Return the sum of two tracks of one body, at all loads of both."""
        points = max(self.points, other.points)
        loads = np.union1d(self.loads_n, other.loads_n)
        own = self.resampled(points).at_loads(loads)
        return BodyTrack(loads_n=loads, approach_m=own + other.resampled(points).at_loads(loads))


@dataclass(frozen=True)
class BearingTracks:
    """Tracks of all bodies of a bearing.

    The track of a ball on the outer raceway is over the same places of its surface as on the inner
    raceway, which it meets half a turn earlier: the motion adds the half turn.
    """

    inner: BodyTrack
    outer: BodyTrack
    balls_on_inner: tuple[BodyTrack, ...]
    balls_on_outer: tuple[BodyTrack, ...]

    def __post_init__(self) -> None:
        if len(self.balls_on_inner) != len(self.balls_on_outer):
            raise ValueError(
                f"tracks of balls: got {len(self.balls_on_inner)} on the inner raceway and"
                f" {len(self.balls_on_outer)} on the outer, allowed: as many"
            )


def smooth_track() -> BodyTrack:
    """Return the track of a smooth and round body."""
    return BodyTrack(loads_n=np.ones(1), approach_m=np.zeros((1, 4)))


def smooth_tracks(geometry: BearingGeometry) -> BearingTracks:
    """Return the tracks of a bearing whose bodies are smooth and round."""
    smooth = smooth_track()
    return BearingTracks(
        inner=smooth,
        outer=smooth,
        balls_on_inner=(smooth,) * geometry.balls,
        balls_on_outer=(smooth,) * geometry.balls,
    )


def wave_track(waves: Waves) -> BodyTrack:
    """Return the track of waves around a body, by their numbers per turn.

    Parameters
    ----------
    waves : dict from int to float, or to a pair of float
        Amplitude A [m] of the waves of each order n, or amplitude and phase [rad]: the heights are
        A cos(n phi + phase).

    Returns
    -------
    BodyTrack
        The same at all loads, because the waves are longer than the contact.
    """
    points = max(_POINTS, _POINTS_PER_WAVE * max(waves, default=1))
    angle = 2 * np.pi * np.arange(points) / points
    height = np.zeros(points)
    for order, wave in waves.items():
        amplitude, phase = wave if isinstance(wave, tuple) else (wave, 0.0)
        height += amplitude * np.cos(order * angle + phase)
    return BodyTrack(loads_n=np.ones(1), approach_m=-height[None])


def with_waves(
    tracks: BearingTracks,
    *,
    inner: Waves | None = None,
    outer: Waves | None = None,
    balls: Mapping[int, Waves] | None = None,
) -> BearingTracks:
    """Return tracks with waves added to raceways, and to balls by their numbers from 0."""
    changed = tracks
    if inner:
        changed = replace(changed, inner=tracks.inner.plus(wave_track(inner)))
    if outer:
        changed = replace(changed, outer=tracks.outer.plus(wave_track(outer)))
    on_inner = list(tracks.balls_on_inner)
    on_outer = list(tracks.balls_on_outer)
    for ball, waves in (balls or {}).items():
        track = wave_track(waves)
        on_inner[ball] = on_inner[ball].plus(track)
        on_outer[ball] = on_outer[ball].plus(track)
    return replace(changed, balls_on_inner=tuple(on_inner), balls_on_outer=tuple(on_outer))

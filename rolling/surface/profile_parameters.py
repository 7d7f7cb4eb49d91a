"""Roughness parameters of profiles along the track by the names of ISO 21920-2.

The settings are those that ISO 21920-3 takes where a drawing says nothing: Ra chooses the nesting
index of the filter, and an evaluation length has five sections. A surface too short for any of them
is evaluated as it is, and its parameters are those of the primary profile. The texts of the
standards were not at hand: the settings, and the share of a hill or dale that counts, are those
that makers of instruments print.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from rolling.surface.gaussian_filter import long_waves
from rolling.surface.parameters import about_mean, without_plane

SECTIONS = 5  # of an evaluation length
MOST_LINES = 64  # across the surface, at equal distances, that are evaluated
COUNTED = 0.1  # of the largest height or depth, from which on a hill or a dale counts
_REACH = 0.5  # nesting index, left out at each end that is no period
_LEAST_NODES = 8  # of a section, or of a profile without sections
_GRADIENT = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60  # over the spacing


@dataclass(frozen=True)
class ProfileClass:
    """Usual settings of a range of roughness.

    up_to_ra_m : float. The largest Ra of the range [m].
    index_m : float. Nesting index of the L-filter, and length of a section [m].
    """

    up_to_ra_m: float
    index_m: float


CLASSES = (
    ProfileClass(up_to_ra_m=0.02e-6, index_m=0.08e-3),
    ProfileClass(up_to_ra_m=0.1e-6, index_m=0.25e-3),
    ProfileClass(up_to_ra_m=2e-6, index_m=0.8e-3),
    ProfileClass(up_to_ra_m=10e-6, index_m=2.5e-3),
    ProfileClass(up_to_ra_m=np.inf, index_m=8e-3),
)
# Unit in SI, and meaning, by the letters behind R or P.
MEANINGS: Mapping[str, tuple[str, str]] = {
    "a": ("m", "arithmetic mean height"),
    "q": ("m", "root mean square height"),
    "sk": ("", "skewness"),
    "ku": ("", "kurtosis"),
    "p": ("m", "mean peak height of the sections"),
    "v": ("m", "mean pit depth of the sections"),
    "z": ("m", "mean maximum height of the sections"),
    "t": ("m", "total height of the evaluation length"),
    "Sm": ("m", "mean spacing of profile elements"),
    "dq": ("", "root mean square gradient"),
}


@dataclass(frozen=True)
class ProfileRoughness:
    """Parameters of profiles, and the settings with which they were found.

    Attributes
    ----------
    letter : str
        R of the roughness profile, P of the primary profile, which no L-filter has passed.
    values : mapping of array (profiles,)
        Parameters in SI by the letters behind R or P, one value for each evaluated profile; NaN
        where one is not defined.
    index_m : float or None, m
        Nesting index of the L-filter, and length of a section; None for a primary profile.
    usual_index_m : float, m
        Nesting index that Ra asks for, of which the surface may be too short.
    evaluation_m : float, m
        Evaluation length.
    sections : int
        Sections of an evaluation length.
    lines : int
        Lines across the surface.
    gaps : int
        Profiles left out, because they have unmeasured nodes.
    """

    letter: str
    values: Mapping[str, Array]
    index_m: float | None
    usual_index_m: float
    evaluation_m: float
    sections: int
    lines: int
    gaps: int

    @property
    def profiles(self) -> int:
        """Number of evaluated profiles."""
        return len(self.values["a"])


def profile_roughness(heights: Array, spacing_m: float, is_periodic: bool) -> ProfileRoughness:
    """Evaluate profiles along the track of a surface.

    Parameters
    ----------
    heights : array (m, n), m
        Heights along and across the track; NaN at unmeasured nodes.
    spacing_m : float, m
        Node spacing along the track.
    is_periodic : bool
        Whether the heights are one period along the track. Otherwise half a nesting index at each
        end is left out behind the filter.

    Returns
    -------
    ProfileRoughness

    References
    ----------
    ISO 21920-2:2021 and ISO 21920-3:2021; ISO 16610-21 for the filter.
    """
    across = heights.shape[1]
    chosen = np.unique(np.linspace(0, across - 1, min(across, MOST_LINES)).round().astype(int))
    lines = about_mean(heights if is_periodic else without_plane(heights))[:, chosen]
    whole = lines[:, ~np.isnan(lines).any(axis=0)]
    ra = float(np.abs(whole - whole.mean(axis=0)).mean()) if whole.size else np.inf
    usual = next(usual.index_m for usual in CLASSES if ra <= usual.up_to_ra_m)
    index = None
    if whole.size:
        index = fitting_index(len(lines) * spacing_m, spacing_m, usual, is_periodic)
    if index is None:
        profiles = (whole - whole.mean(axis=0)).T if whole.size else whole.T
        sections = 1
    else:
        rough = whole - long_waves(whole, spacing_m, index, is_periodic)
        if not is_periodic:
            end = round(_REACH * index / spacing_m)
            rough = rough[end : len(rough) - end]
        profiles = cut(rough, round(SECTIONS * index / spacing_m))
        sections = SECTIONS
    by_profile = [parameters_of(profile, spacing_m, sections) for profile in profiles]
    return ProfileRoughness(
        letter="P" if index is None else "R",
        values={name: np.array([values[name] for values in by_profile]) for name in MEANINGS},
        index_m=index,
        usual_index_m=usual,
        evaluation_m=profiles.shape[1] * spacing_m,
        sections=sections,
        lines=len(chosen),
        gaps=lines.shape[1] - whole.shape[1],
    )


def fitting_index(
    length_m: float, spacing_m: float, usual_m: float, is_periodic: bool
) -> float | None:
    """Return the largest usual nesting index [m], up to one, whose evaluation length fits.

    None where none fits, or where a section would have too few nodes.
    """
    ends = 0.0 if is_periodic else 2 * _REACH
    for usual in reversed(CLASSES):
        needed = (SECTIONS + ends) * usual.index_m
        fits = needed <= length_m * (1 + 1e-9) and usual.index_m >= _LEAST_NODES * spacing_m
        if usual.index_m <= usual_m and fits:
            return usual.index_m
    return None


def cut(lines: Array, nodes: int) -> Array:
    """Cut profiles (m, n) into as many of some nodes as fit along, (profiles, nodes)."""
    fitting = len(lines) // nodes
    return np.concatenate([lines[k * nodes : (k + 1) * nodes].T for k in range(fitting)])


def parameters_of(profile: Array, spacing_m: float, sections: int) -> dict[str, float]:
    """Return the parameters of a profile [m] of one evaluation length, in SI."""
    rms = float(np.sqrt(np.mean(profile**2)))
    shares = profile / rms if rms > 0 else np.full(1, np.nan)
    parts = np.array_split(profile, sections)
    peak = float(np.mean([part.max() for part in parts]))
    pit = 0.0 - float(np.mean([part.min() for part in parts]))
    gradient = np.convolve(profile, _GRADIENT[::-1], mode="valid") / spacing_m
    return {
        "a": float(np.mean(np.abs(profile))),
        "q": rms,
        "sk": float(np.mean(shares**3)),
        "ku": float(np.mean(shares**4)),
        "p": peak,
        "v": pit,
        "z": peak + pit,
        "t": float(profile.max() - profile.min()),
        "Sm": spacing_m * element_spacing(profile),
        "dq": float(np.sqrt(np.mean(gradient**2))) if len(gradient) else np.nan,
    }


def element_spacing(profile: Array) -> float:
    """Return the mean spacing of profile elements [nodes], as the mean of both directions.

    An element is a hill with the dale behind it. Hills and dales count from `COUNTED` of the
    highest and the deepest on. NaN with fewer than two hills.
    """
    forward = _element_spacing(profile)
    backward = _element_spacing(profile[::-1])
    return 0.5 * (forward + backward)


def _element_spacing(profile: Array) -> float:
    """Return the mean spacing of profile elements [nodes] in the direction of the profile."""
    high = COUNTED * max(float(profile.max()), 0.0)
    low = COUNTED * min(float(profile.min()), 0.0)
    if not low < 0 < high:
        return np.nan
    places = np.flatnonzero((profile >= high) | (profile <= low))
    is_hill = profile[places] >= high
    rises = np.flatnonzero(~is_hill[:-1] & is_hill[1:])  # from a dale that counts to such a hill
    if len(rises) < 2:
        return np.nan
    first = _crossing(profile, places[rises[0]], places[rises[0] + 1])
    last = _crossing(profile, places[rises[-1]], places[rises[-1] + 1])
    return (last - first) / (len(rises) - 1)


def _crossing(profile: Array, dale: int, hill: int) -> float:
    """Return the place [nodes] of the last crossing of the mean line between a dale and a hill."""
    below = dale + int(np.flatnonzero(profile[dale : hill + 1] < 0)[-1])
    step = profile[below + 1] - profile[below]
    return below - float(profile[below]) / float(step)

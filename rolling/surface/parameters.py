"""Areal surface parameters by ISO 25178-2 of heights on a grid.

Heights are taken about their mean; form and tilt are to be removed before. A periodic surface goes
on at its edges with its other end; a measured one ends there. Heights that are not finite are
unmeasured and do not count. An undefined parameter, such as the skewness of a flat surface, is NaN.
"""

import tomllib
from collections.abc import Sequence
from importlib.resources import files

import numpy as np

from acoustics.arrays import Array, real_array, truth, within
from acoustics.traps import ignoring_underflow

# Unit in SI and meaning by short name.
_TABLE = files("rolling.surface").joinpath("parameters.toml").read_text(encoding="utf-8")
NAMES: dict[str, tuple[str, str]] = tomllib.loads(_TABLE)
DECAY = 0.2  # of the autocorrelation, the default of ISO 25178-3
CORE = 0.4  # of the material ratio, the section of the core
_ROUNDING = 1e-12  # of the heights with their plane; less is no roughness
_RAYS = 360  # directions of the half-plane
_BLOCK = 64  # samples of a ray at a time, two in each node
_SMOOTHING = np.radians(12.0)  # standard deviation of the smoothed angular spectrum


@ignoring_underflow
def surface_parameters(
    heights: Array, spacing_um: float | Sequence[float], periodic: bool = False
) -> dict[str, float]:
    """Compute the parameters of ISO 25178-2 of heights, with their short names.

    Parameters
    ----------
    heights : array (m, n), m
        Heights along and across the track, without form and tilt; NaN or masked at unmeasured
        points. A profile is an array (m, 1).
    spacing_um : float or pair of float, um
        Node spacing, or the spacings along and across.
    periodic : bool
        Whether the heights are one period of a surface, as made surfaces are. Default: they end at
        their edges, as measurements do.

    Returns
    -------
    parameters : dict
        Sa, Sq, Sp, Sv, Sz, Sal, Sk, Spk, Svk in m; Sdr, Smrk1, Smrk2 in %; Std in degrees from
        along towards across, -90 to 90; Ssk, Sku, Sdq, Str without a unit. NaN: not defined.

    Raises
    ------
    ValueError
        The heights are no array (m, n) with a finite height, or a spacing is not from 1e-15 to
        1e15 um.

    References
    ----------
    ISO 25178-2:2021, clauses 4.2 to 4.5; ISO 25178-3:2012.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> wave = 1e-6 * np.sin(2 * np.pi * np.arange(100) / 100)[:, None] * np.ones(50)
    >>> values = rolling.surface_parameters(wave, spacing_um=2, periodic=True)
    >>> round(values["Sq"] * 1e6, 4), round(values["Sku"], 4), round(values["Std"])
    (0.7071, 1.5, 90)
    """
    pair = spacing_um if isinstance(spacing_um, tuple | list) else (spacing_um, spacing_um)
    if len(pair) != 2:
        raise ValueError(f"spacing_um: got {len(pair)} numbers, allowed: one or a pair")
    steps = [1e-6 * within("spacing_um", step, 1e-15, 1e15) for step in pair]
    periodic = truth("periodic", periodic)
    return parameters(real_array("heights", heights, 2, gaps=True), steps, periodic)


def parameters(
    heights: Array, spacing: float | Sequence[float] | Array, wrap: bool = False
) -> dict[str, float]:
    """Compute all parameters of heights [m] of a spacing [m], periodic if they wrap."""
    z = about_mean(heights)
    steps = np.broadcast_to(spacing, 2)
    values = roughness(z, steps, wrap)
    values |= spatial_parameters(z, steps, wrap)
    values["Sdr"] = developed_area(z, steps, wrap)
    values |= material_parameters(z)
    return {name: values[name] for name in NAMES}


def roughness(
    heights: Array, spacing: float | Sequence[float] | Array, wrap: bool = False
) -> dict[str, float]:
    """Compute Sa, Sq, Sp, Sv, Sz [m], Ssk, Sku and Sdq alone, as `parameters` does."""
    z = about_mean(heights)
    along, across = _squared_slopes(z, np.broadcast_to(spacing, 2), wrap)
    rms = float(np.sqrt(_mean(z**2)))
    shares = z / rms if rms > 0 else np.full(1, np.nan)
    highest = float(np.nanmax(z))
    lowest = float(np.nanmin(z))
    return {
        "Sa": _mean(np.abs(z)),
        "Sq": rms,
        "Ssk": _mean(shares**3),
        "Sku": _mean(shares**4),
        "Sp": highest,
        "Sv": 0.0 - lowest,
        "Sz": highest - lowest,
        "Sdq": float(np.sqrt(_mean(along) + _mean(across))),
    }


def without_plane(heights: Array) -> Array:
    """Return heights [m] less the least-squares plane of the measured nodes."""
    z = about_mean(heights)
    along, across = np.nonzero(~np.isnan(z))
    middle = along.mean(), across.mean()
    terms = np.stack([np.ones(len(along)), along - middle[0], across - middle[1]])
    factors = np.linalg.lstsq(terms @ terms.T, terms @ z[along, across])[0]
    rows = np.arange(z.shape[0]) - middle[0]
    columns = np.arange(z.shape[1]) - middle[1]
    rest = z - factors[0] - np.add.outer(factors[1] * rows, factors[2] * columns)
    if np.nanmax(np.abs(rest)) <= _ROUNDING * np.nanmax(np.abs(z)):
        return np.asarray(0.0 * z)
    return np.asarray(rest)


def about_mean(heights: Array) -> Array:
    """Return heights [m] about their mean, NaN where unmeasured; equal heights become zeros."""
    gaps = ~np.isfinite(heights)
    if gaps.any():
        heights = np.where(gaps, np.nan, heights)
    if np.nanmin(heights) == np.nanmax(heights):
        return np.asarray(heights - np.nanmax(heights))
    return np.asarray(heights - _mean(heights))


def _mean(values: Array) -> float:
    """Return the mean of the values that are no NaN, NaN without any."""
    gaps = np.isnan(values)
    values = values[~gaps] if gaps.any() else values
    return float(values.mean()) if values.size else np.nan


# ---- slopes


def developed_area(z: Array, steps: Array, wrap: bool) -> float:
    """Return Sdr [%] (ISO 25178-2, 4.4), the mean over the two triangles of each cell."""
    along, across = _squared_slopes(z, steps, wrap)
    sides_along = _neighbours(along, 1, wrap)
    sides_across = _neighbours(across, 0, wrap)
    total = 0.0
    for side_along, side_across in zip(sides_along, sides_across, strict=True):
        square = side_along + side_across
        total += _mean(square / (1 + np.sqrt(1 + square)))
    return 50 * total


def _squared_slopes(z: Array, steps: Array, wrap: bool) -> list[Array]:
    """Return the squared slopes between neighbouring heights [m], along and across."""
    slopes = []
    for axis in (0, 1):
        here, beyond = _neighbours(z, axis, wrap)
        slopes.append(((beyond - here) / steps[axis]) ** 2)
    return slopes


def _neighbours(values: Array, axis: int, wrap: bool) -> tuple[Array, Array]:
    """Return values and the next ones along an axis; a single line is next to itself."""
    if wrap or values.shape[axis] == 1:
        return values, np.roll(values, -1, axis)
    lines = np.moveaxis(values, axis, 0)
    return np.moveaxis(lines[:-1], 0, axis), np.moveaxis(lines[1:], 0, axis)


# ---- autocorrelation and lay


def spatial_parameters(z: Array, steps: Array, wrap: bool) -> dict[str, float]:
    """Compute the spatial parameters of ISO 25178-2, 4.3, in m and degrees.

    The aspect ratio is the shortest over the longest distance to the decay on any ray. A ray that
    ends before its decay, at half the surface, counts with its length: Str is then an upper bound.
    """
    if not np.nan_to_num(z).any():
        return {"Sal": np.nan, "Str": np.nan, "Std": np.nan}
    decay, ends = decay_of_rays(autocorrelation(z, wrap), steps, wrap)
    length = float(decay.min()) if np.isfinite(decay).any() else np.nan
    if 1 in z.shape:
        return {"Sal": length, "Str": np.nan, "Std": np.nan}
    ratio = length / float(np.minimum(decay, ends).max())
    return {"Sal": length, "Str": ratio, "Std": _lay(z, steps, wrap)}


def is_upper_bound(heights: Array, spacing: float | Sequence[float] | Array, wrap: bool) -> bool:
    """Tell whether Str is an upper bound: the autocorrelation stays above 0.2 on some ray.

    The lags reach half the surface. Str of a profile or of a flat surface is not defined.
    """
    z = about_mean(heights)
    steps = np.broadcast_to(spacing, 2)
    if 1 in z.shape or not np.nan_to_num(z).any():
        return False
    decay, _ = decay_of_rays(autocorrelation(z, wrap), steps, wrap)
    return bool(np.isinf(decay).any() and np.isfinite(decay).any())


def meanings(str_is_bound: bool) -> dict[str, str]:
    """Return the meaning of each parameter; that of Str says how far the lags reach."""
    words = {name: meaning for name, (_, meaning) in NAMES.items()}
    if str_is_bound:
        words["Str"] += (
            ", an upper bound: in some direction the autocorrelation stays above 0.2 up to half"
            " the surface"
        )
    else:
        words["Str"] += ", of lags up to half the surface"
    return words


def autocorrelation(z: Array, wrap: bool) -> Array:
    """Return the autocorrelation of heights about their mean [m], lag 0 in the middle.

    The lags reach half the surface in each direction. Each is the mean over the pairs of measured
    nodes at that lag.
    """
    from scipy.fft import next_fast_len  # slow to import

    lags = []  # along and across
    counts = []  # nodes of each axis that have a partner at the lag
    size = []  # of the transform
    for n in z.shape:
        if wrap:
            lag = np.arange(n) - n // 2
            count = np.full(len(lag), n)
            padded = n
        else:
            lag = np.arange(2 * (n // 2) + 1) - n // 2
            count = n - np.abs(lag)
            padded = next_fast_len(n + n // 2, real=True)
        lags.append(lag)
        counts.append(count)
        size.append(padded)

    def products(values: Array) -> Array:
        """Return the sum of products at each lag."""
        sums = np.fft.irfft2(np.abs(np.fft.rfft2(values, size)) ** 2, size)
        return np.asarray(sums[np.ix_(lags[0], lags[1])])

    gaps = np.isnan(z)
    pairs = np.outer(counts[0], counts[1])
    if gaps.any():
        pairs = np.round(products((~gaps).astype(float)))
    size_of_all = float(np.nanmax(np.abs(z))) or 1.0  # whose square may vanish
    covariance = products(np.where(gaps, 0.0, z / size_of_all)) / np.maximum(pairs, 1)
    return np.asarray(covariance / covariance[z.shape[0] // 2, z.shape[1] // 2])


def decay_of_rays(
    share: Array, steps: Array, wrap: bool, level: float = DECAY
) -> tuple[Array, Array]:
    """Return the distances [m] at which an autocorrelation falls to a level, and the rays' ends.

    The rays have the angles of `ray_angles`. Without a decay the distance is infinite. The
    autocorrelation is interpolated by cubic splines.
    """
    from scipy import ndimage  # slow to import

    angle = ray_angles()
    half = np.array(share.shape) // 2
    rays = np.array([np.cos(angle), np.sin(angle)]) / steps[:, None]  # nodes of each axis per m
    rays[1, 0] = rays[0, _RAYS // 2] = 0.0  # exactly along an axis
    sample = 0.5 / np.abs(rays).max(axis=0)  # [m]
    reach = np.divide(half[:, None], np.abs(rays), np.full(rays.shape, np.inf), where=rays != 0)
    if wrap:
        longest = max(half * steps)
        mode = "grid-wrap"
    else:
        longest = reach.min(axis=0)
        mode = "mirror"
    count = (longest / sample + 1e-6).astype(int)
    coefficients = ndimage.spline_filter(share, mode=mode)
    decay = np.full(_RAYS, np.inf)
    last = np.ones(_RAYS)
    for first in range(1, count.max() + 1, _BLOCK):
        left = np.flatnonzero(np.isinf(decay) & (count >= first))
        number = first + np.arange(_BLOCK)[:, None]
        places = half[:, None, None] + rays[:, None, left] * (number * sample[left])
        value = ndimage.map_coordinates(coefficients, places, prefilter=False, mode=mode)
        value[number > count[left]] = 1.0
        before = np.vstack([last[left], value])
        last[left] = value[-1]
        column = np.flatnonzero(value.min(axis=0) <= level)
        row = np.argmax(value[:, column] <= level, axis=0)
        high = before[row, column]
        low = value[row, column]
        number = first + row - (level - low) / (high - low)
        decay[left[column]] = number * sample[left[column]]
    return decay, count * sample


def ray_angles() -> Array:
    """Return the angles of the rays [rad], over half a turn from along towards across."""
    return np.pi * np.arange(_RAYS) / _RAYS


def _lay(z: Array, steps: Array, wrap: bool) -> float:
    """Return the direction of the lay [deg], normal to the maximum of the angular spectrum.

    The spectrum by angle is smoothed by a normal distribution. Heights that do not wrap are tapered
    over a tenth of the surface at each edge.
    """
    z = np.nan_to_num(z)
    if not wrap:
        z = z * np.outer(taper(z.shape[0]), taper(z.shape[1]))
    power = np.abs(np.fft.rfft2(z)) ** 2
    power[0, 0] = 0.0
    power[:, 0] /= 2  # both waves of each pair stand in this column
    along = np.fft.fftfreq(z.shape[0], steps[0])
    across = np.fft.rfftfreq(z.shape[1], steps[1])
    power[np.hypot(along[:, None], across) > 0.5 / steps.max()] = 0.0  # alike in all directions
    angle = np.arctan2(across, along[:, None])  # 0 to pi
    bins = np.rint(angle * (_RAYS / np.pi)).astype(int) % _RAYS
    lines = np.fft.rfft(np.bincount(bins.ravel(), power.ravel(), _RAYS))
    lines *= np.exp(-2 * (np.arange(len(lines)) * _SMOOTHING) ** 2)
    normal = 180 * int(np.argmax(np.fft.irfft(lines, _RAYS))) / _RAYS
    if normal == 0:
        return 90.0
    return normal - 90.0


def taper(n: int) -> Array:
    """Return a window of n nodes that rises and falls as a cosine over a tenth of them."""
    edge = np.minimum(np.arange(1, n + 1), np.arange(n, 0, -1)) * 10 / (n + 1)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(edge, 1)))


# ---- material ratio


def material_parameters(z: Array) -> dict[str, float]:
    """Compute the parameters of the material ratio curve (ISO 25178-2, 4.5) in m and %.

    Peaks above the core and dales below it become triangles of the same area.
    """
    descending = np.sort(z[~np.isnan(z)])[::-1]
    top, bottom = core(descending)
    above = float(np.mean(descending > top))
    below = float(np.mean(descending < bottom))
    peaks = np.maximum(descending - top, 0)
    dales = np.maximum(bottom - descending, 0)
    return {
        "Sk": top - bottom,
        "Spk": 2 * float(peaks.mean()) / above if above else 0.0,
        "Svk": 2 * float(dales.mean()) / below if below else 0.0,
        "Smrk1": 100 * above,
        "Smrk2": 100 * (1 - below),
    }


def core(descending: Array) -> tuple[float, float]:
    """Return the heights [m] of the equivalent line at the material ratios 0 and 100 %.

    The secant of least slope over 40 % of the material ratio, the first among equals, finds the
    section of the core, and the equivalent line is the least-squares line of its nodes (ISO
    13565-2). For Gaussian heights Sk is 2.574 Sq.
    """
    count = len(descending)
    width = max(1, round(CORE * count))
    if count == 1:
        return float(descending[0]), float(descending[0])
    drop = descending[:-width] - descending[width:]
    first = int(np.argmax(drop <= drop.min() * (1 + 1e-9)))
    highest = float(descending[first])
    fall = highest - descending[first : first + width + 1]
    ratio = (np.arange(width + 1) - width / 2) / count  # about the middle of the section
    slope = float(ratio @ fall / (ratio @ ratio))
    middle = (first + 0.5 + width / 2) / count
    top = highest - float(fall.mean()) + slope * middle
    return top, top - slope

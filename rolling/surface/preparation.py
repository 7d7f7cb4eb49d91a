"""Preparation of measured heights in the terms and the order of ISO 25178-3.

Outliers become unmeasured points, and these are filled. The S-filter removes short waves, and the
heights are resampled to square nodes. The F-operation removes the form, the L-filter long waves.
Last, the end of each side is led into its beginning, so that the surface is periodic.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.surface import levelling
from rolling.surface.form import has_curved_form, named_form
from rolling.surface.gaussian_filter import robust_smoothed, smoothed
from rolling.surface.heights import SurfaceError
from rolling.surface.markers import Nodes
from rolling.surface.parameters import roughness, without_plane
from rolling.surface.period_grid import SAME, HeightGrid, is_other
from rolling.surface.step_words import filter_words

NAMES = ("Sa", "Sq", "Ssk", "Sku", "Sdq")  # of the roughness before and after a step
NEIGHBOURS = 5  # nodes of each side of the square whose median shows outliers
ROBUST = 1.4826  # standard deviation of Gaussian numbers over the median of their magnitudes
MAX_UNMEASURED = 0.5  # share of the nodes that may be filled
_MIN_CORRELATION = -0.5  # of blended sides; weights grow without bound towards -1


@dataclass(frozen=True)
class Effect:
    """Step of the preparation, and roughness of the measured points before and after it."""

    step: str
    text: str  # the step in words, with the roughness
    before: dict[str, float]  # Sa, Sq [m], Ssk, Sku, Sdq [-]
    after: dict[str, float]
    warning: str | None = None


@dataclass(frozen=True, kw_only=True)
class PreparationSteps:
    """Steps of the preparation.

    Attributes
    ----------
    outliers : float or None
        Threshold beyond which a node counts as unmeasured, as for `without_outliers`.
    fills_unmeasured : bool
        Whether unmeasured points are expected, and filled.
    s_filter_m, l_filter_m : float or None, m
        Nesting indices of the S-filter and the L-filter.
    l_filter_is_robust : bool
        Whether the L-filter is the robust Gaussian one.
    form : str
        Form that is removed, by the values of the key `surface.level`.
    closing : str
        How the heights become one period: "blend", "mirror", or "none" for heights that are one.
    is_profile : bool
        Whether the heights are a line along the track, repeated across.
    """

    outliers: float | None = None
    fills_unmeasured: bool = False
    s_filter_m: float | None = None
    l_filter_m: float | None = None
    l_filter_is_robust: bool = False
    form: str = "auto"
    closing: str = "none"
    is_profile: bool = False


class Preparation:
    """Heights [m] and their spacings [m] on the way to a period, with the steps that were taken."""

    def __init__(self, heights: Array, steps: tuple[float, float], watched: bool) -> None:
        self.heights = heights
        self.steps = steps
        self.effects: list[Effect] = []
        self.roughness = known_roughness(heights, steps) if watched else None

    def replace_heights(
        self, heights: Array, step: str, text: str, warning: str | None = None
    ) -> None:
        """Replace the heights by those after a step, and note its effect."""
        self.heights = heights
        before = self.roughness
        if before is None:
            return
        after = known_roughness(heights, self.steps)
        effect = Effect(
            step=step,
            text=f"{text}; {_change_of_roughness(before, after)}",
            before=before,
            after=after,
            warning=warning,
        )
        self.effects.append(effect)
        self.roughness = after


def prepare(
    heights: Array, steps: PreparationSteps, grid: HeightGrid, marked: Nodes | None = None
) -> tuple[Array, levelling.Levelling, list[Effect]]:
    """Prepare heights [m] about their mean by some steps.

    Nodes that hold marks of unmeasured points are outliers, if these are asked for.

    Returns
    -------
    heights : array, m
        One period, with the nodes of the grid.
    levelling : Levelling
        Plane of the heights, and the seam of the period.
    effects : list of Effect
        Steps that were taken.
    """
    work, plane = _scale_limited(heights, steps, grid, marked)
    if steps.closing != "none":
        _close(work, steps, grid)
    if work.effects:
        seams = (levelling.seam(work.heights, 0), levelling.seam(work.heights, 1))
        plane = replace(plane, seams=seams)
    return np.ascontiguousarray(work.heights), plane, work.effects


def scale_limited(
    heights: Array, steps: PreparationSteps, grid: HeightGrid, marked: Nodes | None = None
) -> tuple[Array, list[Effect]]:
    """Prepare heights [m] as `prepare` does, and leave their nodes and their ends as they are.

    This is the scale-limited surface of ISO 25178-2, whose parameters a measurement has. A profile
    is one column.
    """
    work, _ = _scale_limited(heights, steps, grid, marked, keeps_nodes=True)
    prepared = work.heights[:, :1] if steps.is_profile else work.heights
    return np.ascontiguousarray(prepared), work.effects


def _scale_limited(
    heights: Array,
    steps: PreparationSteps,
    grid: HeightGrid,
    marked: Nodes | None,
    keeps_nodes: bool = False,
) -> tuple[Preparation, levelling.Levelling]:
    """Take all steps but the last one, which makes a period of a measurement.

    The nodes become square unless they are kept, and the levelling has slopes of square nodes.
    """
    is_period = steps.closing == "none"
    if steps.is_profile:
        heights = np.repeat(heights, grid.resampled[1], axis=1)
        marked = None if marked is None else np.repeat(marked, grid.resampled[1], axis=1)
    is_resampled = is_other(grid.steps, grid.spacing) and not keeps_nodes
    watched = (
        bool(steps.outliers)
        or bool(steps.s_filter_m)
        or bool(steps.l_filter_m)
        or steps.fills_unmeasured
        or steps.form not in ("auto", "plane", "none")
        or not is_period
        or is_resampled
    )
    work = Preparation(heights, grid.steps, watched)
    if steps.outliers:
        _remove_outliers(work, steps.outliers, marked)
    form = _form_beneath(work, steps.form)
    _fill_unmeasured(work, form)
    if steps.s_filter_m:
        long = form + smoothed(work.heights - form, work.steps, steps.s_filter_m, is_period)
        text = f"{filter_words(steps.s_filter_m)}, shorter waves removed"
        work.replace_heights(long, "s_filter", text)
    if is_resampled:
        _resample(work, steps.s_filter_m or 0.0, grid, is_period)
    mode = steps.form
    if mode == "auto" and not is_period:
        mode = "plane"
    heights, plane = levelling.level(work.heights, work.steps, mode)
    if plane.form:
        work.replace_heights(heights, "f_operator", plane.form)
    elif any(plane.taken):
        work.replace_heights(heights, "f_operator", "plane")
    if steps.l_filter_m:
        long_waves = robust_smoothed if steps.l_filter_is_robust else smoothed
        long = long_waves(work.heights, work.steps, steps.l_filter_m, is_period)
        filtered = filter_words(steps.l_filter_m, steps.l_filter_is_robust)
        text = f"{filtered}, longer waves removed"
        work.replace_heights(work.heights - long, "l_filter", text)
    return work, plane


def _remove_outliers(work: Preparation, threshold: float, marked: Nodes | None) -> None:
    """Make outliers unmeasured points, and nodes that hold marks of unmeasured points too."""
    heights, count = without_outliers(work.heights, threshold)
    text = f"{count} of {heights.size} nodes, at a threshold of {threshold:g}"
    # In patches, marks are no outliers among their neighbours.
    if marked is not None and not np.isnan(heights[marked]).all():
        heights, count = without_outliers(np.where(marked, np.nan, work.heights), threshold)
        marks = int(np.count_nonzero(marked))
        text = (
            f"{count + marks} of {heights.size} nodes, of which {marks} hold a mark of"
            f" unmeasured points, at a threshold of {threshold:g}"
        )
    work.replace_heights(heights, "outliers", text)


def _form_beneath(work: Preparation, level: str) -> Array | float:
    """Return the form [m] about which gaps are filled and short waves removed; 0 for a plane.

    A harmonic filling is flat under a curved form, and weights at the ends see only one side of it.
    """
    if not has_curved_form(level):
        return 0.0
    heights = work.heights - np.nanmean(work.heights)
    return named_form(heights, work.steps, level)[0]


def _fill_unmeasured(work: Preparation, form: Array | float) -> None:
    """Fill the unmeasured points about a form, if there are any."""
    count = int(np.count_nonzero(np.isnan(work.heights)))
    if not count:
        return
    share = rounded(100 * count / work.heights.size)
    work.replace_heights(
        form + filled(work.heights - form), "unmeasured", f"{count} filled, {share} % of the nodes"
    )


def _resample(work: Preparation, s_filter_m: float, grid: HeightGrid, is_period: bool) -> None:
    """Resample to square nodes; warn where they are coarser and no S-filter precedes."""
    sides = " x ".join(f"{1e6 * step:.4g}" for step in grid.steps)
    least_um = 2e6 * grid.spacing
    warning = None
    if grid.spacing > min(grid.steps) and 1e6 * s_filter_m < least_um * (1 - SAME):
        warning = (
            "waves below two nodes fold onto longer ones: choose a surface.s_filter_um of"
            f" at least {least_um:.4g}"
        )
    work.steps = (grid.spacing, grid.spacing)
    text = f"from {sides} um to {1e6 * grid.spacing:.4g} um"
    work.replace_heights(resampled(work.heights, grid, is_period), "resampling", text, warning)


def _close(work: Preparation, steps: PreparationSteps, grid: HeightGrid) -> None:
    """Lead the end of each side into its beginning; a profile has no end across."""
    heights = work.heights - work.heights.mean()
    if steps.closing == "blend":
        heights, text = blended(heights, grid.overlap, grid.spacing)
        work.replace_heights(heights, "periodic", text)
        return
    axes = (0,) if steps.is_profile else (0, 1)
    warning = "the second half is the first backwards: it sounds palindromic"
    work.replace_heights(mirrored(heights, axes), "periodic", "mirrored", warning)


def known_roughness(heights: Array, steps: Sequence[float]) -> dict[str, float]:
    """Return Sa, Sq [m], Ssk, Sku and Sdq of the measured points, but for undefined ones."""
    numbers = roughness(heights, steps)
    return {name: numbers[name] for name in NAMES if not np.isnan(numbers[name])}


def _change_of_roughness(before: dict[str, float], after: dict[str, float]) -> str:
    """Write the roughness before and after a step, lengths in um."""
    texts = []
    for name in before:
        if name not in after:
            continue
        scale = 1.0
        unit = ""
        if name in ("Sa", "Sq"):
            scale = 1e6
            unit = " um"
        first = rounded(scale * before[name], 3)
        last = rounded(scale * after[name], 3)
        texts.append(f"{name} {first} -> {last}{unit}")
    return ", ".join(texts)


# ---- points


def without_outliers(heights: Array, threshold: float) -> tuple[Array, int]:
    """Replace outliers by NaN: nodes unlike the median of their neighbours; return their count.

    The threshold is in robust standard deviations of the heights about their plane.
    """
    from scipy import ndimage

    gaps = np.isnan(heights)
    z = heights
    if gaps.any():  # the median takes the nearest measured node for an unmeasured one
        nearest = ndimage.distance_transform_edt(gaps, return_distances=False, return_indices=True)
        z = heights[tuple(nearest)]
    edge = NEIGHBOURS // 2  # beyond which slopes go on
    wide = np.pad(z, edge, mode="reflect", reflect_type="odd")
    median = ndimage.median_filter(wide, NEIGHBOURS)[edge:-edge, edge:-edge]
    level = without_plane(z)
    size = ROBUST * np.median(np.abs(level - np.median(level))) or np.std(level)
    outliers = np.abs(heights - median) > threshold * size  # NaN is not above it
    return np.where(outliers, np.nan, heights), int(np.count_nonzero(outliers))


def filled(heights: Array) -> Array:
    """Fill the NaN of heights by the equation of Laplace, with measured nodes as its boundary.

    At the edges the normal slope is zero, of a period too: a file that counts as a period may be
    tilted, and its other end then lies at another height. Raise SurfaceError where more than half
    of the nodes are unmeasured.
    """
    from scipy import sparse
    from scipy.sparse import linalg

    gaps = np.isnan(heights)
    count = int(np.count_nonzero(gaps))
    if count > MAX_UNMEASURED * heights.size:
        share = f"{rounded(100 * count / heights.size)} % of the nodes are unmeasured"
        raise SurfaceError(f"{share}, allowed: up to {100 * MAX_UNMEASURED:.0f} %")
    number = np.full(heights.shape, -1)
    number[gaps] = np.arange(count)
    along, across = np.nonzero(gaps)
    # Beyond an edge a node is its own neighbour, whose part cancels.
    numbers = np.pad(number, 1, "edge")
    z = np.pad(heights, 1, "edge")
    places = [(along + i, across + j) for i, j in ((2, 1), (0, 1), (1, 2), (1, 0))]
    known = np.nansum([z[place] for place in places], axis=0)
    neighbours = np.concatenate([numbers[place] for place in places])
    unknown = np.flatnonzero(neighbours >= 0)
    rows = unknown % count
    columns = neighbours[unknown]
    links = sparse.coo_array((np.ones(len(unknown)), (rows, columns)), shape=(count, count))
    laplace = 4 * sparse.eye_array(count) - links
    symmetric = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    factors = linalg.splu(laplace.tocsc(), "MMD_AT_PLUS_A", **symmetric)
    result = heights.copy()
    result[gaps] = factors.solve(known)
    return result


# ---- nodes


def resampled(heights: Array, grid: HeightGrid, wraps: bool) -> Array:
    """Return heights at the square nodes of a grid, by cubic splines along each axis.

    The splines of a period are periodic, and its nodes divide it into equal parts.
    """
    from scipy import interpolate

    for axis, (step, count) in enumerate(zip(grid.steps, grid.resampled, strict=True)):
        n = heights.shape[axis]
        if n == count and (wraps or abs(step / grid.spacing - 1) <= 1e-12):
            continue
        if wraps:
            z = np.take(heights, range(n + 1), axis, mode="wrap")
            spline = interpolate.CubicSpline(np.arange(n + 1), z, axis, "periodic")
            heights = spline(np.arange(count) * (n / count))
        else:
            own = np.arange(n) * step
            places = np.minimum(np.arange(count) * grid.spacing, own[-1])
            heights = interpolate.make_interp_spline(own, heights, axis=axis)(places)
    return np.asarray(heights)


# ---- period


def blended(heights: Array, overlap: Sequence[int], spacing: float) -> tuple[Array, str]:
    """Blend the last nodes of each side of heights about zero into the first; describe the blend.

    The weights are cosine and sine over a quarter of a turn, scaled by the correlation r of both
    parts, so that the variance c^2 + s^2 + 2 r c s stays.
    """
    words = []
    for axis, count in enumerate(overlap):
        if not count:
            continue
        z = np.moveaxis(heights, axis, 0)
        first = z[:count]
        last = z[-count:]
        size = np.sqrt(np.mean(first**2) * np.mean(last**2)) or 1.0
        r = np.clip(np.mean(first * last) / size, _MIN_CORRELATION, 1.0)
        turn = np.pi / 2 * (np.arange(count) + 0.5) / count
        c = np.cos(turn)[:, None]
        s = np.sin(turn)[:, None]
        zone = (c * last + s * first) / np.sqrt(1 + 2 * r * c * s)
        rest = z[count:-count]
        joined = np.concatenate([zone, rest])
        slopes = np.square(np.diff(joined, axis=0, append=joined[:1]) / spacing).mean(axis=1)
        ends = np.append(slopes[:count], slopes[-1])
        direction = "along" if axis == 0 else "across"
        words.append(
            f"{count * spacing * 1e6:.4g} um blended {direction}"
            f" (Sq {_rms_text(np.square(zone).mean(axis=1), 1e6)} um there,"
            f" {_rms_text(np.square(rest).mean(axis=1), 1e6)} um elsewhere;"
            f" rms slope {_rms_text(ends)}, {_rms_text(slopes[count:-1])})"
        )
        heights = np.moveaxis(joined, 0, axis)
    return heights, ", ".join(words)


def _rms_text(squares: Array, scale: float = 1.0) -> str:
    """Write the root of the mean of squares, times a scale; a dash without any."""
    if not squares.size:
        return "-"
    return f"{scale * np.sqrt(squares.mean()):.3g}"


def mirrored(heights: Array, axes: Sequence[int]) -> Array:
    """Continue heights backwards along some axes; the ends are not doubled."""
    pads = [(0, 0), (0, 0)]
    for axis in axes:
        pads[axis] = (0, heights.shape[axis] - 2)
    return np.pad(heights, pads, mode="reflect")

"""A file of heights as a person describes it, and the section of a scene that rolls over it.

The chain of the preparation is decided from the heights, each step with its reason, and stands in
that section. The heights are prepared by the section itself, so the numbers that are printed of a
file are those of a scene with the line.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.in_si import measured
from rolling.in_si.chosen_filters import StatedLimits, chosen_filters, direction_words, sight_words
from rolling.in_si.in_metres import HIGHEST, LARGEST_RA
from rolling.in_si.offered_lines import PROFILE_NODES, Offer, line
from rolling.in_si.plate_file import ScaleLimited, prepared_file, scale_limited_file
from rolling.scene import height_grid
from rolling.scene.height_files import is_instrument, is_period, takes_units
from rolling.scene.height_format import UNITS, HeightFormatError
from rolling.scene.messages import TABLES, SceneError
from rolling.scene.surfaces import HeightFile, Instrument
from rolling.surface import markers, preparation
from rolling.surface.chosen_form import chosen_form
from rolling.surface.parameters import without_plane
from rolling.surface.period_grid import SAME
from rolling.terminal.whole_files import FolderError


@dataclass(frozen=True)
class FileOptions:
    """How a file is to be read, by the keys of `HeightFile`; None where the default holds."""

    spacing_um: float | None = None
    channel: str | None = None
    height_unit: str | None = None
    xy_unit: str | None = None
    along: str | None = None
    tip_radius_um: float | None = None
    sampling_um: float | None = None
    noise_nm: float | None = None
    l_filter_um: float | None = None


@dataclass(frozen=True)
class ChainStep:
    """A step of the preparation of a file.

    name : str. The step in words.
    reason : str. Why it is taken.
    effect : str. What it did, with the roughness before and after; empty where nothing changed.
    """

    name: str
    reason: str
    effect: str = ""


@dataclass(frozen=True)
class DescribedFile:
    """Measured heights as a scene prepares them, but for their ends.

    Where no scene takes the file they are less their plane only.

    heights : (along, across) array, m. NaN where they are not measured. A profile lies along.
    steps : (2,) array, m. Spacings along and across.
    doubts : list of str. A sentence for each doubt about the file.
    keys : dict. Keys of the section `surface` of a scene that rolls over the file.
    taken : str. What of a text was taken for what; empty for other files.
    chain : list of ChainStep. The preparation; empty where no scene takes the file.
    measured_heights : (along, across) array, m. The heights before, NaN where not measured.
    measured_steps : (2,) array, m. Their spacings.
    sight : str. What the instrument sees; empty where there is nothing to say.
    """

    heights: Array
    steps: Array
    doubts: list[str]
    keys: dict[str, Any]
    taken: str
    chain: list[ChainStep]
    measured_heights: Array
    measured_steps: Array
    sight: str = ""


def described_file(path: Path, options: FileOptions) -> DescribedFile:
    """Read measured heights and prepare them by a chain that is decided from them.

    Marks of missing points are taken where they lie far beyond all heights, and are doubted else.

    Raises
    ------
    FolderError : the heights cannot be used, or an option does not go with the file.
    """
    read = _read(path, options)
    suspects = markers.suspected(read.numbers, read.unit)
    is_marked = bool(suspects) and markers.are_certain(read.numbers, suspects)
    doubts = measured.doubts(path, read, "--xy-unit", "--height-unit")
    if suspects:
        doubts.append(markers.sentence(suspects, "file" if is_marked else "possible"))
    marks = suspects if is_marked else ()
    heights = markers.without(read.numbers, marks) * UNITS[read.unit]
    _refuse_unusable(path, heights, doubts)
    _ask_for_unit(path, read, options)
    if is_marked:
        heights, _ = preparation.without_outliers(heights, markers.OUTLIERS)
    level = without_plane(heights)
    if np.nanmean(np.abs(level)) > LARGEST_RA:
        option = "" if is_instrument(path) else "--height-unit: "
        text = f"Ra would be more than {LARGEST_RA:g} m"
        raise FolderError(f"{path}: {option}{'; '.join([text, *doubts])}")
    steps = np.array(read.spacing_m)
    is_profile = 1 in level.shape
    if len(level) == 1 or (options.along == "x" and not is_profile):
        heights = heights.T
        level = np.ascontiguousarray(level.T)
        steps = steps[::-1]
    gaps = int(np.count_nonzero(np.isnan(level)))
    keys = _keys(path, options, is_marked, has_gaps=gaps > 0)
    if is_profile:
        keys["width_um"] = float(f"{PROFILE_NODES * 1e6 * steps[0]:.10g}")
    _refuse_index(path, options, level.shape, steps)
    form = chosen_form(heights, (float(steps[0]), float(steps[1])))
    if form.level != "plane":
        keys["level"] = form.level
    described = DescribedFile(
        heights=level,
        steps=steps,
        doubts=doubts,
        keys=keys,
        taken=read.taken,
        chain=[],
        measured_heights=heights,
        measured_steps=steps,
    )
    try:
        unfiltered = scale_limited_file(path, HeightFile(**keys))
        filters = chosen_filters(
            unfiltered.heights, unfiltered.steps, limits_of(options), ~np.isnan(level)
        )
        prepared = unfiltered
        if filters.keys:
            keys |= filters.keys
            prepared = scale_limited_file(path, HeightFile(**keys))
    except (SceneError, ValueError):  # the offered line says why
        seen = sight_words(level, (float(steps[0]), float(steps[1])), limits_of(options).instrument)
        return replace(described, sight=seen)
    reasons = filters.reasons | {
        "outliers": markers.sentence(suspects, "reason") if is_marked else "",
        "unmeasured": "a ball cannot roll over nothing",
        "f_operator": form.reason,
    }
    return replace(
        described,
        heights=prepared.heights,
        steps=np.array(prepared.steps),
        sight=sight_words(unfiltered.heights, unfiltered.steps, limits_of(options).instrument),
        chain=[
            *_chain(prepared, reasons, options.along or "y"),
            ChainStep("period", "its ends are blended for the ball, as the scan has edges"),
        ],
    )


def limits_of(options: FileOptions) -> StatedLimits:
    """Return what is stated of the instrument, and the nesting index that is asked for."""
    stated = {
        "tip_radius_um": options.tip_radius_um,
        "sampling_um": options.sampling_um,
        "noise_nm": options.noise_nm,
    }
    stated = {name: value for name, value in stated.items() if value is not None}
    return StatedLimits(
        instrument=Instrument(**stated) if stated else None, l_filter_um=options.l_filter_um
    )


_ORDER = ("outliers", "unmeasured", "s_filter", "f_operator", "l_filter")  # of ISO 25178-3


def scene_chain(prepared: ScaleLimited, surface: HeightFile) -> list[ChainStep]:
    """Return the steps that a scene asks for, in their order, with the lay."""
    reasons = dict.fromkeys(_ORDER, "by the scene")
    return _chain(prepared, reasons, surface.along or "y")


def _chain(prepared: ScaleLimited, reasons: dict[str, str], axis: str) -> list[ChainStep]:
    """Return the steps of a preparation in their order, those that are left out with a reason."""
    effects = {effect.step: effect.text for effect in prepared.effects}
    chain: list[ChainStep] = []
    for step in _ORDER:
        if step in effects or step in ("s_filter", "l_filter"):
            chain.append(
                ChainStep(
                    name=TABLES["steps"].get(step, step),
                    reason=reasons.get(step, ""),
                    effect=effects.get(step, "none"),
                )
            )
    along, across = prepared.steps
    if prepared.heights.shape[1] > 1:
        chain.append(
            ChainStep("direction", direction_words(prepared.heights, prepared.steps, axis))
        )
        if abs(across / along - 1) > SAME:
            words = "to square nodes for the ball, at the finer spacing"
            chain.append(ChainStep("resampling", words))
    return chain


def _read(path: Path, options: FileOptions) -> height_grid.Measured:
    """Read a file whose spacing it holds or an option gives; refuse both and neither."""
    if options.xy_unit is not None and not takes_units(path):
        raise FolderError(f"{path}: --xy-unit: only goes with a text such as .csv or .xyz")
    try:
        read = height_grid.read(path, options.channel, options.height_unit, options.xy_unit)
    except HeightFormatError as error:
        words = error.of(path).replace("the key xy_unit says", "--xy-unit says")
        raise FolderError(words) from error
    if read.spacing_m is None:
        if options.spacing_um is None:
            raise FolderError(f"{path}: --spacing-um: missing; {_lacking(read, options)}")
        step = 1e-6 * options.spacing_um
        return replace(read, spacing_m=(step, step))
    if options.spacing_um is not None:
        raise FolderError(f"{path}: --spacing-um: the file holds its own spacing")
    return read


def _lacking(read: height_grid.Measured, options: FileOptions) -> str:
    """Write what a file without a spacing lacks, and what a text was taken for."""
    words = "the file holds no spacing"
    if options.height_unit is None and not read.names_unit:
        words += ", nor a unit of its heights, which --height-unit gives (default: m)"
    return f"{words} (taken for {read.taken})" if read.taken else words


def _ask_for_unit(path: Path, read: height_grid.Measured, options: FileOptions) -> None:
    """Raise FolderError for a text without a unit whose heights cannot be metres.

    Several units may fit, so that only a person can tell.
    """
    if options.height_unit is not None or read.names_unit or not takes_units(path):
        return
    steepest = measured.steepness(read)
    if steepest <= measured.STEEP or (read.xy_unit and not read.names_xy_unit):
        return
    likely = [name for name, size in UNITS.items() if steepest * size <= measured.STEEP]
    choice = " or ".join(likely)
    raise FolderError(
        f"{path}: --height-unit: missing; the file names no unit of its heights, and in m half of"
        f" the neighbours were steeper than {rounded(steepest, 2)}: give --height-unit {choice}"
        f" (taken for {read.taken})"
    )


def _refuse_unusable(path: Path, heights: Array, doubts: list[str]) -> None:
    """Raise FolderError where a file holds no heights, or heights beyond all surfaces."""
    hint = "".join(f"; {sentence}" for sentence in doubts)
    sizes = np.abs(heights[np.isfinite(heights)])
    if not sizes.size:
        raise FolderError(f"{path}: holds no heights{hint}")
    if sizes.max() > HIGHEST:
        raise FolderError(f"{path}: holds heights above {HIGHEST:g} m{hint}")


def _refuse_index(path: Path, options: FileOptions, shape: tuple[int, ...], steps: Array) -> None:
    """Raise FolderError for a nesting index of the L-filter that the file has no room for."""
    index_um = options.l_filter_um
    if index_um is None:
        return
    nodes_um = [1e6 * float(step) for step, count in zip(steps, shape, strict=True) if count > 1]
    sides_um = [1e6 * count * step for count, step in zip(shape, steps, strict=True) if count > 1]
    least = 2 * max(nodes_um, default=0.0)
    most = min(sides_um, default=0.0)
    if not least <= index_um <= most:
        raise FolderError(
            f"{path}: --l-filter-um: got {index_um:g}, allowed: {rounded(least, 4)}, two nodes, to"
            f" {rounded(most, 4)}, the shorter side"
        )


def _keys(path: Path, options: FileOptions, has_marks: bool, has_gaps: bool) -> dict[str, Any]:
    """Return the keys of the section `surface` that read a file as it was described."""
    keys: dict[str, Any] = {"kind": "file", "path": path.as_posix()}
    given = {
        "channel": options.channel,
        "along": options.along,
        "spacing_um": options.spacing_um,
        "xy_unit": options.xy_unit,
        "height_unit": options.height_unit,
    }
    keys |= {name: value for name, value in given.items() if value is not None}
    if has_marks:
        keys["outliers"] = markers.OUTLIERS
    if has_marks or has_gaps:
        keys["unmeasured"] = "fill"
    if is_period(path):
        keys["periodic"] = "blend"  # as a measurement, which does not close
    instrument = limits_of(options).instrument
    if instrument is not None:
        keys["instrument"] = instrument.model_dump(exclude_none=True)
    return keys


def offer_of_file(path: Path, keys: dict[str, Any]) -> Offer:
    """Write the section `surface` of a scene that rolls over a file, on one line.

    The heights are prepared as a run prepares them. The sentence says the roughness that is left,
    or why no scene rolls over the file.
    """
    try:
        heights, _, _ = prepared_file(path, HeightFile(**keys))
    except (SceneError, ValueError) as error:  # a mistake of pydantic is a ValueError
        return Offer(f"No scene rolls over the file itself: {error}")
    ra_um = 1e6 * float(np.abs(heights - heights.mean()).mean())
    sentence = "In a scene, this rolls over the file itself, with an Ra of"
    return Offer(f"{sentence} {rounded(ra_um, 3)} um once its ends are blended:", line(keys))

"""The roughness report of a surface by the names of ISO 25178-2 and ISO 21920-2."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.numbers.sheet import NONE, Sheet, SheetCell, SheetRow, SheetTable
from rolling.surface import parameters as areal
from rolling.surface import profile_parameters as profiles
from rolling.surface.profile_parameters import ProfileRoughness, profile_roughness

NAME = "roughness"
MADE_HEIGHTS = (
    "The heights are those that the program made or read; no instrument measured them for this"
    " report."
)
DIGITS = 4  # of a parameter
_MICROMETRES = 1e6  # in a metre


def roughness_sheet(
    subject: str,
    heights: Array,
    steps_m: Sequence[float],
    is_periodic: bool,
    *,
    facts: Sequence[tuple[str, str]],
    departures: Sequence[str],
    notice: str = "",
) -> Sheet:
    """Return the report of heights.

    Parameters
    ----------
    subject : str
        What the surface is of.
    heights : array (m, n), m
        Heights along and across the track; NaN at unmeasured nodes.
    steps_m : pair of float, m
        Node spacings along and across.
    is_periodic : bool
        Whether the heights are one period of the surface.
    facts : sequence of pairs of str
        Where the heights are from, and what was done to them.
    departures : sequence of str
        What a measurement would have and these heights do not.
    notice : str
        What a reader has to know first. Default: nothing.
    """
    steps = np.asarray(steps_m, dtype=float)
    values = areal.parameters(heights, steps, is_periodic)
    is_bound = areal.is_upper_bound(heights, steps, is_periodic)
    of_profiles = profile_roughness(heights, float(steps[0]), is_periodic)
    sizes = " x ".join(rounded(1e3 * size, DIGITS) for size in steps * heights.shape)
    nodes = " x ".join(f"{count:,}" for count in heights.shape)
    pixel = " x ".join(rounded(_MICROMETRES * step, DIGITS) for step in steps)
    settings = (
        ("Evaluation area", f"{sizes} mm along and across the track"),
        ("Pixel", f"{pixel} µm, {nodes} nodes"),
        ("Ends", "one period, which closes" if is_periodic else "open; the plane is removed"),
        *facts,
        (
            "Areal filters of this report",
            "neither S-filter nor L-filter: the pixel and the area are the limits",
        ),
        *_profile_facts(of_profiles),
    )
    return Sheet(
        name=NAME,
        title="Roughness report by the names of ISO 25178-2 and ISO 21920-2",
        subject=subject,
        notice=notice,
        tables=(areal_table(values, is_bound), profile_table(of_profiles)),
        facts=settings,
        departures=(*departures, *_profile_departures(of_profiles)),
    )


def areal_table(values: Mapping[str, float], str_is_bound: bool) -> SheetTable:
    """Return the table of the areal parameters."""
    rows = []
    for symbol, meaning in areal.meanings(str_is_bound).items():
        cell = _cell(values[symbol], areal.NAMES[symbol][0])
        rows.append(SheetRow(symbol=symbol, meaning=meaning, cells=(cell,)))
    return SheetTable(title="Areal parameters, ISO 25178-2", heads=("value",), rows=tuple(rows))


def profile_table(roughness: ProfileRoughness) -> SheetTable:
    """Return the table of the profile parameters: mean, deviation and range over the profiles."""
    rows = []
    for name, (unit, meaning) in profiles.MEANINGS.items():
        by_profile = roughness.values[name]
        known = by_profile[~np.isnan(by_profile)]
        cells = [_cell(math.nan, unit)] * 4
        if len(known):
            deviation = float(known.std(ddof=1)) if len(known) > 1 else math.nan
            numbers = (float(known.mean()), deviation, float(known.min()), float(known.max()))
            cells = [_cell(number, unit) for number in numbers]
        row = SheetRow(symbol=f"{roughness.letter}{name}", meaning=meaning, cells=tuple(cells))
        rows.append(row)
    title = f"Profile parameters along the track, ISO 21920-2, of {roughness.profiles} profiles"
    return SheetTable(
        title=title,
        heads=("mean", "standard deviation", "least", "largest"),
        rows=tuple(rows),
    )


def _cell(value: float, unit: str) -> SheetCell:
    """Return a parameter in SI, printed with lengths in micrometres; none for NaN."""
    printed = {"m": "µm", "deg": "°"}.get(unit, unit)
    if math.isnan(value):
        return SheetCell(value=None, unit=unit, text=NONE)
    shown = _MICROMETRES * value if unit == "m" else value
    return SheetCell(value=value, unit=unit, text=f"{rounded(shown, DIGITS)} {printed}".rstrip())


def _profile_facts(roughness: ProfileRoughness) -> list[tuple[str, str]]:
    """Return the settings of the profiles."""
    length = f"{rounded(1e3 * roughness.evaluation_m, DIGITS)} mm"
    if roughness.index_m is None:
        filtered = "no L-filter: primary profile, less its mean"
    else:
        index = rounded(1e3 * roughness.index_m, 3)
        filtered = f"Gaussian L-filter, nesting index Nic {index} mm (ISO 16610-21); mean line"
        length += f", {roughness.sections} sections of {index} mm"
    lines = f"{roughness.profiles} evaluation lengths on {roughness.lines} lines across"
    if roughness.gaps:
        lines += f"; {roughness.gaps} lines with unmeasured nodes are left out"
    counted = f"{100 * profiles.COUNTED:g} %"
    return [
        ("Profile filter", filtered),
        ("S-filter of profiles", "none: the pixel ends the profile"),
        ("Evaluation length", length),
        ("Profiles", lines),
        (
            "Profile elements",
            f"hills and dales of at least {counted} of the largest, mean of both directions",
        ),
        ("Gradient", "Rdq over seven nodes of a profile, Sdq between neighbouring nodes"),
    ]


def _profile_departures(roughness: ProfileRoughness) -> list[str]:
    """Say where the settings are not those that Ra asks for."""
    if not roughness.profiles:
        return ["No line along the track is measured whole, so there are no profile parameters."]
    usual = rounded(1e3 * roughness.usual_index_m, 3)
    if roughness.index_m is None:
        return [
            f"The surface is too short for a nesting index of {usual} mm and for any shorter one,"
            " so these are parameters of the primary profile, and no R-parameters."
        ]
    if roughness.index_m < roughness.usual_index_m:
        index = rounded(1e3 * roughness.index_m, 3)
        return [
            f"Ra asks for a nesting index of {usual} mm, for which the surface is too short:"
            f" {index} mm was used."
        ]
    return []

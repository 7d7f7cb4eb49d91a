"""Heights from a file: resolution, tilt, seam and form."""

from __future__ import annotations

import math
from pathlib import Path

from acoustics.numbers import rounded
from rolling.check import long_steps
from rolling.check.finding import Finding, rounded_down, si
from rolling.scene.height_files import is_instrument
from rolling.scene.height_grid import read
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface.levelling import Levelling
from rolling.surface.scene_surface import SceneSurface, scene_surface

MIN_CORRELATION_NODES = 5  # of a measurement, across the correlation length
# Share of the variance. At 5 nodes per correlation length neighbouring heights differ by 8 % of the
# variance; noise of 4 % doubles that difference.
MAX_NOISE = 0.05
MAX_FORM = 0.5  # share of the variance that a plane and a parabola may make up


def findings(scene: Scene) -> list[Finding]:
    """Judge the heights of a file; generated surfaces have no such findings."""
    if not isinstance(scene.surface, HeightFile):
        return []
    surface, path = scene_surface(scene), scene.height_path
    assert surface.levelling is not None and path is not None  # every file has both
    return [
        *_resolution(surface),
        *_file(path, scene.surface),
        *(
            Finding(e.step, e.step.replace("_", "-"), e.text, e.warning)
            for e in surface.preparation
        ),
        Finding("level", "tilt", tilt_text(surface.levelling)),
        _seam(scene, surface.levelling),
        *_form(surface),
    ]


def tilt_text(levelling: Levelling) -> str:
    """Write the slopes that were taken off and the roughness, or the slopes that stay."""
    taken = any(levelling.taken)
    slopes = zip(
        levelling.taken if taken else levelling.plane,
        levelling.lengths,
        ("along", "across"),
        strict=True,
    )
    plane = ", ".join(
        f"{rounded(slope * 1e3, 3)} um/mm {direction} ({si(slope * length, 'm')} over the file)"
        for slope, length, direction in slopes
        if slope or not taken
    )
    if not taken:
        return f"nothing taken off, the plane has {plane}"
    before, after = si(levelling.ra_before, "m"), si(levelling.ra_after, "m")
    second = (
        "second order taken off with the plane" if levelling.is_quadratic else "plane taken off"
    )
    return f"{second}: {plane}; Ra {before} before, {after} after"


def _file(path: Path, surface: HeightFile) -> list[Finding]:
    """State channel, nodes and spacing of the file of an instrument."""
    if not is_instrument(path):
        return []
    measured = read(path, surface.channel, surface.height_unit)
    rows, columns = measured.heights.shape
    dy, dx = (si(step, "m") for step in measured.spacing_m or ())
    value = f"{columns} x {rows} nodes (x, y) of {dx} x {dy}"
    if len(measured.channels) > 1:
        value += f", {surface.channel or measured.channels[0]} of {', '.join(measured.channels)}"
    return [Finding("file", "measurement", value)]


def _resolution(surface: SceneSurface) -> list[Finding]:
    """Count the nodes per correlation length, and judge them and the noise."""
    along, across = surface.correlations
    length, noise = min(along.length, across.length), max(along.noise, across.noise)
    if not math.isfinite(length):
        return []
    nodes, warnings = length / surface.spacing, []
    least = f"{MIN_CORRELATION_NODES:g} are wanted"
    if nodes < 1:
        warnings.append(
            f"less than 1 node per correlation length (1/e of the autocorrelation), {least}: a"
            " finer measurement is needed, or noise must be filtered out"
        )
    elif round(nodes, 1) < MIN_CORRELATION_NODES:
        spacing = rounded_down(length / MIN_CORRELATION_NODES * 1e6)
        warnings.append(
            f"{rounded(nodes)} nodes per correlation length ({si(length, 'm')}, 1/e of the"
            f" autocorrelation), {least}: a finer measurement is needed, with a spacing of at most"
            f" {spacing} um"
        )
    if noise > MAX_NOISE and nodes >= 1:
        warnings.append(
            f"{rounded(100 * noise)} % of the variance of the heights changes from each node to the"
            " next: filter noise out, or take a finer measurement"
        )
    quantity, warning = "nodes per correlation length", "; ".join(warnings) or None
    return [Finding("correlation_nodes", quantity, rounded(nodes, 3), warning)]


def _seam(scene: Scene, levelling: Levelling) -> Finding:
    """Judge the step from the last row to the first and the time of contact on it."""
    seam = levelling.seams[0]
    sizes = f"{si(seam.step, 'm')} rms, {si(seam.neighbours, 'm')} between neighbouring rows"
    if not seam.stands_out:
        return Finding("seam", "step across the seam", sizes)
    share = _share_on_seam(scene, long_steps.contact_radius(scene))
    warning = None
    if share > 0:
        on_seam, record = si(share * scene.duration, "s"), si(scene.duration, "s")
        warning = (
            f"the file is no period of a surface. The contact is on that step for {on_seam} of the"
            f" record's {record} ({rounded(100 * share)} %); the sound of that time belongs to the"
            " cut, and the record does not loop: roll over the middle of the file only"
            " (rolling.start_um, rolling.duration_s), or set surface.periodic to blend"
        )
    return Finding("seam", "step across the seam", f"{sizes}, stands out", warning)


def _share_on_seam(scene: Scene, radius: float) -> float:
    """Return the share of the track on which a contact of a radius [m] lies on the seam."""
    lap = scene.track.plate_nodes * scene.track.spacing
    within = min(2 * radius, lap)

    def rolled(place: float) -> float:
        """Return the length up to a place that lies within a radius of a seam."""
        laps, rest = divmod(place + radius, lap)
        return laps * within + min(rest, within)

    return (rolled(scene.start + scene.track.distance) - rolled(scene.start)) / scene.track.distance


def _form(surface: SceneSurface) -> list[Finding]:
    share = surface.form_share
    warning = None
    if share > MAX_FORM:
        warning = (
            f"a plane and a parabola make up {100 * share:.0f} % of the variance of the heights and"
            " pass for roughness: take them off with surface.level quadratic"
        )
    return [
        Finding("form", "plane and parabola", f"{rounded(100 * share)} % of the variance", warning)
    ]

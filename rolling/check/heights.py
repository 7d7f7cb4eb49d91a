"""Heights: resolution, tilt, seam and form of a file; moments, spectrum and waves of made ones."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from acoustics.numbers import rounded, si
from rolling.check import cost, refusals, resolution
from rolling.check.finding import Finding, judged, sentence
from rolling.scene.height_files import is_instrument
from rolling.scene.height_grid import read
from rolling.scene.laws import SelfAffineLaw
from rolling.scene.messages import TABLES
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface.heights import correlation
from rolling.surface.levelling import Levelling, form_share
from rolling.surface.made import is_described
from rolling.surface.scene_surface import SceneSurface, scene_surface

MIN_CORRELATION_NODES = 5  # of a measurement, across the correlation length
# Share of the variance. At 5 nodes per correlation length neighbouring heights differ by 8 % of the
# variance; noise of 4 % doubles that difference.
MAX_NOISE = 0.05
MAX_FORM = 0.5  # share of the variance that a plane and a parabola may make up
OFF = 0.005  # difference of skewness or kurtosis that is named
ROLLOFF_WAVES = 4.0  # of the roll-off that a period should hold


def findings(scene: Scene) -> Iterator[Finding]:
    """Judge the heights of files, and made heights that are self-affine or not Gaussian."""
    if scene.height_paths and (suspicions := scene_surface(scene).suspicions):
        yield Finding("doubtful_heights", "heights of the file", "doubtful", "; ".join(suspicions))
    if not isinstance(scene.surface, HeightFile):
        yield from _made(scene)
        return
    surface, path = scene_surface(scene), scene.height_path
    assert surface.levelling is not None and path is not None  # every file has both
    yield from _resolution(surface)
    yield from _file(path, scene.surface)
    for step in surface.preparation:
        name = TABLES["steps"].get(step.step, step.step)
        yield Finding(step.step, name, step.text, step.warning)
    yield Finding("level", "tilt", tilt_text(surface.levelling))
    yield _seam(scene, surface.levelling)
    share = form_share(surface.heights)
    form = f"{rounded(100 * share)} % of the variance"
    yield judged("form", form, share > MAX_FORM, percent=100 * share)


def tilt_text(levelling: Levelling) -> str:
    """Write the slopes that were removed and the roughness, or the slopes that stay."""
    taken, directions = any(levelling.taken), ("along", "across")
    own = levelling.taken if taken else levelling.plane
    slopes = zip(own, levelling.lengths, directions, strict=True)
    plane = ", ".join(
        f"{rounded(slope * 1e3, 3)} um/mm {direction} ({si(slope * length, 'm')} over the file)"
        for slope, length, direction in slopes
        if slope or not taken
    )
    if not taken:
        return f"nothing removed, the plane has {plane}"
    before, after = si(levelling.ra_before, "m"), si(levelling.ra_after, "m")
    order = "second order removed with the plane" if levelling.is_quadratic else "plane removed"
    return f"{order}: {plane}; Ra {before} before, {after} after"


def _file(path: Path, surface: HeightFile) -> Iterator[Finding]:
    """State channel, nodes and spacing of the file of an instrument."""
    if not is_instrument(path):
        return
    measured = read(path, surface.channel, surface.height_unit, surface.xy_unit)
    rows, columns = measured.heights.shape
    dy, dx = (si(step, "m") for step in measured.spacing_m or ())
    value = f"{columns} x {rows} nodes (x, y) of {dx} x {dy}"
    if len(measured.channels) > 1:
        value += f", {surface.channel or measured.channels[0]} of {', '.join(measured.channels)}"
    yield Finding("file", "measurement", value)


def _resolution(surface: SceneSurface) -> Iterator[Finding]:
    """Count the nodes per correlation length, and judge them and the noise."""
    along, across = (correlation(surface.heights, surface.spacing, axis) for axis in (0, 1))
    length, noise = min(along.length, across.length), max(along.noise, across.noise)
    if not math.isfinite(length):
        return
    nodes, kinds = length / surface.spacing, list[str]()
    if nodes < 1:
        kinds.append("none")
    elif round(nodes, 1) < MIN_CORRELATION_NODES:
        kinds.append("few")
    if noise > MAX_NOISE and nodes >= 1:
        kinds.append("noise")
    key, spacing_um = "correlation_nodes", length / MIN_CORRELATION_NODES * 1e6
    numbers = {"nodes": nodes, "least": MIN_CORRELATION_NODES, "length": length}
    numbers |= {"spacing_um": spacing_um, "percent": 100 * noise}
    warning = "; ".join(sentence(key, kind, **numbers) for kind in kinds)
    yield replace(judged(key, rounded(nodes, 3), False), warning=warning or None)


def _seam(scene: Scene, levelling: Levelling) -> Finding:
    """Judge the step from the last row to the first and the time of contact on it."""
    seam = levelling.seams[0]
    sizes = f"{si(seam.step, 'm')} rms, {si(seam.neighbours, 'm')} between neighbouring rows"
    if not seam.stands_out:
        return judged("seam", sizes, False)
    share, record = _share_on_seam(scene, resolution.contact_radius(scene)), scene.duration
    numbers = {"on_seam": share * record, "record": record, "percent": 100 * share}
    return judged("seam", f"{sizes}, stands out", share > 0, **numbers)


def _share_on_seam(scene: Scene, radius: float) -> float:
    """Return the share of the track on which a contact of a radius [m] lies on the seam."""
    lap = scene.track.plate_nodes * scene.track.spacing
    within = min(2 * radius, lap)

    def rolled(place: float) -> float:
        """Return the length up to a place that lies within a radius of a seam."""
        laps, rest = divmod(place + radius, lap)
        return laps * within + min(rest, within)

    return (rolled(scene.start + scene.track.distance) - rolled(scene.start)) / scene.track.distance


# ---- made heights


def _made(scene: Scene) -> Iterator[Finding]:
    """Make heights that are self-affine or not Gaussian, and judge them."""
    laws = [law for law in scene.laws if is_described(law)]
    if not laws or refusals.excess([scene], 1, None):
        return
    for law, (key, heights) in zip(laws, scene_surface(scene).made.items(), strict=True):
        of = "sphere " * key.startswith("ball")
        if not law.is_gaussian:
            skewness, kurtosis = heights["skewness"], heights["kurtosis"]
            wanted = {"wanted_skewness": law.moments[0], "wanted_kurtosis": law.moments[1]}
            got = {"skewness": skewness, "kurtosis": kurtosis}
            value = sentence("surface_made", "value", **got, **wanted)
            off = max(abs(skewness - law.moments[0]), abs(kurtosis - law.moments[1])) > OFF
            yield replace(judged("surface_made", value, off, of=of, value=value), key=key)
        errors, chances = heights["spectrum_error_db"], heights["spectrum_chance_db"]
        octave = max(errors, key=lambda name: abs(errors[name]) / max(chances[name], 0.1))
        numbers = {"octave": octave, "error": errors[octave], "chance": chances[octave]}
        value = sentence("surface_spectrum", "value", **numbers)
        least_um = ROLLOFF_WAVES * law.rolloff_um if isinstance(law, SelfAffineLaw) else 0.0
        few = cost.shortest_period(scene) * 1e6 < least_um
        words = {"of": of, "waves": ROLLOFF_WAVES, "least_um": least_um}
        yield replace(judged("surface_spectrum", value, few, **words), key=f"{key}_spectrum")

"""Heights: resolution, tilt, seam and form of a file; moments, spectrum and waves of made ones."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from acoustics.numbers import rounded, rounded_down, si
from rolling.check import cost, resolution
from rolling.check.finding import Finding
from rolling.in_si.chosen_filters import rounded_up_um
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.in_si.scene_surface import SceneSurface, scene_surface
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.height_files import is_array
from rolling.scene.height_grid import read
from rolling.scene.laws import HeightLaw, SelfAffineLaw
from rolling.scene.messages import TABLES
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface.contact_average import averaged_noise_db
from rolling.surface.heights import correlation
from rolling.surface.levelling import Levelling, form_share
from rolling.surface.made import is_described

MIN_CORRELATION_NODES = 5  # of a measurement, across the correlation length
# Share of the variance. At 5 nodes per correlation length neighbouring heights differ by 8 % of the
# variance; noise of 4 % doubles that difference.
MAX_NOISE = 0.05
MAX_FORM = 0.5  # share of the variance that a plane and a parabola may make up
OFF = 0.005  # difference of skewness or kurtosis that is named
ROLLOFF_WAVES = 4.0  # of the roll-off that a period should hold


def rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge the heights of files, and made heights that are self-affine or not Gaussian."""
    if scene.height_paths and (suspicions := scene_surface(scene).suspicions):
        name = "heights of the file"
        yield Finding("doubtful_heights", name, "doubtful")
        text = f"{name}: {'; '.join(suspicions)}"
        yield Doubt("doubtful_heights", text, Severity.INDICATIVE)
    if not isinstance(scene.surface, HeightFile):
        yield from _made(scene)
        return
    surface = scene_surface(scene)
    path = scene.height_path
    assert surface.levelling is not None and path is not None  # every file has both
    yield from _resolution(surface)
    yield from _file(path, scene.surface)
    for step in surface.preparation:
        name = TABLES["steps"].get(step.step, step.step)
        yield Finding(step.step, name, step.text)
        if step.warning:
            yield Doubt(step.step, f"{name}: {step.warning}", Severity.TRUST)
    yield Finding("level", "tilt", tilt_text(surface.levelling))
    yield from _instrument(scene, surface)
    yield from _seam(scene, surface.levelling)
    yield from _seam_across(scene, surface.levelling)
    yield from _form(surface)


def tilt_text(levelling: Levelling) -> str:
    """Write the slopes that were removed and the roughness, or the slopes that stay."""
    taken = any(levelling.taken)
    directions = ("along", "across")
    own = levelling.taken if taken else levelling.plane
    slopes = zip(own, levelling.lengths, directions, strict=True)
    plane = ", ".join(
        f"{rounded(slope * 1e3, 3)} um/mm {direction} ({si(slope * length, 'm')} over the file)"
        for slope, length, direction in slopes
        if slope or not taken
    )
    if not taken:
        return f"nothing removed, the plane has {plane}"
    before = si(levelling.ra_before, "m")
    after = si(levelling.ra_after, "m")
    order = f"{levelling.form} removed with the plane" if levelling.form else "plane removed"
    return f"{order}: {plane}; Ra {before} before, {after} after"


def _form(surface: SceneSurface) -> Iterator[Finding | Doubt]:
    """Judge the form that may pass for roughness."""
    share = form_share(surface.heights)
    name = "plane and parabola"
    yield Finding("form", name, f"{rounded(100 * share)} % of the variance")
    if share > MAX_FORM:
        yield Doubt(
            "form",
            f"{name}: a plane and a parabola make up {100 * share:.0f} % of the variance of the "
            "heights and pass for roughness",
            Severity.INDICATIVE,
            advice="remove them with surface.level quadratic, cylinder or sphere",
        )


def _file(path: Path, surface: HeightFile) -> Iterator[Finding]:
    """State channel, nodes and spacing of the file of an instrument."""
    if is_array(path):
        return
    measured = read(path, surface.channel, surface.height_unit, surface.xy_unit)
    if measured.taken:
        yield Finding("file", "measurement", measured.taken)
        return
    rows, columns = measured.heights.shape
    dy, dx = (si(step, "m") for step in measured.spacing_m or ())
    value = f"{columns} x {rows} nodes (x, y) of {dx} x {dy}"
    if len(measured.channels) > 1:
        value += f", {surface.channel or measured.channels[0]} of {', '.join(measured.channels)}"
    yield Finding("file", "measurement", value)


def _resolution(surface: SceneSurface) -> Iterator[Finding | Doubt]:
    """Count the nodes per correlation length, and judge them and the noise."""
    along, across = (correlation(surface.heights, surface.spacing, axis) for axis in (0, 1))
    length = min(along.length, across.length)
    noise = max(along.noise, across.noise)
    if not math.isfinite(length):
        return
    name = "nodes per correlation length"
    nodes = length / surface.spacing
    yield Finding("correlation_nodes", name, rounded(nodes, 3))
    of_file = "1/e of the autocorrelation"
    wrong = list[str]()
    advice = list[str]()
    if nodes < 1:
        wrong.append(
            f"less than 1 node per correlation length ({of_file}), {MIN_CORRELATION_NODES:g} are "
            "wanted"
        )
        advice.append("a finer measurement is needed, or noise must be filtered out")
    elif round(nodes, 1) < MIN_CORRELATION_NODES:
        spacing_um = length / MIN_CORRELATION_NODES * 1e6
        wrong.append(
            f"{rounded(nodes)} nodes per correlation length ({si(length, 'm')}, {of_file}), "
            f"{MIN_CORRELATION_NODES:g} are wanted"
        )
        advice.append(
            "a finer measurement is needed, with a spacing of at most "
            f"{rounded_down(spacing_um)} um"
        )
    if noise > MAX_NOISE and nodes >= 1:
        wrong.append(
            f"{rounded(100 * noise)} % of the variance of the heights changes from each node to "
            "the next"
        )
        advice.append("filter noise out, or take a finer measurement")
    if wrong:
        yield Doubt(
            "correlation_nodes",
            f"{name}: {'; '.join(wrong)}",
            Severity.INDICATIVE,
            advice="; ".join(advice),
        )


def _instrument(scene: Scene, surface: SceneSurface) -> Iterator[Finding | Doubt]:
    """State what the instrument sees, and warn of noise that the ball would roll over."""
    seen = surface.seen
    if seen is None:
        return
    name = "measuring instrument"
    yield Finding("instrument", name, f"sees {seen.words}{_noise_words(scene, surface)}")
    if seen.limit == "noise":
        yield Doubt(
            "instrument",
            f"{name}: below {si(seen.cutoff, 'm')} the file shows {seen.noise_words}",
            Severity.INDICATIVE,
            advice="the run tells how much of the levels it is; average measurements, or set "
            f"surface.s_filter_um to at least {rounded_up_um(seen.cutoff):g}",
        )


def _noise_words(scene: Scene, surface: SceneSurface) -> str:
    """Write what noise adds to the heights that the contact averages; empty without noise.

    An S-filter takes most of it away.
    """
    seen = surface.seen
    if seen is None or not seen.noise or seen.s_filter:
        return ""
    semi_axes = smooth_contact_of(scene).semi_axes_m()
    added = averaged_noise_db(surface.heights, surface.spacing, seen.noise, semi_axes)
    if not math.isfinite(added):
        return "; all that the contact averages is noise"
    least = "less than 0.1" if added < 0.1 else rounded(added)
    return f"; noise adds {least} dB to the heights that the contact averages"


def _seam(scene: Scene, levelling: Levelling) -> Iterator[Finding | Doubt]:
    """Judge the step from the last row to the first and the time of contact on it."""
    seam = levelling.seams[0]
    name = "step across the seam"
    sizes = f"{si(seam.step, 'm')} rms, {si(seam.neighbours, 'm')} between neighbouring rows"
    if not seam.stands_out:
        yield Finding("seam", name, sizes)
        return
    yield Finding("seam", name, f"{sizes}, stands out")
    share = _share_on_seam(scene, resolution.contact_radius(scene))
    record = scene.duration
    if share > 0:
        yield Doubt(
            "seam",
            f"{name}: the file is no period of a surface. The contact is on that step for "
            f"{si(share * record, 's')} of the record's {si(record, 's')} "
            f"({rounded(100 * share)} %); the sound of that time belongs to the cut, and the "
            "record does not loop",
            Severity.INDICATIVE,
            advice="roll over the middle of the file only (rolling.start_um, rolling.duration_s), "
            "or set surface.periodic to blend",
        )


def _seam_across(scene: Scene, levelling: Levelling) -> Iterator[Finding | Doubt]:
    """Judge the distance of a track beside the middle from the edge of the file."""
    if scene.across_nodes == 0:
        return
    width = scene.track.n_across * scene.spacing
    from_edge = abs(scene.across_nodes * scene.spacing - width / 2)
    name = "track across"
    place = f"{si(from_edge, 'm')} from the edge of the surface"
    yield Finding("seam_across", name, place)
    reach = smooth_contact_of(scene).semi_axes_m()[1]
    if from_edge < reach and levelling.seams[1].stands_out:
        farthest_um = 1e6 * (width / 2 - reach)
        yield Doubt(
            "seam_across",
            f"{name}: it lies {place}, and the contact reaches {si(reach, 'm')} to either side."
            " The file is no period of a surface across, so the contact lies on the step from one"
            " edge to the other",
            Severity.INDICATIVE,
            advice=f"choose a rolling.across_um of at most {rounded_down(farthest_um)} either way,"
            " or set surface.periodic to blend",
        )


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


def _made(scene: Scene) -> Iterator[Finding | Doubt]:
    """Make heights that are self-affine or not Gaussian, and judge them."""
    laws = [law for law in scene.laws if is_described(law.in_si)]
    if not laws:
        return
    for law, (key, heights) in zip(laws, scene_surface(scene).made.items(), strict=True):
        of = "sphere " if key.startswith("ball") else ""
        if not law.is_gaussian:
            yield from _moments(law, key, f"{of}skewness and kurtosis", heights)
        name = f"{of}spectrum against its law, by octave"
        errors = heights["spectrum_error_db"]
        chances = heights["spectrum_chance_db"]
        octave = max(errors, key=lambda name: abs(errors[name]) / max(chances[name], 0.1))
        yield Finding(
            f"{key}_spectrum",
            name,
            f"largest {errors[octave]:+.1f} dB at {octave} um, where chance alone makes "
            f"{chances[octave]:.1f} dB",
        )
        least_um = ROLLOFF_WAVES * law.rolloff_um if isinstance(law, SelfAffineLaw) else 0.0
        if cost.shortest_period(scene) * 1e6 < least_um:
            yield Doubt(
                f"{key}_spectrum",
                f"{name}: the plateau of the spectrum needs {ROLLOFF_WAVES:g} waves of the "
                "roll-off",
                Severity.TRUST,
                advice=f"choose a surface.width_um and a track of at least {least_um:g} um",
            )


def _moments(
    law: HeightLaw, key: str, name: str, heights: Mapping[str, Any]
) -> Iterator[Finding | Doubt]:
    """Compare skewness and kurtosis of made heights with those of their law."""
    skewness = heights["skewness"]
    kurtosis = heights["kurtosis"]
    wanted_skewness, wanted_kurtosis = law.moments
    value = (
        f"{rounded(skewness, 4)} and {rounded(kurtosis, 4)}, requested "
        f"{rounded(wanted_skewness, 4)} and {rounded(wanted_kurtosis, 4)}"
    )
    yield Finding(key, name, value)
    if max(abs(skewness - wanted_skewness), abs(kurtosis - wanted_kurtosis)) > OFF:
        yield Doubt(
            key,
            f"{name}: {value}",
            Severity.TRUST,
            advice="the spectrum of the law allows no nearer pair; choose another pair, or a "
            "longer or wider surface with more asperities",
        )

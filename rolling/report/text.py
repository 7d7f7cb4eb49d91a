"""What a report says of runs in words and tables: plain text, from scenes, summaries and provenance. Depends on summary."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.ticker import EngFormatter

from acoustics.bands import BAND_NAMES, LEAST_BT, reliable
from acoustics.radiation import RHO_C
from rolling.check import findings, height_files, validity
from rolling.figures.picture import comment, quoted
from rolling.scene.scene import Scene
from rolling.scene.sections import Gaussian, HeightFile
from rolling.simulation import caveats
from rolling.simulation.caveats import Remark
from rolling.simulation.labels import printable
from rolling.simulation.run_result import Heard
from rolling.simulation.summary import uncertain
from rolling.surface.scene_surface import scene_surface

NOTHING = "-"


@dataclass(frozen=True)
class Column:
    """A number of summary.json as a column: its name there and that of its uncertainty, heading, unit, factor, format.

    Without a format it has four digits.
    """

    key: str
    uncertainty: str | None
    head: str
    unit: str
    factor: float = 1.0
    digits: str = ".1f"


COLUMNS = (
    Column("level_db", "level", "LZeq", "dB"),
    Column("laeq_db", "laeq", "LAeq", "dB"),
    Column("laf_max_db", "laf_max", "LAFmax", "dB"),
    Column("las_max_db", "las_max", "LASmax", "dB"),
    Column("lz_peak_db", "lz_peak", "LZpeak", "dB"),
    Column("steady_level_db", "steady", "steady level", "dB re 1 pW/m²"),
    Column("loudness_sone", None, "loudness", "sone", 1.0, ".3g"),
    Column("sharpness_acum", None, "sharpness", "acum", 1.0, ".3g"),
    Column("plastic_ratio", None, "plastic ratio", "", 1.0, ".3f"),
    Column("max_pressure_pa", None, "greatest pressure", "GPa", 1e-9, ".3g"),
    Column("contact_area_mean_m2", None, "contact area", "µm²", 1e12, ""),
    Column("release_power_mean_w", None, "release, mean", "µW", 1e6, ""),
    Column("release_power_rms_w", None, "release, rms", "µW", 1e6, ""),
)
ASKED_FOR = ("loudness_sone", "sharpness_acum")  # not shown where no scene asked


@dataclass(frozen=True)
class Table:
    """Headings, and per row a heading and cells."""

    heads: list[str]
    rows: list[tuple[str, list[str]]]


@dataclass(frozen=True)
class Fact:
    """What holds for all runs (one value, no labels), or for some."""

    what: str
    values: list[tuple[str, str]]


def sentence(runs: Sequence[Heard]) -> str:
    """The result in one sentence."""
    heard = [(level, one) for one in runs if (level := one.sound.levels.laeq_db) is not None]
    if not heard:
        return "No sound: the release does not fluctuate within hearing."
    distances = {f"{one.scene.sound.distance_m:g} m" for one in runs}
    at = f" at {distances.pop()}" if len(distances) == 1 else ""
    silent = len(runs) - len(heard)
    also = f" {silent} of {len(runs)} runs are silent." if silent else ""
    if len(heard) == 1:
        level, one = heard[0]
        laeq = uncertain(level, one.numbers["uncertainty_db"]["laeq"])
        return f"{one.label}: LAeq {laeq} dB re 20 µPa{at}.{also}"
    least, most = min(heard, key=lambda pair: pair[0]), max(heard, key=lambda pair: pair[0])
    return (
        f"LAeq{at} lies between {least[0]:.1f} dB ({least[1].label}) and {most[0]:.1f} dB ({most[1].label}),"
        f" {most[0] - least[0]:.1f} dB apart.{also}"
    )


def levels(runs: Sequence[Heard]) -> Table:
    """Levels and contact numbers, a row per run; a level that is not there is `silent` or, not computed, `-`."""
    columns = _columns(runs)

    def cell(one: Heard, column: Column) -> str:
        if column.key not in one.numbers:
            return NOTHING
        value = one.numbers[column.key]
        if value is None:
            return "silent" if column.key.endswith("_db") else NOTHING
        if column.uncertainty:
            return uncertain(value, _uncertainty(one, column))
        return f"{value * column.factor:{column.digits}}" if column.digits else significant(value * column.factor)

    heads = [column.head + (f" [{column.unit}]" if column.unit else "") for column in columns]
    return Table(heads, [(one.label, [cell(one, column) for column in columns]) for one in runs])


def tsv(runs: Sequence[Heard]) -> str:
    """Write the same numbers for a spreadsheet, the caveats above them.

    Tabs separate the cells, uncertainties have columns of their own, silence leaves a cell empty.
    """
    columns = _columns(runs)
    uncertain = [column for column in columns if any(_uncertainty(one, column) is not None for one in runs)]
    lines = [["run"]]
    for column in columns:
        name = column.head + (f" [{column.unit}]" if column.unit else "")
        lines[0] += [name, f"u({column.head}) [dB]"] if column in uncertain else [name]
    for one in runs:
        row = [one.label]
        for column in columns:
            value = one.numbers.get(column.key)
            row.append("" if value is None else f"{value * column.factor:.6g}")
            if column in uncertain:
                uncertainty = _uncertainty(one, column)
                row.append("" if uncertainty is None else f"{uncertainty:.3g}")
        lines.append(row)
    rows = ["\t".join(quoted(cell, "\t") for cell in row) for row in lines]
    return "".join(f"{line}\n" for line in [*(comment(each.line) for each in remarks(runs)), *rows])


def significant(value: float) -> str:
    """Four digits, without an exponent up to a million."""
    return f"{float(f'{value:.4g}'):g}"


def _columns(runs: Sequence[Heard]) -> list[Column]:
    return [c for c in COLUMNS if c.key not in ASKED_FOR or any(c.key in one.numbers for one in runs)]


def _uncertainty(one: Heard, column: Column) -> float | None:
    return one.numbers["uncertainty_db"].get(column.uncertainty)


def bands(runs: Sequence[Heard]) -> list[tuple[str, bool, list[str]]]:
    """Third octaves: nominal mid frequency, whether every record is long enough to read it, Z level of each run."""
    certain = reliable(min(one.sound.duration for one in runs))

    def cell(one: Heard, band: str) -> str:
        level = one.sound.levels.third_octave_db[band]
        if level is None:
            return NOTHING
        return uncertain(level, one.numbers["third_octave_uncertainty_db"][band])

    return [
        (band, bool(sure), [cell(one, band) for one in runs]) for band, sure in zip(BAND_NAMES, certain, strict=True)
    ]


BANDS_NOTE = (
    f"dB re 20 µPa, Z. Grey: bandwidth times duration below {LEAST_BT:g}, uncertain by 2 dB or more."
    " -: no sound, or above what the steps resolve."
)


LEVELS_NOTE = (
    "Levels re 20 µPa of the fluctuation, which is what sounds, over the whole record, with their standard uncertainty; the"
    " steady level is of the mean intensity, which is silent."
)


def assumptions(runs: Sequence[Heard]) -> list[Fact]:
    """What the numbers rest on, each once where it is the same for all."""
    facts = [_assumed(one) for one in runs]
    return [
        _grouped(what, [(one.label, fact[what]) for one, fact in zip(runs, facts, strict=True)]) for what in facts[0]
    ]


def _assumed(one: Heard) -> dict[str, str]:
    scene, sound = one.scene, one.sound
    fixed = scene.sound.gain_pa_per_w_m2 is not None
    plate, sphere = scene.plate, scene.sphere
    elastic = (
        f", {sphere.youngs_modulus_gpa:g} GPa, Poisson's ratio {sphere.poissons_ratio:g}"
        if sphere.youngs_modulus_gpa
        else ""
    )
    hardness = f"hardness {plate.hardness_gpa:g} GPa" if plate.hardness_gpa else "no hardness: purely elastic"
    slowest, fastest = (
        f"{v:.4g}" for v in (scene.motion.slowest(sound.duration), scene.motion.fastest(sound.duration))
    )
    speed = f"{fastest} m/s" if sound.constant_speed else f"{slowest} to {fastest} m/s"
    return {
        "radiated share q": f"{scene.sound.q:g}",
        "distance": f"{scene.sound.distance_m:g} m, spherical spreading",
        "impedance of air": f"{RHO_C:g} Pa s/m (20 °C)",
        "sound pressure per intensity": f"{significant(sound.factor)} Pa per W/m²" if sound.factor else "none: silent",
        "rule of that factor": "fixed by the scene"
        if fixed
        else "mean p² over the impedance is the rms of the intensity's fluctuation",
        "record": f"{sound.duration:.4g} s" + f", {'closes on itself' if sound.loops else sound.ends}",
        "resolved up to": f"{min(sound.highest, sound.sample_rate / 2) / 1e3:.4g} kHz"
        + ("" if sound.constant_speed else " at the greatest speed, less while it is slower"),
        "load": f"{scene.load:g} N, constant",
        "speed": speed,
        "sphere": f"R {sphere.radius_mm:g} mm" + (elastic or ", rigid"),
        "plate": f"{plate.youngs_modulus_gpa:g} GPa, Poisson's ratio {plate.poissons_ratio:g}, {hardness}, without memory",
        "surface": surface_words(scene),
        "spacing and step": f"{scene.spacing * 1e6:g} µm, {scene.step * 1e6:g} µm",
        "half-space": _half_space(scene),
        "solver": f"tolerance {scene.numerics.tolerance:g}, {scene.numerics.edges} edges, {scene.numerics.precision} precision",
        "release of a node": {
            "mean": "mean pressure of a step's ends",
            "left_end": "pressure at a step's beginning (the article's)",
        }[scene.recovery.rule],
    }


def _half_space(scene: Scene) -> str:
    """How far the scene is from where a half-space no longer holds."""
    values = {finding.key: finding.value for finding in findings.findings(scene)}
    return (
        f"rms slope {values['slope']} (holds up to {validity.MAX_SLOPE:g}),"
        f" contact radius over the sphere's {values['contact_radius']} (up to {validity.MAX_CONTACT:g})"
    )


def surface_words(scene: Scene) -> str:
    """The surface as the scene asks for it."""
    s = scene.surface
    if isinstance(s, Gaussian):
        across = s.correlation_length_across_um
        length = f"{s.correlation_length_um:g} µm" + (f" along, {across:g} µm across" if across else "")
        law = s.autocorrelation.replace("_", " ")
        return f"random, Ra {s.roughness_ra_um:g} µm, correlation length {length} ({law}), seed {s.seed}"
    if not isinstance(s, HeightFile):
        return "smooth"
    levelling = scene_surface(scene).levelling
    tilt = f", {height_files.tilt_text(levelling)}" if levelling and any(levelling.taken) else ""
    return f"heights of {printable(s.path)}{tilt}"


def remarks(runs: Sequence[Heard]) -> list[Remark]:
    """List all caveats of runs, each once."""
    return caveats.gathered([(one.label, caveats.stored(one.numbers)) for one in runs])


def headline(runs: Sequence[Heard]) -> str:
    """Say what belongs beside every level."""
    return " ".join(each.line for each in remarks(runs) if each.key in caveats.HEADLINE)


def partial(runs: Sequence[Heard]) -> list[Remark]:
    """Say which runs are partial, if any are."""
    return [each for each in remarks(runs) if each.key == "partial"]


def standing(runs: Sequence[Heard]) -> list[Remark]:
    """List the caveats that hold of any run like these and are not said at the top."""
    said = (*caveats.HEADLINE, "partial")
    return [each for each in remarks(runs) if each.key in caveats.STANDING and each.key not in said]


def warnings(runs: Sequence[Heard]) -> list[Remark]:
    """List the warnings of the check, each kind once."""
    return [each for each in remarks(runs) if each.key not in caveats.STANDING]


def events(one: Heard) -> list[Fact]:
    """The recovery events of a run in numbers; nothing where none were asked for, or there are none."""
    found = one.event_statistics
    if found is None:
        return []
    joule = EngFormatter("J", places=1)
    told = {
        "events": f"{found.count:,}, {found.per_metre * 1e-3:,.0f} per mm",
        "energy of an event": f"mean {joule(found.energy_mean)}, median {joule(found.energy_median)},"
        f" nine in ten below {joule(found.energy_p90)}",
        "mean duration": f"{found.duration_mean:.3g} steps of {one.result.step * 1e6:g} µm",
        "most of one node in a step": joule(found.peak),
        "top tenth of the events": f"{100 * found.top_tenth_share:.3g} % of the release",
    }
    return [Fact(what, [("", value)]) for what, value in told.items()]


def _grouped(what: str, values: Sequence[tuple[str, str]]) -> Fact:
    if len({value for _, value in values}) == 1:
        return Fact(what, [("", values[0][1])])
    by_value: dict[str, list[str]] = {}
    for label, value in values:
        by_value.setdefault(value, []).append(label)
    return Fact(what, [("; ".join(labels), value) for value, labels in by_value.items()])


def made(runs: Sequence[Heard]) -> list[dict[str, str]]:
    """How to make runs again: their labels, scene file's name, resolved scene in YAML, command; those of one sweep together."""
    found = []
    for folder in dict.fromkeys(one.home for one in runs):
        members = [one for one in runs if one.home == folder]
        name = f"{members[0].scene.name}.yaml"
        text = folder / "resolved.yaml"
        labels = "; ".join(one.label for one in members)
        found.append(
            {
                "labels": labels,
                "file": name,
                "scene": text.read_text(encoding="utf-8"),
                "command": f"rolling run {name}",
            }
        )
    return found


def provenance(runs: Sequence[Heard]) -> list[Fact]:
    """What made the numbers, as the run folders say."""
    stories = [(one.label, _story(one)) for one in runs]
    whats = list(dict.fromkeys(what for _, story in stories for what in story))
    return [_grouped(what, [(label, story.get(what, NOTHING)) for label, story in stories]) for what in whats]


def _story(one: Heard) -> dict[str, str]:
    path = one.folder / "provenance.json"
    if not path.is_file():
        return {}
    told: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    packages = told.pop("packages", {})
    told.pop("written", None)
    return {what: NOTHING if value is None else str(value) for what, value in told.items()} | {
        "packages": ", ".join(f"{name} {version}" for name, version in packages.items())
    }

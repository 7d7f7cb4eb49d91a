"""Texts and tables of the page as plain text, from the summaries of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.ticker import EngFormatter

from acoustics.bands import BAND_NAMES, LEAST_BT, reliable
from acoustics.numbers import bracketed, rounded
from rolling import __version__
from rolling.results import caveats
from rolling.results.caveats import Caveat
from rolling.results.labels import printable
from rolling.results.run_result import Run
from rolling.results.runs_table import beside_text, level_name, uncertain, verdicts
from rolling.scene import file

NOTHING = "-"  # for a number that does not exist
Fact = tuple[str, list[tuple[str, str]]]  # quantity; labels of runs (empty: all runs) and value


class Column(NamedTuple):
    """A number of summary.json as a column of the table of levels.

    The fields are its key and the key of its uncertainty, head, unit, factor to that unit, and
    format (empty: four digits). A column on request is shown only if a run has its number.
    """

    key: str
    uncertainty: str
    head: str
    unit: str
    factor: float = 1.0
    form: str = ".1f"
    on_request: bool = False


COLUMNS = (
    Column("level_db", "level", "LZeq", "dB"),
    Column("laeq_db", "laeq", "LAeq", "dB(A)"),
    Column(
        "compact_source_level_db", "", "compact source of the same power", "dB(A)", 1.0, ".1f", True
    ),
    Column("hemisphere_mean_level_db", "", "mean over the half sphere", "dB(A)", 1, ".1f", True),
    Column("vibration_estimate_laeq_db", "", "vibration, estimated", "dB(A)", 1.0, ".1f", True),
    Column("laeq_grid_error_db", "", "grid error of LAeq", "dB", 1.0, "+.2f", True),
    Column("laeq_subgrid_error_db", "", "error of LAeq from missing detail", "dB", 1, "+.2f", True),
    Column("laeq_solver_error_db", "", "solver error of LAeq", "dB", 1.0, "+.2f", True),
    Column("laeq_uncertainty_db", "", "u(LAeq) with grid and solver", "dB", 1.0, ".2f", True),
    Column("laf_max_db", "laf_max", "LAFmax", "dB"),
    Column("las_max_db", "las_max", "LASmax", "dB"),
    Column("lz_peak_db", "lz_peak", "LZpeak", "dB"),
    Column("steady_level_db", "steady", "steady level", "dB re 1 pW/m²"),
    Column("vibration_laeq_db", "", "LAeq of the vibration", "dB(A)", on_request=True),
    Column("release_laeq_db", "", "level of the release", "dB(A)", on_request=True),
    Column("release_over_vibration_db", "", "release over vibration", "dB", on_request=True),
    Column("equivalent_q", "", "q that equals them", "", 1.0, ".2g", True),
    Column("plate_power_level_db", "", "sound power of the plate", "dB re 1 pW", on_request=True),
    Column("ball_power_level_db", "", "sound power of the sphere", "dB re 1 pW", on_request=True),
    Column("force_rms_n", "", "force, rms", "N", 1.0, ".3g", True),
    Column("force_max_ratio", "", "maximum of F/W", "", 1.0, ".3f", True),
    Column("force_min_ratio", "", "minimum of F/W", "", 1.0, ".3f", True),
    Column("restitution", "", "restitution of the first impact", "", 1.0, ".3f", True),
    Column("loudness_sone", "", "loudness", "sone", 1.0, ".3g", True),
    Column("sharpness_acum", "", "sharpness", "acum", 1.0, ".3g", True),
    Column("plastic_ratio", "", "plastic ratio", "", 1.0, ".3f"),
    Column("max_pressure_pa", "", "maximum pressure", "GPa", 1e-9, ".3g"),
    Column("contact_area_mean_m2", "", "contact area", "µm²", 1e12, ""),
    Column("release_power_mean_w", "", "release, mean", "µW", 1e6, ""),
    Column("release_power_rms_w", "", "release, rms", "µW", 1e6, ""),
)
BANDS_NOTE = (
    f"dB re 20 µPa, Z. Grey: bandwidth times duration below {LEAST_BT:g}, uncertain by 2 dB or"
    " more. -: no sound, or a band that the steps do not resolve."
)
LEVELS_NOTE = (
    "Levels are re 20 µPa and belong to the fluctuation, the audible part, over the whole record,"
    " with their standard uncertainty; the steady level belongs to the mean intensity, which is"
    " silent."
)

CITED_PROGRAM = (
    f"The rolling-contact-noise authors: rolling-contact-noise (version {__version__}), 2026."
)
CITED_ARTICLE = (
    "Lee, B.; Kim, K.; Kim, T.: Analysis of Contact Noise Due to Elastic Recovery of Surface "
    "Asperities for Spherical "
    "Contact. Inventions 2025, 10(1), 17. doi:10.3390/inventions10010017"
)


# ---- levels


def titles(runs: Sequence[Run]) -> str:
    """Join the titles of the scenes, or their names where they have none, in printable letters."""
    return printable(", ".join(dict.fromkeys(run.scene.title or run.scene.name for run in runs)))


def sentence(runs: Sequence[Run]) -> str:
    """State the result in one sentence."""
    sounding = [(level, run) for run in runs if (level := run.sound.levels.laeq_db) is not None]
    if not sounding:
        sources = " or ".join(dict.fromkeys(run.sound.source for run in runs))
        return f"No sound: the {sources} does not fluctuate within hearing."
    distances = {run.scene.listener_place for run in runs}
    at = f" at {distances.pop()}" if len(distances) == 1 else ""
    silent = len(runs) - len(sounding)
    also = f" {silent} of {len(runs)} runs are silent." if silent else ""
    low_db, quietest = min(sounding, key=lambda pair: pair[0])
    high_db, loudest = max(sounding, key=lambda pair: pair[0])
    name = level_head(runs)
    if len(sounding) == 1:
        laeq = uncertain(low_db, quietest.summary["uncertainty_db"]["laeq"])
        return f"{quietest.label}: {name} {laeq} dB(A) re 20 µPa{at}.{also}"
    name = name[0].upper() + name[1:]
    if high_db - low_db < 0.05:
        return f"{name}{at} is {low_db:.1f} dB(A) in all {len(sounding)} runs that sound.{also}"
    return (
        f"{name}{at} lies between {low_db:.1f} dB(A) ({quietest.label}) and {high_db:.1f} dB(A)"
        f" ({loudest.label}), {high_db - low_db:.1f} dB apart.{also}"
    )


def beside(runs: Sequence[Run]) -> str:
    """State the levels beside those of runs in a sentence; empty where there are none."""
    words = beside_text([run.summary for run in runs])
    return f"{words[0].upper()}{words[1:]}." if words else ""


def level_head(runs: Sequence[Run]) -> str:
    """Name the level of runs: of the vibration, of the released power, or of both."""
    names = dict.fromkeys(level_name(run.summary) for run in runs)
    return " or ".join(names)


def judged(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Return words and reasons of the verdicts on the levels, each once with its runs."""
    return verdicts([(run.label, run.summary) for run in runs])


def levels(runs: Sequence[Run]) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """Return heads and rows (label, cells) of the table of levels and contact numbers.

    A level without sound is `silent`, and one that was not computed `-`.
    """
    columns = [
        column
        for column in COLUMNS
        if not column.on_request or any(run.summary.get(column.key) is not None for run in runs)
    ]
    named = {"laeq_db": level_head(runs)}
    heads = [named.get(column.key, column.head) for column in columns]
    units = [f" [{column.unit}]" if column.unit else "" for column in columns]
    heads = [head + unit for head, unit in zip(heads, units, strict=True)]
    return heads, [(run.label, [_cell(run, column) for column in columns]) for run in runs]


def listeners(runs: Sequence[Run]) -> list[tuple[str, str, str, str]]:
    """Return run, place, LAeq and LZeq of each listener of the runs with more than one."""
    rows = []
    for run in runs:
        places = run.summary.get("listeners") or []
        for listener in places if len(places) > 1 else []:
            at = f"{bracketed(listener['at_mm'])} mm"
            laeq, level = (
                "silent" if listener[key] is None else f"{listener[key]:.1f}"
                for key in ("laeq_db", "level_db")
            )
            rows.append((run.label, at, laeq, level))
    return rows


def _cell(run: Run, column: Column) -> str:
    """Write a number of a run for a table."""
    value = run.summary.get(column.key)
    if value is None:
        level = column.uncertainty and column.key in run.summary
        steady = column.key == "steady_level_db" and run.vibration is not None
        return "silent" if level and not steady else NOTHING
    if column.uncertainty:
        return uncertain(value, run.summary["uncertainty_db"].get(column.uncertainty))
    number = value * column.factor
    return f"{number:{column.form}}" if column.form else rounded(number, 4)


def bands(runs: Sequence[Run]) -> list[tuple[str, bool, list[str]]]:
    """Return nominal mid frequency, certainty and Z levels of all runs for each third octave."""
    certain = reliable(min(run.sound.duration for run in runs))

    def cell(run: Run, band: str) -> str:
        level = run.sound.levels.third_octave_db[band]
        if level is None:
            return NOTHING
        text = uncertain(level, run.summary["third_octave_uncertainty_db"][band])
        error = run.errors.total_db[band] if run.errors else None
        return text if error is None else f"{text} (error {error:+.1f})"

    return [
        (band, bool(sure), [cell(run, band) for run in runs])
        for band, sure in zip(BAND_NAMES, certain, strict=True)
    ]


# ---- caveats


def remarks(runs: Sequence[Run]) -> list[Caveat]:
    """List all caveats of runs, each caveat once."""
    return caveats.gathered([(run.label, run.summary) for run in runs])


def headline(runs: Sequence[Run]) -> str:
    """Join the caveats that stand beside every level."""
    return " ".join(caveat.line for caveat in remarks(runs) if caveat.key in caveats.HEADLINE)


def standing(runs: Sequence[Run]) -> list[Caveat]:
    """List the general caveats, which do not stand at the top."""
    kept = set(caveats.STANDING) - set(caveats.HEADLINE)
    return [caveat for caveat in remarks(runs) if caveat.key in kept]


def warnings(runs: Sequence[Run]) -> list[Caveat]:
    """List the warnings, the largest contribution to a level first, each kind once."""
    return caveats.warnings([(run.label, run.summary) for run in runs])


# ---- facts


def facts(runs: Sequence[Run], records: Sequence[Mapping[str, str]]) -> list[Fact]:
    """Merge facts of runs by name, each value once with the labels of its runs."""
    merged: list[Fact] = []
    for name in dict.fromkeys(name for record in records for name in record):
        labels_by_value: dict[str, list[str]] = {}
        for run, record in zip(runs, records, strict=True):
            labels_by_value.setdefault(record.get(name, NOTHING), []).append(run.label)
        alone = len(labels_by_value) == 1
        values = [
            ("" if alone else "; ".join(names), value) for value, names in labels_by_value.items()
        ]
        merged.append((name, values))
    return merged


def events(run: Run) -> list[Fact]:
    """List the numbers of the recovery events of a run; empty without events."""
    statistics = run.event_statistics
    if statistics is None:
        return []
    joule = EngFormatter("J", places=1)
    values = {
        "events": f"{statistics.count:,}, {statistics.per_metre * 1e-3:,.0f} per mm",
        "energy of an event": f"mean {joule(statistics.energy_mean)},"
        f" median {joule(statistics.energy_median)},"
        f" nine in ten below {joule(statistics.energy_p90)}",
        "mean duration": f"{rounded(statistics.duration_mean, 3)} steps"
        f" of {run.result.step * 1e6:g} µm",
        "maximum of a node in a step": joule(statistics.peak),
        "top tenth of the events": f"{rounded(100 * statistics.top_tenth_share, 3)} %"
        " of the release",
    }
    return [(name, [("", value)]) for name, value in values.items()]


def recipes(runs: Sequence[Run]) -> list[dict[str, str]]:
    """Return labels, file, scene and command that reproduce runs, once for the runs of a sweep."""
    members: dict[Path, list[Run]] = {}
    for run in runs:
        members.setdefault(run.home, []).append(run)
    written = []
    for home, sweep in members.items():
        name, path = f"{sweep[0].scene.name}.yaml", home / "scene.yaml"
        # The folder of a run in memory is the working directory, whose scene.yaml is a stranger's.
        is_stored = "provenance" in sweep[0].summary and path.is_file()
        written.append(
            {
                "labels": "; ".join(run.label for run in sweep),
                "file": name,
                "scene": path.read_text("utf-8") if is_stored else file.dump(sweep[0].scene),
                "command": f"rolling run {name}",
            }
        )
    return written


def provenance(runs: Sequence[Run]) -> list[Fact]:
    """List program, packages and machine that made the numbers, from the summaries of runs."""
    return facts(runs, [_provenance(run) for run in runs])


def _provenance(run: Run) -> dict[str, str]:
    """Return the provenance of a run; the result is empty for a run in memory."""
    record: Mapping[str, Any] = run.summary.get("provenance", {})
    facts_by_name = {
        name: NOTHING if value is None else str(value)
        for name, value in record.items()
        if name not in ("packages", "label")
    }
    packages = record.get("packages", {})
    if packages:
        facts_by_name["packages"] = ", ".join(f"{name} {v}" for name, v in packages.items())
    return facts_by_name

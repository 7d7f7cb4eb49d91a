"""Texts and tables of the report as plain text, from scenes, summaries and provenance."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.ticker import EngFormatter

from acoustics.bands import BAND_NAMES, LEAST_BT, reliable
from rolling.figures.picture import comment, quoted
from rolling.report import assumed
from rolling.report.numbers import NOTHING, significant
from rolling.scene import file
from rolling.simulation import batch, caveats
from rolling.simulation.caveats import Remark
from rolling.simulation.labels import printable
from rolling.simulation.run_result import RunResult
from rolling.simulation.summary import error_line, uncertain


@dataclass(frozen=True)
class Column:
    """A number of summary.json as a column of the table of levels.

    Parameters
    ----------
    key : str. Name in summary.json.
    uncertainty : str or None. Name of its uncertainty there.
    head : str. Heading.
    unit : str. Unit in the table.
    factor : float. Factor from summary.json to that unit. Default: 1.
    digits : str. Format; empty for four digits. Default: one decimal.
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
    Column("laeq_grid_error_db", None, "grid error of LAeq", "dB", 1.0, "+.2f"),
    Column("laeq_solver_error_db", None, "solver error of LAeq", "dB", 1.0, "+.2f"),
    Column("laeq_uncertainty_db", None, "u(LAeq) with grid and solver", "dB", 1.0, ".2f"),
    Column("laf_max_db", "laf_max", "LAFmax", "dB"),
    Column("las_max_db", "las_max", "LASmax", "dB"),
    Column("lz_peak_db", "lz_peak", "LZpeak", "dB"),
    Column("steady_level_db", "steady", "steady level", "dB re 1 pW/m²"),
    Column("vibration_laeq_db", None, "LAeq of the vibration", "dB"),
    Column("release_laeq_db", None, "LAeq of the release", "dB"),
    Column("equivalent_q", None, "q that equals them", "", 1.0, ".2g"),
    Column("plate_power_level_db", None, "sound power of the plate", "dB re 1 pW"),
    Column("ball_power_level_db", None, "sound power of the sphere", "dB re 1 pW"),
    Column("force_rms_n", None, "contact force, rms", "N", 1.0, ".3g"),
    Column("force_max_ratio", None, "maximum of F/W", "", 1.0, ".3f"),
    Column("force_min_ratio", None, "minimum of F/W", "", 1.0, ".3f"),
    Column("loudness_sone", None, "loudness", "sone", 1.0, ".3g"),
    Column("sharpness_acum", None, "sharpness", "acum", 1.0, ".3g"),
    Column("plastic_ratio", None, "plastic ratio", "", 1.0, ".3f"),
    Column("max_pressure_pa", None, "maximum pressure", "GPa", 1e-9, ".3g"),
    Column("contact_area_mean_m2", None, "contact area", "µm²", 1e12, ""),
    Column("release_power_mean_w", None, "release, mean", "µW", 1e6, ""),
    Column("release_power_rms_w", None, "release, rms", "µW", 1e6, ""),
)
ASKED_FOR = (
    "vibration_laeq_db",
    "release_laeq_db",
    "equivalent_q",
    "plate_power_level_db",
    "ball_power_level_db",
    "force_rms_n",
    "force_max_ratio",
    "force_min_ratio",
    "loudness_sone",
    "sharpness_acum",
    "laeq_grid_error_db",
    "laeq_solver_error_db",
    "laeq_uncertainty_db",
)  # these columns are shown only if a scene requests them


@dataclass(frozen=True)
class Table:
    """A table: column heads, and per row a head and cells."""

    heads: list[str]
    rows: list[tuple[str, list[str]]]


@dataclass(frozen=True)
class Fact:
    """A fact about runs.

    Parameters
    ----------
    name : str. Quantity.
    values : list of pairs. Labels and value; a single value without labels holds for all runs.
    """

    name: str
    values: list[tuple[str, str]]


@dataclass(frozen=True)
class Recipe:
    """The scene that reproduces runs.

    Parameters
    ----------
    labels : str. Labels of the runs.
    file : str. Name of a scene file.
    scene : str. Resolved scene in YAML.
    command : str. Command that runs the file.
    """

    labels: str
    file: str
    scene: str
    command: str


def titles(runs: Sequence[RunResult]) -> str:
    """Join the titles of the scenes, or their names where they have none, in printable letters."""
    return printable(", ".join(dict.fromkeys(run.scene.title or run.scene.name for run in runs)))


def sentence(runs: Sequence[RunResult]) -> str:
    """State the result in one sentence."""
    sounding = [(level, run) for run in runs if (level := run.sound.levels.laeq_db) is not None]
    if not sounding:
        sources = " or ".join(dict.fromkeys(run.sound.source for run in runs))
        return f"No sound: the {sources} does not fluctuate within hearing."
    distances = {f"{run.scene.sound.distance_m:g} m" for run in runs}
    at = f" at {distances.pop()}" if len(distances) == 1 else ""
    silent = len(runs) - len(sounding)
    also = f" {silent} of {len(runs)} runs are silent." if silent else ""
    if len(sounding) == 1:
        level, run = sounding[0]
        laeq = uncertain(level, run.summary["uncertainty_db"]["laeq"])
        return f"{run.label}: LAeq {laeq} dB re 20 µPa{at}.{also}"
    low_db, quietest = min(sounding, key=lambda pair: pair[0])
    high_db, loudest = max(sounding, key=lambda pair: pair[0])
    if high_db - low_db < 0.05:
        return f"LAeq{at} is {low_db:.1f} dB in all {len(sounding)} runs that sound.{also}"
    return (
        f"LAeq{at} lies between {low_db:.1f} dB ({quietest.label}) and {high_db:.1f} dB "
        f"({loudest.label}),"
        f" {high_db - low_db:.1f} dB apart.{also}"
    )


def levels(runs: Sequence[RunResult]) -> Table:
    """Tabulate levels and contact numbers with a row per run.

    A level without sound is `silent`, and one that was not computed `-`.
    """
    columns = _columns(runs)

    def cell(run: RunResult, column: Column) -> str:
        if column.key not in run.summary:
            return NOTHING
        value = run.summary[column.key]
        if value is None:
            level = column.key.endswith("_db") and column.key not in ASKED_FOR
            silent = level and not (column.key == "steady_level_db" and run.vibration)
            return "silent" if silent else NOTHING
        if column.uncertainty:
            return uncertain(value, _uncertainty(run, column))
        return (
            f"{value * column.factor:{column.digits}}"
            if column.digits
            else significant(value * column.factor)
        )

    heads = [column.head + (f" [{column.unit}]" if column.unit else "") for column in columns]
    return Table(heads, [(run.label, [cell(run, column) for column in columns]) for run in runs])


def tsv(runs: Sequence[RunResult]) -> str:
    """Write the numbers of `levels` for a spreadsheet, with the caveats above them.

    Tabs separate the cells, uncertainties have columns of their own, and silence leaves a cell
    empty.
    """
    columns = _columns(runs)
    uncertain = [
        column for column in columns if any(_uncertainty(run, column) is not None for run in runs)
    ]
    lines = [["run"]]
    for column in columns:
        name = column.head + (f" [{column.unit}]" if column.unit else "")
        lines[0] += [name, f"u({column.head}) [dB]"] if column in uncertain else [name]
    for run in runs:
        row = [run.label]
        for column in columns:
            value = run.summary.get(column.key)
            row.append("" if value is None else f"{value * column.factor:.6g}")
            if column in uncertain:
                uncertainty = _uncertainty(run, column)
                row.append("" if uncertainty is None else f"{uncertainty:.3g}")
        lines.append(row)
    rows = ["\t".join(quoted(cell, "\t") for cell in row) for row in lines]
    return "".join(f"{line}\n" for line in [*(comment(each.line) for each in remarks(runs)), *rows])


def _columns(runs: Sequence[RunResult]) -> list[Column]:
    return [
        column
        for column in COLUMNS
        if column.key not in ASKED_FOR or any(column.key in run.summary for run in runs)
    ]


def _uncertainty(run: RunResult, column: Column) -> float | None:
    uncertainty: float | None = run.summary["uncertainty_db"].get(column.uncertainty)
    return uncertainty


def bands(runs: Sequence[RunResult]) -> list[tuple[str, bool, list[str]]]:
    """Tabulate third octaves.

    Returns
    -------
    list of rows
        Nominal mid frequency, whether every record is long enough to read the band, Z level of each
        run, with its error from grid and solver if the scene asks for an estimate.
    """
    certain = reliable(min(run.sound.duration for run in runs))

    def cell(run: RunResult, band: str) -> str:
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


BANDS_NOTE = (
    f"dB re 20 µPa, Z. Grey: bandwidth times duration below {LEAST_BT:g}, "
    "uncertain by 2 dB or more."
    " -: no sound, or a band that the steps do not resolve."
)


LEVELS_NOTE = (
    "Levels are re 20 µPa and belong to the fluctuation, the audible part, over the whole record, "
    "with their standard"
    " uncertainty; the steady level belongs to the mean intensity, which is silent."
)


def error_lines(runs: Sequence[RunResult]) -> list[str]:
    """Write a line for each run with an error estimate."""
    return [line for run in runs if (line := error_line(run.label, run.summary))]


def assumptions(runs: Sequence[RunResult]) -> list[Fact]:
    """List the assumptions behind the numbers, each once if all runs share it."""
    facts = [assumed.of_run(run) for run in runs]
    names = dict.fromkeys(name for fact in facts for name in fact)
    return [
        _grouped(
            name,
            [(run.label, fact.get(name, NOTHING)) for run, fact in zip(runs, facts, strict=True)],
        )
        for name in names
    ]


def remarks(runs: Sequence[RunResult]) -> list[Remark]:
    """List all caveats of runs, each caveat once."""
    return caveats.gathered([(run.label, caveats.stored(run.summary)) for run in runs])


def headline(runs: Sequence[RunResult]) -> str:
    """Join the caveats that stand beside every level."""
    return " ".join(each.line for each in remarks(runs) if each.key in caveats.HEADLINE)


def band_errors(runs: Sequence[RunResult]) -> list[Remark]:
    """List the caveat that names the bands that the grid or the solver puts off."""
    return [each for each in remarks(runs) if each.key == "band_errors"]


def partial(runs: Sequence[RunResult]) -> list[Remark]:
    """List the caveat that names the partial runs, if there are any."""
    return [each for each in remarks(runs) if each.key == "partial"]


def standing(runs: Sequence[RunResult]) -> list[Remark]:
    """List the general caveats, which do not stand at the top."""
    top = (*caveats.HEADLINE, "partial")
    return [
        remark
        for remark in remarks(runs)
        if remark.key in caveats.STANDING and remark.key not in top
    ]


def warnings(runs: Sequence[RunResult]) -> list[Remark]:
    """List the warnings of the check, each kind once."""
    return [each for each in remarks(runs) if each.key not in caveats.STANDING]


def events(run: RunResult) -> list[Fact]:
    """List the numbers of the recovery events of a run; empty without events."""
    statistics = run.event_statistics
    if statistics is None:
        return []
    joule = EngFormatter("J", places=1)
    values = {
        "events": f"{statistics.count:,}, {statistics.per_metre * 1e-3:,.0f} per mm",
        "energy of an event": f"mean {joule(statistics.energy_mean)}, "
        f"median {joule(statistics.energy_median)},"
        f" nine in ten below {joule(statistics.energy_p90)}",
        "mean duration": f"{statistics.duration_mean:.3g} steps of {run.result.step * 1e6:g} µm",
        "maximum of a node in a step": joule(statistics.peak),
        "top tenth of the events": f"{100 * statistics.top_tenth_share:.3g} % of the release",
    }
    return [Fact(name, [("", value)]) for name, value in values.items()]


def _grouped(name: str, values: Sequence[tuple[str, str]]) -> Fact:
    """Gather the labels (first of each pair) of equal values."""
    if len({value for _, value in values}) == 1:
        return Fact(name, [("", values[0][1])])
    by_value: dict[str, list[str]] = {}
    for label, value in values:
        by_value.setdefault(value, []).append(label)
    return Fact(name, [("; ".join(labels), value) for value, labels in by_value.items()])


def recipes(runs: Sequence[RunResult]) -> list[Recipe]:
    """Return the scenes that reproduce runs, run for all runs of a sweep."""
    members: dict[Path, list[RunResult]] = {}
    for run in runs:
        members.setdefault(run.home, []).append(run)
    return [
        Recipe(
            labels="; ".join(run.label for run in sweep),
            file=f"{sweep[0].scene.name}.yaml",
            scene=_resolved(folder, sweep[0]),
            command=f"rolling run {sweep[0].scene.name}.yaml",
        )
        for folder, sweep in members.items()
    ]


def _resolved(folder: Path, run: RunResult) -> str:
    """Read the resolved scene of a run folder; write it where it stands in result.h5 alone."""
    path = folder / "resolved.yaml"
    if path.is_file():
        return path.read_text(encoding="utf-8")
    return file.dump(batch.seen_from(folder, run.scene))


def provenance(runs: Sequence[RunResult]) -> list[Fact]:
    """List program, packages and machine that made the numbers, from the run folders."""
    records = [(run.label, _provenance(run)) for run in runs]
    names = list(dict.fromkeys(name for _, record in records for name in record))
    return [
        _grouped(name, [(label, record.get(name, NOTHING)) for label, record in records])
        for name in names
    ]


def _provenance(run: RunResult) -> dict[str, str]:
    """Read the provenance of a run from its folder; the result is empty for a run in memory."""
    path, brief = run.folder / "provenance.json", run.folder / "summary.json"
    record: dict[str, Any] = {}
    if path.is_file():
        record = json.loads(path.read_text(encoding="utf-8"))
    elif brief.is_file():
        record = json.loads(brief.read_text(encoding="utf-8")).get("provenance", {})
    if not record:
        return {}
    packages = record.pop("packages", {})
    record.pop("written", None)
    return {name: NOTHING if value is None else str(value) for name, value in record.items()} | {
        "packages": ", ".join(f"{name} {version}" for name, version in packages.items())
    }

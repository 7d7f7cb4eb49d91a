"""Tables of runs: numbers as a data frame, statistics over seeds, and lines for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from acoustics.bands import BAND_NAMES
from acoustics.numbers import bracketed, decibels_a, micrometres, rounded
from acoustics.texts import cell
from rolling.results import verdict
from rolling.results.answer import exposure_db, level_beside, level_key, uncertain
from rolling.results.doubts import band_error_db, band_text
from rolling.results.labels import SEED, labels
from rolling.results.notes import REPEATS, TURNS, above_vibration_db
from rolling.results.run_errors import LINEAR
from rolling.results.run_folder import RunFolder, stored_summary
from rolling.scene.messages import TABLES, table
from rolling.terminal.streams import columns, wrapped

if TYPE_CHECKING:
    import pandas as pd

MAX_STEPS = 8  # of the preparation of height files that are written; one run has at most 7
MAX_BAND_DB = 0.3  # what the steps may cut off of a level that is corrected for its errors
MAX_WARNINGS = 3  # after a run; the page and `rolling check` have all of them
LEVELS, MEANS = table("rolling.results", "levels").values()  # keys of the summary with their words
BANDS = ("third_octave_db", "third_octave_a_db", "third_octave_uncertainty_db")
MAXIMA = ("laf_max_db", "las_max_db")  # with a time weighting that a short record may not reach
_METRES = ("ra", "rq", "highest", "lowest")  # statistics of a surface that are lengths


def runs_table(runs: Sequence[RunFolder]) -> pd.DataFrame:
    """Return the numbers of runs, one row per run.

    The index holds label, folder and the swept keys. The columns are all single numbers of
    summary.json, the keys of the doubts, and the third octaves, such as `third_octave_db_1000`. A
    run without a summary has empty cells.
    """
    import pandas as pd  # slow to import, for tables only

    swept = list(dict.fromkeys(key for run in runs for key in run.values))
    rows = []
    for run, label in zip(runs, labels(runs), strict=True):
        names = {"run": label, "folder": run.folder.name}
        places = names | {key: run.values.get(key) for key in swept}
        rows.append(places | numbers(stored_summary(run) or {}))
    return pd.DataFrame(rows).convert_dtypes().set_index(["run", "folder", *swept])


def without_formulas(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose texts no spreadsheet takes for formulas, in its index too."""
    import pandas as pd

    def safe(value: Any) -> Any:
        return cell(value) if isinstance(value, str) else value

    named = table.map(safe)
    rows = [tuple(map(safe, x)) if isinstance(x, tuple) else safe(x) for x in table.index]
    if table.index.nlevels > 1:
        named.index = pd.MultiIndex.from_tuples(rows, names=table.index.names)
    elif table.index.dtype == object:
        named.index = pd.Index(rows, name=table.index.name)
    return named


def numbers(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a summary by the names of their columns.

    The uncertainty of LAeq from the length of the record has the column `laeq_uncertainty_db`, like
    that of any other level; the one with grid and solver has `laeq_total_uncertainty_db`.
    """
    cells: dict[str, Any] = {}
    for key, value in summary.items():
        if key == "doubts":
            cells[key] = " ".join(doubt.key for doubt in verdict.listed(summary))
        elif key == "uncertainty_db":
            cells |= {f"{name}_uncertainty_db": spread for name, spread in value.items()}
        elif key == "surface":
            for name, number in value.items():
                unit = "_m" if name in _METRES else ""
                cells[f"surface_{name}{unit}"] = number
        elif key == "levelling" and value:
            cells |= {f"levelling_{name}": inner for name, inner in value.items()}
        elif key == "verdict" and value:
            cells |= {"verdict": value["word"], "verdict_reason": value["reason"]}
        elif key == "laeq_uncertainty_db":
            cells["laeq_total_uncertainty_db"] = value
        elif key not in ("name", "levelling", "preparation") and not isinstance(value, Mapping):
            cells[key] = value
    for key in BANDS:
        cells |= {f"{key}_{name}": level for name, level in summary.get(key, {}).items()}
    return cells


def seed_statistics(table: pd.DataFrame, over: str = SEED) -> pd.DataFrame:
    """Return statistics of levels and third octaves over runs that differ in one key alone.

    A sweep of seeds repeats an experiment: `deviation_over_stated` near 1 confirms the uncertainty
    that a record states.

    table : DataFrame. A table of runs, as `runs_table` returns it.
    over : str. The swept key over which the statistics are made. Default: the seed.
    """
    import pandas as pd

    keys = [name for name in table.index.names if name not in ("run", "folder", over)]
    uncertainties = {name: f"{_spread(name)}_uncertainty_db" for name in LEVELS}
    for kind in ("third_octave_db", "third_octave_a_db"):
        for band in BAND_NAMES:
            uncertainties[f"{kind}_{band}"] = f"third_octave_uncertainty_db_{band}"
    stated = {name: spread for name, spread in uncertainties.items() if name in table}
    values = table[[*stated]].astype(float)
    spreads = table[[*stated.values()]].astype(float).set_axis([*stated], axis=1)
    groups = [table.index.get_level_values(key) for key in keys] or [np.zeros(len(table), int)]
    of_levels = values.groupby(groups, sort=False, dropna=False)
    square = np.square(spreads.where(values.notna()))
    parts = {
        "runs": of_levels.count(),
        "mean": of_levels.mean(),
        "standard_deviation": of_levels.std(),
        "standard_error": of_levels.sem(),
        "stated_uncertainty": np.sqrt(square.groupby(groups, sort=False, dropna=False).mean()),
    }
    parts["deviation_over_stated"] = parts["standard_deviation"] / parts["stated_uncertainty"]
    statistics = pd.concat(parts, axis=1).stack(level=1, future_stack=True)
    statistics = statistics.rename_axis([*(keys or ["all"]), "level"]).reset_index()
    names = statistics["level"].str.extract(r"^(third_octave(?:_a)?_db)_(.+)$")
    statistics["level"] = names[0].fillna(statistics["level"])
    statistics.insert(len(keys or ["all"]) + 1, "band_hz", names[1])
    statistics = statistics[statistics["runs"] > 0].astype({"runs": int})
    return statistics if keys else statistics.drop(columns="all")


# ---- texts


def level_text(summary: Mapping[str, Any], key: str) -> str:
    """Write a level of a summary with its uncertainty [dB]."""
    if (level := summary[key]) is None:
        no_level = key == "steady_level_db" and summary["source"] == "vibration"
        too_short = key in MAXIMA and summary["laeq_db"] is not None
        return "-" if no_level or too_short else "silent"
    return uncertain(level, summary["uncertainty_db"][_spread(key)])


def shown_levels(summary: Mapping[str, Any]) -> list[str]:
    """Return the keys of the levels of a run that tables show, the first read first."""
    levels = [key for key in LEVELS if key in summary]
    if summary.get("single_event"):
        first = ["lae_db", "laf_max_db"]
        return first + [key for key in levels if key not in (*first, "laeq_db", "level_db")]
    return [key for key in levels if key != "lae_db"]


def error_line(label: str, summary: Mapping[str, Any]) -> str:
    """Write the error estimate of a run, or an empty text without one."""
    estimate = summary.get("error_estimate", {})
    grid = summary.get("laeq_grid_error_db")
    if "stretches" not in estimate or grid is None:
        return ""
    solver = summary["laeq_solver_error_db"] or 0.0
    spread = summary["uncertainty_db"]["laeq"]
    grid_spread = summary["laeq_grid_error_uncertainty_db"] or 0.0
    signals = {name: summary[f"{name}_signal_db"] for name in ("grid", "solver")}
    signal = [f"{db:.0f} dB from the {name}" for name, db in signals.items() if db is not None]
    errors = [f"LAeq {grid:+.2f} ± {grid_spread:.2f} dB from the grid"]
    if subgrid := summary.get("laeq_subgrid_error_db"):
        of_detail = summary["laeq_subgrid_error_uncertainty_db"] or 0.0
        errors.append(f"{subgrid:+.2f} ± {of_detail:.2f} dB from missing detail below the spacing")
    errors.append(f"{solver:+.2f} dB from the solver")
    whole = spread and math.hypot(spread, grid_spread)
    corrected = f"corrected LAeq {uncertain(summary['laeq_db'] - grid - solver, whole)} dB(A)"
    if (band_error_db(summary) or 0.0) > MAX_BAND_DB:
        cut = band_text(summary, summary["laeq_band_end_hz"])
        corrected = f"no corrected level, because {cut}"
    return (
        f"errors of {label}: {', '.join(errors)}, {corrected}; rms error of the "
        f"{summary['source']} over its fluctuation {', '.join(signal)}; {estimate['stretches']} "
        f"stretches of {estimate['steps']} steps, order {estimate['order']:.1f}"
    )


def level_name(summary: Mapping[str, Any]) -> str:
    """Name the level of a run: LAeq of the vibration, or of the released power with its q.

    A single event has the sound exposure level LAE.
    """
    event = summary.get("single_event")
    quantity, reference = ("LAE", " (re 1 s)") if event else ("LAeq", "")
    if summary["source"] == "vibration":
        place = "at the listener" if summary.get("listeners") else "on the axis"
        return f"{quantity} {place}{reference}"
    if _fixed_gain(summary):
        return f"{quantity} under the fixed gain{reference}"
    q = f"q = {summary.get('q') or 1:g}"
    if event:
        return f"LAE of the released power (re 1 s, {q})"
    return f"level of the released power ({q})"


def _fixed_gain(summary: Mapping[str, Any]) -> bool:
    """Tell whether the gain of the scene decides the level of a release."""
    return summary["source"] == "release" and summary.get("q", 1) is None


def beside_text(summaries: Sequence[Mapping[str, Any]]) -> str:
    """State the levels beside those of runs of one source; empty where there are none."""
    known = [x for x in summaries if above_vibration_db(x) is not None and not _fixed_gain(x)]
    sources = {summary["source"] for summary in known}
    events = {bool(summary.get("single_event")) for summary in known}
    if len(sources) != 1 or len(events) != 1:
        return ""
    of_event = "LAE of " if events == {True} else ""
    above = _range([above_vibration_db(summary) for summary in known])
    if sources == {"vibration"}:
        words = f"the release with q = 1 is {above} dB above it: an upper bound"
        for key, name in MEANS.items():
            present = [level_beside(summary, key) for summary in known if key in summary]
            if present:
                mean = _range(present, 1)
                level = f"{mean} dB(A)" if mean else "not available"
                words += f"; {of_event}{name}: {level}"
        if len(known) == 1:
            words += _others(known[0])
        return words
    if level := _range([level_beside(summary, "vibration_laeq_db") for summary in known], 1):
        if any(summary["release_laeq_db"] != summary["laeq_db"] for summary in known):
            return (
                f"at the listener's distance it lies {above} dB above the vibration, which has "
                f"{level} dB(A) there"
            )
        return f"it lies {above} dB above the vibration, which has {level} dB(A)"
    level = _range([level_beside(summary, "vibration_estimate_laeq_db") for summary in known])
    bodies = " or ".join(dict.fromkeys(summary["vibration_estimate_bodies"] for summary in known))
    ratio: float = max(summary["vibration_estimate_force_ratio"] for summary in known)
    spreads = [summary.get("vibration_estimate_uncertainty_db") for summary in known]
    if widest := max((spread for spread in spreads if spread is not None), default=0.0):
        level += f" ± {math.ceil(widest)}"
    words = (
        f"it lies {above} dB above the vibration, which a linear chain estimates at {level} dB(A) "
        f"for {bodies}"
    )
    if ratio > LINEAR:
        words += "; too high where the ball would lose contact"
    return words


def _others(summary: Mapping[str, Any]) -> str:
    """State the other listeners' levels and the plate's sound power; empty without edges."""
    words = ""
    power = summary.get("plate_power_level_db")
    if summary.get("listeners") and power is not None:
        words = f"; sound power of the plate: {power:.1f} dB re 1 pW"
    quantity = "LAE " if summary.get("single_event") else ""
    for listener in summary.get("listeners", ())[1:]:
        level = decibels_a(listener_level(summary, listener))
        words += f"; {quantity}at {bracketed(listener['at_mm'])} mm: {level}"
    return words


def listener_level(summary: Mapping[str, Any], listener: Mapping[str, Any]) -> float | None:
    """Return the level of a run at one of its listeners [dB], as LAE for an event."""
    level = listener["laeq_db"]
    return None if level is None else level + exposure_db(summary)


def _range(levels: Sequence[float | None], digits: int = 0) -> str:
    """Write the lowest and the highest of some levels; empty without any."""
    known = sorted(level for level in levels if level is not None)
    ends = dict.fromkeys(f"{level:.{digits}f}" for level in [*known[:1], *known[-1:]])
    return " to ".join(ends)


class Head(NamedTuple):
    """Two lines of a head of the table of levels."""

    name: str
    unit: str = ""


def _cells(summary: Mapping[str, Any]) -> dict[Head, str]:
    """Return the cells of a run in the table of levels by their heads."""
    cells = {_level_head(summary): level_text(summary, level_key(summary))}
    if summary.get("single_event"):
        cells[Head("LAFmax", "dB(A)")] = level_text(summary, "laf_max_db")
    cells |= _cells_beside(summary)
    judged = summary.get("verdict")
    cells[Head("verdict")] = judged["word"] if judged else "-"
    cells[Head("plastic", "ratio")] = f"{summary['plastic_ratio']:.3f}"
    return cells


def _level_head(summary: Mapping[str, Any]) -> Head:
    """Return the head of the level of a run that is read first."""
    event = summary.get("single_event")
    quantity, unit = ("LAE", "dB(A), 1 s") if event else ("LAeq", "dB(A)")
    if _fixed_gain(summary):
        return Head("LAE, fixed gain" if event else "fixed gain", unit)
    if summary["source"] == "vibration":
        place = "listener" if summary.get("listeners") else "axis"
        return Head(f"{quantity}, {place}", unit)
    q = summary.get("q") or 1
    return Head("LAE, released" if event else "released power", f"q = {q:g}, {unit}")


def _cells_beside(summary: Mapping[str, Any]) -> dict[Head, str]:
    """Return the cells of the levels beside that of a run, and how far they are apart."""
    cells = {}
    as_event = ", LAE" if summary.get("single_event") else ""
    if summary["source"] == "vibration":
        key = next((key for key in MEANS if key in summary), None)
        mean = level_beside(summary, key) if key else None
        head = Head("compact", f"source{as_event}")
        if summary.get("listeners"):
            head = Head("half sphere", f"mean{as_event}")
        cells[head] = "n/a" if mean is None else f"{mean:.1f}"
        head = Head("release", f"q = 1{as_event}")
        other = level_beside(summary, "release_laeq_db")
    else:
        head = Head("vibration", f"dB(A){as_event}")
        other = level_beside(summary, "vibration_laeq_db")
        if other is None:
            head = Head("vibration", f"estimated{as_event}")
            other = level_beside(summary, "vibration_estimate_laeq_db")
    if "drop_mm" in summary:  # the release of a ball that rolls is none of a fall
        return cells
    above = None if _fixed_gain(summary) else above_vibration_db(summary)
    cells[head] = "-" if other is None else f"{other:.1f}"
    cells[Head("apart", "dB")] = "-" if above is None else f"{above:.0f}"
    return cells


def levels_table(runs: Sequence[RunFolder]) -> str:
    """Write levels and verdicts of runs for a terminal, with reasons and doubts below."""
    names = labels(runs)
    stored = zip(names, map(stored_summary, runs), strict=True)
    solved = [(label, summary) for label, summary in stored if summary is not None]
    by_run = {label: _cells(summary) for label, summary in solved}
    heads = list(dict.fromkeys(head for cells in by_run.values() for head in cells))
    rows = [["run", *(head.name for head in heads)]]
    if heads:
        rows.append(["", *(head.unit for head in heads)])
    for name in names:
        cells = by_run.get(name, {})
        rows.append([name, *(cells.get(head, "-") for head in heads)])
    if not solved:
        return columns(rows)
    return "\n".join([columns(rows), "", *map(wrapped, _remarks(solved))])


def _remarks(runs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """Write what stands below the levels: reasons, errors, surfaces, notes and warnings."""
    lines = []
    summaries = [summary for _, summary in runs]
    beside = beside_text(summaries)
    if beside:
        lines.append(f"{beside[0].upper()}{beside[1:]}.")
    lines += [f"{word}: {reason}" for word, reason in verdict.verdicts(runs)]
    lines += filter(None, (error_line(label, summary) for label, summary in runs))
    lines += [verdict.headline(runs), ""]
    lines += dict.fromkeys(surface_text(summary) for summary in summaries)
    lines += _preparation(summaries)
    noted = (*REPEATS, TURNS)
    lines += [f"note: {doubt.text}" for doubt in verdict.notes(runs) if doubt.key in noted]
    warnings = [f"warning: {doubt.text}" for doubt in verdict.warnings(runs)]
    lines += warnings[:MAX_WARNINGS]
    more = len(warnings) - MAX_WARNINGS
    if more > 0:
        others = "1 more warning" if more == 1 else f"{more} more warnings"
        lines.append(f"{others}: on the page, and by `rolling check`")
    return lines


def _preparation(summaries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Write the steps that prepared height files, each once, and the tilts that were removed."""
    steps = dict[str, None]()
    tilts = dict[str, None]()
    for summary in summaries:
        for step in summary.get("preparation", ()):
            name = TABLES["steps"].get(str(step["step"]), step["step"])
            steps[f"{name}: {step['text']}"] = None
        levelling = summary["levelling"]
        if levelling and (levelling["slope_along"] or levelling["slope_across"]):
            tilts[f"tilt: {levelling['text']}"] = None
    lines = [*steps][:MAX_STEPS]
    more = len(steps) - MAX_STEPS
    if more > 0:
        lines.append(f"{more} more steps of the preparation: in each summary.json")
    return [*lines, *tilts]


def surface_text(summary: Mapping[str, Any]) -> str:
    """Write the statistics of the surface of a run."""
    surface = summary["surface"]
    return (
        f"surface: Ra {micrometres(surface['ra'])} µm, Rq {micrometres(surface['rq'])} µm, "
        f"skewness {surface['skewness']:.2f}, kurtosis {surface['kurtosis']:.2f}, rms slope "
        f"{rounded(surface['rms_slope'], 3)}{surface_parts(summary)}"
    )


def surface_parts(summary: Mapping[str, Any]) -> str:
    """Write the roughness of plate and sphere, whose sum a sphere with a surface rolls over."""
    if "ball_ra_m" not in summary:
        return ""
    return (
        f"; plate Ra {micrometres(summary['plate_ra_m'])} µm and sphere Ra "
        f"{micrometres(summary['ball_ra_m'])} µm, added up over the turns"
    )


def _spread(key: str) -> str:
    """Return the name of a level in `uncertainty_db`."""
    return "steady" if key.startswith("steady") else key.removesuffix("_db")

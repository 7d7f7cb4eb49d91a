"""Lines about runs for a terminal: what rolls, the two numbers, what follows, and what to doubt."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from acoustics.numbers import bracketed, decibels_a, micrometres, rounded, rounded_up, si
from rolling.check import resolution
from rolling.check.doubt import Severity
from rolling.results import verdict
from rolling.results.answer import (
    Answer,
    follows,
    gap,
    level_beside,
    listener_level,
    released_power,
    uncertain,
    vibration,
)
from rolling.results.channels import channel_line
from rolling.results.description import runs_sentence
from rolling.results.doubts import band_error_db, band_text
from rolling.results.labels import labels
from rolling.results.notes import REPEATS, TURNS
from rolling.results.run_folder import RunFolder, stored_summary
from rolling.results.runs_table import MEANS, level_text
from rolling.results.verdict import Verdict
from rolling.scene.messages import TABLES
from rolling.terminal.streams import columns, folded, line_width

MAX_STEPS = 8  # of the preparation of height files that are written; one run has at most 7
MAX_BAND_DB = 0.3  # what the steps may cut off of a level that is corrected for its errors
UPPER_BOUND = "released power: what one would hear if all of it were sound (q = 1)"
LEAST_DB = 0.01  # smallest error that the line of grid and solver names

Solved = Sequence[tuple[str, Mapping[str, Any]]]  # label and summary of each run


def answer_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return what a person reads first of runs: their sentence, table, and what follows."""
    lines = [folded(runs_sentence(runs)), "", levels_table(runs)]
    conclusion = follows(runs)
    if conclusion:
        lines += ["", folded(conclusion)]
    return lines


def channel_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return a line for each channel that runs ask for, with a level and its reference."""
    lines = []
    solved = _solved(runs)
    for label, summary in solved:
        before = f"{label}, " if len(solved) > 1 else ""
        lines += [f"{before}{channel_line(channel)}" for channel in summary.get("channels", [])]
    return [folded(line) for line in lines]


def doubt_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return the few lines on what the numbers are worth: doubt, grid and solver, surface."""
    solved = _solved(runs)
    if not solved:
        return []
    lines = [*_missing(solved), *_largest_doubts(solved)]
    lines += [_grid_and_solver(solved), *_instrument(solved), _surface(solved)]
    return [folded(line) for line in lines if line]


def further_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return all other numbers, notes and warnings of runs, for --verbose."""
    solved = _solved(runs)
    if not solved:
        return []
    summaries = [summary for _, summary in solved]
    lines = [gap(summaries), *_beside(solved)]
    lines += [error_line(label, summary) for label, summary in solved]
    lines.append(verdict.headline(solved))
    lines += dict.fromkeys(surface_text(summary) for summary in summaries)
    lines += _preparation(summaries)
    noted = (*REPEATS, TURNS)
    lines += [f"note: {doubt.text}" for doubt in verdict.notes(solved) if doubt.key in noted]
    lines += [f"warning: {doubt.text}" for doubt in verdict.warnings(solved)]
    return [folded(line) for line in lines if line]


def _solved(runs: Sequence[RunFolder]) -> list[tuple[str, dict[str, Any]]]:
    """Return labels and summaries of the runs that are solved."""
    stored = zip(labels(runs), map(stored_summary, runs), strict=True)
    return [(label, summary) for label, summary in stored if summary is not None]


# ---- table


class Head(NamedTuple):
    """Two lines of the head of a column of the table of levels."""

    name: str
    unit: str = ""


def levels_table(runs: Sequence[RunFolder]) -> str:
    """Write the two numbers of runs in columns, with the verdict on the number to its left."""
    by_run = {label: _cells(summary) for label, summary in _solved(runs)}
    heads = list(dict.fromkeys(head for cells in by_run.values() for head in cells))
    rows = [["run", *(head.name for head in heads)]]
    if heads:
        rows.append(["", *(head.unit for head in heads)])
    for label in labels(runs):
        cells = by_run.get(label, {})
        rows.append([label, *(cells.get(head, "-") for head in heads)])
    text = columns(rows)
    is_too_wide = max(map(len, text.splitlines())) > line_width()
    if heads and is_too_wide:
        text = columns([row[:-1] for row in rows])  # the last column is the least needed
    return text


def _cells(summary: Mapping[str, Any]) -> dict[Head, str]:
    """Return the cells of a run in the table of levels by their heads."""
    heard = vibration(summary)
    released = released_power(summary)
    of_vibration = verdict.of_vibration(summary)
    of_release = verdict.of_released_power(summary)
    cells = {_head("vibration", heard): heard.number}
    if of_vibration is not None:
        cells[Head("verdict")] = of_vibration.short
    if summary.get("single_event") and summary["source"] == "vibration":
        cells[Head("LAFmax", "dB(A)")] = level_text(summary, "laf_max_db")
    if released.how != "none":
        cells[_head("released power", released)] = released.number
    if of_vibration is None and of_release is not None:
        cells[Head("verdict")] = of_release.short
    cells[Head("plastic", "ratio")] = f"{summary['plastic_ratio']:.3f}"
    return cells


def _head(name: str, answer: Answer) -> Head:
    """Return the head of one of the two numbers: what it is, and how it was found."""
    unit = "dB(A)" if answer.quantity == "LAeq" else "LAE, dB(A)"
    return Head(name, unit if answer.how == "none" else f"{answer.how}, {unit}")


def html_table(runs: Sequence[RunFolder]) -> str:
    """Write sentence, table and conclusion of runs as HTML for a notebook."""
    if not runs:
        return "<p>no run</p>"
    rows = "<tr><th>run</th><th>vibration</th><th>verdict on it</th><th>released power</th></tr>"
    for label, summary in _solved(runs):
        judged = verdict.of_vibration(summary)
        cells = [
            label,
            vibration(summary).text,
            "-" if judged is None else judged.short,
            released_power(summary).text,
        ]
        rows += f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"
    first = escape(runs_sentence(runs))
    last = escape(follows(runs))
    return f"<p>{first}</p><table>{rows}</table><p>{last}</p>"


# ---- what the numbers are worth


def _missing(runs: Solved) -> list[str]:
    """Say why a number is missing, each reason once."""
    lines = dict[str, None]()
    for name, number in (("vibration", vibration), ("released power", released_power)):
        for _, summary in runs:
            answer = number(summary)
            if answer.level_db is None:
                lines[f"{name}: {answer.text}"] = None
    return [*lines]


def _largest_doubts(runs: Solved) -> list[str]:
    """Write the largest doubt about each of the two numbers, and how many others there are."""
    lines = []
    for name, judge in (
        ("vibration", verdict.of_vibration),
        ("released power", verdict.of_released_power),
    ):
        judged = [(label, judge(summary)) for label, summary in runs]
        known = [(label, of_run) for label, of_run in judged if of_run is not None]
        if not known:
            continue
        label, largest = max(known, key=lambda pair: pair[1].worst.rank)
        worst = largest.worst
        # The ± beside a released power, or the line of grid and solver, says it already.
        is_said = worst.severity is Severity.TRUST or worst.key == resolution.LEVEL_KEY
        if name == "vibration" or not is_said:
            of_label = f" of {label}" if _differ(known) else ""
            lines.append(f"{name}{of_label}: {largest.sentence}")
    others = len(verdict.warnings(runs)) - len(lines)
    if lines and others > 0:
        lines[-1] += f" ({_count(others, 'more doubt')} with -v)"
    if any(released_power(summary).how == "upper bound" for _, summary in runs):
        lines.append(UPPER_BOUND)
    return lines


def _differ(judged: Sequence[tuple[str, Verdict]]) -> bool:
    """Tell whether runs have different verdicts, in other things than their decibels."""
    return len({(of_run.word, of_run.worst.key) for _, of_run in judged}) > 1


def _count(number: int, noun: str) -> str:
    """Write a number of things."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _grid_and_solver(runs: Solved) -> str:
    """Write in one line what grid and solver leave of the level of the sound files."""
    errors = []
    for _, summary in runs:
        if summary.get("laeq_grid_error_db") is None:
            continue
        parts = [summary.get("laeq_solver_error_db") or 0.0]
        for name in ("laeq_grid_error", "laeq_subgrid_error"):
            error = summary.get(f"{name}_db") or 0.0
            parts.append(math.hypot(error, summary.get(f"{name}_uncertainty_db") or 0.0))
        errors.append(max(map(abs, parts)))
    if not errors:
        reasons = {(summary.get("error_estimate") or {}).get("reason") for _, summary in runs}
        known = [reason for reason in reasons if reason]
        why = known[0] if known else "numerics.error_estimate: true does it"
        return f"grid and solver: errors not measured ({why})"
    size = max(LEAST_DB, math.ceil(100 * max(errors)) / 100)  # no error prints as 0.00 dB
    return f"grid and solver: errors below {size:g} dB"


def _instrument(runs: Solved) -> list[str]:
    """Write in one line what the instruments of measurements leave of both numbers of runs."""
    lines = dict[str, None]()
    for _, summary in runs:
        numbers = summary.get("instrument")
        if numbers is None:
            continue
        text = f"measuring instrument: sees waves above {si(numbers['cutoff_m'], 'm')}"
        if numbers["noise_m"]:
            share = rounded(100 * numbers["noise_over_sq"])
            text += f", noise {si(numbers['noise_m'], 'm')} rms ({share} % of Sq)"
        for name in ("vibration", "released_power"):
            spread = numbers[f"{name}_spread_db"]
            words = "unknown" if spread is None else f"± {rounded_up(spread)} dB"
            text += f"; {name.replace('_', ' ')} {words}"
        lines[text] = None
    return [*lines]


def _surface(runs: Solved) -> str:
    """Write the surface in one line, with the name of its run where runs differ."""
    texts = [(label, _short_surface(summary)) for label, summary in runs]
    label, text = texts[0]
    others = len({text for _, text in texts}) - 1
    if not others:
        return f"surface: {text}"
    return f"surface of {label}: {text} ({_count(others, 'other')} with -v)"


def _short_surface(summary: Mapping[str, Any]) -> str:
    """Write the roughness of a surface in a few numbers."""
    surface = summary["surface"]
    text = (
        f"Ra {rounded(surface['ra'] * 1e6, 3)} µm, Rq {rounded(surface['rq'] * 1e6, 3)} µm, "
        f"rms slope {rounded(surface['rms_slope'], 3)}"
    )
    if "ball_ra_m" in summary:
        text += ", of plate and ball together"
    return text


# ---- with --verbose


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


def _beside(runs: Solved) -> list[str]:
    """Write other levels of the vibration of runs: of an even source, and at other listeners."""
    lines = []
    for label, summary in runs:
        texts = other_levels(summary)
        if texts:
            lines.append(f"other levels of {label}: {'; '.join(texts)}")
    return lines


def other_levels(summary: Mapping[str, Any]) -> list[str]:
    """Return levels beside that of a vibration: mean over directions, power, other listeners."""
    if summary["source"] != "vibration":
        return []
    quantity = "LAE" if summary.get("single_event") else "LAeq"
    texts = []
    for key, name in MEANS.items():
        if key in summary:
            level = level_beside(summary, key)
            text = "not available" if level is None else f"{level:.1f} dB(A)"
            texts.append(f"{quantity} of {name}: {text}")
    power = summary.get("plate_power_level_db")
    if summary.get("listeners") and power is not None:
        texts.append(f"sound power of the plate: {power:.1f} dB re 1 pW")
    for listener in summary.get("listeners", ())[1:]:
        text = decibels_a(listener_level(summary, listener))
        texts.append(f"{quantity} at {bracketed(listener['at_mm'])} mm: {text}")
    return texts


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

"""Lines about runs for a terminal: what rolls, the two numbers, what follows, and what to doubt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from acoustics.numbers import bracketed, decibels_a, micrometres, rounded, rounded_up, si
from rolling.check import resolution
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.doubt import Severity
from rolling.numbers.quantity import BOUND, Quantity, Verdict, joined, uncertain
from rolling.results import verdict
from rolling.results.answer import follows, gap
from rolling.results.channels import channel_line
from rolling.results.description import runs_sentence
from rolling.results.labels import labels
from rolling.results.level_words import number_rows
from rolling.results.notes import REPEATS, TURNS
from rolling.results.run_doubts import band_error_db, band_text
from rolling.results.run_quantities import LAE, heard_levels, level_beside, measure
from rolling.results.shared_lines import numbered_runs
from rolling.scene.messages import TABLES
from rolling.terminal.streams import columns, folded, line_width

MAX_STEPS = 8  # of the preparation of height files that are written; one run has at most 7
MAX_BAND_DB = 0.3  # what the steps may cut off of a level that is corrected for its errors
UPPER_BOUND = "released power: what one would hear if all of it were sound (q = 1)"
LEAST_DB = 0.01  # smallest error that the line of grid and solver names
CORRECTED = ("grid", "solver")  # sources whose errors a corrected level does not have

Solved = Sequence[tuple[str, RunNumbers]]  # label and numbers of each run


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
    solved = numbered_runs(runs)
    for label, numbers in solved:
        before = f"{label}, " if len(solved) > 1 else ""
        lines += [f"{before}{channel_line(channel)}" for channel in numbers.channels or ()]
    return [folded(line) for line in lines]


def doubt_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return the few lines on what the numbers are worth: doubt, grid and solver, surface."""
    solved = numbered_runs(runs)
    if not solved:
        return []
    lines = [*_missing(solved), *_largest_doubts(solved)]
    lines += [_grid_and_solver(solved), *_instrument(solved), _surface(solved)]
    return [folded(line) for line in lines if line]


def further_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return all other numbers, notes and warnings of runs, for --verbose."""
    solved = numbered_runs(runs)
    if not solved:
        return []
    every = [numbers for _, numbers in solved]
    lines = [gap(every), *_at_listeners(solved)]
    lines += [error_line(label, numbers) for label, numbers in solved]
    lines.append(verdict.headline(solved))
    lines += dict.fromkeys(surface_text(numbers) for numbers in every)
    lines += _preparation(every)
    noted = (*REPEATS, TURNS)
    lines += [f"note: {doubt.text}" for doubt in verdict.notes(solved) if doubt.key in noted]
    lines += [f"warning: {doubt.text}" for doubt in verdict.warnings(solved)]
    return [*(folded(line) for line in lines if line), "", *_number_tables(solved)]


# ---- table


class Head(NamedTuple):
    """Two lines of the head of a column of the table of levels."""

    name: str
    unit: str = ""


def levels_table(runs: Sequence[RunFolder]) -> str:
    """Write the two numbers of runs in columns, with the verdict on the number to its left."""
    by_run = {label: _cells(numbers) for label, numbers in numbered_runs(runs)}
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


def _cells(numbers: RunNumbers) -> dict[Head, str]:
    """Return the cells of a run in the table of levels by their heads."""
    vibration = numbers.vibration
    released = numbers.released_power
    cells = {_head("vibration", vibration): vibration.number}
    if numbers.leading.judged is not None:
        cells[Head("verdict")] = numbers.leading.judged.short
    if numbers.record.single_event and numbers.record.source == "vibration":
        levels = heard_levels(numbers)
        spread = None if levels.spreads is None else levels.spreads.laf_max_db
        text = "-" if levels.laf_max_db is None else uncertain(levels.laf_max_db, spread)
        cells[Head("LAFmax", "dB(A)")] = text
    if released.value is not None:
        cells[_head("released power", released)] = released.number
    cells[Head("plastic", "ratio")] = f"{numbers.contact.plastic_ratio:.3f}"
    return cells


def _head(name: str, quantity: Quantity) -> Head:
    """Return the head of one of the two numbers: what it is, and how it was found."""
    unit = "dB(A)" if quantity.measure != LAE else "LAE, dB(A)"
    return Head(name, unit if quantity.value is None else f"{quantity.how}, {unit}")


def html_table(runs: Sequence[RunFolder]) -> str:
    """Write sentence, table and conclusion of runs as HTML for a notebook."""
    rows = "<tr><th>run</th><th>vibration</th><th>verdict</th><th>released power</th></tr>"
    for label, numbers in numbered_runs(runs):
        judged = numbers.leading.judged
        cells = [
            label,
            str(numbers.vibration),
            "-" if judged is None else judged.short,
            str(numbers.released_power),
        ]
        rows += f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"
    first = escape(runs_sentence(runs))
    last = escape(follows(runs))
    return f"<p>{first}</p><table>{rows}</table><p>{last}</p>"


# ---- what the numbers are worth


def _missing(runs: Solved) -> list[str]:
    """Say why a number is missing, each reason once."""
    lines = dict[str, None]()
    for _, numbers in runs:
        if numbers.vibration.value is None:
            lines[f"vibration: {numbers.vibration}"] = None
    for _, numbers in runs:
        if numbers.released_power.value is None:
            lines[f"released power: {numbers.released_power}"] = None
    return [*lines]


def _largest_doubts(runs: Solved) -> list[str]:
    """Write the largest doubt about each of the two numbers, and how many others there are."""
    of_vibration = [(label, numbers.vibration.judged) for label, numbers in runs]
    of_release = [
        (label, numbers.released_power.judged)
        for label, numbers in runs
        if numbers.released_power.is_solved
    ]
    lines = []
    for name, judged in (("vibration", of_vibration), ("released power", of_release)):
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
    bounds = [numbers.released_power for _, numbers in runs]
    if any(bound.verdict == BOUND for bound in bounds):
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
    largest = []
    for _, numbers in runs:
        errors = numbers.errors
        if errors.grid_db is None:
            continue
        grid = math.hypot(errors.grid_db, errors.grid_uncertainty_db or 0.0)
        detail = math.hypot(errors.subgrid_db or 0.0, errors.subgrid_uncertainty_db or 0.0)
        largest.append(max(grid, detail, abs(errors.solver_db or 0.0)))
    if not largest:
        known = [numbers.errors.reason for _, numbers in runs if numbers.errors.reason]
        why = known[0] if known else "numerics.error_estimate: true does it"
        return f"grid and solver: errors not measured ({why})"
    size = max(LEAST_DB, math.ceil(100 * max(largest)) / 100)  # no error prints as 0.00 dB
    return f"grid and solver: errors below {size:g} dB"


def _instrument(runs: Solved) -> list[str]:
    """Write in one line what the instruments of measurements leave of both numbers of runs."""
    lines = dict[str, None]()
    for _, numbers in runs:
        seen = numbers.surface.instrument
        if seen is None:
            continue
        text = f"measuring instrument: sees waves above {si(seen.cutoff_m, 'm')}"
        if seen.noise_m:
            share = rounded(100 * (seen.noise_over_sq or 0.0))
            text += f", noise {si(seen.noise_m, 'm')} rms ({share} % of Sq)"
        for name, of_source in (
            ("vibration", seen.vibration),
            ("released power", seen.released_power),
        ):
            spread = None if of_source is None else of_source.spread_db
            words = "unknown" if spread is None else f"± {rounded_up(spread)} dB"
            text += f"; {name} {words}"
        lines[text] = None
    return [*lines]


def _surface(runs: Solved) -> str:
    """Write the surface in one line, with the name of its run where runs differ."""
    texts = [(label, _short_surface(numbers)) for label, numbers in runs]
    label, text = texts[0]
    others = len({text for _, text in texts}) - 1
    if not others:
        return f"surface: {text}"
    return f"surface of {label}: {text} ({_count(others, 'other')} with -v)"


def _short_surface(numbers: RunNumbers) -> str:
    """Write the roughness of a surface in a few numbers."""
    surface = numbers.surface
    text = (
        f"Ra {rounded(surface.ra_m * 1e6, 3)} µm, Rq {rounded(surface.rq_m * 1e6, 3)} µm, "
        f"rms slope {rounded(surface.rms_slope, 3)}"
    )
    if surface.ball_ra_m is not None:
        text += ", of plate and ball together"
    return text


# ---- with --verbose


def error_line(label: str, numbers: RunNumbers) -> str:
    """Write the error estimate of a run, or an empty text without one."""
    errors = numbers.errors
    own = numbers.of_record
    if errors.stretches is None or errors.grid_db is None or own.laeq_db is None:
        return ""
    grid = errors.grid_db
    grid_spread = errors.grid_uncertainty_db or 0.0
    solver = errors.solver_db or 0.0
    signals = {"grid": errors.grid_signal_db, "solver": errors.solver_signal_db}
    signal = [f"{db:.0f} dB from the {name}" for name, db in signals.items() if db is not None]
    texts = [f"LAeq {grid:+.2f} ± {grid_spread:.2f} dB from the grid"]
    if errors.subgrid_db:
        of_detail = errors.subgrid_uncertainty_db or 0.0
        detail = f"{errors.subgrid_db:+.2f} ± {of_detail:.2f} dB"
        texts.append(f"{detail} from missing detail below the spacing")
    texts.append(f"{solver:+.2f} dB from the solver")
    parts = numbers.quantity_of_record.parts
    whole = math.hypot(joined(parts, left_out=CORRECTED), grid_spread) if parts else None
    corrected = f"corrected LAeq {uncertain(own.laeq_db - grid - solver, whole)} dB(A)"
    band_db = band_error_db(numbers)
    if band_db is not None and band_db > MAX_BAND_DB and errors.band_end_hz is not None:
        corrected = f"no corrected level, because {band_text(numbers, errors.band_end_hz)}"
    return (
        f"errors of {label}: {', '.join(texts)}, {corrected}; rms error of the "
        f"{numbers.record.source} over its fluctuation {', '.join(signal)}; {errors.stretches} "
        f"stretches of {errors.stretch_steps} steps, order {errors.order:.1f}"
    )


def _number_tables(runs: Solved) -> list[str]:
    """Write the numbers of runs that have a word in a table, or in one a run if it is too wide."""
    table = _number_table(runs)
    if max(map(len, table.splitlines())) <= line_width():
        return [table]
    return [f"{_number_table([run])}\n" for run in runs]


def _number_table(runs: Solved) -> str:
    """Write the numbers of runs in aligned columns, a column each."""
    rows = number_rows([numbers for _, numbers in runs])
    return columns([["", *(label for label, _ in runs)], *([row.head, *row.cells] for row in rows)])


def _at_listeners(runs: Solved) -> list[str]:
    """Write the levels of runs at other listeners than the first."""
    lines = []
    for label, numbers in runs:
        texts = other_listeners(numbers)
        if texts:
            lines.append(f"other listeners of {label}: {'; '.join(texts)}")
    return lines


def other_listeners(numbers: RunNumbers) -> list[str]:
    """Return the levels of the vibration of a run at other listeners than the first."""
    if numbers.record.source != "vibration":
        return []
    name = measure(numbers)
    texts = []
    for listener in (numbers.levels.listeners or ())[1:]:
        text = decibels_a(level_beside(numbers, listener.laeq_db))
        texts.append(f"{name} at {bracketed(listener.at_mm)} mm: {text}")
    return texts


def _preparation(every: Sequence[RunNumbers]) -> list[str]:
    """Write the steps that prepared height files, each once, and the tilts that were removed."""
    steps = dict[str, None]()
    tilts = dict[str, None]()
    for numbers in every:
        for step in numbers.surface.preparation or ():
            name = TABLES["steps"].get(step.step, step.step)
            steps[f"{name}: {step.text}"] = None
        levelling = numbers.surface.levelling
        if levelling is not None and (levelling.slope_along or levelling.slope_across):
            tilts[f"tilt: {levelling.text}"] = None
    lines = [*steps][:MAX_STEPS]
    more = len(steps) - MAX_STEPS
    if more > 0:
        lines.append(f"{more} more steps of the preparation: in each summary.json")
    return [*lines, *tilts]


def surface_text(numbers: RunNumbers) -> str:
    """Write the statistics of the surface of a run."""
    surface = numbers.surface
    return (
        f"surface: Ra {micrometres(surface.ra_m)} µm, Rq {micrometres(surface.rq_m)} µm, "
        f"skewness {surface.skewness:.2f}, kurtosis {surface.kurtosis:.2f}, rms slope "
        f"{rounded(surface.rms_slope, 3)}{surface_parts(numbers)}"
    )


def surface_parts(numbers: RunNumbers) -> str:
    """Write the roughness of plate and sphere, whose sum a sphere with a surface rolls over."""
    surface = numbers.surface
    if surface.plate_ra_m is None or surface.ball_ra_m is None:
        return ""
    return (
        f"; plate Ra {micrometres(surface.plate_ra_m)} µm and sphere Ra "
        f"{micrometres(surface.ball_ra_m)} µm, added up over the turns"
    )

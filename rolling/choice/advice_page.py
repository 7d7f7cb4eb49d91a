"""Pages of advice: what would help, which value stays below a level, and which waves to lower."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes

from acoustics.texts import printable
from rolling.choice.advice_pictures import plot_design, plot_limit
from rolling.choice.change_words import in_words
from rolling.figures.picture import finish, picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.page_parts import Part
from rolling.kinds.run_folder import RunFolder
from rolling.report import text
from rolling.report.condition_parts import conditions_part, methods_part
from rolling.report.level_bars import Bars, Row, bars_around_zero
from rolling.report.machine_drawing import MachineDrawing, drawing_of
from rolling.report.page_of_parts import PageOfParts, exhibit
from rolling.results import labels
from rolling.results.notes import UNVALIDATED

if TYPE_CHECKING:
    from rolling.choice.advice import Advice
    from rolling.choice.design import Design
    from rolling.choice.limit import Limit, Point
    from rolling.choice.sensitivity import Sensitivities, Sensitivity


def sensitivities_page(result: Sensitivities) -> bytes:
    """Write the page of what would help: the change by each value of the drawing as a bar."""
    heads = ["Value", f"per step, {result.quantity.decibels}", "linear chain", "specimens"]
    rows = [_cells(row) for row in result.rows]
    title = f"What would make it quieter? {_title(result)}"
    return _page(result, title, {"bars": _bars(result), "charts": []}, heads, rows)


def _bars(result: Sensitivities) -> Bars | None:
    """Return the changes as bars with their ± and the linear chain; None without any."""
    if not result.rows:
        return None
    where = "" if result.quantity.is_level else f" from {result.quantity.words}"
    chain = ""
    if any(row.chain_db is not None for row in result.rows):
        chain = "; the line across a bar is the linear chain"
    unit = result.quantity.decibels
    label = f"Louder{where} with a larger value [{unit}]; left is quieter{chain}"
    rows = []
    for row in result.rows:
        words = in_words(row.db, row.uncertainty_db, result.quantity).removesuffix(f" {unit}")
        value, _, spread = words.partition(" ± ")
        low = high = None
        if row.uncertainty_db is not None:
            low = row.db - row.uncertainty_db
            high = row.db + row.uncertainty_db
        bar = Row(
            name=_name(row),
            value=row.db,
            low=low,
            high=high,
            words=value,
            spread=f"± {spread}" if spread else "",
            beside=row.chain_db,
        )
        rows.append(bar)
    return bars_around_zero(label, rows)


def _name(row: Sensitivity) -> str:
    """Name a value of the drawing with its step."""
    return printable(f"{row.change.name}, +{row.change.step}")


def _cells(row: Sensitivity) -> list[str]:
    """Return the cells of a value in the table."""
    chain = ""
    if row.chain_db is not None:
        chain = in_words(row.chain_db, row.chain_uncertainty_db, row.quantity)
    computed = in_words(row.db, row.uncertainty_db, row.quantity)
    return [_name(row), computed, chain, str(row.difference.pairs)]


def limit_page(result: Limit) -> bytes:
    """Write the page of a search for the coarsest value below a level."""
    unit = result.quantity.level_unit
    word, _ = labels.named(result.key)
    charts = []
    with left_out_if_it_fails("below"):
        charts.append(exhibit(picture("below", partial(_search, result))))
    heads = ["Value", f"mean, {unit}", f"95 % lie below, {unit}", "specimens", "step of the search"]
    rows: list[list[str]] = []
    for number, point in enumerate(result.points, start=1):
        rows.append(
            [
                printable(labels.worded(result.key, point.value)),
                f"{point.mean_db:.1f}",
                f"{point.upper_db:.1f}",
                _count_cell(point),
                str(number),
            ]
        )
    title = f"Which {word} stays below {result.level_db:g} {unit}? {_title(result)}"
    return _page(result, title, {"bars": None, "charts": charts}, heads, rows)


def _count_cell(point: Point) -> str:
    """Return the cell of the number of specimens of a value, and as how many they count."""
    count = str(len(point.levels_db))
    if point.independent is None:
        return count
    return f"{count}, as {point.independent:.1f} independent"


def design_page(result: Design) -> bytes:
    """Write the page of a design: amplitudes of waves as they are and as they are aimed at."""
    charts = []
    with left_out_if_it_fails("design"):
        charts.append(exhibit(picture("design", partial(_design, result))))
    heads = ["Wavelength", "rms now", "target", "lower by", "fall of the level"]
    rows: list[list[str]] = []
    for row in result.table().itertuples():
        response = f"{row.response_db_per_db:.3f}"
        if math.isfinite(row.response_error_db_per_db):
            response += f" ± {row.response_error_db_per_db:.3f}"
        rows.append(
            [
                f"{row.wavelength_um:g} um",
                f"{row.amplitude_now_nm:.3g} nm",
                f"{row.amplitude_target_nm:.3g} nm",
                f"{row.lowered_db:.1f} dB",
                f"{response} dB/dB",
            ]
        )
    title = f"Which waves must be lower? {_title(result)}"
    return _page(result, title, {"bars": None, "charts": charts}, heads, rows)


def _title(result: Advice) -> str:
    """Say what rolls on what, or give the name of a scene that is not known."""
    if result.scene is None:
        return printable(result.name)
    return text.titles([RunFolder({}, result.scene, result.folder)])


def _drawing(result: Advice) -> MachineDrawing | None:
    """Draw the machine of the scene; None where the scene is not known."""
    return None if result.scene is None else drawing_of([result.scene])


def _search(result: Limit, ax: Axes) -> Axes:
    """Plot the path of a search with a title and a note."""
    note = f"all {result.noun} as points; 95 % of them lie below the curve with 95 % confidence"
    return finish(plot_limit(result, ax), f"Search in {result.name}", [note])


def _design(result: Design, ax: Axes) -> Axes:
    """Plot the amplitudes of a design with a title and a note."""
    note = f"profiles along the track of {result.fall.pairs} {result.noun}; phases stay"
    return finish(plot_design(result, ax), f"Waves of {result.name}", [note])


def _doubts(sentences: Sequence[str]) -> Part:
    """Return the section on what to doubt."""
    values: dict[str, Any] = {
        "doubts": sentences,
        "headline": "",
        "notes": [UNVALIDATED],
        "doubted": [],
    }
    return Part("doubts.html", values)


def _page(
    result: Advice, title: str, shown: dict[str, Any], heads: list[str], rows: list[list[str]]
) -> bytes:
    """Write a page of an answer: its lead, bars and charts, what to doubt, a table, methods."""
    lead, *others = result.sentences
    made = PageOfParts(
        title=title,
        machine=_drawing(result),
        first=[
            conditions_part(result.conditions),
            Part("advice_first.html", {"lead": lead} | shown),
        ],
        parts=[
            _doubts(others),
            Part("table.html", {"heads": heads, "rows": rows}),
            methods_part(result.methods),
        ],
    )
    return made.written()

"""The conformance page of `acoustics` in Markdown: results against standards and own requirements.

`python tests/benchmarks/conformance_page.py` computes every number on the page and prints it. The
standards are IEC 61672-1 and IEC 61260-1.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence

from conformance import bands, levels, resampling
from conformance.rows import MAX_DB, Row, Table

COMMAND = "python tests/benchmarks/conformance_page.py > acoustics/CONFORMANCE.md"

_HEADS = ("expected", "computed", "difference", "lower limit", "upper limit")


def tables() -> tuple[Table, ...]:
    """Compute all tables of the page."""
    return (
        levels.a_weighting(),
        levels.tone_bursts(),
        levels.decay_rates(),
        levels.steady_tone(),
        bands.mid_band_frequencies(),
        bands.band_edges(),
        bands.closed_records(),
        bands.open_records(),
        bands.effective_bandwidth(),
        resampling.resampled_levels(),
        resampling.step_mean_correction(),
        resampling.alias_rejection(),
        resampling.varying_speed(),
        levels.levels(),
    )


def page(measured: Sequence[Table]) -> str:
    """Write the page in Markdown: introduction, summary and tables."""
    summary = [
        (
            f"{number}. {table.title}",
            table.source,
            len(table.rows),
            _number(table.worst.share, 1),
            verdict(table),
        )
        for number, table in enumerate(measured, start=1)
    ]
    parts = [
        "# Conformance of the package `acoustics`",
        "**Do weightings, third octaves, resampling and levels meet class 1 of IEC 61672-1 and "
        "IEC 61260-1?** Weightings, time weightings and the bands of records that close do. Third "
        "octaves of records that do not close exceed the limits in some cases (section 8): for "
        "tones several octaves outside the band, and in bands of a few lines. The effective "
        "bandwidth of the lowest bands exceeds them, too (section 9). Only arithmetic is tested "
        "here: no microphone, no display, no environment. This is no pattern evaluation.",
        f"This command computes every number on this page:\n\n```sh\n{COMMAND}\n```\n\n"
        "A test fails when the page differs from its output.",
        "## How to read the tables",
        "- *Limits* are on the difference between computed and expected. The attenuation of a "
        "tone outside a band is infinite in the ideal case (∞); its lower limit is the minimum "
        "attenuation.\n"
        "- *Share* is the part of the tolerance used: the difference over the limit on its side, "
        "or the required over the computed attenuation. Above 100 % the limit is exceeded, and "
        "the share is in **bold**.\n"
        f"- *> {MAX_DB:g}* means that the remainder is rounding, or close to it.\n"
        "- *Class 1* stands for the acceptance limits of IEC 61672-1:2013 and IEC 61260-1:2014. "
        "They leave out the uncertainty of a testing laboratory, which the tolerance limits of "
        "earlier editions included.",
        "## Summary",
        _markdown(("section", "source", "rows", "worst share %", "verdict"), summary, "llrrl"),
    ]
    for number, table in enumerate(measured, start=1):
        cells = [(*row.keys, *_cells(row, table.decimals)) for row in table.rows]
        heads = (*table.heads, *(f"{head} {table.unit}" for head in _HEADS), "share %")
        parts += [
            f"## {number}. {table.title}",
            f"{table.source[0].upper()}{table.source[1:]}. {table.text}",
            _markdown(heads, cells, "l" * len(table.heads) + "r" * (len(_HEADS) + 1)),
            f"{len(table.rows)} rows, worst share {_number(table.worst.share, 1)} % "
            f"({', '.join(table.worst.keys)}): {verdict(table)}.",
        ]
        if table.after:
            parts.append(table.after)
    return "\n\n".join(parts) + "\n"


def verdict(table: Table) -> str:
    """State that all rows are within the limits, or count the rows outside."""
    if table.outside:
        return f"**{len(table.outside)} of {len(table.rows)} outside {table.limits}**"
    return f"all within {table.limits}"


def _cells(row: Row, decimals: int) -> tuple[str, ...]:
    share = _number(row.share, 1)
    if math.isinf(row.expected):
        computed = f"> {MAX_DB:g}" if math.isinf(row.computed) else _number(row.computed, decimals)
        difference = ""
        lower = _number(row.lower, decimals)
        upper = ""
    else:
        computed = _number(row.computed, decimals)
        difference = _number(row.difference, decimals, signed=True)
        lower, upper = (_number(limit, decimals, signed=True) for limit in (row.lower, row.upper))
    return (
        _number(row.expected, decimals),
        computed,
        difference,
        lower,
        upper,
        share if row.within else f"**{share}**",
    )


def _number(value: float, decimals: int, signed: bool = False) -> str:
    """Write a rounded number without the sign of a zero, so that rounding does not show.

    The text is empty for a missing limit.
    """
    if math.isinf(value):
        return "∞" if value > 0.0 else ""
    rounded = round(value, decimals) + 0.0  # turns -0.0 into 0.0
    if signed and rounded:
        return f"{rounded:+.{decimals}f}"
    return f"{rounded:.{decimals}f}"


def _markdown(heads: Sequence[str], rows: Iterable[Sequence[object]], align: str) -> str:
    """Write a Markdown table with padded columns; ``align`` holds l or r for each."""
    cells = [[str(cell) for cell in row] for row in [heads, *rows]]
    widths = []
    for k in range(len(cells[0])):
        longest = max(len(row[k]) for row in cells)
        widths.append(max(3, longest))

    def line(row: Sequence[str]) -> str:
        padded = (
            cell.rjust(width) if side == "r" else cell.ljust(width)
            for cell, width, side in zip(row, widths, align, strict=True)
        )
        return f"| {' | '.join(padded)} |"

    rule = [
        "-" * (width - 1) + ":" if side == "r" else "-" * width
        for width, side in zip(widths, align, strict=True)
    ]
    return "\n".join([line(cells[0]), line(rule), *map(line, cells[1:])])


def main() -> None:
    """Print the page."""
    sys.stdout.buffer.write(page(tables()).encode())  # UTF-8 and plain line ends wherever it runs


if __name__ == "__main__":
    main()

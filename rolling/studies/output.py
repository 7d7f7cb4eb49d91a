"""Tables and pictures of studies in files: one form of both for all commands."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURE_DPI = 110


def markdown_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table in Markdown, a line for each row of cells."""
    lines = [_markdown_row(columns), _markdown_row(["---"] * len(columns))]
    lines += [_markdown_row(cells) for cells in rows]
    return "\n".join(lines)


def _markdown_row(cells: Sequence[str]) -> str:
    """Write a row of a table in Markdown."""
    return f"|{'|'.join(cells)}|"


def png(figure: Figure) -> bytes:
    """Draw a figure as a PNG file."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=PICTURE_DPI)
    return content.getvalue()

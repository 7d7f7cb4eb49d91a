"""Rows of the check of one run, each with the line of its doubt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rolling.check.findings import check_run
from rolling.scene.scene import Scene

if TYPE_CHECKING:
    from rolling.check.probe import Probe


@dataclass(frozen=True)
class Row:
    """A row of the check; its warning is the line of the doubt of its key, or None."""

    key: str
    quantity: str
    value: str
    seconds: float
    warning: str | None


def checked(scene: Scene, solved: Probe | None = None) -> list[Row]:
    """Return the rows of one run with their doubts."""
    rows, doubts = check_run(scene, solved)
    lines = {doubt.key: doubt.line for doubt in doubts}
    return [Row(x.key, x.quantity, x.value, x.seconds, lines.get(x.key)) for x in rows]

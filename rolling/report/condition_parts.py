"""Conditions of an answer as parts of its page: the first lines, and the paragraph on methods."""

from __future__ import annotations

from rolling.kinds.page_parts import Part
from rolling.numbers.conditions import Conditions


def conditions_part(conditions: Conditions) -> Part:
    """Return the conditions for the first view of a page: what leads, and all in a fold."""
    return Part("conditions.html", {"lead": conditions.lead, "lines": conditions.lines})


def methods_part(paragraph: str) -> Part:
    """Return the fold with the paragraph on methods."""
    return Part("methods.html", {"methods": paragraph})

"""Parts of a page: a kind of scene gives those of its runs, beside the ones that all pages have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Part:
    """A part of a page: a template of `report/assets` and its values.

    Parameters
    ----------
    template : str
        Template of the part alone.
    values : mapping
        Values for it, beside those that all parts of the page share. Default: none.
    """

    template: str
    values: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class PageParts:
    """What the page of runs of one kind has of its own.

    Parts stand in the order of the page: title, drawing, first view, what stays beside, charts,
    what to doubt, how to make it again, and what few people ask for.

    has_drawing_within : bool
        Whether the first view has the drawing of the machine within it. Default: it stands between
        title and first view.
    first : sequence of Part, optional
        The first view, below title and drawing: sentence, quantity, Play. Default: the sentences,
        the quantities and the players that all runs have.
    beside : sequence of Part
        Parts between the first view and the charts: a bar of the player, the contents.
    charts : sequence of Part
        Charts, and what else answers.
    doubted : sequence of Part
        What the section on doubts has beside the doubts.
    more : sequence of Part
        What few people ask for, folded, at the end.
    has_number_table : bool
        Whether the table of all numbers has a section of its own. Default: true.
    styles : sequence of str
        Style sheets beside those of all pages.
    has_plain_players : bool
        Whether it has a plain player for each sound of its runs. Default: true.
    script, engine : str
        Modules of scripts: the first runs on the page, the second one in a worker. Empty: none.
    shared : mapping
        Values and functions for all its parts.
    data : mapping
        Data for its scripts.
    charted : object, optional
        The list of its charts, with the methods of `report/page_of_parts.py: ChartList`. Default: a
        new one.
    cited : sequence of str
        Works that it cites beside the program.
    """

    has_drawing_within: bool = False
    first: Sequence[Part] | None = None
    beside: Sequence[Part] = ()
    charts: Sequence[Part] = ()
    doubted: Sequence[Part] = ()
    more: Sequence[Part] = ()
    has_number_table: bool = True
    styles: Sequence[str] = ()
    has_plain_players: bool = True
    script: str = "page/plain.js"
    engine: str = ""
    shared: Mapping[str, Any] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    charted: Any = None
    cited: Sequence[str] = ()

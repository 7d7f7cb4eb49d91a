"""Parts of a page that a kind of scene gives its runs, beside those that all pages have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class PageParts:
    """What the page of runs of one kind has of its own.

    template : str
        Template, which extends page.html. Default: page.html itself.
    styles : tuple of str
        Style sheets beside that of all pages.
    has_plain_players : bool
        Whether it has a plain player for each sound of its runs. Default: true.
    script, engine : str
        Modules of scripts: the first runs on the page, the second one in a worker. Empty: none.
    values : mapping
        Values for the template.
    shared : mapping
        Values and functions for its macros.
    data : mapping
        Data for its scripts.
    """

    template: str = "page.html"
    styles: tuple[str, ...] = ()
    has_plain_players: bool = True
    script: str = "page/players.js"
    engine: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    shared: Mapping[str, Any] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)

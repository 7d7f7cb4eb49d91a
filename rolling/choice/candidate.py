"""Candidates of a choice: scenes with their labels, of any kind."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

MAX_CANDIDATES = 24
LONGEST_NAME = 80  # letters of the name of a folder


@dataclass(frozen=True, eq=False)
class Candidate:
    """One of the scenes among which a person chooses.

    label : str. What it is called in sentences.
    scene : scene of any kind. A scene without a sweep.
    """

    label: str
    scene: Any

    @property
    def folder_name(self) -> str:
        """Name of the folder of its specimens."""
        return slug(self.label)[:LONGEST_NAME]


def slug(label: str) -> str:
    """Write a label in letters that every file system takes."""
    return re.sub(r"[^A-Za-z0-9.=-]+", "_", label.replace("µ", "u")).strip("._") or "candidate"

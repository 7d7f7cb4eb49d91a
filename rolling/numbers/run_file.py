"""What a run folder holds of the numbers of a run of a ball."""

from __future__ import annotations

from dataclasses import dataclass

from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.files import FileFacts, Provenance

FORMAT = 1  # of numbers.json and summary.json
KIND = "ball"


@dataclass(frozen=True, kw_only=True)
class StoredNumbers:
    """The numbers of a run with facts about its files."""

    format: int = FORMAT
    kind: str = KIND
    numbers: RunNumbers
    files: FileFacts
    provenance: Provenance

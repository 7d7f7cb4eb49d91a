"""What a run folder holds of the numbers of a run of a ball, or of a bearing."""

from __future__ import annotations

from dataclasses import dataclass

from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.file_facts import BearingFiles, FileFacts, Provenance

FORMAT = 1  # of numbers.json and summary.json
KIND = "ball"
BEARING_FORMAT = 2  # of these files of a bearing; format 1 had flat names in summary.json
BEARING_KIND = "bearing"


@dataclass(frozen=True, kw_only=True)
class StoredNumbers:
    """The numbers of a run with facts about its files."""

    format: int = FORMAT
    kind: str = KIND
    numbers: RunNumbers
    files: FileFacts
    provenance: Provenance


@dataclass(frozen=True, kw_only=True)
class StoredBearing:
    """The numbers of a run of a bearing with facts about its files."""

    format: int = BEARING_FORMAT
    kind: str = BEARING_KIND
    numbers: BearingNumbers
    files: BearingFiles
    provenance: Provenance

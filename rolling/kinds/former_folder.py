"""Folders of version 0.8: they are recognised, and refused where a run would go on in them."""

from __future__ import annotations

import json
from collections.abc import Iterable

from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import MAX_NUMBERS, SUMMARY, RunFolder, is_former
from rolling.terminal.whole_files import FolderError, read_regular


def is_of_0_8(run: RunFolder) -> bool:
    """Tell whether version 0.8 wrote the numbers of a run, by the format of its summary."""
    if not is_former(run.folder):
        return False
    try:
        content = json.loads(read_regular(run.folder / SUMMARY, MAX_NUMBERS))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and content.get("format") == kind_of(run.scene).former_format


def refuse_former(runs: Iterable[RunFolder]) -> None:
    """Refuse to go on with runs of version 0.8, or to make their sound anew.

    Raises
    ------
    FolderError : one of the runs has the numbers of version 0.8.
    """
    for run in runs:
        if is_of_0_8(run):
            raise FolderError(
                f"{run.folder}: a run of version 0.8. This version shows it (`rolling report`,"
                " `table`), but does not go on with it or make its sound anew. Version 0.8.1 does;"
                " or solve its scene in a new folder, with another --out"
            )

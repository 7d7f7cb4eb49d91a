"""The common gain of a sweep, with which the sounds of each run are written again.

A run that ends does not know how loud the other runs of its sweep are, so its sounds have their own
gain. When the sweep ends or grows, all of them are written with one gain for each group. They then
depend on the runs alone, and not on the order in which runs, processes or parts ended.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import soundfile

from rolling.kinds.heard_sound import FileGain, common_gains
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RunFolder
from rolling.results import labels
from rolling.results.stored_numbers import read_stored, write_stored
from rolling.terminal import progress
from rolling.terminal.whole_files import open_regular, write_bytes

Read = Callable[[RunFolder, str], Any]  # of a run that is done, under a label


def _reader_of_files(run: RunFolder) -> Read:
    """Return the function that reads a run from its files."""
    return kind_of(run.scene).read_run


def each_here(function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Call a function with some arguments each, in this process."""
    return [function(*arguments) for arguments in calls]


def write_with_common_gain(
    runs: Sequence[RunFolder],
    reader_of: Callable[[RunFolder], Read] = _reader_of_files,
    each: Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], Any] = each_here,
) -> None:
    """Write the sounds of the runs of a sweep that are done with the gains that they share.

    A file that has this gain already stays as it is. The others are written from the sound of the
    run, because samples that were rounded twice would depend on the order of the runs.

    Parameters
    ----------
    runs : sequence of RunFolder
    reader_of : function. It returns the function that reads a run. Default: that of its kind.
    each : function. It calls a function of this module with some arguments each, in some process.

    Raises
    ------
    FolderError, SceneError : as `Kind.read_run`.
    OSError : a file cannot be written. The earlier file is kept, and the next call goes on.
    """
    stored = {run: read_stored(run.folder) for run in runs if run.is_done and run.values}
    files = {
        run: list(kind_of(run.scene).file_gains(stored_run)) for run, stored_run in stored.items()
    }
    gains = common_gains(file for of_run in files.values() for file in of_run)
    waiting = []
    for run, label in zip(runs, labels.labels(runs), strict=True):
        if run not in stored:
            continue
        is_named = stored[run].provenance.label == label
        wanted = {
            file.file: gains[file.group]
            for file in files[run]
            if not (is_named and _is_current(run.folder, file, gains[file.group]))
        }
        if wanted:
            waiting.append((run, label, wanted, reader_of(run)))
    if not waiting:
        return
    with progress.step("writing the sounds with one gain for the sweep"):
        each(_write_again, waiting)


def _is_current(folder: Path, file: FileGain, common: float) -> bool:
    """Tell whether a sound file and the numbers of its run have the common gain.

    The file is asked as well as the numbers, because a command may have ended between the two.
    """
    if file.used != common:
        return False
    try:
        with open_regular(folder / file.file) as stream, soundfile.SoundFile(stream) as sound:
            return file.words(common) in sound.comment
    except (OSError, ValueError, soundfile.LibsndfileError):
        return False


def _write_again(run: RunFolder, label: str, gains: Mapping[str, float], read: Read) -> None:
    """Write sounds of a run with common gains by file, then its numbers, which name the gains."""
    opened = read(run, label)
    if opened.stored is None:
        return
    facts = {}
    for sound in kind_of(run.scene).sounds(opened):
        if sound.file in gains:
            write_bytes(run.folder / sound.file, sound.wav(gains[sound.file]))
            facts[Path(sound.file).stem] = sound.facts(gains[sound.file])
    stored = replace(
        opened.stored,
        files=replace(opened.stored.files, **facts),
        provenance=replace(opened.stored.provenance, label=label),
    )
    write_stored(run.folder, stored)

"""The common gain of a sweep, with which listen.wav of each run is written again.

A run that ends does not know how loud the other runs of its sweep are, so its listen.wav has its
own gain. When the sweep ends or grows, all its listen.wav are written with one gain. They then
depend on the runs alone, and not on the order in which runs, processes or parts ended.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from rolling.kinds.run_folder import RunFolder
from rolling.numbers.files import ListenFacts
from rolling.numbers.run_file import StoredNumbers
from rolling.results import labels, listening
from rolling.results.listening import COMMON_GAIN, SILENCE, Gain
from rolling.results.run_result import LISTEN, Run, read_run
from rolling.results.stored_numbers import read_stored, write_stored
from rolling.terminal import progress
from rolling.terminal.files import write_bytes

Read = Callable[[RunFolder, str], Run]  # of a run that is done, under a label


def _reader_of_files(run: RunFolder) -> Read:
    """Return the function that reads a run from its files."""
    return read_run


def each_here(function: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Call a function with some arguments each, in this process."""
    return [function(*arguments) for arguments in calls]


def write_with_common_gain(
    runs: Sequence[RunFolder],
    reader_of: Callable[[RunFolder], Read] = _reader_of_files,
    each: Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], Any] = each_here,
) -> None:
    """Write listen.wav of the runs of a sweep that are done with the gain that they share.

    A file that has this gain already stays as it is. The others are written from the sound of the
    run, because samples that were rounded twice would depend on the order of the runs.

    Parameters
    ----------
    runs : sequence of RunFolder
    reader_of : function. It returns the function that reads a run. Default: `read_run` for all.
    each : function. It calls a function of this module with some arguments each, in some process.

    Raises
    ------
    FolderError, SceneError : as `read_run`.
    OSError : a file cannot be written. The earlier file is kept, and the next call goes on.
    """
    stored = {run: read_stored(run.folder) for run in runs if run.is_done and run.values}
    gains = common_gains(list(stored.values()))
    waiting = []
    for run, label in zip(runs, labels.labels(runs), strict=True):
        if run not in stored:
            continue
        common = gains.get(stored[run].numbers.record.source)
        if common is not None and not _is_current(run, label, stored[run].files.listen, common):
            waiting.append((run, label, common, reader_of(run)))
    if not waiting:
        return
    with progress.step("writing listen.wav with one gain for the sweep"):
        each(_write_again, waiting)


def common_gains(runs: Sequence[StoredNumbers]) -> dict[str, float]:
    """Return the common gain [full scale per Pa] of the runs of each source.

    It is the minimum of their own gains: the loudest run plays as it would alone, and none clips.
    Vibration and release have gains of their own, because one does not compare the two by ear.
    """
    gains: dict[str, float] = {}
    for stored in runs:
        listen = stored.files.listen
        own = listen.own_gain_full_scale_per_pa
        if own <= 0.0 or listen.rule == SILENCE:
            continue
        source = stored.numbers.record.source
        gains[source] = min(own, gains.get(source, own))
    return gains


def _is_current(run: RunFolder, label: str, listen: ListenFacts, common: float) -> bool:
    """Tell whether listen.wav and the numbers of a run have the common gain and its label.

    The file is asked as well as the numbers, because a command may have ended between the two.
    """
    if listen.rule == SILENCE:
        return True
    if listen.common_gain_full_scale_per_pa != common:
        return False
    gain = Gain(common, COMMON_GAIN)
    return listening.has_gain(run.folder / LISTEN, gain, listening.wav_title(run, label))


def _write_again(run: RunFolder, label: str, common: float, read: Read) -> None:
    """Write listen.wav of a run with a common gain, then its numbers, which name the gain."""
    opened = read(run, label)
    if opened.stored is None:
        return
    content, facts = listening.listen_wav(opened, common)
    write_bytes(run.folder / LISTEN, content)
    stored = replace(
        opened.stored,
        files=replace(opened.stored.files, listen=facts),
        provenance=replace(opened.stored.provenance, label=label),
    )
    write_stored(run.folder, stored)

"""The common gain of a sweep, with which listen.wav of each run is written again.

A run that ends does not know how loud the other runs of its sweep are, so its listen.wav has its
own gain. When the sweep ends or grows, all its listen.wav are written with one gain. They then
depend on the runs alone, and not on the order in which runs, processes or parts ended.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rolling.results import labels, listening
from rolling.results.listening import COMMON_GAIN, SILENCE, Gain
from rolling.results.run_folder import SUMMARY, RunFolder, read_summary
from rolling.results.run_result import LISTEN, Run, read_run
from rolling.terminal import progress
from rolling.terminal.files import write_bytes, write_json

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
    summaries = {}
    for run in runs:
        if run.is_done and run.values:
            summaries[run] = read_summary(run.folder / SUMMARY)
    gains = common_gains(list(summaries.values()))
    waiting = []
    for run, label in zip(runs, labels.labels(runs), strict=True):
        if run not in summaries:
            continue
        common = gains.get(summaries[run]["source"])
        if common is not None and not _is_current(run, label, summaries[run], common):
            waiting.append((run, label, common, reader_of(run)))
    if not waiting:
        return
    with progress.step("writing listen.wav with one gain for the sweep"):
        each(_write_again, waiting)


def common_gains(summaries: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the common gain [full scale per Pa] of the runs of each source.

    It is the minimum of their own gains: the loudest run plays as it would alone, and none clips.
    Vibration and release have gains of their own, because one does not compare the two by ear.
    """
    gains: dict[str, float] = {}
    for summary in summaries:
        listen = summary.get("listen", {})
        own = listen.get("own_gain_full_scale_per_pa")
        if not own or own < 0.0 or listen.get("rule") == SILENCE:
            continue
        source = summary["source"]
        gains[source] = min(own, gains.get(source, own))
    return gains


def _is_current(run: RunFolder, label: str, summary: Mapping[str, Any], common: float) -> bool:
    """Tell whether listen.wav and summary.json of a run have the common gain and its label.

    The file is asked as well as the summary, because a command may have ended between the two.
    """
    listen = summary.get("listen", {})
    if listen.get("rule") == SILENCE:
        return True
    if listen.get("common_gain_full_scale_per_pa") != common:
        return False
    gain = Gain(common, COMMON_GAIN)
    return listening.has_gain(run.folder / LISTEN, gain, listening.wav_title(run, label))


def _write_again(run: RunFolder, label: str, common: float, read: Read) -> None:
    """Write listen.wav of a run with a common gain, then its summary, which names the gain."""
    opened = read(run, label)
    content, facts = listening.listen_wav(opened, common)
    write_bytes(run.folder / LISTEN, content)
    provenance = opened.summary.get("provenance", {}) | {"label": label}
    write_json(run.folder / SUMMARY, opened.summary | {"listen": facts, "provenance": provenance})

"""The files of a run: result.h5, summary.json, signal.wav and listen.wav."""

from rolling.results import listening, result_file
from rolling.results.run_folder import RESULT, SUMMARY, RunFolder
from rolling.results.run_result import Run, hear
from rolling.results.summary import provenance
from rolling.results.summary_file import read_summary
from rolling.terminal.files import make_below, write_bytes, write_json

SIGNAL, LISTEN = "signal.wav", "listen.wav"
PASSES = "passes.wav"  # of a plate that remembers


def write_run(run: Run) -> None:
    """Write the files of a run into its folder, last summary.json, which tells that all are whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    listen_wav, listen = listening.listen_wav(run)
    contents = {LISTEN: listen_wav, RESULT: result_file.write_result(run)}
    if run.result.passes is not None:
        contents[PASSES], _ = listening.passes_wav(run)
    make_below(run.home, run.folder)
    run.sound.write_wav(run.folder / SIGNAL, listening.facts(run), listening.wav_title(run))
    for name, content in contents.items():
        write_bytes(run.folder / name, content)
    facts = {"listen": listen, "provenance": provenance(run.scene, run.label)}
    write_json(run.folder / SUMMARY, run.summary | facts)


def read_run(run: RunFolder, label: str) -> Run:
    """Read a run from its folder, with its stored numbers, under a label.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene or surface.
    SceneError : the heights of the scene cannot be read.
    """
    summary = read_summary(run.folder / SUMMARY)
    return hear(run, label, result_file.read_result(run.folder / RESULT, run.scene), summary)

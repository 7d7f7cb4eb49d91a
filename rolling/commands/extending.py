"""The command extend: long records with the spectra of stored runs, to listen to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from acoustics import extension, wav
from rolling.folders.files import FolderError
from rolling.simulation import batch, labels, sound_files
from rolling.simulation.batch import Run
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import read_runs
from rolling.terminal import defaults, progress


@dataclass(frozen=True)
class Extended:
    """An extended record that was written.

    label : str. Label of the run.
    path : Path. The sound file.
    text : str. Kurtosis of the record and of the extended one, in words.
    """

    label: str
    path: Path
    text: str


def extend(folder: Path, seconds: float = defaults.EXTENDED_SECONDS) -> Iterator[Extended]:
    """Write extended.wav and extended.json for each run of a run folder.

    All runs are read and checked before the first file is written.

    Parameters
    ----------
    folder : Path. The run folder.
    seconds : float, s. Length of the records to make. Default: 30.

    Yields
    ------
    Extended
        Each record as it is written.

    Raises
    ------
    FolderError : the folder is not a run folder, a run in it has no sound that can be extended, or
        `seconds` is not longer than its record or too long.
    """
    if seconds > defaults.MOST_EXTENDED_SECONDS:
        raise FolderError(
            f"--seconds: got {seconds:g}, allowed is up to {defaults.MOST_EXTENDED_SECONDS:g}"
        )
    runs = read_runs(folder)
    with progress.step("reading the runs, making their sound"):
        heard = [
            _heard(each, label, seconds)
            for each, label in zip(runs, labels.labels(runs), strict=True)
        ]
    for run in heard:
        yield _write(run, seconds)


def _heard(run: Run, label: str, seconds: float) -> RunResult:
    """Read a run and make its sound.

    Raises
    ------
    FolderError : the sound cannot be extended.
    """
    result = batch.stored(run)
    heard = hear(label, run.values, run.folder, run.scene, result) if result else None
    if heard is None:
        raise FolderError(f"{run.folder}: nothing is solved yet, so there is nothing to extend")
    if reason := heard.sound.not_extendable:
        raise FolderError(f"{run.folder}: {reason}, so it cannot be extended")
    if seconds <= heard.sound.duration:
        raise FolderError(
            f"{run.folder}: --seconds: got {seconds:g}, the record itself is"
            f" {heard.sound.duration:.4g} s long; give more"
        )
    return heard


def _write(run: RunResult, seconds: float) -> Extended:
    """Extend the record of a run and write it."""
    record = run.sound.pressure
    extended = extension.extend(
        record, round(seconds * wav.SAMPLE_RATE_HZ), wav.SAMPLE_RATE_HZ, run.laps
    )
    sound_files.write_extended(run.folder, run.scene, run.label, run.sound, extended)
    text = (
        f"kurtosis {extension.kurtosis(extended):.1f}, of the record"
        f" {extension.kurtosis(record):.1f} (3: Gaussian noise)"
    )
    return Extended(run.label, run.folder / "extended.wav", text)

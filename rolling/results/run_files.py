"""The files of a run: result.h5, summary.json, signal.wav and listen.wav."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from acoustics import extension, wav
from acoustics.arrays import Array
from rolling.results import result_file
from rolling.results.run_result import Run, hear
from rolling.results.summary import provenance
from rolling.results.summary_file import read_summary
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.terminal.files import make_below, write_bytes, write_json

RESULT, SUMMARY, SIGNAL, LISTEN = "result.h5", "summary.json", "signal.wav", "listen.wav"
EXTENDED = (
    "stationary Gaussian noise with the band levels of the record; it has none of the record's"
    " single events and never repeats"
)


def write_run(run: Run) -> None:
    """Write the files of a run into its folder, last summary.json, which tells that all are whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    sound, gain = run.sound, wav.listening_gain(run.sound.pressure)
    facts, title = _facts(run), f"{run.scene.name}, {run.label}"
    comment = f"{gain:.6g} full scale per Pa, {_rule(run, gain)}; {facts}"
    contents = {
        SIGNAL: wav.calibrated(sound.pressure, f"1.0 = 1 Pa; {facts}", title, sound.loops),
        LISTEN: wav.listening(sound.pressure, gain, comment, title, loops=sound.loops),
        RESULT: result_file.write_result(run),
    }
    make_below(run.home, run.folder)
    for name, content in contents.items():
        write_bytes(run.folder / name, content)
    write_json(
        run.folder / SUMMARY,
        run.summary
        | {"listen": _listen(run, gain), "provenance": provenance(run.scene, run.label)},
    )


def read_run(folder: Path, scene: Scene, values: Mapping[str, Value], label: str) -> Run:
    """Read a run from its folder, with its stored numbers.

    folder : Path. The folder with the files of the run.
    scene : Scene. The scene without a sweep.
    values : mapping. The swept values of the run by dotted key.
    label : str. The label that distinguishes it from other runs.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene or surface.
    SceneError : the heights of the scene cannot be read.
    """
    summary = read_summary(folder / SUMMARY)
    result = result_file.read_result(folder / RESULT, scene)
    return hear(label, values, folder, scene, result, summary)


def write_extended(run: Run, extended: Array) -> Path:
    """Write extended.wav, a long record [Pa] for the ear, and return its path.

    Raises
    ------
    OSError : the file cannot be written. An earlier file is kept.
    """
    gain = wav.listening_gain(extended)
    kurtosis = extension.kurtosis(extended), extension.kurtosis(run.sound.pressure)
    comment = (
        f"extended: {EXTENDED}; kurtosis {kurtosis[0]:.3g}, of the record {kurtosis[1]:.3g};"
        f" {gain:.6g} full scale per Pa, {_rule(run, gain)}; {_facts(run)}"
    )
    title = f"{run.scene.name}, {run.label}, extended"
    path = run.folder / "extended.wav"
    make_below(run.home, run.folder)
    write_bytes(path, wav.listening(extended, gain, comment, title, loops=True))
    return path


def _facts(run: Run) -> str:
    """Write the facts that the comment of a sound file holds."""
    s, factor = run.scene.sound, run.sound.factor
    source = f"vibration of {'plate and sphere' if s.ball else 'plate'} on the axis"
    if factor is not None:
        source = f"q {s.q:g}, {factor:.6g} Pa per W/m2 of fluctuation"
    facts = f"distance {s.distance_m:g} m, {source}; {run.sound.ends}"
    return f"{run.scene.name}, {run.label}; {facts}"


def _rule(run: Run, gain: float) -> str:
    """Name the rule that sets the gain [full scale per Pa] of a record for the ear."""
    if not run.sound.pressure.any():
        return "silence"
    return "the largest gain" if gain >= wav.MOST_GAIN else "equal loudness"


def _listen(run: Run, gain: float) -> dict[str, Any]:
    """Return the meaning of the samples of listen.wav."""
    rule = _rule(run, gain)
    consequences = {
        "silence": "the record is silent, and the gain is 1",
        "the largest gain": "the gain is the largest there is, that of a record at 0 dB(A): this"
        " one is below and stays quieter than others",
        "equal loudness": "the gain makes runs equally loud, so compare their levels by the"
        " numbers, not by ear",
    }
    return {
        "meaning": "Samples times pascal_per_full_scale are sound pressure in Pa at the listener;"
        f" {consequences[rule]}.",
        "pascal_per_full_scale": 1.0 / gain,
        "gain_full_scale_per_pa": gain,
        "gain_db_re_1_per_pa": 20.0 * math.log10(gain),
        "rule": rule,
    }

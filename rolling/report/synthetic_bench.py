"""The synthetic bench: the folder of a bench whose recordings are made from its own run.

The recordings hold the channels of the run in noise and offset, at another sample rate, with
silence before and after, in units of a full scale that only a tone tells.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import soundfile

from acoustics import resampling
from acoustics.arrays import Array
from acoustics.wav import SAMPLE_RATE_HZ
from rolling.in_si.measured import write
from rolling.in_si.scene_surface import heights
from rolling.report.bench import CALIBRATION, RUN
from rolling.results.run_result import Run
from rolling.run import folder as folders
from rolling.run.solving import open_runs, solve_folder
from rolling.scene import library
from rolling.scene.file import read_as
from rolling.scene.scene import Scene
from rolling.terminal import progress
from rolling.terminal.whole_files import FolderError, write_bytes

NAME = Path("synthetic-bench")
SCENE = "scene.yaml"
SCAN = "scan.csv"
RATE_HZ = 44_100  # of the recordings
BEFORE_S = 0.4  # silence before the run
AFTER_S = 0.3  # silence after it
TONE_HZ = 159.2  # at which 10 m/s2 are 10 mm/s
TONE_S = 2.0
BACKGROUND_S = 3.0
NOISE_DB = -40.0  # rms re that of the signal
HEADROOM = 3.0  # full scale over the largest value
OFFSET = 0.05  # of full scale
_SURFACE = re.compile(r"^surface: .*$", flags=re.MULTILINE)


class SensorChain(NamedTuple):
    """Quantity of a recording, and the rms of the tone that calibrates it, in the SI unit."""

    quantity: str
    tone_rms: float


CHAINS = (SensorChain("acceleration", 10.0), SensorChain("force", 1.0))


def make(folder: Path) -> Path:
    """Make the synthetic bench in a new folder, and return the folder; one that is there stays.

    Its scene is run, and each chain gets a recording, a tone and a background.

    Raises
    ------
    FolderError : the run failed.
    """
    if folder.exists():
        return folder
    file = library.scenes()[NAME.name]
    made = read_as(file, Scene)
    folder.mkdir(parents=True)
    with progress.step(f"making {folder}"):
        write(folder / SCAN, heights(made), (made.spacing, made.spacing))
        surface = f"surface: {{kind: file, path: {SCAN}, spacing_um: {1e6 * made.spacing:g}}}"
        text = _SURFACE.sub(surface, file.read_text(encoding="utf-8"))
        write_bytes(folder / SCENE, text.encode())
    failures = solve_folder(read_as(folder / SCENE, Scene), folder / RUN)
    if failures:
        raise FolderError("; ".join(failures.values()))
    (run,) = open_runs([folders.done_run(folder / RUN, "record")])
    lines = []
    for seed, chain in enumerate(CHAINS):
        _record(run, chain, folder, np.random.default_rng(seed))
        lines.append(f"{chain.quantity}: tone-{chain.quantity}.wav={chain.tone_rms:g}")
    head = f"# rms of the tone of {TONE_HZ:g} Hz, in m/s2 or N\n"
    write_bytes(folder / CALIBRATION, (head + "\n".join(lines) + "\n").encode())
    return folder


def _record(run: Run, chain: SensorChain, folder: Path, rng: np.random.Generator) -> None:
    """Write recording, tone and background of the channels of a quantity of a run."""
    channels = [item.samples for item in run.channels if item.quantity == chain.quantity]
    before = np.zeros(round(BEFORE_S * SAMPLE_RATE_HZ))
    after = np.zeros(round(AFTER_S * SAMPLE_RATE_HZ))
    record = np.stack([np.concatenate((before, item, after)) for item in channels], axis=1)
    tone_times = np.arange(round(TONE_S * RATE_HZ)) / RATE_HZ
    tone = np.sqrt(2) * chain.tone_rms * np.sin(2 * np.pi * TONE_HZ * tone_times)
    silence = np.zeros((round(BACKGROUND_S * RATE_HZ), len(channels)))
    scale = HEADROOM * max(np.abs(record).max(), np.abs(tone).max())
    noise = 10 ** (NOISE_DB / 20) * np.std(np.array(channels), axis=1)
    contents = {
        f"{chain.quantity}.wav": _at_rate(record),
        f"tone-{chain.quantity}.wav": np.repeat(tone[:, None], len(channels), axis=1),
        f"background-{chain.quantity}.wav": silence,
    }
    for name, samples in contents.items():
        noisy = samples + noise * rng.standard_normal(samples.shape)
        soundfile.write(folder / name, noisy / scale + OFFSET, RATE_HZ, subtype="PCM_24")


def _at_rate(record: Array) -> Array:
    """Return channels of 48 kHz, (samples, channels), at the rate of the recordings."""
    count = round(len(record) * RATE_HZ / SAMPLE_RATE_HZ)
    return np.stack([resampling.resample_closed(item, count) for item in record.T], axis=1)

"""Compare the levels of the sounds that play with those that are stated, over scenes.

Run: python tests/benchmarks/heard_levels.py [FOLDER ...] [--shorten SECONDS]

Each FOLDER is a run folder, or one of a sweep. Without one, all scenes of the library are run into
a temporary folder; --shorten sets the length of their record where a scene allows it, for a quick
look. A line for each sound of each run has the level that is stated, that of the samples in its
file, the gain that brought the record there, and the difference that is left. A sound is wrong if
its samples do not have the level that its file states within 0.05 dB, if its file states another
level than the run although the ± of the level allows the gain, if a sample is clipped, or if a
record that repeats clicks at its seam. The exit code is 1 then.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import rolling
from acoustics import wav
from acoustics.arrays import Array
from acoustics.level import lae_db, laeq_db
from rolling import cli
from rolling.kinds.heard_sound import HeardSound
from rolling.kinds.registry import kind_of
from rolling.run import folder as run_folder
from rolling.scene import library

LEFT_DB = 0.05
# Largest bend of a record where it repeats, over the largest one elsewhere.
MOST_BEND = 1.5
LENGTHS = ("rolling.duration_s", "sound.duration_s", "rolling.distance_mm")
HEAD = (
    f"{'run':40} {'file':13} {'what':24} {'stated':>7} {'played':>7} {'gain':>6} {'left':>6}"
    f" {'peak':>5} {'seam':>5}"
)


class HeardLevel(NamedTuple):
    """Level of a sound file of a run.

    run, file, what : str. The run, the file, and what it plays.
    stated_db, played_db : float or None, dB. Level that is stated, and of the samples in the file.
    file_db : float or None, dB. Level that the file states.
    gain_db : float, dB. Gain that brought the record to its level.
    is_told : bool. Whether the file says that it is further off than its ±.
    peak : float. Largest sample, of full scale.
    seam : float. Largest bend where the file repeats, over the largest one elsewhere.
    """

    run: str
    file: str
    what: str
    stated_db: float | None
    played_db: float | None
    file_db: float | None
    gain_db: float
    is_told: bool
    peak: float
    seam: float

    @property
    def left_db(self) -> float:
        """Level of the samples over the level that is stated [dB]; 0 without both."""
        if self.stated_db is None or self.played_db is None:
            return 0.0
        return self.played_db - self.stated_db

    @property
    def is_right(self) -> bool:
        """Whether the samples have their level, do not clip and do not click."""
        of_file = 0.0
        if self.file_db is not None and self.played_db is not None:
            of_file = self.played_db - self.file_db
        is_level = abs(of_file) <= LEFT_DB and (abs(self.left_db) <= LEFT_DB or self.is_told)
        return is_level and self.peak <= 1.0 and self.seam <= MOST_BEND

    def __str__(self) -> str:
        stated = "-" if self.stated_db is None else f"{self.stated_db:.2f}"
        played = "-" if self.played_db is None else f"{self.played_db:.2f}"
        mark = "" if self.is_right else "  WRONG"
        if self.is_right and abs(self.left_db) > LEFT_DB:
            mark = "  told"
        return (
            f"{self.run:40} {self.file:13} {self.what:24} {stated:>7} {played:>7}"
            f" {self.gain_db:+6.2f} {self.left_db:+6.2f} {self.peak:5.2f} {self.seam:5.2f}{mark}"
        )


def heard_levels(run: Any, name: str) -> list[HeardLevel]:
    """Return the levels of the sound files of a run that is opened from its folder."""
    return [heard_level(run, name, sound) for sound in kind_of(run.scene).sounds(run)]


def heard_level(run: Any, name: str, sound: HeardSound) -> HeardLevel:
    """Return the level of a sound file of a run."""
    path = run.folder / sound.file
    samples, rate, _ = wav.read(path)
    facts = getattr(run.stored.files, path.stem)
    first = samples if samples.ndim == 1 else samples[:, 0]
    is_of_ball = hasattr(facts, "pascal_per_full_scale")
    if is_of_ball:
        pressure = first * facts.pascal_per_full_scale
        if facts.raised is not None:
            pressure = pressure[: round(facts.raised.begin_s * rate)]
        level = lae_db if facts.measure == "LAE" else laeq_db
        quantity = run.vibration if facts.source == "vibration" else run.released_power
        stated_db = quantity.value if facts.measure == quantity.measure else None
        if sound.stated.stated_db is None:  # it goes on at other speeds, or ends later
            stated_db = None
        what = f"{facts.source}, {facts.how}"
    else:
        pressure = first * facts.full_scale
        level = laeq_db
        stated_db = run.numbers.housing.laeq.value if sound.group == "housing" else None
        what = sound.words[:24]
    return HeardLevel(
        run=name,
        file=sound.file,
        what=what,
        stated_db=stated_db,
        played_db=level(pressure, rate),
        file_db=facts.level_db,
        gain_db=facts.stated_gain_db,
        is_told="the level that is stated, beyond its ±" in sound.words,
        peak=float(np.abs(samples).max()),
        seam=seam(first) if b"smpl" in path.read_bytes() else 0.0,
    )


def seam(samples: Array) -> float:
    """Return how much a record bends where it repeats, over its largest bend elsewhere."""
    if not samples.any():
        return 0.0
    ends = np.concatenate((samples[-2:], samples[:2]))
    return float(np.abs(np.diff(ends, 2)).max() / np.abs(np.diff(samples, 2)).max())


def solved_library(out: Path, shorten: float | None) -> list[Path]:
    """Run all scenes of the library into a folder, and return their folders."""
    folders = []
    for name in library.scenes():
        words = ["run", name, "--out", str(out / name), "--no-report", "-q"]
        lengths = [] if shorten is None else [f"{key}={shorten}" for key in LENGTHS]
        for length in [*lengths, ""]:
            if cli.main([*words, *(["--set", length] if length else [])]) == 0:
                folders.append(out / name)
                break
    return folders


def main() -> int:
    """Print the table, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--shorten", type=float)
    given = parser.parse_args()
    wrong = 0
    with tempfile.TemporaryDirectory() as temporary:
        folders = given.folders or solved_library(Path(temporary), given.shorten)
        print(HEAD)
        for folder in folders:
            for run in run_folder.stored_runs(folder):
                if not run.is_done:
                    continue
                part = "" if run.folder == folder else f" {run.folder.name}"
                for heard in heard_levels(rolling.open_run(run.folder), folder.name + part):
                    print(heard, flush=True)
                    wrong += not heard.is_right
    print(f"{wrong} sounds are wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())

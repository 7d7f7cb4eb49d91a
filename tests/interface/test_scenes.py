"""Every scene in scenarios/ runs, shortened, from the command line, and its files agree."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from commands import words_of
from helpers import rough
from scene_text import SCENES

from acoustics import level, wav
from rolling import cli, open_run, read_scene
from rolling.run import folder as folders
from rolling.scene import library
from rolling.scene.surfaces import HeightFile

pytestmark = pytest.mark.slow

TRACK_M = 300e-6  # wider than any contact at half a newton


def shortened(path: Path) -> list[str]:
    """Return settings that make a scene short and light; a height file is its own track."""
    scene = read_scene(path)
    if isinstance(scene.surface, HeightFile):
        return []
    length = f"rolling.duration_s={float(scene.motion.time(TRACK_M)):.9f}"
    if scene.rolling.distance_mm is not None:
        length = f"rolling.distance_mm={1e3 * TRACK_M}"
    settings = [length, "rolling.load_n=0.5"]
    if scene.sound.listen_s:
        settings.append("sound.listen_s=0.2")
    for key, values in scene.sweep.items():
        if key != "rolling.load_n":
            settings.append(f"sweep.{key}=[{values[0]}, {values[-1]}]")
    return [word for setting in settings for word in ("--set", setting)]


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scene_runs(path: Path, tmp_path: Path) -> None:
    scene = read_scene(path)
    source = tmp_path / path.name
    out = tmp_path / "out"
    source.write_bytes(path.read_bytes())
    for heights in library.companions(path):
        shutil.copy(heights, tmp_path)
    if isinstance(scene.surface, HeightFile) and scene.surface.path.endswith(".npy"):
        np.save(tmp_path / scene.surface.path, rough(60, 128, 1e-7))
    assert cli.main(words_of(source, out, "--workers", "1", *shortened(source))) == 0
    for stored in folders.stored_runs(out):
        run = open_run(stored.folder)
        numbers = run.numbers
        assert numbers.record.steps >= 9
        if stored.scene.recovery.rule != "left_end":  # the mean rule is exact to rounding
            assert numbers.energy.balance_error < 1e-12
        stated = run.stated()
        levels_db = {"signal.wav": level.laeq_db(stated.along_track.pressure, 48000)}
        if stated.source == numbers.record.source:  # before the gain to the level that is stated
            own_db = level.laeq_db(stated.record.pressure, 48000)
            assert own_db == pytest.approx(numbers.record.laeq_db, abs=1e-3)
        else:
            levels_db["released_signal.wav"] = numbers.record.laeq_db
        for name, level_db in levels_db.items():
            pressure, rate, comment = wav.read(stored.folder / name)
            assert rate == 48000 and scene.name in comment and "1.0 = 1 Pa" in comment
            again = level.laeq_db(pressure.T[0] if pressure.ndim > 1 else pressure, rate)
            # 24 bits of a float sample leave 1e-4 dB
            assert again == pytest.approx(level_db, abs=1e-3) if again else again is None
        listened, _, _ = wav.read(stored.folder / "listen.wav")
        assert np.abs(listened).max() <= 1.0
        assert len(run.series["approach"]) == len(run.release_power) + 1
        if stored.scene.recovery.events:
            released = run.series["release_energy"][: run.result.solved_steps].sum()
            assert run.events["energy"].sum() == pytest.approx(released, rel=1e-12)
        else:
            assert run.events is None

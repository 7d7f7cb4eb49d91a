"""Every scene in scenarios/ runs, shortened, from the command line and leaves its files."""

from __future__ import annotations

import json
import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from helpers import rough

from acoustics import level, wav
from rolling import cli
from rolling.folders import own_files, run_record
from rolling.scene import file as scene_file
from rolling.scene.surfaces import HeightFile

pytestmark = pytest.mark.slow

SCENES = sorted((Path(__file__).parents[2] / "scenarios").glob("*.yaml"))
TRACK_M = 300e-6  # wider than any contact at half a newton


def shortened(path: Path) -> list[str]:
    """Return settings that make a scene short and light; a height file is its own track.

    Two values of each swept key are enough; the load is not swept.
    """
    scene = scene_file.read_scene(path)
    if isinstance(scene.surface, HeightFile):
        return []
    swept = [
        word
        for key, values in scene.sweep.items()
        if key != "rolling.load_n"
        for word in ("--set", f"sweep.{key}=[{values[0]}, {values[-1]}]")
    ]
    length = f"rolling.duration_s={float(scene.motion.time(TRACK_M)):.9f}"
    if scene.rolling.distance_mm is not None:
        length = f"rolling.distance_mm={1e3 * TRACK_M}"
    return ["--set", length, "--set", "rolling.load_n=0.5", *swept]


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scene_runs(path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = scene_file.read_scene(path)
    source = path
    if isinstance(scene.surface, HeightFile):
        source = tmp_path / path.name
        source.write_bytes(path.read_bytes())
        np.save(tmp_path / scene.surface.path, rough(60, 128, 1e-7))
    settings = shortened(path)
    out = tmp_path / "out"
    code = cli.main(["run", str(source), *settings, "--out", str(out), "--workers", "1"])
    printed = capsys.readouterr()
    assert code == 0, printed.err
    resolved = scene_file.read_scene(out / "resolved.yaml")
    for values, one in resolved.runs():
        folder = (
            out
            if not values
            else next(f for f in out.iterdir() if f.is_dir() and matches(f, one.load, values))
        )
        summary = json.loads((folder / "summary.json").read_text())
        assert summary["complete"] and summary["steps"] >= 9
        assert summary["energy_balance_error"] < (1e-12 if not left_end(one) else 10)
        pressure, rate, comment = wav.read(folder / "signal.wav")
        assert rate == 48000 and scene.name in comment and "1.0 = 1 Pa" in comment
        again = level.laeq_db(pressure, rate)
        if summary["laeq_db"] is None:
            assert again is None
        else:
            # 24 bits of a float sample leave 1e-4 dB
            assert again == pytest.approx(summary["laeq_db"], abs=1e-3)
        listened, _, _ = wav.read(folder / "listen.wav")
        assert np.abs(listened).max() <= 1.0
        for picture in (
            "spectrum",
            "psd",
            "third_octaves",
            "spectrogram",
            "release_power",
            "surface",
            "contact",
        ):
            assert (folder / f"{picture}.png").stat().st_size > 5000
        assert run_record.read(folder).state == "done" and (folder / "provenance.json").is_file()
        with h5py.File(folder / "result.h5") as file:
            assert file["release_power"].dims[0].keys() == ["step"]
            assert file["release_power"].attrs["units"] == "W"
            assert len(file["approach"]) == len(file["release_power"]) + 1
            if one.recovery is not None and one.recovery.events:
                energy = file["events/energy"][:].sum()
                assert energy == pytest.approx(file["release_energy"][:].sum(), rel=1e-12)
            else:
                assert "events" not in file
    # --force knows every file that a run writes
    assert own_files.foreign(out, run_record.read(out)) == []
    assert "LAeq" in printed.out and str(out) in printed.out


def matches(folder: Path, load: float, values: dict[str, float]) -> bool:
    return all(
        f"{key.rpartition('.')[2]}={value:g}" in folder.name.split(",")
        for key, value in values.items()
    )


def left_end(scene) -> bool:
    return scene.recovery is not None and scene.recovery.rule == "left_end"


def test_there_is_a_scene_for_every_capability() -> None:
    names = {path.stem for path in SCENES}
    assert {
        "quickstart",
        "smooth",
        "elastic-sphere",
        "measured-surface",
        "accelerating",
        "events",
    } <= names
    assert math.isinf(scene_file.read_scene(SCENES[0].parent / "smooth.yaml").hardness)

"""Channels of a run in its folder: WAVs, summary.json, result.h5, tables, page and terminal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import rolling
from acoustics import vibration_levels, wav
from rolling.cli import main

CHANNELS = (
    "sound.channels=[{of: plate, quantity: velocity, x_mm: 30, y_mm: 40},"
    " {of: ball, quantity: velocity}, {of: contact, quantity: force, name: F}]"
)
KEYS = [
    "dynamics={}",
    "sphere.density_kg_m3=7850",
    "plate.density_kg_m3=7850",
    "plate.thickness_mm=10",
    "rolling.load_n=1",
    "rolling.duration_s=0.01",
    "surface.width_um=128",
    "numerics.error_estimate=false",
    "sound.listen_s=0.5",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Solve a run with channels into a folder, with its page."""
    out = tmp_path_factory.mktemp("channels") / "run"
    words = [word for key in (*KEYS, CHANNELS) for word in ("--set", key)]
    assert main(["run", "quickstart", *words, "--workers", "1", "--out", str(out)]) == 0
    return out


def test_files_hold_the_channels_with_their_scale(folder: Path) -> None:
    run = rolling.open_run(folder)
    samples, rate, comment = wav.read(folder / "velocity.wav")
    expected = np.stack([channel.samples for channel in run.channels[:2]], axis=1)
    assert rate == 48000
    assert samples == pytest.approx(expected, rel=1e-6, abs=1e-20)
    assert comment.startswith("1.0 is 1 m/s; channel 1: plate velocity at (30, 40) mm; 2: ball")
    stored = run.to_xarray()["channels"]
    assert stored["velocity"].attrs["units"] == "m/s"
    assert np.array_equal(stored["force"].values[0], run.channels[2].samples)
    force = rolling.open_run(folder).numbers.channels[2]
    assert (force.name, force.reference) == ("F", "re 1e-6 N")
    by_hand = 20 * np.log10(np.sqrt(np.mean(np.square(run.channels[2].samples))) / 1e-6)
    assert force.level_db == pytest.approx(by_hand, abs=1e-9)
    rms = stored["force_band_rms"].values[0]
    assert np.nansum(np.square(rms)) == pytest.approx(force.rms**2, rel=1e-3)


def test_page_figures_and_terminal_show_the_channels(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (folder / "report.html").read_text()
    assert "re 1e-9 m/s" in page and "Third octaves of the channels" in page
    names = ["channel_third_octaves", "channel_spectrum", "channel_envelope"]
    words = ["--figure", *names, "--format", "csv", "--out", str(tmp_path)]
    assert main(["plot", str(folder), *words]) == 0
    capsys.readouterr()
    table = pd.read_csv(tmp_path / "channel_third_octaves.csv")
    band = table[(table["channel"] == "F") & (table["band_hz"] == 1000)].iloc[0]
    assert 20 * np.log10(band["rms"] / 1e-6) == pytest.approx(band["level_db"], abs=1e-6)
    density = pd.read_csv(tmp_path / "channel_spectrum.csv")
    assert set(density["channel"]) == set(table["channel"])


@pytest.mark.slow
def test_a_solved_run_gets_and_loses_channels(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "other"
    word = "sound.channels=[{of: ball, quantity: acceleration}]"
    assert main(["resound", str(folder), "--set", word, "--out", str(out)]) == 0
    assert "ball acceleration: " in capsys.readouterr().out
    assert (out / "acceleration.wav").is_file() and not (out / "velocity.wav").exists()
    assert [channel.unit for channel in rolling.open_run(out).channels] == ["m/s2"]


def test_levels_by_hand() -> None:
    # 1 m/s2 rms at 1 kHz, and 2 mm/s rms at 100 Hz: 20 lg(1 / 1e-6), 20 lg(2e-3 / 1e-9).
    time = np.arange(48000) / 48000
    acceleration = vibration_levels(
        np.sqrt(2) * np.sin(2 * np.pi * 1000 * time), 48000, "acceleration"
    )
    assert acceleration.third_octave_db["1000"] == pytest.approx(120, abs=1e-9)
    assert acceleration.octave_db["1000"] == pytest.approx(120, abs=1e-9)
    velocity = vibration_levels(
        2e-3 * np.sqrt(2) * np.sin(2 * np.pi * 100 * time), 48000, "velocity", 200
    )
    assert velocity.level_db == pytest.approx(20 * np.log10(2e6), abs=1e-9)
    assert velocity.third_octave_db["1000"] is None  # beyond the highest frequency
    assert velocity.reference.words == "re 1e-9 m/s"

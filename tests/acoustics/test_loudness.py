"""Loudness meets the definitions of sone and acum: 1 kHz at 40 and 60 dB.

The program also says what to install where the package is missing.
"""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from acoustics.loudness import Loudness, loudness
from acoustics.radiation import P_REF_PA
from rolling import cli
from rolling.check import refusals

RATE = 48000
SCENE = """\
name: heard
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 200, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.002}
sound: {loudness: true}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "heard.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def mosqito():
    return pytest.importorskip(
        "mosqito", reason='needs mosqito: pip install "rolling-contact-noise[loudness]"'
    )


def tone(level_db, n=24000, frequency_hz=1000.0):
    amplitude = P_REF_PA * 10.0 ** (level_db / 20.0) * np.sqrt(2.0)
    return amplitude * np.sin(2.0 * np.pi * frequency_hz * np.arange(n) / RATE)


@pytest.mark.parametrize(
    ("level_db", "sone"), [(40.0, 1.0), (50.0, 2.0), (60.0, 4.0), (80.0, 16.0)]
)
def test_1_khz_doubles_every_10_db_from_1_sone_at_40_db(mosqito, level_db, sone):
    # ISO 532-1:2017 allows 5 %.
    assert loudness(tone(level_db), RATE, closed=True).sone == pytest.approx(sone, rel=0.05)


def test_narrow_noise_at_1_khz_and_60_db_has_1_acum(mosqito):
    # DIN 45692: a critical band (160 Hz) about 1 kHz at 60 dB; it allows 5 %.
    frequency = np.fft.rfftfreq(2 * RATE, 1.0 / RATE)
    lines = np.fft.rfft(np.random.default_rng(1).standard_normal(2 * RATE)) * (
        np.abs(frequency - 1000.0) < 80.0
    )
    noise = np.fft.irfft(lines, 2 * RATE)
    noise *= P_REF_PA * 1e3 / np.sqrt(np.mean(noise**2))
    assert loudness(noise, RATE, closed=True).acum == pytest.approx(1.0, rel=0.05)


def test_a_loop_has_the_loudness_of_what_is_heard_of_it(mosqito):
    long, short = (loudness(tone(60.0, n), RATE, closed=True).sone for n in (10 * RATE, 480))
    # Swinging in takes 0.2 s of 4 s at most: 2 %, and mosqito gives three digits.
    assert short == pytest.approx(long, rel=0.02)


def test_silence_and_what_has_no_loudness(mosqito):
    assert loudness(np.zeros(4800), RATE, closed=True) == Loudness(0.0, None)
    # a steady pressure is not heard
    assert loudness(np.full(4800, 1.0), RATE, closed=True) == Loudness(0.0, None)
    # below the threshold of 2.4 dB
    assert loudness(tone(0.0), RATE, closed=True) == Loudness(0.0, None)
    # Zwicker's tables end at 120 dB in the low third octaves; ten samples that do not close are too
    # few for the filters.
    assert loudness(tone(130.0, frequency_hz=100.0), RATE, closed=True) == Loudness(None, None)
    assert loudness(tone(60.0, 10), RATE, closed=False) == Loudness(None, None)
    with pytest.raises(ValueError, match="sample rate of 48000 Hz or more, got 44100"):
        loudness(tone(60.0), 44100.0, closed=True)
    with pytest.raises(ValueError, match="finite"):
        loudness(np.array([0.0, np.nan]), RATE, closed=True)


@pytest.mark.slow
def test_a_scene_gets_what_it_asks_for(mosqito, scene: Path, tmp_path: Path, undrawn: None):
    first, again, without = tmp_path / "first", tmp_path / "again", tmp_path / "without"
    assert cli.main(["run", str(scene), "--out", str(first), "--workers", "1"]) == 0
    found = json.loads((first / "summary.json").read_text())
    assert found["loudness_sone"] > 0.0 and found["sharpness_acum"] > 0.0
    assert "mosqito" in json.loads((first / "provenance.json").read_text())["packages"]
    # Nearer is louder: half the distance, 6 dB, is 1.5 times the sones, and more at low levels.
    assert (
        cli.main(["resound", str(first), "--set", "sound.distance_m=0.5", "--out", str(again)]) == 0
    )
    assert (
        json.loads((again / "summary.json").read_text())["loudness_sone"]
        > 1.3 * found["loudness_sone"]
    )
    assert (
        cli.main(["resound", str(first), "--set", "sound.loudness=false", "--out", str(without)])
        == 0
    )
    assert "loudness_sone" not in json.loads((without / "summary.json").read_text())


@pytest.mark.slow
def test_without_the_package_the_scene_is_refused_before_anything_is_done(
    scene: Path, tmp_path: Path, undrawn: None, monkeypatch, capsys
):
    there = importlib.util.find_spec
    monkeypatch.setattr(
        refusals, "find_spec", lambda name: None if name == "mosqito" else there(name)
    )
    out, plain = tmp_path / "out", tmp_path / "plain"
    message = (
        "sound.loudness: needs the package mosqito, which is not installed; "
        'pip install "rolling-contact-noise[loudness]"'
    )
    assert cli.main(["run", str(scene), "--out", str(out)]) == 2
    assert message in capsys.readouterr().err and not out.exists()
    assert cli.main(["check", str(scene)]) == 2
    assert message in capsys.readouterr().err
    settings = ["--set", "sound.loudness=false", "--workers", "1"]
    assert cli.main(["run", str(scene), *settings, "--out", str(plain)]) == 0
    capsys.readouterr()
    assert cli.main(["resound", str(plain), "--set", "sound.loudness=true", "--out", str(out)]) == 2
    assert message in capsys.readouterr().err and not out.exists()
    # A run made where the package is: to be resumed it would have to be here.
    resolved = plain / "resolved.yaml"
    resolved.write_text(resolved.read_text().replace("loudness: false", "loudness: true"))
    before = sorted((file, file.stat().st_mtime_ns) for file in plain.iterdir())
    assert cli.main(["resume", str(plain)]) == 2
    assert message in capsys.readouterr().err
    assert sorted((file, file.stat().st_mtime_ns) for file in plain.iterdir()) == before

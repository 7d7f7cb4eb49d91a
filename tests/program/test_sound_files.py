"""A run leaves two WAV files with their meaning, and levels with their uncertainty."""

from __future__ import annotations

import json
import math
import re
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile
from scene_text import PLAIN

from acoustics import wav
from acoustics.bands import BAND_NAMES
from acoustics.level import laeq_db, peak_pressure
from acoustics.radiation import P_REF_PA
from rolling import cli
from rolling.folders import files
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene
from rolling.simulation import sound_files, summary
from rolling.sound.contact_sound import ContactSound, contact_sound

STEP = 2e-6
# 0.1 m/s: 25000 steps
SCENE = scene_file.loads(PLAIN.replace("duration_s: 0.01", "duration_s: 0.5"))


def sound_of(
    release: np.ndarray, closed: bool = True, scene=SCENE, lap_steps: int | None = None
) -> ContactSound:
    return contact_sound(scene, release, STEP, closed, lap_steps)


def noise(seed: int, n: int = 25000) -> np.ndarray:
    """Return the energy of each step [J], positive, with white noise."""
    return 1e-9 * (1.0 + 0.1 * np.random.default_rng(seed).standard_normal(n))


CAVEATS = [{"key": "unvalidated", "text": "No level has been validated against a microphone."}]
SILENT = np.full(25000, 1e-9)


def written(folder: Path, sound: ContactSound, scene=SCENE) -> dict[str, bytes]:
    folder.mkdir()
    sound_files.write(folder, scene, "load 20 N", sound, CAVEATS)
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


@pytest.mark.parametrize("release", [noise(1), SILENT], ids=["noise", "silence"])
def test_the_same_sound_leaves_the_same_bytes(release, tmp_path: Path) -> None:
    sound = sound_of(release)
    first, second = written(tmp_path / "a", sound), int(time.time())
    assert list(first) == ["listen.json", "listen.wav", "signal.json", "signal.wav"]
    while int(time.time()) == second:  # libsndfile's time stamp counts seconds
        time.sleep(0.02)
    assert written(tmp_path / "b", sound) == first
    assert not any(str(tmp_path).encode() in content for content in first.values())


@pytest.mark.parametrize("closed", [True, False])
def test_the_numbers_beside_a_file_are_those_of_the_file(closed, tmp_path: Path) -> None:
    sound = sound_of(noise(2), closed)
    written(tmp_path / "a", sound)
    for name in ("signal", "listen"):
        samples, rate, comment = wav.read(tmp_path / "a" / f"{name}.wav")
        beside = json.loads((tmp_path / "a" / f"{name}.json").read_text())
        assert (beside["scene"], beside["run"], beside["sample_rate_hz"]) == (
            "trial",
            "load 20 N",
            rate,
        )
        assert len(samples) / rate == beside["duration_s"] == 0.5
        pressure = samples * beside["pascal_per_full_scale"]
        # Rounding to 24 bits lies 126 dB below the record.
        assert laeq_db(pressure, rate) == pytest.approx(beside["laeq_db"], abs=1e-4)
        assert 20.0 * math.log10(peak_pressure(pressure) / P_REF_PA) == pytest.approx(
            beside["lz_peak_db"], abs=1e-4
        )
        gain = beside["gain_full_scale_per_pa"]
        assert gain * beside["pascal_per_full_scale"] == pytest.approx(1.0, rel=1e-15)
        assert beside["gain_db_re_1_per_pa"] == pytest.approx(20.0 * math.log10(gain), abs=1e-12)
        assert beside["loops"] is closed and beside["caveats"] == CAVEATS
        assert (b"smpl" in (tmp_path / "a" / f"{name}.wav").read_bytes()) is closed
        assert beside["factor_pa_per_w_m2"] == sound.factor and (
            beside["distance_m"],
            beside["q"],
        ) == (1.0, 1.0)
        for said in (
            f"{sound.factor:.6g} Pa per W/m2",
            "distance 1 m",
            "q 1",
            "loops" if closed else "faded",
        ):
            assert said in comment
        with soundfile.SoundFile(tmp_path / "a" / f"{name}.wav") as file:
            assert file.title == "trial, load 20 N"
            assert (
                beside["format"]
                == f"WAV, mono, {'32-bit float' if file.subtype == 'FLOAT' else '24-bit PCM'}"
            )
    assert f"{gain:.6g} full scale per Pa" in comment


def test_silence_is_written_with_no_level(tmp_path: Path) -> None:
    content = written(tmp_path / "a", sound_of(SILENT))
    beside = json.loads(content["listen.json"])
    assert (
        beside["laeq_db"] is None
        and beside["lz_peak_db"] is None
        and beside["gain_db_re_1_per_pa"] == 0.0
    )


def test_a_record_below_hearing_says_that_its_gain_is_bounded(tmp_path: Path) -> None:
    # A real record at -22 dB(A), which plays at -45 dB of full scale and not at -23.
    far = Scene.from_dict(SCENE.to_dict() | {"sound": {"distance_m": 1e3, "q": 0.03}, "sweep": {}})
    sound = sound_of(noise(3), scene=far)
    assert sound.levels.laeq_db is not None and -30 < sound.levels.laeq_db < 0
    content = written(tmp_path / "a", sound, far)
    beside = json.loads(content["listen.json"])
    assert (
        beside["gain_full_scale_per_pa"] == wav.MOST_GAIN
        and "stays quieter than others" in beside["meaning"]
    )
    assert (
        b"the largest gain" in content["listen.wav"]
        and b"equal loudness" not in content["listen.wav"]
    )


def test_no_half_file_is_left_by_a_full_disk(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource", reason="Windows sets no limit on the size of files")
    path = tmp_path / "signal.wav"
    files.write_bytes(path, wav.calibrated(np.zeros(100), "the old one"))
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))  # the file needs 96 kB
    try:
        with pytest.raises(OSError):
            files.write_bytes(path, wav.calibrated(np.ones(24000), "the new one"))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list(tmp_path.iterdir()) == [path] and path.read_bytes() == before


def test_levels_spread_over_seeds_as_a_run_states() -> None:
    """Levels of 150 seeds spread as stated, within 18 %.

    The factor of each run removes half of the spread of LZeq. 150 seeds are good to 6 %, and
    three of these are allowed. White power to 22.4 kHz has 11000 lines.
    """
    found = [sound_of(noise(seed)) for seed in range(150)]
    stated = [
        (
            s.uncertainty.level_db,
            s.uncertainty.laeq_db,
            s.uncertainty.third_octave_db["1000"],
            s.steady_uncertainty,
        )
        for s in found
    ]
    levels = [
        (s.levels.level_db, s.levels.laeq_db, s.levels.third_octave_db["1000"], s.steady_level)
        for s in found
    ]
    ratio = np.std(levels, axis=0, ddof=1) / np.sqrt(np.mean(np.square(stated), axis=0))
    assert np.all((ratio > 0.8) & (ratio < 1.2)), ratio
    # White step means are those of a density that rises as 1/sinc^2: half of 4.34/sqrt(N) with N =
    # T (int S)^2 / int S^2.
    density = 1.0 / np.sinc(np.arange(18.0, 22387.0) / 50000.0) ** 2
    lines = 0.5 * density.sum() ** 2 / np.sum(density**2)
    assert np.mean(stated, axis=0)[0] == pytest.approx(0.5 * 4.343 / math.sqrt(lines), rel=0.005)
    fixed = scene_file.loads(PLAIN.replace("0.01", "0.5"), ["sound.gain_pa_per_w_m2=10"])
    assert sound_of(noise(1), scene=fixed).uncertainty.level_db == pytest.approx(
        2.0 * stated[1][0], rel=1e-9
    )


def test_a_track_gone_round_twice_is_known_no_better() -> None:
    lap = noise(3, 12500)
    short = scene_file.loads(PLAIN.replace("0.01", "0.25"))
    once, twice = sound_of(lap, scene=short), sound_of(np.tile(lap, 2), lap_steps=12500)
    assert twice.steady_uncertainty == pytest.approx(once.steady_uncertainty, rel=1e-9)
    assert twice.uncertainty.laeq_db == pytest.approx(once.uncertainty.laeq_db, rel=1e-6)
    assert twice.uncertainty.third_octave_db["100"] == pytest.approx(
        once.uncertainty.third_octave_db["100"], rel=1e-6
    )


@pytest.mark.parametrize("steps", [2, 3, 50])
@pytest.mark.parametrize("closed", [True, False])
def test_what_is_solved_of_an_interrupted_run_has_its_numbers(
    steps, closed, tmp_path: Path
) -> None:
    sound = sound_of(noise(4, steps), closed)
    assert len(sound.pressure) >= 2
    content = written(tmp_path / "a", sound)
    for name in ("signal.json", "listen.json"):
        json.loads(content[name], parse_constant=pytest.fail)  # NaN and Infinity


def test_summary_and_table_hold_levels_with_uncertainty(tmp_path: Path, capsys) -> None:
    path, out = tmp_path / "s.yaml", tmp_path / "out"
    path.write_text(
        PLAIN.replace("load_n: 20", "load_n: 1").replace("width_um: 64", "width_um: 200")
    )
    settings = ["--set", "rolling.duration_s=0.004", "--out", str(out), "--workers", "1"]
    assert cli.main(["run", str(path), *settings]) == 0
    found = json.loads((out / "summary.json").read_text())
    assert list(found["uncertainty_db"]) == [
        "laeq",
        "level",
        "laf_max",
        "las_max",
        "lz_peak",
        "steady",
    ]
    assert all(value > 0.0 for value in found["uncertainty_db"].values())
    assert list(found["third_octave_uncertainty_db"]) == list(BAND_NAMES)
    for name, level in found["third_octave_db"].items():
        assert (level is None) == (found["third_octave_uncertainty_db"][name] is None)
    # 4 ms played round and round: the weightings hold the mean, within their ripple of a percent.
    assert found["las_max_db"] == pytest.approx(found["laeq_db"], abs=0.05)
    assert found["laf_max_db"] >= found["las_max_db"] and found["lz_peak_db"] > found["level_db"]
    printed = capsys.readouterr().out
    assert "LZeq dB" in printed
    shown = re.search(r"(-?\d+\.\d) ± (\d+\.\d)", printed)
    assert shown is not None and float(shown[1]) == pytest.approx(found["laeq_db"], abs=0.0501)
    assert 0.0 <= float(shown[2]) - found["uncertainty_db"]["laeq"] < 0.1001  # rounded up


def test_a_table_of_silence_has_no_uncertainty() -> None:
    numbers = {
        "laeq_db": None,
        "level_db": None,
        "steady_level_db": 70.0,
        "uncertainty_db": {"laeq": None},
    }
    numbers |= {"plastic_ratio": 0.1, "steps": 5, "complete": True, "step_ms": 1.0, "caveats": []}
    numbers["surface"] = dict.fromkeys(("ra", "rq", "skewness", "kurtosis", "rms_slope"), 0.0)
    row = summary.table([("run", "folder", numbers)]).splitlines()[1]
    assert row.split()[:4] == ["run", "silent", "silent", "70.0"]

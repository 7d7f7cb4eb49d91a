"""A run leaves WAV files of its sounds, and summary.json says what their samples are."""

from __future__ import annotations

import io
import json
import math
import sys
import tempfile
import time
import webbrowser
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile
from commands import contents
from finished import marched
from scene_sounds import sound_of_release
from scene_text import PLAIN, TINY

from acoustics import wav
from acoustics.level import laeq_db, peak_pressure
from acoustics.radiation import P_REF_PA
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results.listening import ListenSound
from rolling.results.run_result import Run, write_run
from rolling.scene import file
from rolling.scene.scene import Scene

SCENE = file.loads(PLAIN.replace("duration_s: 0.01", "duration_s: 0.5"))
SILENT = np.full(25000, 1e-9)  # J in each step of 2 um


def noise(seed: int) -> np.ndarray:
    return SILENT * (1.0 + 0.1 * np.random.default_rng(seed).standard_normal(25000))


@pytest.fixture(scope="module")
def run() -> Run:
    return marched(TINY)


def without_levels(numbers: RunNumbers) -> RunNumbers:
    """Return numbers that state no level, so that the release plays as it was made."""
    return replace(
        numbers,
        vibration=replace(numbers.vibration, value=None, reason="nothing vibrates"),
        released_power=replace(numbers.released_power, value=None),
    )


def written_run(
    run: Run, folder: Path, release: np.ndarray, closed: bool = True, scene: Scene = SCENE
) -> Run:
    """Return a run that sounds like a release [J] and does not vibrate, with its files written."""
    sound = sound_of_release(scene, release, 2e-6, closed)
    other = replace(
        run,
        sound=sound,
        folder=folder,
        scene=scene,
        label="load 20 N",
        numbers=without_levels(run.numbers),
    )
    write_run(other)
    return other


def listen_of(folder: Path) -> dict:
    content = json.loads((folder / "numbers.json").read_text(), parse_constant=pytest.fail)
    return content["files"]["listen"]


@pytest.mark.parametrize("release", [noise(1), SILENT], ids=["noise", "silence"])
def test_the_same_sound_leaves_the_same_files(
    release: np.ndarray, run: Run, tmp_path: Path
) -> None:
    written_run(run, tmp_path / "a", release)
    second = int(time.time())
    while int(time.time()) == second:  # libsndfile's time stamp counts seconds
        time.sleep(0.02)
    written_run(run, tmp_path / "b", release)
    sounds = ["listen.wav", "released.wav", "released_signal.wav", "signal.wav"]
    names = sorted(["numbers.json", "result.h5", "summary.json", *sounds])
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == names
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    for name in ("result.h5", *sounds):
        assert str(tmp_path).encode() not in (tmp_path / "a" / name).read_bytes()


@pytest.mark.parametrize("closed", [True, False])
def test_samples_times_their_factor_are_the_sound(closed: bool, run: Run, tmp_path: Path) -> None:
    sound = written_run(run, tmp_path, noise(2), closed).sound
    listen = listen_of(tmp_path)
    gain = listen["gain_full_scale_per_pa"]
    assert gain * listen["pascal_per_full_scale"] == pytest.approx(1.0, rel=1e-15)
    assert listen["gain_db_re_1_per_pa"] == pytest.approx(20.0 * math.log10(gain), abs=1e-12)
    for name, factor, subtype in (
        ("signal", 1.0, "FLOAT"),
        ("listen", listen["pascal_per_full_scale"], "PCM_24"),
    ):
        path = tmp_path / f"{name}.wav"
        samples, rate, comment = wav.read(path)
        pressure = samples * factor
        # Rounding to 24 bits lies 126 dB below the record.
        assert laeq_db(pressure, rate) == pytest.approx(sound.levels.laeq_db, abs=1e-4)
        if closed or name == "signal":  # a lap without the faded ends may lack the peak
            peak = 20.0 * math.log10(peak_pressure(pressure) / P_REF_PA)
            assert peak == pytest.approx(sound.levels.lz_peak_db, abs=1e-4)
        assert (b"smpl" in path.read_bytes()) is (closed or name == "listen")
        assert np.abs(samples).max() < 1.0
        for word in (f"{sound.factor:.6g} Pa per W/m2", "distance 1 m", "q 1", "load 20 N"):
            assert word in comment
        assert ("loops" if closed else "faded") in comment
        with soundfile.SoundFile(path) as stream:
            assert stream.title.startswith("trial, load 20 N") and stream.subtype == subtype
            assert ("pascals" in stream.title) is (name == "signal")
    assert f"{gain:.6g} full scale per Pa" in comment


def test_silence_and_records_below_hearing_say_so(run: Run, tmp_path: Path) -> None:
    """A record at -22 dB(A) plays at -45 dB of full scale, silence at a gain of 1."""
    written_run(run, tmp_path / "silent", SILENT)
    assert listen_of(tmp_path / "silent")["gain_full_scale_per_pa"] == 1.0
    far = SCENE.with_({"sound.distance_m": 1e3, "sound.q": 0.03})
    level = written_run(run, tmp_path / "far", noise(3), scene=far).sound.levels.laeq_db
    assert level is not None and -30 < level < 0
    listen = listen_of(tmp_path / "far")
    assert listen["gain_full_scale_per_pa"] == pytest.approx(wav.MAX_GAIN, rel=1e-6)
    assert "stays quieter than others" in listen["meaning"]
    assert "the largest gain" in wav.read(tmp_path / "far" / "listen.wav")[2]


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("seconds", [0.012, 0.5, 6.0])
def test_listen_wav_lasts_five_seconds(
    seconds: float, closed: bool, run: Run, tmp_path: Path
) -> None:
    """A record of 12 ms is a click; its laps bend nowhere more than twice as much as it does."""
    steps = round(seconds * 0.1 / 2e-6)
    release = 1e-9 * (1.0 + 0.1 * np.random.default_rng(6).standard_normal(steps))
    scene = SCENE.with_(duration_s=seconds)
    sound = written_run(run, tmp_path, release, closed, scene).sound
    listen = listen_of(tmp_path)
    samples = wav.read(tmp_path / "listen.wav")[0] * listen["pascal_per_full_scale"]
    assert len(samples) / wav.SAMPLE_RATE_HZ == listen["duration_s"] >= 5.0
    laps = round(len(samples) / len(sound.lap)) if seconds < 5 else 1
    if closed:
        record = np.tile(sound.pressure, laps)
        assert np.abs(samples - record).max() < 1e-6 * np.abs(record).max()  # 24 bits
    bends = [np.abs(np.diff(x, 2)).max() for x in (samples, sound.pressure)]
    assert bends[0] < 2 * bends[1]
    words = "laps of the record" if seconds < 5 else f"the record, {sound.ends}"
    assert words in listen["content"] and listen["content"] in wav.read(tmp_path / "listen.wav")[2]
    assert ("cross-faded" in listen["content"]) is (seconds < 5 and not closed)


def test_a_script_names_the_file_and_opens_a_player_on_a_terminal_only(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A run in memory has a temporary file, and a stranger's listen.wav is not played."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "listen.wav").write_bytes(b"a stranger's")
    played: list[str] = []
    monkeypatch.setattr(webbrowser, "open", played.append)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.delenv("CI", raising=False)
    for is_terminal in (False, True):
        monkeypatch.setattr(sys.stdout, "isatty", lambda answer=is_terminal: answer)
        run.play()
        path = Path(capsys.readouterr().out.split()[1])
        assert path.name.startswith("tiny-listen-") and len(wav.read(path)[0]) >= 5 * 48000
        assert played == [path.as_uri()] * is_terminal


@pytest.mark.parametrize(
    ("kind", "reason"),
    [("noise", ""), ("ramp", ""), ("clicks", "kurtosis of"), ("silent", "record is silent")],
)
def test_a_release_is_continued_where_noise_sounds_like_it(
    kind: str, reason: str, run: Run
) -> None:
    """Two steps in a thousand with ten times the release raise the kurtosis far above 3."""
    release = noise(2) if kind in ("noise", "ramp") else SILENT.copy()
    if kind == "clicks":
        release[np.random.default_rng(8).random(len(release)) < 0.002] *= 10
    speed = [[0, 0.05], [0.4, 0.15]] if kind == "ramp" else 0.1
    scene = SCENE.with_({"rolling.speed_m_s": speed, "rolling.distance_mm": 50, "duration_s": None})
    sound = sound_of_release(scene, release, 2e-6, True)
    series = run.result.series | {"release_energy": release}
    result = replace(run.result, series=series, steps=25000, solved_steps=25000, step=2e-6)
    numbers = without_levels(run.numbers)
    other = replace(run, sound=sound, scene=scene, result=result, numbers=numbers)
    assert reason in other.no_long and bool(reason) == bool(other.no_long)
    if reason:
        with pytest.raises(ValueError, match=reason):
            other.listen(1)
        return
    long = other.listen(2.0)
    assert len(long.pressure) == 96000 and long.numbers.rolled_mm > 199
    assert long.numbers.kurtosis == pytest.approx(3 if kind == "noise" else 3.3, abs=0.3)
    if kind == "noise":  # bands of 0.5 s of record; 0.3 dB
        assert long.numbers.laeq_db == pytest.approx(sound.levels.laeq_db, abs=0.5)


@pytest.mark.law(
    "listening: what follows the impacts of a fall is raised, and its factor is stated."
)
def test_a_ball_that_rolls_on_after_its_impacts_is_heard(run: Run) -> None:
    """Both parts times their factors are the sound, apart from 10 ms of fades at their ends."""
    rate = wav.SAMPLE_RATE_HZ
    random = np.random.default_rng(3)
    rolling = 1e-5 * random.standard_normal(6 * rate)
    decay = np.exp(-np.arange(6 * rate) / (0.02 * rate))
    knocks = np.roll(decay, rate // 10) * random.standard_normal(6 * rate)
    sound = replace(run.sound, pressure=rolling + knocks, closed=False, once=True)
    run = replace(run, numbers=without_levels(run.numbers))
    listen = ListenSound(replace(run, sound=sound))
    content, facts = listen.wav(), listen.facts()
    samples, _ = soundfile.read(io.BytesIO(content))
    begin = round(facts.raised.begin_s * rate)
    fade = round(0.02 * rate)
    parts = (
        (slice(fade, begin - fade), facts.pascal_per_full_scale),
        (slice(begin + fade, len(samples) - fade), facts.raised.pascal_per_full_scale),
    )
    for part, factor in parts:
        assert np.abs(samples[part] * factor - sound.pressure[part]).max() <= factor * 2**-23
    assert np.abs(samples).max() < 1.0 and len(samples) < 6 * rate
    heard = laeq_db(samples[begin:], rate)
    assert heard is not None and heard > laeq_db(samples[:begin], rate) - 20
    # A fall without an end that sounds is cut; a record that goes round is not touched.
    dying = replace(sound, pressure=knocks * (np.arange(len(knocks)) < rate))
    listen = ListenSound(replace(run, sound=dying))
    content, facts = listen.wav(), listen.facts()
    assert facts.raised is None and facts.duration_s < 4
    listen = ListenSound(replace(run, sound=replace(sound, once=False)))
    content, facts = listen.wav(), listen.facts()
    assert facts.raised is None and facts.duration_s >= 5

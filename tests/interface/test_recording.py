"""`rolling compare` on recordings that are made from runs, so that every difference is known."""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import soundfile
from finished import VIBRATING, heard_again, marched

from acoustics import BAND_NAMES, resampling
from rolling import cli, open_run, save_run
from rolling.numbers.quantity import joined
from rolling.recordings import ball_records, recording_comparison
from rolling.recordings.record_levels import Total, third_octave_levels
from rolling.recordings.recorded import PRESSURE, QUANTITIES, Recording, full_scales
from rolling.recordings.run_spread import run_spread
from rolling.results import listening
from rolling.results.run_result import Run

RATE = 44100
SECONDS = 6.0
FULL_SCALE_PA = 0.02
TEXT = VIBRATING.replace("sound: {", f"sound: {{listen_s: {SECONDS}, ")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Store a run with a long record."""
    out = tmp_path_factory.mktemp("compared") / "run"
    return save_run(marched(TEXT), out, report=False)


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return open_run(folder)


def at_rate(pressure: np.ndarray, rate: int = RATE) -> np.ndarray:
    """Resample a record of 48 kHz."""
    return resampling.resample_closed(pressure, round(len(pressure) * rate / 48000))


def filtered(samples: np.ndarray, rate: int) -> tuple[np.ndarray, np.ndarray]:
    """Play a record through a filter that falls by 9 dB between two frequencies.

    Return also the filter in third octaves [dB].
    """
    frequency = np.fft.rfftfreq(len(samples), 1 / rate)
    lines = np.fft.rfft(samples)
    bands = 10 ** (np.arange(13, 44) / 10)
    gains = [np.interp(np.log(x + 1e-9), np.log([800, 2500]), [2, -7]) for x in (frequency, bands)]
    return np.fft.irfft(lines * 10 ** (gains[0] / 20), len(samples)), gains[1]


def compared(folder: Path, recording: Path, *words: object) -> pd.DataFrame:
    """Compare a run with a recording and read the table."""
    assert cli.main(["compare", str(folder), str(recording), *map(str, words)]) == 0
    return pd.read_csv(folder / f"compare-{recording.name.replace('.wav', '')}.wav.csv")


def bands(table: pd.DataFrame) -> pd.DataFrame:
    return table[table["quantity"] == "third octave"].astype({"frequency_hz": float})


def tone(path: Path, pascal: float, rate: int = RATE) -> str:
    """Write a tone of 1 kHz with a rms [Pa] and the hiss of a phone; return its calibration."""
    sound = np.sqrt(2) * pascal * np.sin(2 * np.pi * 1000.3 * np.arange(2 * rate) / rate)
    sound += 0.02 * pascal * np.random.default_rng(1).standard_normal(2 * rate)
    soundfile.write(path, sound / FULL_SCALE_PA, rate, subtype="PCM_16")
    return f"{path}={20 * np.log10(pascal / 2e-5):.6f}"


def test_the_difference_is_the_filter_within_the_stated_uncertainty(
    folder: Path, run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another continuation of the run, filtered, in noise, whose second channel is quieter.

    Few bands are beyond two standard uncertainties, which hold for recordings of other surfaces.
    """
    other = at_rate(run.listen(SECONDS, seed=5).pressure)
    sound, gain = filtered(other, RATE)
    rng = np.random.default_rng(2)
    full = np.abs(sound).max() / 0.5
    noise = 0.002 * sound.std() * rng.standard_normal((2, len(sound)))
    wav = tmp_path / "phone.wav"
    hush = tmp_path / "hush.wav"
    soundfile.write(wav, np.stack([sound + noise[0], 0.1 * sound], 1) / full, RATE, "PCM_24")
    soundfile.write(hush, np.stack([noise[1], 0 * sound], 1) / full, RATE, "PCM_24")
    words = (wav, "--calibration", full, "--background", hush)
    table = bands(compared(folder, *words))
    assert len(table) >= 15
    wanted = table["frequency_hz"].map(dict(zip(map(float, BAND_NAMES), gain, strict=True)))
    # Run and recording have the same bodies here, so the lengths of the records make the rest.
    error = (table["difference_db"] + wanted) / table["records_uncertainty_db"]
    assert (error.abs() > 2).sum() <= 2
    longest = table["records_uncertainty_db"] / table["recording_uncertainty_db"]
    assert longest.min() > 2**0.5  # the solved track is shorter than the recording
    said = " ".join(capsys.readouterr().out.split())
    assert "not clearly above the background, left out: 20, 25," in said
    assert "levels of the vibration" in said and "long record of 6 s" in said


def test_a_tone_gives_the_level_back(folder: Path, run: Run, tmp_path: Path) -> None:
    """The run as its own recording has no difference: 0.1 dB of the tone, 0.01 dB of rounding."""
    wav = tmp_path / "self.wav"
    long = run.long.pressure
    scale = np.abs(long).max() * 1.1
    soundfile.write(wav, long / scale, 48000, subtype="PCM_24")
    level = tone(tmp_path / "tone.wav", 0.3 * FULL_SCALE_PA)
    words = wav, "--calibration", level
    table = compared(folder, *words)
    offset = 20 * np.log10(scale / FULL_SCALE_PA)
    laeq = table[table["quantity"] == "LAeq"].iloc[0]
    assert laeq["difference_db"] == pytest.approx(offset, abs=0.1)
    loud = bands(table)["run_db"] > bands(table)["run_db"].max() - 40
    assert bands(table)["difference_db"][loud].to_numpy() == pytest.approx(offset, abs=0.1)
    modulation = table[table["quantity"].str.startswith("modulation")]
    assert len(modulation) >= 5
    assert modulation["difference_db"].abs().max() < 0.2  # the fades of the recording


def test_without_calibration_shapes_are_compared(
    folder: Path, run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The page is one file with both sounds at the same level; it stands in the run folder."""
    before = {path.name for path in folder.iterdir()}
    wav = tmp_path / "a <b> & c.ogg"
    soundfile.write(
        wav, at_rate(run.long.pressure, 16000) / np.abs(run.long.pressure).max() / 3, 16000
    )
    assert cli.main(["compare", str(folder), str(wav)]) == 0
    out = folder / "compare-a_b_c.ogg.html"
    written = {path.name for path in folder.iterdir()} - before
    assert written == {out.name, "compare-a_b_c.ogg.csv", "compare-a_b_c.ogg.json"}
    stated = json.loads(out.with_suffix(".json").read_text())
    assert run.scene.name in stated["conditions"]["scenes"] and "a <b> & c.ogg" in stated["methods"]
    said = capsys.readouterr().out
    html = out.read_text(encoding="utf-8")
    assert said.splitlines()[-1] == str(out) and "is made equal" in " ".join(said.split())
    assert "a <b>" not in html and html.count("<audio") == 2
    assert re.findall(r'(?:src|href)="(?!data:)', html) == []
    table = pd.read_csv(out.with_suffix(".csv"))
    laeq = table[table["quantity"] == "LAeq"].iloc[0]
    assert laeq["difference_db"] == pytest.approx(0, abs=1e-9)
    assert bands(table)["frequency_hz"].astype(float).max() == 6300  # the band of 8 kHz ends beyond


FREE = {
    "plate.length_mm": 300,
    "plate.width_mm": 240,
    "plate.edges": "free",
    "plate.loss_factor": 0.1,
    "sound.listen_s": 1,
    "rolling.speed_m_s": 0.05,
}


SMALL = {
    "plate.length_mm": 60,
    "plate.width_mm": 50,
    "plate.thickness_mm": 1.5,
    "plate.edges": "free",
    "plate.loss_factor": 0.1,
}


def with_itself(run: Run, folder: Path) -> recording_comparison.RecordingComparison:
    """Compare a run with its own record, repeated until it is long enough for a recording."""
    pressure = ball_records.of_run(run).samples
    scale = 2 * np.abs(pressure).max()
    laps = int(np.ceil(RATE / len(pressure)))
    soundfile.write(folder / "own.wav", np.tile(pressure, laps) / scale, 48000, "FLOAT")
    return recording_comparison.compare(run, folder / "own.wav", f"{scale:.9g}")


@pytest.mark.law("Recordings: a difference has the ± that the run states, in each band.")
@pytest.mark.parametrize("estimate", [False, True], ids=["", "error estimate"])
def test_run_and_comparison_state_the_same_uncertainty(
    run: Run, tmp_path: Path, estimate: bool
) -> None:
    """The ± of a small free plate is mostly its baffle. The error estimate needs 256 steps."""
    if estimate:
        run = marched(VIBRATING, ["rolling.distance_mm=0.516", "numerics.error_estimate=true"])
    free = heard_again(run, run.scene.with_(SMALL))
    stated = free.vibration
    assert stated.parts["baffle"] > 5
    assert ("grid" in stated.parts) == estimate
    table, notes, _, _ = with_itself(free, tmp_path)
    laeq = table[table["quantity"] == "LAeq"].iloc[0]
    assert laeq["run_uncertainty_db"] == pytest.approx(stated.uncertainty, rel=1e-3)
    assert f"which `rolling run` states as {stated.number} dB(A), computed" in notes[0]
    assert laeq["left_out"] == ""
    stated_bands = free.numbers.bands.vibration
    own = pd.Series(stated_bands.uncertainty_by_name, dtype=float).dropna()
    found = bands(table).set_index(bands(table)["frequency_hz"].map("{:g}".format))
    shared = found.index.intersection(own.index)
    assert len(shared) > 10
    assert found.loc[shared]["run_uncertainty_db"].to_numpy() == pytest.approx(
        own[shared], rel=1e-9
    )
    of_parts = np.sqrt(sum(np.square(part) for part in stated_bands.parts.values()))
    of_parts = pd.Series(of_parts, index=stated_bands.by_name)
    assert of_parts[own.index].to_numpy() == pytest.approx(own.to_numpy(), rel=1e-9)


@pytest.mark.law("Recordings: what a comparison cannot have of the ± of a run is left out by name.")
def test_what_the_comparison_cannot_have_is_left_out_by_name(run: Run, tmp_path: Path) -> None:
    """The motion of a plate needs no baffle. Slow steps end the band below the end of hearing.

    A recording shares nothing with a run, so the difference has the whole ± of both.
    """
    free = heard_again(run, run.scene.with_(FREE))
    stated = free.vibration
    assert stated.parts["band"] > 0.05
    table, notes, _, _ = with_itself(free, tmp_path)
    laeq = table[table["quantity"] == "LAeq"].iloc[0]
    without = joined(stated.parts, left_out=["band"])
    assert laeq["run_uncertainty_db"] == pytest.approx(without, rel=1e-3)
    assert laeq["left_out"] == "band"
    said = " ".join(notes)
    assert "dB by the baffle that a free plate does not have" in said
    assert "dB by the unknown loss of the contact" in said
    assert "left out of the ± of the run's LAeq: the end of the simulated band, because" in said
    whole = np.hypot(table["run_uncertainty_db"], table["recording_uncertainty_db"])
    assert table["difference_uncertainty_db"].to_numpy() == pytest.approx(whole.to_numpy())
    found = bands(table)
    assert (found["records_uncertainty_db"] < found["difference_uncertainty_db"]).all()
    none = np.zeros(len(BAND_NAMES))
    without_parts = replace(free.numbers.bands.vibration, parts={})
    older = replace(free.numbers, bands=replace(free.numbers.bands, vibration=without_parts))
    known = run_spread(free, PRESSURE).known
    of_older, of_run = (
        run_spread(one, PRESSURE).of_bands(none).whole_db[known]
        for one in (replace(free, numbers=older), free)
    )
    assert of_older == pytest.approx(of_run, rel=1e-9)
    of_motion = run_spread(free, QUANTITIES["acceleration"])
    everywhere = np.ones(len(BAND_NAMES), dtype=bool)
    of_total = of_motion.of_total(
        Total("all bands", "Z"), everywhere, everywhere + none, record_db=0.5
    )
    assert of_total.left_out == ("baffle",)
    assert of_total.parts.keys() == stated.parts.keys() - {"baffle"}
    assert of_total.parts["record"] == 0.5
    assert (of_motion.of_bands(none).whole_db < of_motion.band_parts["baffle"]).all()


def test_the_scatter_of_a_tone_is_in_the_uncertainty_of_the_recording(
    run: Run, tmp_path: Path
) -> None:
    """A tone whose parts differ by some tenths of a decibel says no more than that of a level."""
    rise = np.geomspace(1, 1.03, 2 * RATE)
    sound = 0.1 * rise * np.sin(2 * np.pi * 1000.3 * np.arange(2 * RATE) / RATE)
    soundfile.write(tmp_path / "rising.wav", sound, RATE, subtype="PCM_24")
    (scale,) = full_scales(f"{tmp_path / 'rising.wav'}=94", PRESSURE, 1)
    assert 0.05 < scale.uncertainty_db < 0.2
    wav = tmp_path / "noise.wav"
    soundfile.write(wav, 0.1 * np.random.default_rng(5).standard_normal(RATE), RATE, "FLOAT")
    by_number, by_tone = (
        recording_comparison.compare(run, wav, calibration).table["recording_uncertainty_db"]
        for calibration in ("1", f"{tmp_path / 'rising.wav'}=94")
    )
    is_level = recording_comparison.compare(run, wav).table["quantity"] != "modulation"
    part = np.sqrt(by_tone[is_level] ** 2 - by_number[is_level] ** 2)
    assert part.to_numpy() == pytest.approx(scale.uncertainty_db, rel=1e-3)


def write_odd(path: Path) -> None:
    """Write recordings that are none, by the name of the file."""
    rate = 16000
    sound = 0.1 * np.random.default_rng(3).standard_normal(16000)
    if path.name == "silent.wav":
        sound[:] = 0.25
    if path.name == "nan.wav":
        sound[77] = np.nan
    if path.name == "huge.wav":
        sound[77] = 1e30
    if path.name == "short.wav":
        sound = sound[:7999]
    if path.name == "empty.wav":
        sound = sound[:0]
    if path.name == "slow.wav":
        rate = 8000
    if path.name == "fast.wav":
        rate = 192001
        sound = np.tile(sound, 7)
    soundfile.write(path, sound, rate, subtype="FLOAT")
    if path.name == "text.wav":
        path.write_text("no sound")
    if path.name == "cut.wav":
        path.write_bytes(path.read_bytes()[:40])
    if path.name == "folder.wav":
        path.unlink()
        path.mkdir()
    if path.name == "missing.wav":
        path.unlink()


ODD = {
    "silent.wav": "first channel is silent",
    "nan.wav": "or holds no finite numbers",
    "huge.wav": "or holds no finite numbers",
    "short.wav": "got 0.5 s at 16000 Hz, allowed: 0.5 to 120 s",
    "empty.wav": "got 0 s",
    "slow.wav": "8000 Hz, allowed: 0.5 to 120 s at 16000 to 192000 Hz",
    "fast.wav": "192001 Hz, allowed: 0.5 to 120 s at 16000 to 192000 Hz",
    "text.wav": "no sound that can be read (Format not recognised.), allowed: WAV",
    "cut.wav": "no sound that can be read (",
    "folder.wav": "no sound that can be read (is a folder), allowed: WAV",
    "missing.wav": "no sound that can be read (No such file or directory), allowed: WAV",
}


@pytest.mark.parametrize(("name", "message"), ODD.items(), ids=ODD)
def test_what_is_no_recording_is_refused(
    name: str, message: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_odd(tmp_path / name)
    assert cli.main(["compare", str(folder), str(tmp_path / name)]) == 2
    said = capsys.readouterr().err
    assert message in said and "object at" not in said and len(said.splitlines()) == 1
    assert not [*folder.glob(f"compare-{name}*")]


def test_calibrations_that_are_none_are_refused(
    folder: Path, run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(4)
    sound = 0.1 * rng.standard_normal(RATE)
    t = np.arange(RATE) / RATE
    files = {
        "ok": sound,
        "noise": sound,
        "clipped": np.clip(3 * np.sin(2 * np.pi * 1000 * t), -1, 1),
        "stops": np.sin(2 * np.pi * 1000 * t) * (t < 0.5),
    }
    for name, samples in files.items():
        soundfile.write(tmp_path / f"{name}.wav", samples, RATE)
    command = ["compare", str(folder), str(tmp_path / "ok.wav")]
    for word in ("noise", "clipped", "stops"):
        assert cli.main([*command, "--calibration", f"{tmp_path / word}.wav=94"]) == 2
        assert "no steady tone" in capsys.readouterr().err
    for word in (
        "",
        "nan",
        "inf",
        "0",
        "-1",
        "1e300",
        "=94",
        "tone.wav=",
        "tone.wav=nan",
        "tone.wav=1e9",
    ):
        assert cli.main([*command, f"--calibration={word}"]) == 2
        said = capsys.readouterr().err
        assert "--calibration: got" in said and "full scale, 1e-6 to 1e6 Pa" in said
    assert cli.main([*command, "--background", str(tmp_path / "ok.wav")]) == 2
    assert (
        "no third octave can be compared; not clearly above the background, left out: 20, 25,"
        in capsys.readouterr().err
    )
    assert not [*folder.glob("compare-ok*")]


def test_slow_changes_widen_all_bands_alike_and_a_drop_has_none(run: Run, tmp_path: Path) -> None:
    """A level that falls widens each band by that of LAeq, also bands that are uncertain already.

    A drop is one event, whose parts differ by nature. Bands uncertain by 10 dB are left out.
    """
    falling = np.random.default_rng(8).standard_normal(6 * RATE) * np.geomspace(1, 0.01, 6 * RATE)
    soundfile.write(tmp_path / "falling.wav", falling / 10, RATE, "FLOAT")
    tables = []
    for scene in (run.scene, run.scene.with_(drop_mm=0.01)):
        table, notes, _, _ = recording_comparison.compare(
            replace(run, scene=scene), tmp_path / "falling.wav"
        )
        tables.append(bands(table)["recording_uncertainty_db"])
        assert table["difference_uncertainty_db"].max() < 10
        assert "uncertain by 10 dB or more, left out: 20, 25" in notes[-1]
    assert tables[1].between(0.02, 1).all() and tables[1].iloc[0] > 5 * tables[1].iloc[-1]
    scatter = np.sqrt(tables[0] ** 2 - tables[1] ** 2).dropna()
    assert scatter.iloc[0] > 3 and scatter.to_numpy() == pytest.approx(scatter.iloc[0], rel=1e-6)


def test_the_uncertainty_of_a_band_with_a_sharp_resonance_is_that_of_its_lines() -> None:
    """The levels of 200 records of a resonance of 10 Hz, in noise, scatter by what they state.

    Its third octave of 1 kHz holds 23 times as many lines; 15 % are 3 standard deviations of 200.
    """
    spreads = []
    levels = []
    frequency = np.fft.rfftfreq(48000, 1 / 48000)
    gain = 1e-3 + 1 / np.abs(1 - (frequency / 1000) ** 2 + 0.01j * frequency / 1000)
    for seed in range(200):
        noise = np.random.default_rng(seed).standard_normal(48000)
        samples = np.fft.irfft(gain * np.fft.rfft(noise))
        found = third_octave_levels(Recording("noise", samples, 24000.0, 1.0))
        levels.append(found[0])
        spreads.append(found[2])
    resonant = BAND_NAMES.index("1000")
    broad = BAND_NAMES.index("4000")
    for band in (resonant, broad):
        scatter = np.std(levels, axis=0)[band]
        assert np.mean(spreads, axis=0)[band] == pytest.approx(scatter, rel=0.15)
    assert np.mean(spreads, axis=0)[resonant] > 2 * 4.34 / np.sqrt(230)


def test_clipping_is_named(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sound = np.random.default_rng(6).standard_normal(48000)
    for clip, name in ((1.0, "hard"), (9.0, "soft")):
        smooth = np.cumsum(sound - sound.mean())
        smooth = 3 * smooth / np.abs(smooth).max() if clip == 1.0 else smooth / np.abs(smooth).max()
        soundfile.write(tmp_path / f"{name}.wav", np.clip(smooth, -clip, clip), 48000)
        compared(folder, tmp_path / f"{name}.wav")
        assert ("is clipped" in capsys.readouterr().out) == (name == "hard")


@pytest.mark.slow
def test_a_damaged_recording_is_read_or_refused(folder: Path, tmp_path: Path) -> None:
    """Flipped bytes of a header end in a page or in a refusal, never in a traceback."""
    rng = np.random.default_rng(7)
    whole = tmp_path / "whole.wav"
    codes = set()
    soundfile.write(whole, 0.1 * rng.standard_normal((16000, 2)), 16000, "PCM_16")
    content = whole.read_bytes()
    for number in range(25):
        damaged = bytearray(content)
        for place in rng.integers(0, 64, 3):
            damaged[place] = rng.integers(0, 256)
        path = tmp_path / f"{number}.wav"
        path.write_bytes(damaged)
        codes.add(cli.main(["compare", str(folder), str(path)]))
    assert codes <= {0, 2}


def flac_that_says(path: Path, frames: int, channels: int, rate: int) -> None:
    """Write a short FLAC whose header says that it has so many frames."""
    soundfile.write(path, np.zeros((rate // 10, channels)), rate)
    content = bytearray(path.read_bytes())
    content[21:26] = (content[21] & 0xF0 | frames >> 32).to_bytes(1, "big") + (
        frames & 0xFFFFFFFF
    ).to_bytes(4, "big")
    path.write_bytes(content)


def test_a_small_file_that_says_many_samples_is_refused_unread(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Eight channels of 60 s at 192 kHz take 737 MB, whatever the size of their file."""
    path = tmp_path / "bomb.flac"
    flac_that_says(path, 60 * 192_000, channels=8, rate=192_000)
    assert path.stat().st_size < 100_000
    for words in (
        ["compare", str(folder), str(path)],
        ["compare", str(folder), str(path), "--quantity", "acceleration"],
    ):
        assert cli.main(words) == 2
        said = capsys.readouterr().err
        assert "got 60 s of 8 channels, which take 737 MB, allowed: 500 MB" in said
        assert "save fewer channels, or a stretch of at most 40.7 s" in said


def test_a_packed_sound_in_place_of_a_long_record_is_not_unpacked(run: Run, tmp_path: Path) -> None:
    """A file of this program takes three bytes for each sample; the record is made anew."""
    assert listening.stored_long_record(run) is not None
    packed = io.BytesIO()
    channels = 16
    with soundfile.SoundFile(packed, "w", 48_000, channels, format="OGG") as file:
        file.comment = listening.comment_of_gain(listening.Gain(1.0, "own"))
        file.write(np.zeros((round(SECONDS * 48_000), channels)))
    assert len(packed.getvalue()) < 300_000
    (tmp_path / "listen.wav").write_bytes(packed.getvalue())
    assert listening.stored_long_record(replace(run, folder=tmp_path)) is None

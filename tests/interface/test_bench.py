"""Accelerations and forces beside a run: records whose truth is known, and folders of a bench."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile
from finished import VIBRATING, marched

from acoustics import resampling
from rolling import cli, save_run
from rolling.kinds.stated_conditions import conditions_of
from rolling.recordings import recording_comparison
from rolling.report import recording_page
from rolling.report.bench import read_bench
from rolling.results.channels import Channel
from rolling.results.run_result import Run
from rolling.terminal.whole_files import FolderError

SECONDS = 1.0
TONE_RMS = 10.0  # m/s2, at 159.2 Hz
FULL_SCALE = 37.0  # m/s2


def ringing(seed: int) -> np.ndarray:
    """Return the acceleration [m/s2] of a plate that rings."""
    samples = round(48000 * SECONDS)
    lines = np.fft.rfft(np.random.default_rng(seed).standard_normal(samples))
    frequency = np.fft.rfftfreq(samples, 1 / 48000)
    gain = 0.02 + 1 / np.abs(1 - (frequency / 900) ** 2 + 0.05j * frequency / 900)
    lines[(frequency < 18) | (frequency > 8000)] = 0
    return 0.2 * np.fft.irfft(lines * gain, samples)


@pytest.fixture(scope="module")
def run() -> Run:
    """Return a run with the channels of two accelerometers and a force transducer."""
    made = marched(VIBRATING)
    of_plate = [
        Channel("corner", "plate", "acceleration", "m/s2", (0.03, 0.04), ringing(1)),
        Channel("middle", "plate", "acceleration", "m/s2", (0.1, 0.1), ringing(2)),
    ]
    force = Channel("contact force", "contact", "force", "N", None, ringing(3))
    vars(made)["channels"] = (*of_plate, force)
    return made


def write(path: Path, channels: list[np.ndarray], rate: int, noise: float = 0.002) -> Path:
    """Write what an accelerometer records of accelerations: noise and offset, silence around."""
    before = np.zeros(round(0.3 * 48000))
    columns = []
    for seed, channel in enumerate(channels):
        padded = np.concatenate((before, channel, before))
        recorded = resampling.resample_closed(padded, round(len(padded) * rate / 48000))
        columns.append(
            recorded + noise * np.random.default_rng(seed).standard_normal(len(recorded))
        )
    soundfile.write(path, np.stack(columns, axis=1) / FULL_SCALE + 0.1, rate, subtype="PCM_24")
    return path


def tone(path: Path, rate: int) -> str:
    """Write the tone of a shaker in the noise of the chain; return its calibration."""
    times = np.arange(2 * rate) / rate
    shaken = np.sqrt(2) * TONE_RMS * np.sin(2 * np.pi * 159.2 * times)
    write_one = shaken + 0.002 * np.random.default_rng(9).standard_normal(len(shaken))
    soundfile.write(path, write_one / FULL_SCALE + 0.1, rate, subtype="PCM_24")
    return f"{path}={TONE_RMS:g}"


@pytest.mark.parametrize("rate", [44100, 51200])
def test_an_acceleration_in_noise_and_offset_is_recovered_by_a_tone(
    run: Run, tmp_path: Path, rate: int
) -> None:
    """In the bands 20 dB above the noise 0.2 dB are left, which that noise explains.

    Noise of the relative power 0.01 shifts a band by 0.09 dB at most after its mean is subtracted,
    and the tone has 0.02 dB.
    """
    own = [channel.samples for channel in run.channels[:2]]
    wav = write(tmp_path / "acceleration.wav", own, rate)
    hush = write(tmp_path / "hush.wav", [0 * samples for samples in own], rate)
    calibration = tone(tmp_path / "tone.wav", rate)
    table, notes, pairs, _ = recording_comparison.compare(
        run, wav, calibration, hush, "acceleration"
    )
    assert [pair.name for pair in pairs] == ["corner", "middle"]
    assert "the recording from 0.300 to 1.300 s has the waveform" in " ".join(notes)
    noise_line = 0.002**2 / (rate / 2)
    for name in ("corner", "middle"):
        rows = table[(table["channel"] == name) & (table["quantity"] == "third octave")]
        width = 0.23 * rows["mid_frequency_hz"]
        noise_db = 10 * np.log10(noise_line * width / 1e-12)
        is_loud = rows["recording_db"] > noise_db + 20
        assert is_loud.sum() >= 12
        assert rows["difference_db"][is_loud].abs().max() < 0.2
    assert set(table["reference"]) == {"1e-6 m/s2", "full modulation"}
    assert set(table["weighting"]) == {"Z", "-"}


def test_full_scale_of_each_channel_and_names_of_channels(run: Run, tmp_path: Path) -> None:
    """Channels that are named go where they belong; a factor of two is 6.02 dB."""
    own = [channel.samples for channel in run.channels[:2]]
    wav = write(tmp_path / "swapped.wav", own[::-1], 48000)
    calibration = f"{FULL_SCALE:g},{2 * FULL_SCALE:g}"
    table, notes, _, _ = recording_comparison.compare(
        run, wav, calibration, None, "acceleration", ["middle", "corner"]
    )
    total = table[table["quantity"] == "all bands"].set_index("channel")["difference_db"]
    assert total["middle"] == pytest.approx(0, abs=0.1)
    assert total["corner"] == pytest.approx(-6.02, abs=0.1)
    assert any("channel 2 with the run's corner" in note for note in notes)
    alone = recording_comparison.compare(
        run, wav, calibration, None, "acceleration", ["-", "corner"]
    )
    assert set(alone.table["channel"]) == {"corner"}
    page = recording_page.page(run, alone, conditions_of({"run": run.scene}), "as it was done")
    assert b"<h3>Third octaves, corner</h3>" in page and b"as it was done" in page


REFUSED = {
    "two": ("two.wav", "force", "37", "got 2 channels, and the run has 1 of force"),
    "velocity": ("two.wav", "velocity", "37", "no channel of velocity, only acceleration of plate"),
    "unknown": ("two.wav", "aceleration", "37", "got aceleration, nearest: acceleration, allowed"),
    "many": ("two.wav", "acceleration", "1,2,3", "got 3 values for 2 channels"),
    "none": ("two.wav", "acceleration", "0", "the acceleration of full scale in m/s2"),
    "clipped": ("two.wav", "acceleration", "clipped.wav=10", "no steady tone, or it is clipped"),
    "silent": ("silent.wav", "acceleration", "37", "its channel 2 is silent"),
    "nan": ("nan.wav", "acceleration", "37", "or holds no finite numbers"),
    "slow": ("slow.wav", "acceleration", "37", "3999 Hz, allowed: 0.5 to 120 s at 4000 to 192000"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_acceleration_is_refused(
    run: Run, tmp_path: Path, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name, quantity, calibration, message = REFUSED[case]
    noise = 0.1 * np.random.default_rng(4).standard_normal((8000, 2))
    rate = 8000
    if case == "silent":
        noise[:, 1] = 0.2
    if case == "nan":
        noise[7, 0] = np.nan
    if case == "slow":
        rate = 3999
    soundfile.write(name, noise, rate, subtype="FLOAT")
    shaken = 3 * np.sin(2 * np.pi * 159.2 * np.arange(8000) / 8000)
    soundfile.write("clipped.wav", np.clip(shaken, -1, 1), 8000)
    with pytest.raises(FolderError) as error:
        recording_comparison.compare(run, Path(name), calibration, None, quantity)
    assert message in str(error.value)


def test_a_run_without_channels_names_the_line_to_add_and_clipping_is_named(
    run: Run, tmp_path: Path
) -> None:
    wav = write(tmp_path / "one.wav", [run.channels[0].samples], 48000)
    with pytest.raises(FolderError) as error:
        recording_comparison.compare(marched(VIBRATING), wav, "37", None, "acceleration")
    assert "channels: [{of: plate, quantity: acceleration, x_mm: 30, y_mm: 40}]" in str(error.value)
    hard = np.clip(5 * run.channels[2].samples, -1, 1)
    soundfile.write(tmp_path / "hard.wav", hard, 48000)
    notes = recording_comparison.compare(run, tmp_path / "hard.wav", "1", None, "force").notes
    assert "the recording, contact force is clipped: repeat it with less gain" in notes


def test_a_second_comparison_keeps_the_first(run: Run, tmp_path: Path) -> None:
    folder = save_run(marched(VIBRATING), tmp_path / "run", report=False)
    noise = 0.1 * np.random.default_rng(4).standard_normal(24000)
    soundfile.write(tmp_path / "a.wav", noise, 48000)
    command = ["compare", str(folder), str(tmp_path / "a.wav")]
    assert cli.main(command) == 0
    first = (folder / "compare-a.wav.csv").read_bytes()
    assert cli.main([*command, "--calibration", "2"]) == 0
    assert (folder / "compare-a.wav.csv").read_bytes() == first
    names = {path.name for path in folder.glob("compare-*")}
    stems = ("compare-a.wav", "compare-a.wav-2")
    assert names == {f"{stem}.{ending}" for stem in stems for ending in ("csv", "html", "json")}


def test_an_empty_folder_is_told_what_a_bench_needs(tmp_path: Path) -> None:
    with pytest.raises(FolderError) as error:
        read_bench(tmp_path)
    lines = str(error.value).splitlines()
    assert [line.removeprefix(f"{tmp_path}: ").split(";")[0] for line in lines] == [
        "no scene",
        "no scan of the surface",
        "no recording",
    ]


def test_each_missing_thing_of_a_bench_has_its_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Mass, dimensions, motion, scan, calibration, tone: one line each, and nothing is written."""
    (tmp_path / "scene.yaml").write_text(
        "name: mine\nsphere: {radius_mm: 5}\n"
        "plate: {youngs_modulus_gpa: 70, poissons_ratio: 0.2, thickness_mm: 8}\n"
        "surface: {kind: smooth, spacing_um: 5, width_um: 300}\n"
        "rolling: {load_n: 1, speed_m_s: 0.1, distance_mm: 1}\n",
        encoding="utf-8",
    )
    (tmp_path / "heights.csv").write_text("0,1\n1,0\n", encoding="utf-8")
    (tmp_path / "calibration.txt").write_text("force: shaker.wav=1\n", encoding="utf-8")
    for name in ("force.wav", "acceleration-1.wav"):
        soundfile.write(tmp_path / name, np.zeros(48000), 48000)
    before = sorted(path.name for path in tmp_path.iterdir())
    assert cli.main(["compare", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    for text in (
        "no mass of the ball; weigh it",
        "no mass of the plate; weigh it",
        "no dimensions of the plate; measure them: plate.length_mm, plate.width_mm",
        "no motion; ball and plate move with the line: dynamics: {}",
        "the scene does not take the scan; write surface: {kind: file, path: heights.csv}",
        "no calibration of acceleration; record a tone",
        "calibration.txt:1: no tone shaker.wav",
    ):
        assert text in said
    assert len(said.splitlines()) == 7
    assert sorted(path.name for path in tmp_path.iterdir()) == before


@pytest.mark.slow
def test_the_synthetic_bench_is_recovered_and_becomes_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The levels lie within 0.2 dB; the second command uses the run that is there."""
    monkeypatch.chdir(tmp_path)
    assert cli.main(["compare", "synthetic-bench"]) == 0
    said = capsys.readouterr().out
    assert said.count("has the waveform of the other") == 2
    assert cli.main(["validate", "--bench", "outputs/synthetic-bench"]) == 0
    page = Path("validation.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in page.splitlines() if line.startswith("|measured level, ")]
    assert len(rows) == 3
    assert all(abs(float(row[5])) < 0.2 for row in rows)

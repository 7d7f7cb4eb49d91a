"""`rolling compare` of bearings with made recordings, so that every difference is known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from bearing_runs import moved_as, turning
from scipy.io import savemat

from acoustics import resampling
from rolling import cli, save_run
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.bearing_kind.compared_records import pulse_lines_hz
from rolling.recordings.recorded_units import STANDARD_GRAVITY_M_S2, UNITS
from rolling.recordings.recording_comparison import Healthy, compare
from rolling.recordings.series_files import FileLayout
from rolling.terminal.whole_files import FolderError

RATE = 48_000
SECONDS = 2
T = np.arange(SECONDS * RATE) / RATE
RESONANCE_HZ = 3500.0


def acceleration(bpfi_hz: float, seed: int) -> np.ndarray:
    """Return noise with knocks at a frequency, if there is one [m/s2]."""
    record = 0.5 * np.random.default_rng(seed).standard_normal(len(T))
    if bpfi_hz:
        since = T % (1 / bpfi_hz)
        record += 20 * np.exp(-3000 * since) * np.sin(2 * np.pi * RESONANCE_HZ * since)
    return np.asarray(record)


def ring_run(bpfi_hz: float, seed: int, amplitude: float = 1.0) -> BearingRun:
    """Return a run whose ring has a made acceleration along all axes."""
    own = amplitude * acceleration(bpfi_hz, seed)
    lines = np.fft.rfft(own)
    angular = 2 * np.pi * np.fft.rfftfreq(len(own), 1 / RATE)
    lines[angular < 2 * np.pi * 10] = 0
    lines[1:] /= 1j * angular[1:]
    velocity = np.fft.irfft(lines, len(own))
    base = turning()
    record = replace(
        base.record,
        velocity_m_s=np.stack([velocity] * 3, 1),
        acceleration_m_s2=np.stack([own] * 3, 1),
        ball_load_n=np.resize(base.record.ball_load_n, (len(T), base.geometry.balls)),
    )
    scene = base.scene.with_({"sound.duration_s": SECONDS, "sound.listen_s": SECONDS})
    return moved_as(base, record, scene)


@cache
def bpfi_hz() -> float:
    return pulse_lines_hz(turning().kinematics)["BPFI"]


@cache
def faulty() -> BearingRun:
    return ring_run(bpfi_hz(), 1)


@cache
def healthy() -> BearingRun:
    return ring_run(0.0, 2)


def record_file(folder: Path, name: str, samples: np.ndarray, rate_hz: int = RATE) -> Path:
    """Write accelerations [m/s2] in g at a rate, beside the speed and another sensor."""
    own = resampling.resample_closed(samples, len(samples) * rate_hz // RATE)
    path = folder / f"{name}.mat"
    sensors = {"DE_time": own[:, None] / STANDARD_GRAVITY_M_S2, "FE_time": own[:, None]}
    savemat(path, {**sensors, "RPM": 1797}, do_compression=True)
    return path


def layout(rate_hz: int = RATE) -> FileLayout:
    return FileLayout(["DE_time"], rate_hz)


def figures_of(run: BearingRun, path: Path, **others: object) -> pd.DataFrame:
    comparison = compare(
        run=run,
        path=path,
        calibration=str(UNITS["g"].si),
        quantity="acceleration",
        channels=["x"],
        **{"layout": layout(), **others},
    )
    return comparison.figures.set_index(["figure", "item"])


def test_the_same_record_has_the_same_figures(tmp_path: Path) -> None:
    """Twice the vibration has 6 dB more velocity, and pulses of the same shape."""
    path = record_file(tmp_path, "own", acceleration(bpfi_hz(), 1))
    own = figures_of(faulty(), path)
    assert own.loc["velocity"]["difference"].abs().max() < 0.05
    assert own.loc["kurtosis"]["difference"].abs().max() < 0.1
    assert own.loc[("kurtosis", "all bands"), "run"] > 5
    assert own.loc["crest factor"]["difference"].abs().max() < 0.2
    line = own.loc[("line of the envelope", "BPFI")]
    assert line["run"] > 50 and abs(line["difference"]) < 0.5
    double = figures_of(faulty(), record_file(tmp_path, "double", 2 * acceleration(bpfi_hz(), 1)))
    assert double.loc["velocity"]["difference"].to_numpy() == pytest.approx(-6.02, abs=0.05)
    assert double.loc["kurtosis"]["difference"].abs().max() < 0.1


def test_a_recording_of_another_speed_and_rate(tmp_path: Path) -> None:
    """Lines are found where slip has them, and bands end where the shorter of both records does."""
    path = record_file(tmp_path, "slow", acceleration(0.995 * bpfi_hz(), 5), 12_000)
    own = figures_of(faulty(), path, layout=layout(12_000))
    line = own.loc[("line of the envelope", "BPFI")]
    assert line["recording_hz"] == pytest.approx(0.995 * bpfi_hz(), abs=0.02)
    assert line["run_hz"] == pytest.approx(bpfi_hz(), abs=0.02)
    assert line["recording"] > 30
    highest = min(6000.0, turning().scene.ring_bending_hz)
    assert list(own.loc["velocity"].index)[-1] == f"1,800 to {0.999 * highest:,.0f} Hz"


def test_the_rise_by_a_fault(tmp_path: Path) -> None:
    """The recording of a fault twice as large rises by 6 dB more where the fault leads."""
    large = record_file(tmp_path, "large", 2 * acceleration(bpfi_hz(), 3))
    own = Healthy(healthy(), record_file(tmp_path, "healthy", acceleration(0.0, 4)), layout())
    table = figures_of(faulty(), large, healthy=own)
    rises = table.loc["rise of the velocity"]
    high = rises.iloc[-1]
    assert high["run"] > 10
    assert high["difference"] == pytest.approx(-6.0, abs=0.1)
    assert high["difference_uncertainty"] < 1
    kurtosis = table.loc[("rise of the kurtosis", "all bands")]
    assert kurtosis["run"] > 2 and abs(kurtosis["difference"]) < 0.3


def test_without_a_unit_shapes_are_compared(tmp_path: Path) -> None:
    """Velocities need a unit; kurtosis, crest factor and lines of the envelope do not."""
    path = record_file(tmp_path, "own", 7 * acceleration(bpfi_hz(), 1))
    comparison = compare(faulty(), path, quantity="acceleration", channels=["x"], layout=layout())
    figures = set(comparison.figures["figure"])
    assert figures == {"kurtosis", "crest factor", "line of the envelope"}


def test_velocities_are_compared_as_they_are(tmp_path: Path) -> None:
    run = faulty()
    path = tmp_path / "v.csv"
    np.savetxt(path, np.stack([T, 1e6 * run.record.velocity_m_s[:, 0]], 1), delimiter=",")
    comparison = compare(run, path, "1e-06", quantity="velocity", channels=["x"])
    bands = comparison.figures[comparison.figures["figure"] == "velocity"]
    assert bands["difference"].abs().max() < 0.05


def test_the_command_writes_page_and_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A message says what the file holds; page, terminal and CSV have the figures."""
    run = save_run(faulty(), tmp_path / "faulty", report=False)
    before = save_run(healthy(), tmp_path / "healthy", report=False)
    recording = record_file(tmp_path, "fault", acceleration(bpfi_hz(), 3))
    well = record_file(tmp_path, "well", acceleration(0.0, 4))
    words = ["compare", str(run), str(recording), "--unit", "g", "--channel", "x"]
    assert cli.main([*words, "--rate", "48000"]) == 2
    assert "DE_time (96,000 numbers), FE_time" in capsys.readouterr().err
    words += ["--variable", "DE_time", "--rate", "48000"]
    assert cli.main([*words, "--healthy", str(well)]) == 2
    assert "--healthy-run: got one of them" in capsys.readouterr().err
    words += ["--healthy", str(well), "--healthy-run", str(before)]
    assert cli.main([*words, "--healthy-variable", "DE_time"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "The fault changes the run by" in said and "kurtogram of the recording" in said
    page = (run / "compare-fault.mat.html").read_text("utf-8")
    assert "rise of the velocity by the fault" in page.lower()
    table = pd.read_csv(run / "compare-fault.mat-figures.csv")
    assert len(table[table["figure"] == "velocity"]) == 3
    assert table["unit"].isin(["um/s", "dB", "1"]).all()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--unit", "G"], "--unit: got G, nearest: g"),
        (["--unit", "mm/s", "--quantity", "acceleration"], "a unit of velocity"),
        (["--unit", "g", "--calibration", "3"], "got a unit and a --calibration"),
        (["--rate", "0"], "rate"),
    ],
)
def test_odd_options_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    path = record_file(tmp_path, "own", acceleration(0.0, 1))
    code: object
    try:
        code = cli.main(["compare", str(tmp_path), str(path), *words])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_a_sound_file_has_no_variables(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    path.write_bytes(b"")
    with pytest.raises(FolderError, match="only go with CSV"):
        compare(faulty(), path, quantity="acceleration", layout=layout())

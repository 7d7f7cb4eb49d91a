"""Folders that version 0.8.0 wrote are shown with the numbers that it stored, and not resumed.

`tests/data/folders_0_8_0` holds a folder of each kind, and says how they were made. The tests read
the stored numbers from the files themselves. Only `shown_answer` and `shown_bands` know by which
names this program shows them.
"""

from __future__ import annotations

import csv
import json
import shutil
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pytest
from commands import tree

import rolling as rc
from rolling import cli
from rolling.bearing_kind.former_bearing import former_names
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.results.listening import content_words, listen_sounds
from rolling.results.run_result import Run
from rolling.results.stored_numbers import read_stored

FOLDERS = Path(__file__).parents[1] / "data" / "folders_0_8_0"
SUMMARIES = [
    "measured",
    "quickstart/load_n=20",
    "release_of_motion",
    "running_in",
    "with_error_estimate",
]
SWEEP = FOLDERS / "sweep"
BEARING = FOLDERS / "bearing"
RUNS = ["ball", "dynamics", "fall", "choice/ground/01", "sweep/load_n=0.03,seed=2"]
SERIES = (
    *("release_energy", "loading_energy", "energy_defect", "stored_energy"),
    *("release_power", "loading_power", "release_per_metre", "loading_per_metre", "speed"),
    *("approach", "contact_area", "plastic_area", "max_pressure", "max_deflection"),
    *("residual", "iterations", "convolutions"),
)
CLOSE = 1e-9  # relative difference of numbers that are stored unrounded
ROUNDED = 1e-4  # of numbers of a table
SAME_SOUND_DB = 0.1  # of a sound that is made again
# Numbers of bearings by direction and band.
Bands = dict[str, dict[str, float]]


class Number(NamedTuple):
    """One of the two numbers of a run."""

    level_db: float | None
    uncertainty_db: float | None
    verdict: str | None


class Answer(NamedTuple):
    """Both numbers of a run. An upper bound has words of its own in later versions."""

    vibration: Number
    released_power: tuple[float | None, float | None]  # level and uncertainty, dB


# ---- what is stored, and what this program shows


def stored_summary(folder: Path) -> dict[str, Any]:
    """Read the summary of a run folder as it stands in its file."""
    return json.loads((folder / "summary.json").read_text())


def stored_answer(folder: Path) -> Answer:
    """Return the two numbers that a run folder has stored."""
    summary = stored_summary(folder)
    heard = summary["answer"]["vibration"]
    released = summary["answer"]["released_power"]
    word = None if heard["verdict"] is None else heard["verdict"]["word"]
    # Errors of grid and solver stood beside the ± of the record, and are a part of it now.
    spread_db = released["standard_uncertainty_db"]
    if spread_db is not None:
        spread_db = summary.get("laeq_uncertainty_db") or spread_db
    return Answer(
        vibration=Number(heard["level_db"], heard["standard_uncertainty_db"], word),
        released_power=(released["level_db"], spread_db),
    )


def shown_answer(numbers: RunNumbers) -> Answer:
    """Return the two numbers of a run that this program shows."""
    heard = numbers.vibration
    released = numbers.released_power
    return Answer(
        vibration=Number(heard.value, heard.uncertainty, heard.verdict),
        released_power=(released.value, released.uncertainty),
    )


def shown_bands(numbers: BearingNumbers) -> Bands:
    """Return the velocities of a ring [um/s] that this program shows."""
    velocities = numbers.velocities.by_direction
    return {direction: bands.um_s for direction, bands in velocities.items()}


def rows_of(table: Path) -> list[dict[str, str]]:
    """Read the rows of a table."""
    return list(csv.DictReader(table.read_text().splitlines()))


@cache
def opened(name: str) -> Run:
    """Return a run of the test data."""
    return rc.open_run(FOLDERS / name)


def are_same(shown: Answer, stored: Answer) -> bool:
    """Tell whether two answers have the same words and, but for their rounding, numbers."""
    pairs = zip(
        (*shown.vibration, *shown.released_power),
        (*stored.vibration, *stored.released_power),
        strict=True,
    )
    return all(
        one == (pytest.approx(other, rel=CLOSE) if isinstance(other, float) else other)
        for one, other in pairs
    )


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """Return a copy of all folders, into which commands may write."""
    return Path(shutil.copytree(FOLDERS, tmp_path / "folders"))


# ---- the test data


def test_the_folders_are_small_and_written_by_version_0_8_0() -> None:
    files = [path for path in FOLDERS.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 1_000_000
    for path in files:
        if path.name == "scene.yaml":
            head = path.read_text().split("\n")[0]
            assert head.endswith("written by version 0.8.0, sources 323e6180755d")
        if path.name == "summary.json":
            assert stored_summary(path.parent)["provenance"]["program"] == "0.8.0"


# ---- runs


@pytest.mark.parametrize("name", RUNS)
def test_a_run_has_the_numbers_that_are_stored(name: str) -> None:
    stored = stored_answer(FOLDERS / name)
    assert stored.vibration.level_db is not None
    assert are_same(shown_answer(opened(name).numbers), stored)


@pytest.mark.parametrize("name", RUNS)
def test_a_run_has_the_series_that_are_stored(name: str) -> None:
    run = opened(name)
    with h5py.File(FOLDERS / name / "result.h5") as file:
        for series in SERIES:
            assert np.array_equal(run.series[series], file[series][()]), series
        assert np.array_equal(run.distance, file["step"][()])
        assert np.array_equal(run.time, file["time"][()])
        pressure = file["sound/pressure"][()]
    # The sound of the same record is made again.
    assert run.sound.pressure.shape == pressure.shape
    ratio = np.sqrt(np.mean(np.square(run.sound.pressure)) / np.mean(np.square(pressure)))
    assert abs(20 * np.log10(ratio)) < SAME_SOUND_DB


@pytest.mark.parametrize("names", [["ball", "dynamics", "fall"], ["sweep"]], ids="-".join)
def test_a_page_shows_the_vibrations_that_are_stored(copied: Path, names: list[str]) -> None:
    before = tree(copied)
    page = copied / "page.html"
    folders = [str(copied / name) for name in names]
    assert cli.main(["report", *folders, "--out", str(page), "-q"]) == 0
    text = page.read_text()
    for name in names:
        for summary in (FOLDERS / name).rglob("summary.json"):
            level_db = stored_answer(summary.parent).vibration.level_db
            assert f">{level_db:.1f}<" in text
    after = tree(copied)
    assert after.pop("page.html")
    assert after == before


def test_a_table_has_the_numbers_of_all_runs_of_a_sweep(copied: Path) -> None:
    assert cli.main(["table", str(copied / "sweep"), "-q"]) == 0
    rows = rows_of(copied / "sweep" / "runs.csv")
    assert len(rows) == 4
    for row in rows:
        stored = stored_answer(SWEEP / row["folder"])
        for column, number in (
            ("vibration_db", stored.vibration.level_db),
            ("vibration_uncertainty_db", stored.vibration.uncertainty_db),
            ("released_power_db", stored.released_power[0]),
            ("released_power_uncertainty_db", stored.released_power[1]),
        ):
            assert float(row[column]) == pytest.approx(number, rel=ROUNDED)
    assert (copied / "sweep" / "statistics.csv").is_file()


@pytest.mark.parametrize("name", SUMMARIES)
def test_a_summary_has_the_numbers_that_are_stored(name: str) -> None:
    """Summaries have an error estimate, passes, a fixed gain, a measured surface, and so on."""
    folder = FOLDERS / "numbers_only" / name
    numbers = read_stored(folder).numbers
    assert are_same(shown_answer(numbers), stored_answer(folder))


# ---- bearings


def test_a_summary_of_a_bearing_with_a_fault_is_read() -> None:
    folder = FOLDERS / "numbers_only" / "faulty_bearing"
    numbers = read_stored(folder).numbers
    former = former_names(numbers, label="")
    stored = stored_summary(folder)
    for name in (
        *("name", "title", "bands_um_s", "bands_uncertainty_db", "iso_departures", "housing"),
        *("moving_ring", "duration_s", "without_faults", "kinematics", "loads", "resonances_hz"),
        *("energy_error", "lost_contact_share", "doubts", "contact_doubts", "sentences"),
    ):
        assert former[name] == stored[name], name
    for name in ("lines", "envelope_lines"):  # 0.8.0 read lines that a record does not resolve
        for line, old in zip(former[name], stored[name], strict=True):
            assert old.items() <= line.items()
    assert [contact.name for contact in numbers.contacts] == [
        "outer",
        "balls-on-inner",
        "balls-on-outer",
    ]
    assert numbers.effort.march_cpu_s is None


def test_a_bearing_has_the_velocities_and_the_motion_that_are_stored() -> None:
    run = rc.open_run(BEARING)
    stored = stored_summary(BEARING)["bands_um_s"]
    shown = shown_bands(run.numbers)
    for direction, bands in stored.items():
        assert shown[direction] == pytest.approx(bands, rel=1e-6, abs=1e-9)
    with h5py.File(BEARING / "result.h5") as file:
        assert np.array_equal(run.record.velocity_m_s, file["velocity"][()])
        assert np.array_equal(run.record.acceleration_m_s2, file["acceleration"][()])
        assert np.array_equal(run.record.ball_load_n, file["ball_load"][()])
        assert np.array_equal(run.tracks.inner.loads_n, file["track_loads"][()])


def test_page_and_table_of_a_bearing_are_written(copied: Path) -> None:
    folder = copied / "bearing"
    stored = stored_summary(BEARING)
    assert cli.main(["report", str(folder), "-q"]) == 0
    assert (folder / "report.html").is_file()
    assert cli.main(["table", str(folder), "-q"]) == 0
    (row,) = rows_of(folder / "runs.csv")
    for band in ("low", "medium", "high"):
        velocity_um_s = float(row[f"velocities_radial_{band}_um_s"])
        assert velocity_um_s == pytest.approx(stored["bands_um_s"]["radial"][band], rel=ROUNDED)
        uncertainty_db = float(row[f"velocities_radial_{band}_uncertainty_db"])
        stated_db = stored["bands_uncertainty_db"]["radial"][band]
        assert uncertainty_db == pytest.approx(stated_db, rel=ROUNDED)


# ---- choices


def test_a_specimen_of_a_choice_has_the_level_that_the_choice_stores() -> None:
    choice = json.loads((FOLDERS / "choice" / "choice.json").read_text())
    (ground,) = [one for one in choice["candidates"] if one["label"] == "ground"]
    level_db = shown_answer(opened("choice/ground/01").numbers).vibration.level_db
    # A choice hears each specimen at five speeds around that of its run.
    assert level_db == pytest.approx(ground["vibration_db"][0], abs=0.1)


# ---- nothing is resumed


@pytest.mark.parametrize(
    "words",
    [
        ["run", "ball/scene.yaml", "--out", "ball"],
        ["run", "sweep/scene.yaml", "--out", "sweep"],
        ["run", "ball/scene.yaml", "--out", "new", "--from", "ball"],
        ["run", "bearing/scene.yaml", "--out", "bearing"],
        ["run", "bearing/scene.yaml", "--out", "new", "--from", "bearing"],
        ["resound", "ball", "--set", "sound.distance_m=2", "--out", "new"],
        ["listen", "ball"],
        ["listen", "sweep/load_n=0.03,seed=2"],
        ["listen", "bearing"],
    ],
    ids=" ".join,
)
def test_what_goes_on_with_a_run_is_refused_with_the_version_that_does(
    words: list[str],
    copied: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(copied)
    before = tree(copied)
    assert cli.main([*words, "-q"]) == 2
    said = capsys.readouterr().err
    assert "a run of version 0.8" in said and "Version 0.8.1 does" in said
    assert len(said.strip().splitlines()) == 1
    assert tree(copied) == before


def test_a_run_that_lost_its_numbers_is_not_taken_for_one_of_080(copied: Path) -> None:
    """Its summary says its format, and the message what to delete."""
    summary = copied / "ball" / "summary.json"
    summary.write_text(json.dumps({"format": 1, **json.loads(summary.read_text())}))
    with pytest.raises(rc.FolderError, match=r"numbers\.json, is missing\); delete it"):
        rc.open_run(copied / "ball")


def test_runs_are_not_added_to_a_sweep(copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = copied / "sweep"
    (folder / "load_n=0.01,seed=1" / "summary.json").unlink()
    before = tree(folder)
    words = ["run", str(SWEEP / "scene.yaml"), "--out", str(folder), "--no-report"]
    assert cli.main([*words, "--workers", "1"]) == 2
    assert "a run of version 0.8" in capsys.readouterr().err
    assert tree(folder) == before


def test_a_choice_does_not_go_on(copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = (FOLDERS / "choice" / "ground" / "01" / "scene.yaml").read_text()
    ground = copied / "ground.yaml"
    lapped = copied / "lapped.yaml"
    ground.write_text(scene)
    lapped.write_text(scene.replace("ground", "lapped").replace("ra_um: 0.05", "ra_um: 0.02"))
    before = tree(copied / "choice")
    words = ["choose", str(ground), str(lapped), "--out", str(copied / "choice")]
    assert cli.main([*words, "--workers", "1"]) == 2
    assert "a choice of version 0.8.0" in capsys.readouterr().err
    assert tree(copied / "choice") == before


def test_a_choice_of_bearings_does_not_go_on(
    copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Version 0.8.0 did not write its name into the choice."""
    scene = copied / "swept.yaml"
    text = (BEARING / "scene.yaml").read_text()
    scene.write_text(f"{text}sweep: {{bearing.radial_load_n: [10, 20]}}\n")
    before = tree(copied / "choice_bearings")
    words = ["choose", str(scene), "--out", str(copied / "choice_bearings"), "--workers", "1"]
    assert cli.main(words) == 2
    assert "numbers of two programs are not mixed" in capsys.readouterr().err
    assert tree(copied / "choice_bearings") == before


@pytest.mark.parametrize(
    ("name", "words", "source"),
    [
        ("ball", "released power", "release"),
        ("dynamics", "vibration, computed", "vibration"),
        ("fall", "vibration, computed", "vibration"),
    ],
)
def test_a_sound_file_keeps_its_own_source(name: str, words: str, source: str) -> None:
    """A listen.wav of version 0.8 has the release of a run without dynamics, as it was made."""
    run = rc.open_run(FOLDERS / name)
    assert content_words(run.stored) == words
    (sound,) = listen_sounds(run)
    assert (sound.file, sound.group) == ("listen.wav", source)
    assert sound.stated.level.gain_db == 0.0

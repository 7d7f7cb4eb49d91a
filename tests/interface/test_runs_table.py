"""Tables and statistics of runs are what the summaries of the runs say."""

from __future__ import annotations

import csv
import io
import json
import statistics
from pathlib import Path

import pandas as pd
import pytest
from finished import run_of
from scene_text import TINY

from rolling.commands.derived import write_table
from rolling.figures.picture import csv_bytes
from rolling.results import verdict
from rolling.results.answer import uncertain
from rolling.results.labels import labels
from rolling.results.run_folder import RunFolder
from rolling.results.run_lines import doubt_lines, error_line, further_lines, levels_table
from rolling.results.run_result import make_run, write_run
from rolling.results.runs_table import level_text, numbers, runs_table, seed_statistics
from rolling.scene import file
from rolling.terminal.streams import FILE_WIDTH, columns

SWEEP = f"""\
{TINY}sweep:
  rolling.load_n: [0.005, 0.01]
  rolling.speed_m_s: [0.1, 0.2]
  surface.seed: [1, 2, 3]
"""


def test_a_corrected_level_is_as_uncertain_as_level_and_correction() -> None:
    """The ± of 0.3 dB of the record and of 0.4 dB of the grid make 0.5 dB."""
    summary = {
        "source": "release",
        "laeq_db": 50.0,
        "uncertainty_db": {"laeq": 0.3},
        "laeq_grid_error_db": 1.0,
        "laeq_grid_error_uncertainty_db": 0.4,
        "laeq_solver_error_db": 0.0,
        "error_estimate": {"stretches": 4, "steps": 239, "order": 1.5},
        "grid_signal_db": None,
        "solver_signal_db": None,
    }
    assert "corrected LAeq 49.0 ± 0.5 dB(A)" in error_line("run", summary)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """Return twelve runs of a sweep, of which the last is not solved."""
    folder = tmp_path_factory.mktemp("table")
    stored = [
        RunFolder(dict(values), scene, folder / str(number))
        for number, (values, scene) in enumerate(file.loads(SWEEP).runs())
    ]
    for run in stored[:-1]:
        write_run(make_run(run, "run", run_of(run.scene).result))
    return stored


def summary_of(run: RunFolder) -> dict:
    return json.loads((run.folder / "summary.json").read_text())


def test_the_table_has_every_run_and_its_numbers(runs: list[RunFolder]) -> None:
    table = runs_table(runs)
    keys = ["rolling.load_n", "rolling.speed_m_s", "surface.seed"]
    assert list(table.index.names) == ["run", "folder", *keys]
    assert list(table.index.get_level_values("run")) == labels(runs)
    read = pd.read_csv(io.StringIO(table.to_csv()))
    assert len(read) == 12 and read["laeq_db"].isna().tolist() == [False] * 11 + [True]
    assert read["folder"].tolist() == list(range(12))
    first = summary_of(runs[0])
    for column, value in (
        ("laeq_db", first["laeq_db"]),
        ("laeq_uncertainty_db", first["uncertainty_db"]["laeq"]),
        ("surface_ra_m", first["surface"]["ra"]),
        ("surface_rms_slope", first["surface"]["rms_slope"]),
        ("plastic_ratio", first["plastic_ratio"]),
        ("steps", 25),
        ("third_octave_db_12500", first["third_octave_db"]["12500"]),
        ("doubts", " ".join(doubt.key for doubt in verdict.listed(first))),
        ("rolling.load_n", 0.005),
    ):
        assert read[column][0] == value, column


def test_statistics_are_those_of_the_summaries(runs: list[RunFolder]) -> None:
    table = seed_statistics(runs_table(runs))
    of_first = table[(table["rolling.load_n"] == 0.005) & (table["rolling.speed_m_s"] == 0.1)]
    summaries = [summary_of(run) for run in runs[:3]]
    for level, band, values, stated in (
        (
            "laeq_db",
            None,
            [summary["laeq_db"] for summary in summaries],
            [summary["uncertainty_db"]["laeq"] for summary in summaries],
        ),
        (
            "third_octave_a_db",
            "12500",
            [summary["third_octave_a_db"]["12500"] for summary in summaries],
            [summary["third_octave_uncertainty_db"]["12500"] for summary in summaries],
        ),
    ):
        named = of_first["level"] == level
        named &= of_first["band_hz"] == band if band else of_first["band_hz"].isna()
        ((_, row),) = of_first[named].iterrows()
        deviation = statistics.stdev(values)
        mean_stated = statistics.fmean([spread**2 for spread in stated]) ** 0.5
        assert row["runs"] == 3
        assert row["mean"] == pytest.approx(statistics.fmean(values), rel=1e-12)
        assert row["standard_deviation"] == pytest.approx(deviation, rel=1e-12)
        assert row["standard_error"] == pytest.approx(deviation / 3**0.5, rel=1e-12)
        assert row["stated_uncertainty"] == pytest.approx(mean_stated, rel=1e-12)
        ratio = deviation / mean_stated
        assert row["deviation_over_stated"] == pytest.approx(ratio, rel=1e-12)
    laeq = table[table["level"] == "laeq_db"]
    assert laeq["runs"].tolist() == [3, 3, 3, 2]  # a run is not solved


def test_statistics_over_another_key_and_over_all_runs(runs: list[RunFolder]) -> None:
    over_speed = seed_statistics(runs_table(runs), "rolling.speed_m_s")
    laeq = over_speed[over_speed["level"] == "laeq_db"]
    assert laeq["runs"].tolist() == [2, 2, 2, 2, 2, 1]
    assert laeq["standard_deviation"].isna().tolist() == [False] * 5 + [True]
    alone = [
        RunFolder({"surface.seed": k}, run.scene, run.folder) for k, run in enumerate(runs[:3])
    ]
    every = seed_statistics(runs_table(alone))
    assert every.columns[0] == "level" and every[every["level"] == "laeq_db"]["runs"].item() == 3


@pytest.mark.parametrize("total", [2.5, None])
def test_the_record_and_the_total_have_their_own_uncertainty(total: float | None) -> None:
    summary = {
        "laeq_db": 60.0,
        "uncertainty_db": {"laeq": 0.5},
        "laeq_uncertainty_db": total,
        "laeq_uncertainty_parts_db": {"record": 0.5, "grid": 2.4},
    }
    cells = numbers(summary)
    assert cells["laeq_uncertainty_db"] == 0.5 and cells["laeq_total_uncertainty_db"] == total


def test_the_terminal_shows_the_vibration_before_the_released_power(
    runs: list[RunFolder],
) -> None:
    text = levels_table(runs)
    lines = text.splitlines()
    summary = summary_of(runs[0])
    heads = lines[0]
    assert heads.index("vibration") < heads.index("verdict") < heads.index("released power")
    released = uncertain(summary["laeq_db"], summary["uncertainty_db"]["laeq"])
    heard = f"{summary['vibration_estimate_laeq_db']:.1f}"
    assert heard in lines[2] and released in lines[2]
    assert lines[2].index(heard) < lines[2].index(released)
    assert lines[13].split()[-3:] == ["-"] * 3  # not solved
    assert "estimated" in lines[1] and "upper bound" in lines[1]


def test_few_lines_follow_the_table_and_the_others_wait_for_verbose(runs: list[RunFolder]) -> None:
    few = "\n".join(doubt_lines(runs)).splitlines()
    assert len(few) <= 8 and all(len(line) <= FILE_WIDTH for line in few)
    assert any(line.startswith("grid and solver: ") for line in few)
    assert any(line.startswith("surface") for line in few)
    further = " ".join("\n".join(further_lines(runs)).split())
    for word in ("upper bound", "microphone", "surface: Ra", "note: When it loops", "warning: "):
        assert word in further
    assert further.count("microphone") == 1


def test_a_level_of_a_fixed_gain_is_none_of_a_share_q(tmp_path: Path) -> None:
    scene = file.loads(TINY, ("sound.gain_pa_per_w_m2=2",))
    run = make_run(RunFolder({}, scene, tmp_path / "gain"), "run", run_of(scene).result)
    write_run(run)
    text = levels_table([run])
    assert run.summary["q"] is None and "assumed" in text.splitlines()[1]
    assert "upper bound" not in text and "upper bound" not in repr(run)
    assert not any("above the" in line for line in further_lines([run]))


@pytest.mark.parametrize(
    ("level", "spread", "text"),
    [(30.04, 0.01, "30.0 ± 0.1"), (30.06, None, "30.1"), (None, None, "silent")],
)
def test_uncertainties_are_rounded_up(level: float | None, spread: float | None, text: str) -> None:
    summary = {"laeq_db": level, "uncertainty_db": {"laeq": spread}, "source": "vibration"}
    summary["steady_level_db"] = None
    assert level_text(summary, "laeq_db") == text
    assert level_text(summary, "steady_level_db") == "-"


def test_columns_are_as_wide_as_their_cells() -> None:
    text = columns([["a", "b"], ["long cell", "x"], ["y", "z"]])
    assert text.splitlines() == ["a          b", "long cell  x", "y          z"]


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("=HYPERLINK(1)", "'=HYPERLINK(1)"),
        ("+1+cmd", "'+1+cmd"),
        ("-2+3", "'-2+3"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("\t=1", "'\\t=1"),
        ("\r=1", "'\\r=1"),
        ("red \x1b[31m", "red \\x1b[31m"),
        ("-5", "-5"),
        ("+1e3", "+1e3"),
        ("load 5 N", "load 5 N"),
    ],
)
def test_no_cell_of_a_table_is_a_formula(text: str, cell: str, tmp_path: Path) -> None:
    """Texts in the index and in columns are written as texts, and numbers stay numbers."""
    index = pd.MultiIndex.from_tuples([(text, -1.5)], names=["run", "surface.path"])
    frame = pd.DataFrame({"number": [-2.5], "word": [text]}, index=index)
    write_table(frame, tmp_path / "runs.csv")
    for content in ((tmp_path / "runs.csv").read_bytes(), csv_bytes(frame.reset_index())):
        (head, row) = csv.reader(io.StringIO(content.decode(), newline=""))
        assert head == ["run", "surface.path", "number", "word"]
        assert row == [cell, "-1.5", "-2.5", cell]

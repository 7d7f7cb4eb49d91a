"""Tables and statistics of runs are what the numbers of the runs say."""

from __future__ import annotations

import csv
import io
import math
import statistics
from pathlib import Path

import pandas as pd
import pytest
from finished import VIBRATING, run_of
from made_numbers import computed, released
from scene_text import TINY

from rolling.commands.derived import write_table
from rolling.kinds.run_folder import RunFolder
from rolling.numbers import views
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results import verdict
from rolling.results.labels import labels
from rolling.results.level_words import number_texts
from rolling.results.run_lines import doubt_lines, error_line, further_lines, levels_table
from rolling.results.run_result import make_run, write_run
from rolling.results.runs_table import bands_table, csv_bytes, runs_table, seed_statistics
from rolling.results.stored_numbers import read_stored
from rolling.scene import file
from rolling.terminal.streams import FILE_WIDTH, columns

ENDS = ("db", "uncertainty_db", "verdict", "how", "measure")  # of the columns of a quantity
SWEEP = f"""\
{TINY}sweep:
  rolling.load_n: [0.005, 0.01]
  rolling.speed_m_s: [0.1, 0.2]
  surface.seed: [1, 2, 3]
"""


def test_a_corrected_level_is_as_uncertain_as_level_and_correction() -> None:
    """The ± of 0.3 dB of the record and of 0.4 dB of the correction make 0.5 dB.

    The errors that are corrected do not count.
    """
    errors = {
        "is_asked": True,
        "grid_db": 1.0,
        "grid_uncertainty_db": 0.4,
        "solver_db": 0.0,
        "stretches": 4,
        "stretch_steps": 239,
        "order": 1.5,
    }
    parts = {"record": 0.3, "grid": math.hypot(1.0, 0.4), "solver": 0.1}
    numbers = released(50.0, parts=parts, errors=errors)
    assert "corrected LAeq 49.0 ± 0.5 dB(A)" in error_line("run", numbers)


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


def numbers_of(run: RunFolder) -> RunNumbers:
    return read_stored(run.folder).numbers


def test_the_table_has_every_run_and_its_numbers(runs: list[RunFolder]) -> None:
    table = runs_table(runs)
    keys = ["rolling.load_n", "rolling.speed_m_s", "surface.seed"]
    assert list(table.index.names) == ["run", "folder", *keys]
    assert list(table.index.get_level_values("run")) == labels(runs)
    read = pd.read_csv(io.StringIO(table.to_csv()))
    assert len(read) == 12 and read["released_power_db"].isna().tolist() == [False] * 11 + [True]
    assert read["folder"].tolist() == list(range(12))
    first = numbers_of(runs[0])
    for column, value in (
        ("vibration_db", first.vibration.value),
        ("vibration_uncertainty_db", first.vibration.uncertainty),
        ("vibration_verdict", first.vibration.verdict),
        ("released_power_db", first.released_power.value),
        ("released_power_uncertainty_db", first.released_power.uncertainty),
        ("released_power_verdict", "bound"),
        ("surface_ra_m", first.surface.ra_m),
        ("surface_rms_slope", first.surface.rms_slope),
        ("contact_plastic_ratio", first.contact.plastic_ratio),
        ("record_steps", 25),
        ("doubts", " ".join(doubt.key for doubt in verdict.listed(first))),
        ("rolling.load_n", 0.005),
    ):
        assert read[column][0] == value, column


def test_a_table_for_people_has_few_columns_of_numbers_and_words(runs: list[RunFolder]) -> None:
    table = runs_table(runs, shown=True)
    assert len(table.columns) <= 40
    for cell in table.reset_index().to_numpy().flat:
        assert pd.isna(cell) or isinstance(cell, int | float | str)
        assert not str(cell).startswith(("[", "{", "("))
    every = runs_table(runs)
    assert set(table.columns) < set(every.columns)


def test_both_numbers_have_columns_of_the_same_names_in_every_scene(tmp_path: Path) -> None:
    """A run with dynamics, one without, and one that is heard by its release."""
    runs = []
    for name, text, words in (
        ("plain", TINY, ()),
        ("moves", VIBRATING, ("rolling.distance_mm=0.16",)),
        ("released", VIBRATING, ("rolling.distance_mm=0.16", "sound.source=release")),
    ):
        scene = file.loads(text, words)
        runs.append(make_run(RunFolder({}, scene, tmp_path / name), "run", run_of(scene).result))
    names = [f"vibration_{end}" for end in ENDS] + [f"released_power_{end}" for end in ENDS]
    table = runs_table(runs).reset_index()
    shown = runs_table(runs, shown=True)
    assert {*names} <= {*shown.columns} <= {*table.columns}
    for row, run in zip(table.to_dict("records"), runs, strict=True):
        for quantity in (run.vibration, run.released_power):
            name = quantity.name
            assert row[f"{name}_db"] == quantity.value
            assert row[f"{name}_verdict"] == quantity.verdict
            assert row[f"{name}_how"] == quantity.how
            spread = row[f"{name}_uncertainty_db"]
            assert pd.isna(spread) if quantity.uncertainty is None else True
            assert quantity.uncertainty is None or spread == quantity.uncertainty
    assert [run.vibration.how for run in runs] == ["estimated", "computed", "computed"]
    # The source is no part of what a name means: the vibration of one run is that of the other.
    assert runs[1].vibration.value == pytest.approx(runs[2].vibration.value, abs=1e-9)


def test_third_octaves_stand_in_long_form(runs: list[RunFolder]) -> None:
    table = bands_table(runs).reset_index()
    first = numbers_of(runs[0]).bands.released_power
    assert first is not None and first.uncertainty is not None
    rows = table[(table["run"] == labels(runs)[0]) & (table["quantity"] == "released_power")]
    assert rows["band_hz"].tolist() == list(first.frequency_hz)
    for column, values in (("value", first.value), ("uncertainty", first.uncertainty)):
        for cell, value in zip(rows[column], values, strict=True):
            assert pd.isna(cell) if value is None else cell == value
    assert set(rows["unit"]) == {"dB"}
    assert "rolling.load_n" in table.columns and len(set(table["run"])) == 11


def test_statistics_are_those_of_the_summaries(runs: list[RunFolder]) -> None:
    table = seed_statistics(runs)
    of_first = table[(table["rolling.load_n"] == 0.005) & (table["rolling.speed_m_s"] == 0.1)]
    numbers = [numbers_of(run) for run in runs[:3]]
    octaves = [one.bands.released_power_a for one in numbers]
    for level, band, values, stated in (
        (
            "released_power_db",
            None,
            [one.released_power.value for one in numbers],
            [one.released_power.uncertainty for one in numbers],
        ),
        (
            "levels_released_power_laeq_db",
            None,
            [one.of_record.laeq_db for one in numbers],
            [one.of_record.spreads.laeq_db for one in numbers],
        ),
        (
            "released_power_a",
            12500,
            [one.by_name["12500"] for one in octaves],
            [one.uncertainty_by_name["12500"] for one in octaves],
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
    laeq = table[table["level"] == "released_power_db"]
    assert laeq["runs"].tolist() == [3, 3, 3, 2]  # a run is not solved


def test_statistics_over_another_key_and_over_all_runs(runs: list[RunFolder]) -> None:
    over_speed = seed_statistics(runs, "rolling.speed_m_s")
    laeq = over_speed[over_speed["level"] == "released_power_db"]
    assert laeq["runs"].tolist() == [2, 2, 2, 2, 2, 1]
    assert laeq["standard_deviation"].isna().tolist() == [False] * 5 + [True]
    alone = [
        RunFolder({"surface.seed": k}, run.scene, run.folder) for k, run in enumerate(runs[:3])
    ]
    every = seed_statistics(alone)
    assert (
        every.columns[0] == "level" and every[every["level"] == "vibration_db"]["runs"].item() == 3
    )


def test_the_record_and_the_quantity_have_their_own_uncertainty() -> None:
    parts = {"record": 0.5, "grid": 2.4}
    levels = {"released_power": {"spreads": {"laeq_db": 0.5}}}
    numbers = released(60.0, parts, levels=levels)
    cells = {name: cell.value for name, cell in views.columns(numbers).items()}
    assert cells["levels_released_power_spreads_laeq_db"] == 0.5
    assert cells["released_power_uncertainty_db"] == math.hypot(0.5, 2.4)


def test_the_terminal_shows_the_vibration_before_the_released_power(
    runs: list[RunFolder],
) -> None:
    text = levels_table(runs)
    lines = text.splitlines()
    numbers = numbers_of(runs[0])
    heads = lines[0]
    assert heads.index("vibration") < heads.index("verdict") < heads.index("released power")
    power = numbers.released_power.number
    heard = numbers.vibration.number
    assert heard in lines[2] and power in lines[2]
    assert lines[2].index(heard) < lines[2].index(power)
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
    crest = f"{read_stored(runs[0].folder).numbers.record.crest_factor_db:.1f}"
    assert f"crest factor [dB] {crest}" in further


def test_a_level_of_a_fixed_gain_is_none_of_a_share_q(tmp_path: Path) -> None:
    scene = file.loads(TINY, ("sound.gain_pa_per_w_m2=2",))
    run = make_run(RunFolder({}, scene, tmp_path / "gain"), "run", run_of(scene).result)
    write_run(run)
    text = levels_table([run])
    assert run.numbers.record.q is None and "assumed" in text.splitlines()[1]
    assert "upper bound" not in text and "upper bound" not in repr(run)
    assert not any("above the" in line for line in further_lines([run]))


@pytest.mark.parametrize(
    ("level", "spread", "text"),
    [(30.04, 0.01, "30.0 ± 0.1"), (30.06, None, "30.1"), (None, None, "silent")],
)
def test_uncertainties_are_rounded_up(level: float | None, spread: float | None, text: str) -> None:
    levels = {"vibration": {"level_db": level, "spreads": {"laeq_db": spread, "level_db": spread}}}
    rows = number_texts(computed(level, levels=levels))
    texts = {one.number_field.word: one.text for one in rows if one.is_of_record}
    assert texts["LAeq"] == texts["LZeq"] == text
    assert texts["steady level"] == "-"  # a vibration has none


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

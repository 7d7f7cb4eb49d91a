"""Tables, statistics and plots of a sweep are what the summaries of its runs say."""

from __future__ import annotations

import csv
import io
import json
import statistics
from pathlib import Path

import pytest
from scene_text import TINY

from rolling import cli
from rolling.commands import table, work
from rolling.figures import sweep_figures
from rolling.folders import own_files, run_record
from rolling.simulation import runs_table, seed_statistics

SCENE = f"""\
{TINY}sweep:
  rolling.load_n: [0.005, 0.01]
  rolling.speed_m_s: [0.1, 0.2]
  surface.seed: [1, 2, 3]
"""


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of twelve runs, of which the last is not solved."""
    folder = tmp_path_factory.mktemp("table")
    (folder / "tiny.yaml").write_text(SCENE)
    out = folder / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        assert (
            cli.main(["run", str(folder / "tiny.yaml"), "--out", str(out), "--workers", "1"]) == 0
        )
    for path in (out / "load_n=0.01,speed_m_s=0.2,seed=3").iterdir():
        if path.name != "run.json":
            path.unlink()
    return out


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def summaries(sweep: Path, pattern: str) -> list[dict]:
    return [json.loads(path.read_text()) for path in sorted(sweep.glob(f"{pattern}/summary.json"))]


def test_statistics_are_those_of_the_summaries(sweep: Path) -> None:
    table.tabulate(sweep)
    every = rows(sweep / "statistics.csv")
    own = [
        row
        for row in every
        if (row["rolling.load_n"], row["rolling.speed_m_s"], row["level"])
        == ("0.005", "0.1", "laeq_db")
    ]
    (row,) = own
    runs = summaries(sweep, "load_n=0.005,speed_m_s=0.1,*")
    levels = [run["laeq_db"] for run in runs]
    stated = [run["uncertainty_db"]["laeq"] for run in runs]
    assert len(levels) == 3 and row["runs"] == "3"
    deviation = statistics.stdev(levels)
    expected = {
        "mean": statistics.fmean(levels),
        "standard_deviation": deviation,
        "standard_error": deviation / 3**0.5,
        "stated_uncertainty": statistics.fmean([one**2 for one in stated]) ** 0.5,
    }
    for name, value in expected.items():
        assert float(row[name]) == pytest.approx(value, rel=1e-12)
    assert float(row["deviation_over_stated"]) == pytest.approx(
        deviation / expected["stated_uncertainty"], rel=1e-12
    )
    bands = [
        each
        for each in every
        if each["level"] == "third_octave_a_db" and each["band_hz"] == "12500"
    ]
    assert [each["runs"] for each in bands] == ["3", "3", "3", "2"]  # a run is not solved


@pytest.mark.parametrize("total", [2.5, None])
def test_the_record_and_the_total_have_their_own_uncertainty(total: float | None) -> None:
    """The statistics state the uncertainty of the record, whatever the error estimate found."""
    summary = {
        "laeq_db": 60.0,
        "uncertainty_db": {"laeq": 0.5},
        "laeq_uncertainty_db": total,
        "laeq_uncertainty_parts_db": {"record": 0.5, "grid": 2.4},
    }
    columns = runs_table.numbers(summary)
    assert columns["laeq_uncertainty_db"] == 0.5
    assert columns["laeq_total_uncertainty_db"] == total
    run = runs_table.Row("seed 1", "seed=1", {"surface.seed": 1}, summary)
    (group,) = seed_statistics.groups([run])
    level = group.of("laeq_db", seed_statistics.LEVELS["laeq_db"])
    assert level is not None and level.stated == 0.5


def test_tables_have_every_run_and_every_band(sweep: Path) -> None:
    written = table.tabulate(sweep)
    assert [path.name for path in written if path.suffix == ".csv"] == [
        "runs.csv",
        "bands.csv",
        "statistics.csv",
    ]
    runs = rows(sweep / "runs.csv")
    assert len(runs) == 12 and runs[-1]["laeq_db"] == "" != runs[0]["laeq_db"]
    bands = rows(sweep / "bands.csv")
    assert len(bands) == 11 * 31
    (one,) = [row for row in bands if row["run"] == runs[0]["run"] and row["band_hz"] == "12500"]
    (summary,) = summaries(sweep, runs[0]["folder"])
    assert float(one["third_octave_db"]) == summary["third_octave_db"]["12500"]


def test_plots_hold_the_means(sweep: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--plot", "plastic_ratio", "--against", "rolling.speed_m_s"]
    assert cli.main(["table", str(sweep), *words]) == 0
    name = "plot_plastic_ratio_against_rolling.speed_m_s"
    assert f"{sweep / name}.svg" in capsys.readouterr().out
    lines = rows(sweep / f"{name}.csv")
    assert [row["curve"] for row in lines] == ["load 0.005 N"] * 2 + ["load 0.01 N"] * 2
    runs = summaries(sweep, "load_n=0.01,speed_m_s=0.1,*")
    mean = statistics.fmean(run["plastic_ratio"] for run in runs)
    assert float(lines[2]["plastic_ratio_mean"]) == pytest.approx(mean, rel=1e-8)
    two = ["--against", "rolling.load_n", "rolling.speed_m_s"]
    assert cli.main(["table", str(sweep), "--plot", "plastic_ratio", *two]) == 0
    cells = rows(sweep / "plot_plastic_ratio_against_rolling.load_n_rolling.speed_m_s.csv")
    assert [row["runs"] for row in cells] == ["3", "3", "3", "2"]
    assert float(cells[1]["plastic_ratio_mean"]) == pytest.approx(mean, rel=1e-8)
    spectra = rows(sweep / "mean_third_octaves.csv")
    assert len(spectra) == 4 * 31
    # All of these are this program's own files.
    assert own_files.foreign(sweep, run_record.read(sweep)) == []


def test_a_number_that_one_run_lacks_can_be_plotted(
    sweep: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first run has no vibration, say, and all others have one."""
    known = table.read_rows(sweep)
    for number, row in enumerate(known[1:11]):
        assert row.summary is not None
        row.summary["vibration_laeq_db"] = 40.0 + number
    monkeypatch.setattr(table, "read_rows", lambda _: known)
    table.tabulate(sweep, ["vibration_laeq_db"])
    lines = rows(sweep / "plot_vibration_laeq_db_against_rolling.load_n.csv")
    # The first of three seeds has no number.
    assert float(lines[0]["vibration_laeq_db_mean"]) == 40.5


def test_many_curves_are_drawn_as_their_median(
    sweep: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = table.read_rows(sweep)[:11]
    groups = seed_statistics.groups(rows, "rolling.load_n")
    few = sweep_figures.lines("laeq_db", "surface.seed", groups, "tiny")
    assert "mean of 1 to 2 values of load; bars: their standard deviation" in few.alt
    assert len(few.figure.axes[0].lines) > 1
    monkeypatch.setattr(sweep_figures, "_MOST_CURVES", 1)
    many = sweep_figures.lines("laeq_db", "surface.seed", groups, "tiny")
    assert "line: median of 2 curves; shaded: 90 % and all of them" in many.alt
    (median,) = many.figure.axes[0].lines
    slow = [row.summary["laeq_db"] for row in rows if row.values["rolling.speed_m_s"] == 0.1]
    fast = [row.summary["laeq_db"] for row in rows if row.values["rolling.speed_m_s"] == 0.2]
    first = [statistics.fmean(levels[::3]) for levels in (slow, fast)]  # of seed 1
    assert median.get_ydata()[0] == pytest.approx(statistics.median(first))
    assert "median of 6 curves" in sweep_figures.mean_third_octaves(groups, "tiny").alt


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--plot", "laeq"], "laeq_db"),
        (["--against", "rolling.load"], "rolling.load_n"),
        (["--against", "a", "b", "c"], "one for lines, two for a map"),
        (["--over", "surface.sed"], "surface.seed"),
    ],
)
def test_unknown_names_get_the_nearest_and_nothing_is_written(
    sweep: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path.name: path.stat().st_mtime_ns for path in sweep.iterdir()}
    assert cli.main(["table", str(sweep), *words]) == 2
    assert message in capsys.readouterr().err
    assert {path.name: path.stat().st_mtime_ns for path in sweep.iterdir()} == before


def test_parquet_holds_the_same_tables(sweep: Path) -> None:
    """Every cell: numbers as numbers, text as text, empty cells as nulls."""
    parquet = pytest.importorskip("pyarrow.parquet", reason="Parquet is written with pyarrow only")
    table.tabulate(sweep)
    for name in ("runs", "bands", "statistics"):
        read = parquet.read_table(sweep / f"{name}.parquet").to_pylist()
        for packed, row in zip(read, rows(sweep / f"{name}.csv"), strict=True):
            assert {key: _as_csv(value, row[key]) for key, value in packed.items()} == row
    content = table._parquet(b"run,x,surface\n001,2,nan\n", ["run", "surface"])
    assert parquet.read_table(io.BytesIO(content)).to_pylist() == [
        {"run": "001", "x": 2, "surface": "nan"}
    ]


def _as_csv(value: object, text: str) -> str:
    """Return the text of a cell if the value says the same."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return text if float(text) == value else f"{value}"
    return "" if value is None else str(value)


def test_a_single_run_has_no_spread() -> None:
    alone = seed_statistics.statistic([(70.0, 0.5), (None, None)])
    assert alone == seed_statistics.Statistic(1, 70.0, None, None, 0.5) and alone.ratio is None
    assert seed_statistics.statistic([(None, 0.1), ("x", None), (True, None)]) is None

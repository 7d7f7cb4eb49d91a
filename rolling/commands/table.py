"""The command table: all numbers of a sweep, their statistics over the seeds, and their plots."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rolling.folders import files
from rolling.folders.files import FolderError
from rolling.scene.messages import nearest
from rolling.simulation import labels, runs_table, seed_statistics
from rolling.simulation.runs_table import Row
from rolling.simulation.seed_statistics import SEED, Group
from rolling.simulation.stored_runs import read_runs
from rolling.terminal import progress

DEFAULT = "laeq_db"


def tabulate(
    folder: Path,
    numbers: Sequence[str] = (),
    against: Sequence[str] = (),
    over: str = SEED,
) -> list[Path]:
    """Write the tables, statistics and plots of a sweep, as far as its runs are solved.

    Parameters
    ----------
    folder : Path. The folder of the sweep.
    numbers : sequence of str. Columns of runs.csv to plot. Default: LAeq.
    against : sequence of str. One or two swept keys. Default: the first swept key.
    over : str. The swept key over which statistics are made. Default: the seed.

    Returns
    -------
    files : list of Path. The files, the table of runs first.

    Raises
    ------
    FolderError : the folder holds no solved run of a sweep, or a name is unknown. Nothing is
        written.
    """
    with progress.step("reading the runs"):
        rows = read_rows(folder)
    solved = [row for row in rows if row.summary is not None]
    if not solved or not solved[0].values:
        raise FolderError(f"{folder}: no solved run of a sweep, so there is nothing to tabulate")
    if over != SEED:
        _refuse_unknown(over, [*solved[0].values], "swept key")
    keys = [key for key in solved[0].values if key != over]
    if len(against) > 2:
        raise FolderError(
            f"--against: got {len(against)} keys, allowed: one for lines, two for a map"
        )
    for key in against:
        _refuse_unknown(key, keys, "swept key")
    # A number may belong to some of the runs alone, such as those with dynamics.
    known = dict.fromkeys(name for row in solved for name in runs_table.numbers(row.summary or {}))
    known.pop("caveats", None)
    for name in numbers:
        _refuse_unknown(name, [*known], "number of runs.csv")
    groups = seed_statistics.groups(solved, over)
    contents = {
        "runs": runs_table.csv(rows),
        "bands": seed_statistics.bands_csv(rows),
        "statistics": seed_statistics.csv(groups),
    }
    written = []
    for name, content in contents.items():
        written.append(_write(folder / f"{name}.csv", content))
        if (packed := _parquet(content, _texts(rows))) is not None:
            written.append(_write(folder / f"{name}.parquet", packed))
    return written + _pictures(folder, groups, numbers or [DEFAULT], against or keys[:1])


def summarize(folder: Path, rows: Sequence[Row]) -> None:
    """Draw the plots of a sweep of many runs from its summaries, without any curve of a run."""
    solved = [row for row in rows if row.summary is not None]
    if solved:
        keys = [key for key in solved[0].values if key != SEED]
        _pictures(folder, seed_statistics.groups(solved), [DEFAULT], keys[:1])


def read_rows(folder: Path) -> list[Row]:
    """Read the runs of a sweep with the summaries that they have."""
    runs = read_runs(folder)
    rows = []
    for run, label in zip(runs, labels.labels(runs), strict=True):
        path = run.folder / "summary.json"
        summary: dict[str, Any] | None = None
        if path.is_file():
            summary = json.loads(path.read_text(encoding="utf-8"))
            summary.pop("provenance", None)
        rows.append(Row(label, run.folder.name, run.values, summary))
    return rows


def _refuse_unknown(name: str, known: Sequence[str], kind: str) -> None:
    if name not in known:
        raise FolderError(f"{name}: no {kind}{nearest(name, known)}, allowed: {', '.join(known)}")


def _pictures(
    folder: Path, groups: Sequence[Group], numbers: Sequence[str], against: Sequence[str]
) -> list[Path]:
    """Draw the plots of a sweep into its folder."""
    # Matplotlib is slow to import, and a misspelt name does not need it.
    from rolling.figures import sweep_figures

    subject = groups[0].rows[0].summary["name"] if groups[0].rows[0].summary else folder.name
    pictures = [sweep_figures.mean_third_octaves(groups, subject)]
    for number in numbers if against else ():
        if len(against) == 2:
            keys = against[0], against[1]
            pictures.append(sweep_figures.heat_map(number, keys, groups, subject))
        else:
            pictures.append(sweep_figures.lines(number, against[0], groups, subject))
    for picture in pictures:
        picture.write(folder)
    return [folder / f"{picture.name}.svg" for picture in pictures]


def _write(path: Path, content: bytes) -> Path:
    files.write_bytes(path, content)
    return path


def _texts(rows: Sequence[Row]) -> list[str]:
    """Return the columns of the tables that hold text, whatever a value looks like."""
    swept = [key for row in rows for key, value in row.values.items() if isinstance(value, str)]
    return list(dict.fromkeys(["run", "folder", "level", "caveats", *swept]))


def _parquet(content: bytes, texts: Sequence[str]) -> bytes | None:
    """Turn a CSV table with columns of text into Parquet; None where pyarrow is not installed."""
    try:
        import pyarrow  # type: ignore[import-not-found, unused-ignore]
        from pyarrow import csv, parquet
    except ImportError:
        return None
    stream = io.BytesIO()
    options = csv.ConvertOptions(column_types=dict.fromkeys(texts, pyarrow.string()))
    parquet.write_table(csv.read_csv(io.BytesIO(content), convert_options=options), stream)
    return stream.getvalue()
